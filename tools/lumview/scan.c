/* Reads captures once before they are played: the range of their frames, what
 * is odd in them, how their sensors' clocks run. */
#define _POSIX_C_SOURCE 200809L
#include "scan.h"

#include "thread.h"

#include <stdlib.h>

/* Records between looks at whether to end. */
#define RECORDS_A_LOOK 64u

struct scan {
    const struct captures *captures;
    const struct provenance_source *said;
    struct decoder_options options;
    pthread_t thread;

    pthread_mutex_t lock; /* guards what follows */
    bool is_known;
    int64_t first;
    int64_t last;
};

/* Give a decoder the records of the first span_ns, or all: INT64_MAX. False: it
 * was stopped. The player reports read errors. */
static bool read_records(const struct captures *captures, lum_capture *capture,
                         int64_t span_ns, struct stage *stage,
                         struct decoder *decoder)
{
    lum_record record;
    int64_t end_ns = INT64_MAX;
    bool goes_on = true;
    for (uint64_t i = 0;
         goes_on && captures_next(captures, capture, &record, NULL) > 0; i++) {
        if (i == 0 && span_ns != INT64_MAX) {
            end_ns = add_clamped(record.time_ns, span_ns);
        }
        decoder_set_interface(decoder, lum_capture_interface(capture));
        goes_on = record.time_ns <= end_ns &&
                  (i % RECORDS_A_LOOK != 0 || !stage_is_closing(stage)) &&
                  decoder_push(decoder, &record) == DECODED_ALL;
    }
    return goes_on;
}

static void note(struct scan *scan, const struct decoder *decoder)
{
    int64_t first = 0;
    int64_t last = 0;
    if (!decoder_range(decoder, &first, &last)) {
        return;
    }
    (void)pthread_mutex_lock(&scan->lock);
    scan->is_known = true;
    scan->first = first;
    scan->last = last;
    (void)pthread_mutex_unlock(&scan->lock);
    stage_set_range(scan->options.stage, first, last);
}

static void *run(void *argument)
{
    struct scan *scan = argument;
    lum_capture *capture = NULL;
    struct stage *stage = scan->options.stage;
    struct decoder *decoder = decoder_new(&scan->options);
    if (decoder != NULL && captures_open(scan->captures, &capture, NULL) == 0) {
        decoder_skip_to(decoder, INT64_MAX);
        if (read_records(scan->captures, capture, INT64_MAX, stage, decoder) &&
            decoder_flush(decoder) == DECODED_ALL) {
            note(scan, decoder);
            captures_tell(scan->captures, capture, decoder_demux(decoder),
                          scan->said, stage);
            captures_warn(scan->captures, capture, decoder_demux(decoder));
        }
    }
    lum_capture_close(capture);
    decoder_free(decoder);
    return NULL;
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
    scan->options.second_layout = NULL; /* the first tells the time */
    (void)pthread_mutex_init(&scan->lock, NULL);
    if (thread_start(&scan->thread, run, scan, error) != 0) {
        (void)pthread_mutex_destroy(&scan->lock);
        free(scan);
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
    (void)pthread_join(scan->thread, NULL);
    (void)pthread_mutex_destroy(&scan->lock);
    free(scan);
}

bool scan_range(struct scan *scan, int64_t *first, int64_t *last)
{
    (void)pthread_mutex_lock(&scan->lock);
    const bool is_known = scan->is_known;
    *first = scan->first;
    *last = scan->last;
    (void)pthread_mutex_unlock(&scan->lock);
    return is_known;
}

struct decoder *scan_learn(const struct captures *captures,
                           const struct decoder_options *options)
{
    lum_capture *capture = NULL;
    struct decoder *learned = NULL;
    struct decoder_options alone = *options;
    alone.second_layout = NULL;
    if (captures_are_files(captures) &&
        captures_open(captures, &capture, NULL) == 0) {
        learned = decoder_new(&alone);
    }
    if (learned != NULL) {
        decoder_skip_to(learned, INT64_MAX);
        (void)read_records(captures, capture, SOURCES_LEARN_NS, options->stage,
                           learned);
    }
    lum_capture_close(capture);
    return learned;
}
