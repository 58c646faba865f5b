/* A run with --infer: the capture is read, and the layout that was found is
 * written and reported. */
#include "runs.h"

#include "../common/interrupt.h"
#include "../common/misfit.h"
#include "../common/shell_word.h"
#include "infer_report.h"
#include "replay.h"
#include "targets.h"

#include "base/outfile.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Records between looks at signals. */
#define RECORDS_A_LOOK 256u

struct inference {
    const struct options *options;
    lum_infer *infer;
    lum_capture *capture;
    struct infer_report report;
    uint32_t skipped; /* records of other interfaces than the one asked for */
    char capture_word[MISFIT_CAPTURE_BYTES];
    char profile_word[MISFIT_CAPTURE_BYTES];
};

/* --- Reading --- */

/* What cannot be read to its end is looked at as far as it can. */
static void note_break(struct inference *f, const lum_error *why)
{
    f->report.is_truncated = true;
    conclude_warn(f->options, "%s", why->text);
}

static void note_damage(struct inference *f)
{
    lum_error why = {""};
    f->report.damaged = lum_capture_damaged(f->capture, &why);
    if (f->report.damaged != 0) {
        conclude_warn(f->options, "%s", why.text);
    }
}

static bool is_of_asked_interface(const struct inference *f)
{
    const char *asked = f->options->sensor.interface;
    const char *interface = lum_capture_interface(f->capture);
    return *asked == '\0' ||
           (interface != NULL && strcmp(interface, asked) == 0);
}

static enum pass_result read_all(struct inference *f, lum_error *error)
{
    lum_record record;
    lum_error broken = {""};
    int wants = 1;
    int status = 1;
    for (uint64_t i = 1;
         wants > 0 &&
         (status = lum_capture_next(f->capture, &record, &broken)) > 0;
         i++) {
        const bool is_asked = is_of_asked_interface(f);
        wants = is_asked ? lum_infer_push(f->infer, &record, error) : wants;
        f->skipped += !is_asked;
        if (i % RECORDS_A_LOOK == 0 && interrupt_signal() != 0) {
            return PASS_INTERRUPTED;
        }
    }
    f->report.records = replay_records(f->capture);
    if (interrupt_signal() != 0) {
        return PASS_INTERRUPTED;
    }
    note_damage(f);
    if (status < 0) {
        note_break(f, &broken);
    }
    return wants < 0 ? PASS_FAILED : PASS_DONE;
}

static enum pass_result solve(struct inference *f, lum_error *error)
{
    const struct options *o = f->options;
    const lum_infer_options options = {.struct_size = sizeof options,
                                       .has_sensor = o->sensor.is_chosen,
                                       .sensor = o->sensor.address,
                                       .port = o->sensor.port};
    enum pass_result result = replay_open(o, &f->capture, error);
    if (result != PASS_DONE) {
        return result;
    }
    if (lum_infer_create(&options, &f->infer, error) != 0) {
        return PASS_FAILED;
    }
    result = read_all(f, error);
    if (result != PASS_DONE) {
        return result;
    }
    f->report.result.struct_size = sizeof f->report.result;
    const int solved = lum_infer_solve(f->infer, &f->report.result, error);
    f->report.result.counts.elsewhere += f->skipped;
    if (interrupt_signal() != 0) {
        return PASS_INTERRUPTED;
    }
    return solved < 0 ? PASS_FAILED : PASS_DONE;
}

/* --- Telling --- */

/* Where the profile goes; NULL: with --json, into that alone. */
static const char *target_of(const struct options *o)
{
    if (o->output_count > 0) {
        return o->outputs[0].name;
    }
    return o->json ? NULL : "-";
}

static const char *name_file(struct inference *f, const char *target)
{
    return target == NULL || strcmp(target, "-") == 0
               ? NULL
               : shell_word(target, f->profile_word, sizeof f->profile_word);
}

/* The report comes first: on a terminal the profile follows it. */
static enum exit_status tell(struct inference *f, lum_error *error)
{
    const struct options *o = f->options;
    const char *target = target_of(o);
    const bool is_found = f->report.result.has_profile;
    if (is_found) {
        (void)lum_infer_write_yaml(&f->report.result, f->report.yaml,
                                   sizeof f->report.yaml);
    }
    conclude_remarks(o, f->capture, NULL);
    if (!is_found || (!o->json && !o->quiet)) {
        infer_report_text(&f->report, stderr);
    }
    if (is_found && target != NULL &&
        lum_outfile_save(target, f->report.yaml, strlen(f->report.yaml),
                         error) != 0) {
        return errno == EPIPE ? EXIT_DONE : conclude_error(error, EXIT_FAILED);
    }
    if (o->json) {
        infer_report_json(&f->report, stdout);
    }
    const enum exit_status printed = conclude_stdout();
    return is_found ? printed : EXIT_FAILED;
}

enum exit_status infer_run(const struct options *options)
{
    lum_error error = {""};
    const char *target = target_of(options);
    if ((target != NULL &&
         targets_check_inputs(options, target, &error) != 0) ||
        (options->json && targets_check_inputs(options, "-", &error) != 0)) {
        return conclude_error(&error, EXIT_BAD);
    }
    struct inference *f = calloc(1, sizeof *f);
    if (f == NULL) {
        (void)lum_error_set(&error, "out of memory");
        return conclude_error(&error, EXIT_FAILED);
    }
    f->options = options;
    f->report.source = options->source;
    f->report.capture = misfit_capture(&options->sources, f->capture_word,
                                       sizeof f->capture_word);
    f->report.profile = name_file(f, target);
    const enum pass_result result = solve(f, &error);
    enum exit_status status = EXIT_DONE;
    if (result == PASS_DONE) {
        status = tell(f, &error);
    } else if (result != PASS_INTERRUPTED) {
        status = conclude_error(&error, EXIT_FAILED);
    }
    lum_infer_free(f->infer);
    lum_capture_close(f->capture);
    free(f);
    if (interrupt_signal() != 0) {
        interrupt_die();
    }
    return status;
}
