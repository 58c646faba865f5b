/* Reads captures once before they are played: the range of their frames, what
 * is odd in them, how their sensors' clocks run. */
#include "scan.h"

#include "thread.h"

#include <stdlib.h>

/* Records of a step. */
#define RECORDS_A_STEP 64u

struct sweep {
    const struct captures *captures;
    lum_capture *capture;
    struct decoder *decoder;
    int64_t span_ns;
    int64_t end_ns;
    bool has_begun;
    bool is_whole; /* all was read */
};

struct scan {
    const struct captures *captures;
    const struct provenance_source *said;
    struct decoder_options options;
    struct sweep *sweep; /* NULL: it is over, or nothing can be read */
    struct thread *thread;

    struct gate *gate; /* guards what follows */
    bool is_known;
    int64_t first;
    int64_t last;
};

/* --- Sweeps --- */

struct sweep *sweep_new(const struct captures *captures,
                        const struct decoder_options *options, int64_t span_ns)
{
    struct sweep *sweep = calloc(1, sizeof *sweep);
    struct decoder_options first = *options;
    first.second_layout = NULL; /* the first tells the time */
    if (sweep == NULL) {
        return NULL;
    }
    *sweep = (struct sweep){
        .captures = captures, .span_ns = span_ns, .end_ns = INT64_MAX};
    if (captures_open(captures, &sweep->capture, NULL) == 0) {
        sweep->decoder = decoder_new(&first);
    }
    if (sweep->decoder == NULL) {
        (void)sweep_end(sweep);
        return NULL;
    }
    decoder_skip_to(sweep->decoder, INT64_MAX);
    return sweep;
}

struct decoder *sweep_end(struct sweep *sweep)
{
    if (sweep == NULL) {
        return NULL;
    }
    struct decoder *decoder = sweep->decoder;
    lum_capture_close(sweep->capture);
    free(sweep);
    return decoder;
}

/* The player reports read errors. */
static bool read_record(struct sweep *s)
{
    lum_record record;
    s->is_whole = captures_next(s->captures, s->capture, &record, NULL) <= 0;
    if (s->is_whole) {
        return false;
    }
    if (!s->has_begun && s->span_ns != INT64_MAX) {
        s->end_ns = add_clamped(record.time_ns, s->span_ns);
    }
    s->has_begun = true;
    decoder_set_interface(s->decoder, lum_capture_interface(s->capture));
    return record.time_ns <= s->end_ns &&
           decoder_push(s->decoder, &record) == DECODED_ALL;
}

bool sweep_step(struct sweep *sweep)
{
    unsigned i = 0;
    while (i < RECORDS_A_STEP && read_record(sweep)) {
        i++;
    }
    return i == RECORDS_A_STEP;
}

/* --- The scan --- */

static void note(struct scan *scan, const struct decoder *decoder)
{
    int64_t first = 0;
    int64_t last = 0;
    if (!decoder_range(decoder, &first, &last)) {
        return;
    }
    gate_take(scan->gate);
    scan->is_known = true;
    scan->first = first;
    scan->last = last;
    gate_leave(scan->gate);
    stage_set_range(scan->options.stage, first, last);
}

static void tell(struct scan *scan)
{
    const struct sweep *s = scan->sweep;
    if (s->is_whole && decoder_flush(s->decoder) == DECODED_ALL) {
        note(scan, s->decoder);
        captures_tell(scan->captures, s->capture, decoder_demux(s->decoder),
                      scan->said, scan->options.stage);
        captures_warn(scan->captures, s->capture, decoder_demux(s->decoder));
    }
}

static void end_sweep(struct scan *scan)
{
    decoder_free(sweep_end(scan->sweep));
    scan->sweep = NULL;
}

bool scan_step(struct scan *scan)
{
    if (scan == NULL || scan->sweep == NULL) {
        return false;
    }
    if (sweep_step(scan->sweep)) {
        return true;
    }
    tell(scan);
    end_sweep(scan);
    return false;
}

static void *run(void *argument)
{
    struct scan *scan = argument;
    while (!stage_is_closing(scan->options.stage) && scan_step(scan)) {
    }
    return NULL;
}

static int start(struct scan *scan, lum_error *error)
{
    scan->gate = gate_new();
    if (scan->gate == NULL) {
        return lum_error_set(error, "out of memory");
    }
    scan->sweep = sweep_new(scan->captures, &scan->options, INT64_MAX);
    return thread_exists() ? thread_start(&scan->thread, run, scan, error) : 0;
}

int scan_start(const struct captures *captures,
               const struct provenance_source *said,
               const struct decoder_options *decoder, struct scan **out,
               lum_error *error)
{
    struct scan *scan = calloc(1, sizeof *scan);
    if (scan == NULL) {
        return lum_error_set(error, "out of memory");
    }
    scan->captures = captures;
    scan->said = said;
    scan->options = *decoder;
    if (start(scan, error) != 0) {
        scan_end(scan);
        return -1;
    }
    *out = scan;
    return 0;
}

void scan_end(struct scan *scan)
{
    if (scan == NULL) {
        return;
    }
    thread_join(scan->thread);
    end_sweep(scan);
    gate_free(scan->gate);
    free(scan);
}

bool scan_range(struct scan *scan, int64_t *first, int64_t *last)
{
    gate_take(scan->gate);
    const bool is_known = scan->is_known;
    *first = scan->first;
    *last = scan->last;
    gate_leave(scan->gate);
    return is_known;
}
