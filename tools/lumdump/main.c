/* lumdump: captures and sensors to clouds. */
#include "../common/interrupt.h"
#include "conclude.h"
#include "live.h"
#include "options.h"
#include "replay.h"
#include "targets.h"

#include "lum/io/config.h"

static int load(const struct options *o, lum_layout *layout,
                lum_projector *projector, lum_error *error)
{
    lum_calibration calibration;
    lum_profile profile;
    lum_calibration_default(&calibration);
    lum_profile_default(&profile);
    if (o->calibration != NULL &&
        lum_calibration_load(o->calibration, &calibration, error) != 0) {
        return -1;
    }
    if (o->profile != NULL &&
        lum_profile_load(o->profile, &profile, error) != 0) {
        return -1;
    }
    if (lum_layout_init(layout, &profile, NULL, NULL) != LUM_OK ||
        lum_projector_init(projector, &calibration, layout) != LUM_OK) {
        return lum_error_set(error, "the calibration or the profile is out of "
                                    "range; see docs/formats.md");
    }
    return 0;
}

static enum exit_status run_capture(struct pass *pass)
{
    lum_error error = {""};
    const enum pass_result result = replay(pass, &error);
    const enum exit_status status = conclude(pass, result, &error);
    outputs_abort(pass->outputs);
    pass_free(pass);
    if (interrupt_signal() != 0) {
        interrupt_die();
    }
    return status;
}

static enum exit_status run(const struct options *o)
{
    lum_error error = {""};
    lum_layout layout;
    lum_projector projector;
    if (load(o, &layout, &projector, &error) != 0 ||
        targets_check(o, &error) != 0) {
        return conclude_error(&error, EXIT_BAD);
    }
    struct pass pass = {
        .options = o, .layout = &layout, .projector = &projector};
    return o->is_live ? live_run(&pass) : run_capture(&pass);
}

int main(int argc, char **argv)
{
    struct options options;
    interrupt_catch();
    switch (options_parse(argc, argv, &options)) {
    case PARSED_DONE:
        return (int)conclude_stdout();
    case PARSED_BAD:
        return EXIT_BAD;
    case PARSED_RUN:
    default:
        return (int)run(&options);
    }
}
