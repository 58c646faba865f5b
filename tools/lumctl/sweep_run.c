#include "sweep_run.h"

#include "../common/input_files.h"
#include "config_files.h"
#include "ctl_session.h"
#include "laser_outcome.h"

#include "base/system.h"
#include "lum/base/time.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FOLDER_BYTES 4096
#define LASER_NS     INT64_C(20000000000)
#define DROP_NS      INT64_C(3000000000)
#define AGAIN_NS     INT64_C(10000000)

/* --- Before anything is sent --- */

/* That of the plan's name, without its end. */
static const char *name_folder(const struct ctl *ctl, const char *plan,
                               char out[FOLDER_BYTES])
{
    const char *base = lum_system_base(plan);
    const char *dot = strrchr(base, '.');
    if (ctl->options.sweep.output != NULL) {
        return ctl->options.sweep.output;
    }
    if (dot == NULL || dot == base) {
        return "sweep";
    }
    (void)snprintf(out, FOLDER_BYTES, "%.*s", (int)(dot - base), base);
    return out;
}

static enum exit_status check_words(const struct ctl *ctl, int count)
{
    if (count != 2) {
        return ctl_complain(EXIT_BAD, count < 2
                                          ? "sweep: give a plan, such as the "
                                            "sample calib/sweep.yaml"
                                          : "sweep: one plan, not more");
    }
    if (ctl->in_shell) {
        return ctl_complain(EXIT_BAD,
                            "sweep: a shell has a session of its own; "
                            "run lumctl sweep beside it");
    }
    return EXIT_DONE;
}

static enum exit_status load(struct sweep *s)
{
    const struct ctl_options *o = &s->ctl->options;
    lum_error error = {""};
    if (input_files_check(&(struct input_file){s->file, "the plan"}, 1, "-",
                          &error) != 0 ||
        lum_sweep_load(s->file, &s->plan, &error) != 0 ||
        files_load_calibration(o->calibration, &o->set,
                               &s->geometry.calibration, &error) != 0) {
        return ctl_complain(EXIT_BAD, "%s", error.text);
    }
    s->ctl->calibration = &s->geometry.calibration;
    s->geometry.profile = s->ctl->layout.profile;
    s->geometry.has_profile =
        o->profile != NULL || set_keys_first(&o->set, true) != NULL;
    s->geometry.has_calibration =
        o->calibration != NULL || set_keys_first(&o->set, false) != NULL;
    return EXIT_DONE;
}

static enum exit_status make(struct sweep *s, const lum_settings *from,
                             bool tells, struct settings_plan *out)
{
    struct ctl *ctl = s->ctl;
    const bool was_quiet = ctl->options.quiet;
    ctl->options.quiet = was_quiet || !tells;
    const enum exit_status status = plan_make(ctl, s->file, from, out);
    ctl->options.quiet = was_quiet;
    return status;
}

static void print_step(const struct sweep *s, size_t step)
{
    const lum_sweep_step *what = &s->plan.steps[step];
    (void)fprintf(stderr, "step %u of %u", (unsigned)step + 1u,
                  (unsigned)s->plan.count);
    if (what->frames > 0) {
        (void)fprintf(stderr, ", records %u frame%s", (unsigned)what->frames,
                      what->frames == 1 ? "" : "s");
    } else if (what->record_ns > 0) {
        (void)fprintf(stderr, ", records %.6g s",
                      (double)what->record_ns / 1e9);
    }
    (void)fputc('\n', stderr);
    if (s->settings.count > 0) {
        plan_print(stderr, &s->settings);
    }
}

static enum exit_status print_dry(struct sweep *s)
{
    for (size_t i = 0; i < s->plan.count; i++) {
        enum exit_status status =
            make(s, &s->plan.steps[i].settings, true, &s->settings);
        if (status == EXIT_DONE && !s->ctl->options.quiet) {
            print_step(s, i);
        }
        if (status == EXIT_DONE && s->settings.count > 0) {
            status = plan_send(s->ctl, &s->settings);
        }
        if (status != EXIT_DONE) {
            return status;
        }
    }
    return EXIT_DONE;
}

/* Looks at all steps before the first; how many are to be done. */
static enum exit_status prepare(struct sweep *s, size_t *missing)
{
    struct ctl *ctl = s->ctl;
    enum exit_status status =
        manifest_open(ctl, s->folder, s->file, s->plan.count,
                      ctl->options.sweep.goes_on, &s->manifest);
    *missing = 0;
    for (size_t i = 0; i < s->plan.count && status == EXIT_DONE; i++) {
        const lum_sweep_step *what = &s->plan.steps[i];
        status = make(s, &what->settings, true, &s->settings);
        if (status == EXIT_DONE) {
            status = make(s, &what->all, false, &s->in_force);
        }
        if (status == EXIT_DONE &&
            !manifest_name(s->manifest, i, &s->in_force, what)) {
            status = ctl_complain(EXIT_FAILED, "out of memory");
        }
        if (status == EXIT_DONE) {
            *missing += manifest_is_done(s->manifest, i) ? 0 : 1u;
        }
    }
    return status == EXIT_DONE ? manifest_check(s->manifest) : status;
}

