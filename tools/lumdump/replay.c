#include "replay.h"

#include "../common/file_look.h"
#include "../common/interrupt.h"
#include "../common/terminal.h"
#include "conclude.h"
#include "health.h"
#include "lum/base/time.h"
#include "targets.h"

#include <inttypes.h>
#include <stdio.h>

/* Records between looks at signals and at the clock for the progress line. */
#define RECORDS_A_LOOK 256u

#define INTERVAL_NS INT64_C(200000000)

/* A line on a terminal that says how far the work has come. */
struct progress {
    bool is_on;
    bool is_shown;
    int64_t next_ns;
};

/* Redraws it five times a second, where standard error is a terminal in whose
 * foreground the run is; total 0: unknown. */
static void progress_update(struct progress *progress, uint64_t done,
                            uint64_t total, uint64_t points)
{
    if (!progress->is_on) {
        return;
    }
    const int64_t now = lum_time_monotonic_ns();
    if (now < progress->next_ns) {
        return;
    }
    progress->next_ns = now + INTERVAL_NS;
    if (!terminal_is_foreground(stderr)) {
        progress->is_shown = false;
        return;
    }
    progress->is_shown = true;
    if (total > 0) {
        (void)fprintf(stderr, "\r\033[K%3" PRIu64 " %%  ", done * 100 / total);
    } else {
        (void)fputs("\r\033[K", stderr);
    }
    (void)fprintf(stderr, "%" PRIu64 " MB read, %" PRIu64 " points",
                  done / 1000000, points);
}

static void progress_clear(struct progress *progress)
{
    if (progress->is_shown && terminal_is_foreground(stderr)) {
        (void)fputs("\r\033[K", stderr);
    }
    progress->is_shown = false;
}

uint64_t replay_records(const lum_capture *capture)
{
    uint64_t records = 0;
    const size_t n = lum_capture_source_count(capture);
    for (size_t i = 0; i < n; i++) {
        lum_capture_source source = {.struct_size = sizeof source};
        (void)lum_capture_get_source(capture, i, &source);
        records += source.records;
    }
    return records;
}

static int open_sources(const struct options *o, lum_capture **out,
                        lum_error *error)
{
    return sources_check_folders(&o->sources, error) == 0
               ? lum_capture_open_several(o->sources.paths, o->sources.count,
                                          out, error)
               : -1;
}

static enum pass_result look_around(struct pass *pass,
                                    struct progress *progress, lum_error *error)
{
    uint64_t done = 0;
    uint64_t total = 0;
    if (interrupt_signal() != 0) {
        return PASS_INTERRUPTED;
    }
    lum_capture_progress(pass->source.capture, &done, &total);
    progress_update(progress, done, total,
                    summary_count(&pass->summary).points);
    return health_tell_on_the_way(pass, error);
}

static void tell_notes(struct pass *pass, struct progress *progress)
{
    if (pass->notes.told < pass->notes.count) {
        progress_clear(progress);
        conclude_notes(pass);
    }
}

static bool is_past_duration(const struct pass *pass, int64_t first_ns,
                             int64_t time_ns)
{
    return pass->options->choice.duration_ns != 0 &&
           time_ns - first_ns > pass->options->choice.duration_ns;
}

/* A file that was there at the start, and could not be opened when its turn
 * came. */
static bool lacks_source(const struct pass *pass)
{
    const size_t n = lum_capture_source_count(pass->source.capture);
    for (size_t i = 0; i < n; i++) {
        lum_capture_source source = {.struct_size = sizeof source};
        lum_capture_get_source(pass->source.capture, i, &source);
        if (source.end == LUM_CAPTURE_UNREAD) {
            return true;
        }
    }
    return false;
}

static enum pass_result read_all(struct pass *pass, struct progress *progress,
                                 lum_error *error)
{
    struct summary *s = &pass->summary;
    lum_record record;
    int64_t first_ns = 0;
    int status = 0;
    for (uint64_t i = 0;
         (status = lum_capture_next(pass->source.capture, &record,
                                    &pass->source.warning)) > 0;
         i++) {
        first_ns = i == 0 ? record.time_ns : first_ns;
        if (is_past_duration(pass, first_ns, record.time_ns)) {
            s->records = replay_records(pass->source.capture) - 1u;
            return PASS_DONE;
        }
        lum_framer_set_interface(pass->framer,
                                 lum_capture_interface(pass->source.capture));
        enum pass_result result = pass_take(pass, &record, error);
        tell_notes(pass, progress);
        if (result == PASS_DONE && i % RECORDS_A_LOOK == 0) {
            result = look_around(pass, progress, error);
        }
        if (result != PASS_DONE) {
            return result;
        }
    }
    s->records = replay_records(pass->source.capture);
    if (interrupt_signal() != 0) {
        return PASS_INTERRUPTED;
    }
    if (lacks_source(pass)) {
        *error = pass->source.warning;
        return PASS_FAILED;
    }
    s->truncated = status < 0;
    record.kind = LUM_RECORD_FRAGMENT;
    return pass_take(pass, &record, error);
}

/* A fit uses only earlier packets, so the first lines of a stream are uncertain
 * by a batch of the system. The beginning of a file is read in advance; after
 * that the fit knows enough. Errors are reported when it is read again. */
