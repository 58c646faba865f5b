#include "live.h"

int main(int argc, char **argv)
{
    struct options options;
    const int status = options_parse(argc, argv, &options);
    if (status >= 0) {
        return status;
    }
    return options.mode == MODE_FILE ? offline_run(&options)
                                     : live_run(&options);
}