/* --- The session --- */

/* Until it is up; what keeps it down is trouble. */
static enum exit_status switch_on(struct sweep *s)
{
    struct ctl *ctl = s->ctl;
    lum_laser_session_view view = {.struct_size = sizeof view};
    lum_laser_session_want(ctl->laser, LUM_WANT_ON, lum_time_monotonic_ns());
    const enum exit_status status = sweep_await_laser(s, LASER_NS);
    (void)lum_laser_session_look(ctl->laser, &view);
    if (status == EXIT_DONE && view.laser != LUM_LASER_UP) {
        (void)snprintf(s->why, sizeof s->why, "the laser did not come up");
        return EXIT_FAILED;
    }
    return status;
}

/* What steps that were done before have set is sent with the next one. */
static enum exit_status do_steps(struct sweep *s)
{
    enum exit_status status =
        s->ctl->options.owner.laser ? switch_on(s) : EXIT_DONE;
    lum_settings unsent = {.has_shape = false};
    for (size_t i = 0; i < s->plan.count && status == EXIT_DONE; i++) {
        lum_sweep_merge(&unsent, &s->plan.steps[i].settings);
        if (manifest_is_done(s->manifest, i)) {
            continue;
        }
        status = make(s, &s->plan.steps[i].all, false, &s->in_force);
        if (status == EXIT_DONE) {
            status = make(s, &unsent, false, &s->settings);
        }
        if (status == EXIT_DONE) {
            status = sweep_step(s, i);
        }
        unsent = (lum_settings){.has_shape = false};
    }
    return status;
}

/* The file of a step that is not done goes. */
static void discard_dropped(struct sweep *s)
{
    const int64_t end = lum_time_monotonic_ns() + DROP_NS;
    lum_error error;
    while (s->dropped != NULL &&
           recorder_look(s->dropped, &error) < RECORDER_WHOLE &&
           lum_time_monotonic_ns() < end) {
        lum_time_sleep_until(lum_time_monotonic_ns() + AGAIN_NS);
    }
    recorder_discard(s->dropped);
    s->dropped = NULL;
}

static enum exit_status run(struct sweep *s)
{
    struct ctl *ctl = s->ctl;
    enum exit_status status = ctl_open(ctl, true);
    if (status != EXIT_DONE) {
        (void)snprintf(s->why, sizeof s->why, "the session could not be begun");
        return status;
    }
    ctl->trouble.kind = 0;
    ctl->trouble.struct_size = sizeof ctl->trouble;
    status = do_steps(s);
    s->is_whole = status == EXIT_DONE;
    if (s->is_whole) { /* a signal comes too late now */
        status = sweep_trouble(s);
    }
    if (ctl->options.owner.laser && laser_leave(ctl) != EXIT_DONE &&
        status == EXIT_DONE) {
        (void)snprintf(s->why, sizeof s->why,
                       "the laser was not confirmed off");
        status = EXIT_FAILED;
    }
    discard_dropped(s);
    return status;
}

/* --- The command --- */

static enum exit_status conclude(struct sweep *s, enum exit_status status)
{
    if (status == EXIT_DONE) {
        return status;
    }
    (void)ctl_complain(status, "%s: %s %s", s->file,
                       s->is_whole ? "all steps are done, but"
                                   : "not all steps are done:",
                       s->why);
    if (!s->is_whole) {
        ctl_note(s->ctl,
                 "the same command with --continue does what is missing");
    }
    return status;
}

static enum exit_status sweep(struct sweep *s)
{
    size_t missing = 0;
    lum_error error = {""};
    const enum exit_status status = prepare(s, &missing);
    if (status != EXIT_DONE) {
        return status;
    }
    if (missing < s->plan.count) {
        ctl_note(s->ctl, "%u of %u steps were done before",
                 (unsigned)(s->plan.count - missing), (unsigned)s->plan.count);
    }
    if (missing == 0) {
        return EXIT_DONE;
    }
    if (!s->ctl->options.owner.laser) {
        ctl_note(s->ctl, "without --laser the laser is left as it is");
    }
    return manifest_begin(s->manifest, &error)
               ? conclude(s, run(s))
               : ctl_complain(EXIT_FAILED, "%s", error.text);
}

enum exit_status command_sweep(struct ctl *ctl, int count, char **words)
{
    struct sweep *s = calloc(1, sizeof *s);
    char folder[FOLDER_BYTES];
    enum exit_status status = check_words(ctl, count);
    if (s == NULL) {
        return ctl_complain(EXIT_FAILED, "out of memory");
    }
    s->ctl = ctl;
    if (status == EXIT_DONE) {
        s->file = words[1];
        s->folder = name_folder(ctl, words[1], folder);
        status = load(s);
    }
    if (status == EXIT_DONE) {
        status = ctl->options.dry_run ? print_dry(s) : sweep(s);
    }
    ctl->calibration = NULL;
    if (!manifest_end(s->manifest, s->why, status)) {
        status = ctl_complain(status != EXIT_DONE ? status : EXIT_FAILED,
                              "%s/manifest.json is not up to date", s->folder);
    }
    lum_sweep_free(&s->plan);
    free(s);
    return status;
}
