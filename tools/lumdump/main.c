/* lumdump: captures and sensors to clouds. */
#include "../common/geometry.h"
#include "../common/interrupt.h"
#include "conclude.h"
#include "live.h"
#include "options.h"
#include "replay.h"
#include "targets.h"

static enum exit_status run_capture(struct pass *pass)
{
    lum_error error = {""};
    const enum pass_result result = replay(pass, &error);
    const enum exit_status status = conclude(pass, result, &error);
    conclude_notes(pass);
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
    if (geometry_load(o->calibration, o->profile, &layout, &projector,
                      &error) != 0 ||
        targets_check(o, &error) != 0) {
        return conclude_error(&error, EXIT_BAD);
    }
    if (o->time == TIME_UTC &&
        layout.profile.group[LUM_FIELD_TIMESTAMP].bytes == 0) {
        (void)lum_error_set(&error,
                            "--time utc: by the profile %s packets have no "
                            "timestamp to fit; use --time arrival",
                            o->profile);
        return conclude_error(&error, EXIT_BAD);
    }
    struct pass pass = {
        .options = o, .layout = &layout, .projector = &projector};
    return o->is_live ? live_run(&pass) : run_capture(&pass);
}

static enum exit_status act(enum parsed parsed, const struct options *options)
{
    switch (parsed) {
    case PARSED_DONE:
        return conclude_stdout();
    case PARSED_BAD:
        return EXIT_BAD;
    case PARSED_RUN:
    default:
        return run(options);
    }
}

int main(int argc, char **argv)
{
    struct options options;
    interrupt_catch();
    const enum exit_status status =
        act(options_parse(argc, argv, &options), &options);
    options_free(&options);
    return (int)status;
}
