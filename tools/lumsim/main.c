/* lumsim: a simulated sensor, on the network or into a capture. */
#include "live_sensor.h"
#include "moving.h"
#include "rig_capture.h"

int main(int argc, char **argv)
{
    struct options options;
    int status = options_parse(argc, argv, &options);
    if (status < 0) {
        status = options.mode == MODE_FILE ? offline_run(&options)
                                           : live_run(&options);
    }
    rig_free(&options);
    moving_free(&options);
    return status;
}