static enum pass_result learn_clocks(struct pass *pass, lum_error *error)
{
    struct pass ahead = {.options = pass->options,
                         .counts_alone = true,
                         .layout = pass->layout,
                         .projector = pass->projector};
    enum pass_result result = PASS_DONE;
    lum_capture *capture = NULL;
    lum_record record;
    int64_t first_ns = INT64_MAX;
    if ((pass->options->points.time != TIME_UTC &&
         !motion_is_utc(pass->motion) &&
         !options_any(pass->options, options_has_messages)) ||
        !sources_are_files(&pass->options->sources) ||
        open_sources(pass->options, &capture, NULL) != 0) {
        return PASS_DONE;
    }
    result = pass_prepare(&ahead, error);
    while (result == PASS_DONE && interrupt_signal() == 0 &&
           lum_capture_next(capture, &record, NULL) > 0) {
        first_ns = first_ns != INT64_MAX ? first_ns : record.time_ns;
        if (record.time_ns - first_ns > SOURCES_LEARN_NS) {
            break;
        }
        lum_framer_set_interface(ahead.framer, lum_capture_interface(capture));
        result = pass_take(&ahead, &record, error);
    }
    if (result == PASS_DONE &&
        lum_framer_learn_clocks(pass->framer, ahead.framer) != 0) {
        (void)lum_error_set(error, "out of memory");
        result = PASS_FAILED;
    }
    pass_free(&ahead);
    lum_capture_close(capture);
    return result;
}

enum pass_result replay_open(const struct options *options, lum_capture **out,
                             lum_error *error)
{
    if (open_sources(options, out, error) == 0) {
        return PASS_DONE;
    }
    return interrupt_signal() != 0 ? PASS_INTERRUPTED : PASS_FAILED;
}

static enum pass_result begin_voxels(struct pass *pass, lum_error *error)
{
    return pass->options->cloud.voxel == 0 || pass->outputs == NULL ||
                   voxels_new(pass->options, &pass->voxels, error) == 0
               ? PASS_DONE
               : PASS_FAILED;
}

/* The map, once all frames came. */
static enum pass_result write_voxels(struct pass *pass, lum_error *error)
{
    bool is_done = pass->voxels == NULL;
    if (!is_done && voxels_check(pass->voxels, error) != 0) {
        return PASS_REFUSED;
    }
    while (!is_done) {
        if (interrupt_signal() != 0) {
            return PASS_INTERRUPTED;
        }
        if (voxels_write(pass->voxels, pass->outputs, &is_done, error) != 0) {
            return pass_failure();
        }
    }
    if (pass->voxels != NULL) {
        voxels_count(pass->voxels, &pass->summary.voxels);
    }
    return PASS_DONE;
}

static enum pass_result run(struct pass *pass, lum_error *error)
{
    struct progress progress = {.is_on = !pass->options->quiet};
    enum pass_result result = pass_prepare(pass, error);
    if (result == PASS_DONE) {
        result = learn_clocks(pass, error);
    }
    if (result == PASS_DONE && pass->source.capture == NULL) {
        result = replay_open(pass->options, &pass->source.capture, error);
    }
    if (result == PASS_DONE &&
        outputs_any(pass->outputs, output_wants_points) &&
        row_threads_new(pass->options, pass->outputs, &pass->rows, error) !=
            0) {
        result = PASS_FAILED;
    }
    if (result == PASS_DONE) {
        result = begin_voxels(pass, error);
    }
    if (result != PASS_DONE) {
        return result;
    }
    pass->summary.capture = pass->source.capture;
    result = read_all(pass, &progress, error);
    if (result == PASS_DONE) {
        result = pass_flush(pass, error);
    }
    if (result == PASS_DONE) {
        result = write_voxels(pass, error);
    }
    row_threads_free(pass->rows); /* also before the outputs are aborted */
    pass->rows = NULL;
    if (result == PASS_DONE) {
        result = health_tell(pass, error);
    }
    pass->source.has_changed =
        provenance_has_changed(pass->source.capture, pass->source.about);
    progress_clear(&progress);
    return result;
}

/* The first of two passes; if it does not come to its end, its results stay in
 * pass. */
static enum pass_result rehearse(struct pass *pass, struct outputs **rehearsal,
                                 lum_error *error)
{
    const struct pass fresh = *pass;
    if (!sources_are_files(&pass->options->sources)) {
        (void)lum_error_set(error,
                            "the format's header holds the number of points: "
                            "a source that can be read once cannot go to an "
                            "output that cannot seek; use -o FILE, or csv");
        return PASS_REFUSED;
    }
    if (outputs_open(pass->options, NULL, NULL, &pass->outputs, error) != 0) {
        return PASS_FAILED;
    }
    const enum pass_result result = run(pass, error);
    *rehearsal = pass->outputs;
    pass->outputs = NULL;
    if (result == PASS_DONE) {
        pass_free(pass);
        *pass = fresh;
        pass->source.capture = NULL; /* it was read */
    }
    return result;
}

enum pass_result replay(struct pass *pass, lum_error *error)
{
    const struct options *o = pass->options;
    struct outputs *rehearsal = NULL;
    enum pass_result result = PASS_DONE;
    if (options_any(o, targets_needs_rehearsal)) {
        result = rehearse(pass, &rehearsal, error);
    }
    if (result == PASS_DONE && o->output_count > 0 &&
        outputs_open(o, rehearsal, &pass->notes, &pass->outputs, error) != 0) {
        result = PASS_FAILED;
    }
    outputs_abort(rehearsal);
    return result == PASS_DONE ? run(pass, error) : result;
}
