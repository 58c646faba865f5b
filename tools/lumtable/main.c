/* lumtable: what a controller needs of a sensor's YAML, in C. */
#include "base/outfile.h"
#include "c_text.h"
#include "lum/config/config.h"
#include "options.h"

#include <stdio.h>

enum exit_status {
    EXIT_DONE = 0,
    EXIT_FAILED = 1,
    EXIT_BAD = 2
};

static int complain(const lum_error *error, enum exit_status status)
{
    (void)fprintf(stderr, "lumtable: %s\n", error->text);
    return (int)status;
}

static int load(const struct options *o, lum_layout *layout,
                lum_fixed_projector *projector, lum_error *error)
{
    lum_calibration calibration;
    lum_profile profile;
    lum_calibration_default(&calibration);
    lum_profile_default(&profile);
    if (o->profile != NULL && lum_profile_load(o->profile, &profile, error)) {
        return -1;
    }
    if (o->calibration != NULL &&
        lum_calibration_load(o->calibration, &calibration, error) != 0) {
        return -1;
    }
    if (set_keys_profile(&o->set, o->profile == NULL, &profile, error) != 0 ||
        set_keys_calibration(&o->set, o->calibration == NULL, &calibration,
                             error) != 0) {
        return -1;
    }
    if (lum_layout_init(layout, &profile, NULL, NULL) != LUM_OK ||
        lum_fixed_projector_init(projector, &calibration, layout) != LUM_OK) {
        return lum_error_set(error, "the calibration or the profile is out of "
                                    "range; see docs/formats.md");
    }
    return 0;
}

int main(int argc, char **argv)
{
    static struct source source;
    struct options options;
    lum_layout layout;
    lum_fixed_projector projector;
    lum_error error = {""};
    const enum option_end parsed = options_parse(argc, argv, &options);
    if (parsed != OPTIONS_READ) {
        if (parsed == OPTIONS_SHOWN && fflush(stdout) != 0) {
            return EXIT_FAILED;
        }
        return parsed == OPTIONS_SHOWN ? EXIT_DONE : EXIT_BAD;
    }
    if (load(&options, &layout, &projector, &error) != 0) {
        return complain(&error, EXIT_BAD);
    }
    const struct origin origin = {
        options.name != NULL ? options.name : "lum_table", options.profile,
        options.calibration, &options.set};
    if (options.is_layout) {
        layout_write(&source, &origin, &layout);
    } else {
        tables_write(&source, &origin, &layout, &projector);
    }
    if (source.is_cut) {
        (void)lum_error_set(&error, "the source is longer than expected");
        return complain(&error, EXIT_FAILED);
    }
    return lum_outfile_save(options.output, source.text, source.len, &error) ==
                   0
               ? EXIT_DONE
               : complain(&error, EXIT_FAILED);
}
