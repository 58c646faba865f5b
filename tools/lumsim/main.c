#include "live.h"
#include "moving.h"

int main(int argc, char **argv)
{
    struct options options;
    int status = options_parse(argc, argv, &options);
    if (status < 0) {
        status = options.mode == MODE_FILE ? offline_run(&options)
                                           : live_run(&options);
    }
    moving_free(&options);
    return status;
}
