/* Reads captures once before they are played: the range of their frames, where
 * these are, what is odd in them, how their sensors' clocks run. */
#include "capture_scan.h"

#include "capture/capture_internal.h"
#include "frame/framer_state.h"
#include "frame/reader_internal.h"
#include "thread_monitor.h"

#include <stdlib.h>

/* Records of a step. */
#define RECORDS_A_STEP 64u

/* Until whoever waits looks whether to end. */
#define PATIENCE_NS INT64_C(100000000)

/* The sensor that is shown, as no other gives frames. */
#define SENSOR 0u

/* What the next step is about. */
enum phase {
    PHASE_LEARNING, /* the beginning is read */
    PHASE_READING,  /* all is read */
    PHASE_OVER
};

struct scan {
    const struct captures *captures;
    const struct provenance_source *said;
    struct decoder_options options;
    struct thread *thread; /* NULL: there are none */

    /* of who takes the steps */
    enum phase phase;
    lum_capture *capture;
    struct decoder *decoder;
    bool has_begun;
    int64_t end_ns; /* later records are not read */

    struct monitor *monitor; /* guards what follows; news: it has learned */
    struct decoder *learned;
    bool has_learned;
    lum_reader *places; /* NULL: nobody knows where frames are */
    bool has_range;
    int64_t first;
    int64_t last;
};

/* --- Where frames are --- */

/* They are noted while a capture is read once: of one file that is not
 * compressed, with one sensor shown by one profile; all else is read from the
 * start. A reader of the library keeps the index and jumps; records are read
 * and pushed by others here, so it has neither of its own. */

static lum_reader *places_new(lum_capture *capture, struct decoder *decoder)
{
    lum_framer *framer = decoder_framer(decoder);
    lum_reader *r = framer != NULL ? calloc(1, sizeof *r) : NULL;
    if (r != NULL) {
        r->capture = capture;
        r->framer = framer;
        r->place.keeps_index = true;
        lum_place_begin(r);
    }
    return r;
}

static void places_free(lum_reader *places)
{
    if (places != NULL) {
        lum_place_free(&places->place);
        free(places);
    }
}

static bool notes(const lum_reader *places)
{
    return places != NULL && places->place.keeps_index;
}

/* All was read, or no more will be: they are known from here on. */
static void places_end(lum_reader *places)
{
    if (places != NULL) {
        lum_index_entries_forget(&places->place.entries);
        places->place.keeps_index = false;
    }
}

static void places_note_frame(lum_reader *places)
{
    struct place *at = &places->place;
    const struct last_frame before = at->frames.last[SENSOR];
    lum_framer_get_lines(places->framer, SENSOR, at->frames.last[SENSOR].lines);
    lum_index_entries_finish(
        at, SENSOR, lum_framer_frame_number(places->framer), before.lines);
    at->index.frames = ++at->frames.order;
}

/* The one with which reading would begin to get to a frame; NULL: all must be
 * read. */
static const lum_index_entry *places_find(const lum_reader *places,
                                          int64_t frame)
{
    const lum_index *index = places != NULL ? &places->place.index : NULL;
    const lum_index_entry *entry =
        index != NULL ? lum_index_at_number(index, SENSOR, frame) : NULL;
    return entry != NULL && lum_index_is_certain(index, entry->after) ? entry
                                                                      : NULL;
}

/* Another sensor's data might have to be awaited, and that is not worth it. */
static bool jump(lum_reader *to, const lum_index_entry *entry)
{
    const bool is_there =
        lum_place_jump(to, entry, NULL) == 0 && to->place.jump.is_made &&
        lum_place_approach(to, NULL) == 0 && to->place.jump.is_made &&
        to->place.jump.awaited_next == to->place.jump.awaited_count;
    if (!is_there) {
        (void)lum_place_restart(to, NULL);
    }
    return is_there;
}

/* The index is lent: a jump drops it where it is of no use. */
static bool places_go(lum_reader *places, lum_capture *capture,
                      struct decoder *decoder, int64_t frame)
{
    const lum_index_entry *entry = places_find(places, frame);
    lum_reader *to = entry != NULL ? places_new(capture, decoder) : NULL;
    if (!notes(to)) {
        places_free(to);
        return false;
    }
    lum_index *index = &places->place.index;
    const size_t entries = index->count;
    to->place.index = *index;
    const bool is_there = jump(to, entry);
    *index = to->place.index;
    to->place.index = (lum_index){.stride = 1};
    if (index->count < entries) {
        places_end(places);
    }
    places_free(to);
    return is_there;
}

/* --- Its readings --- */

/* False: they cannot be read, which the player tells. */
static bool begin(struct scan *s)
{
    s->has_begun = false;
    s->end_ns = INT64_MAX;
    if (captures_open(s->captures, NULL, &s->capture, NULL) == 0) {
        s->decoder = decoder_new(&s->options);
    }
    return s->decoder != NULL;
}

static void end(struct scan *s)
{
    lum_capture_close(s->capture);
    decoder_free(s->decoder);
    s->capture = NULL;
    s->decoder = NULL;
}

/* Where frames are is noted as by who plays, whose clocks are known. */
static void begin_all(struct scan *s)
{
    const bool can_read = begin(s) && (s->learned == NULL ||
                                       decoder_learn(s->decoder, s->learned));
    s->phase = can_read ? PHASE_READING : PHASE_OVER;
    if (can_read) {
        lum_reader *places = places_new(s->capture, s->decoder);
        monitor_lock(s->monitor);
        s->places = places;
        monitor_unlock(s->monitor);
    }
}

static void begin_learning(struct scan *s)
{
    if (begin(s)) {
        decoder_skip_to(s->decoder, INT64_MAX);
    } else {
        s->phase = PHASE_OVER;
    }
}

/* The player may take it from here on. */
static void end_learning(struct scan *s)
{
    monitor_lock(s->monitor);
    s->learned = s->decoder;
    s->has_learned = true;
    monitor_notify(s->monitor);
    monitor_unlock(s->monitor);
    s->decoder = NULL;
    end(s);
}

/* --- Records --- */

static void begin_record(struct scan *s)
{
    monitor_lock(s->monitor);
    if (notes(s->places)) {
        lum_demux_set_record(lum_framer_sensors(s->places->framer),
                             ++s->places->place.records);
    }
    monitor_unlock(s->monitor);
}

static void note_record(struct scan *s)
{
    monitor_lock(s->monitor);
    if (notes(s->places)) {
        lum_index_entries_note_record(s->places);
    }
    monitor_unlock(s->monitor);
}

static void note_frame(struct scan *s)
{
    const struct picture *picture = decoder_picture(s->decoder);
    const struct feed_loss *loss = &picture->loss;
    monitor_lock(s->monitor);
    if (notes(s->places)) {
        places_note_frame(s->places);
    }
    monitor_unlock(s->monitor);
    if (loss->words > 0 || loss->lines > 0 || loss->pauses > 0) {
        stage_mark(s->options.stage, picture->frame, loss);
    }
}

/* record: NULL at the end. False: there was no memory. */
static bool push(struct scan *s, const lum_record *record)
{
    enum decoded decoded = DECODED_ALL;
    do {
        decoded = record != NULL ? decoder_push(s->decoder, record)
                                 : decoder_flush(s->decoder);
        if (decoded == DECODED_FRAME) {
            note_frame(s);
        }
    } while (decoded == DECODED_FRAME);
    return decoded == DECODED_ALL;
}

/* 1: a record was read; 0: there are no more, or none that is wanted; -1: there
 * was no memory. The player reports read errors. */
static int read_record(struct scan *s)
{
    lum_record record;
    if (lum_capture_next(s->capture, &record, NULL) <= 0) {
        return 0;
    }
    if (!s->has_begun && s->phase == PHASE_LEARNING) {
        s->end_ns = add_clamped(record.time_ns, SOURCES_LEARN_NS);
    }
    s->has_begun = true;
    if (record.time_ns > s->end_ns) {
        return 0;
    }
    decoder_set_interface(s->decoder, lum_capture_interface(s->capture));
    begin_record(s);
    if (!push(s, &record)) {
        return -1;
    }
    note_record(s);
    return 1;
}

/* --- What it tells --- */

static void note_range(struct scan *s)
{
    int64_t first = 0;
    int64_t last = 0;
    if (!decoder_range(s->decoder, &first, &last)) {
        return;
    }
    monitor_lock(s->monitor);
    s->has_range = true;
    s->first = first;
    s->last = last;
    monitor_unlock(s->monitor);
    stage_set_range(s->options.stage, first, last);
}

static void note_progress(struct scan *s)
{
    uint64_t done = 0;
    uint64_t total = 0;
    lum_capture_progress(s->capture, &done, &total);
    if (total > 0) {
        stage_set_scanned(s->options.stage, (double)done / (double)total);
    }
}

static void end_all(struct scan *s, bool is_whole)
{
    stage_set_scanned(s->options.stage, 1);
    if (is_whole && push(s, NULL)) {
        note_range(s);
        captures_tell(s->captures, s->capture, decoder_demux(s->decoder),
                      s->said, s->options.stage);
        captures_warn(s->captures, s->capture, decoder_demux(s->decoder));
    }
    monitor_lock(s->monitor);
    places_end(s->places);
    monitor_unlock(s->monitor);
    end(s);
    s->phase = PHASE_OVER;
}

/* --- Who takes the steps --- */

bool scan_step(struct scan *scan)
{
    int status = 1;
    if (scan == NULL || scan->phase == PHASE_OVER) {
        return false;
    }
    for (unsigned i = 0; i < RECORDS_A_STEP && status > 0; i++) {
        status = read_record(scan);
    }
    if (status <= 0 && scan->phase == PHASE_LEARNING) {
        end_learning(scan);
        begin_all(scan);
    } else if (status <= 0) {
        end_all(scan, status == 0);
    } else if (scan->phase == PHASE_READING) {
        note_progress(scan);
    }
    return scan->phase != PHASE_OVER;
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
    scan->monitor = monitor_new();
    if (scan->monitor == NULL) {
        return lum_error_set(error, "out of memory");
    }
    begin_learning(scan);
    scan->has_learned = scan->phase == PHASE_OVER;
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
    scan->options.second_layout = NULL; /* the first tells the time */
    scan->options.makes_no_points = true;
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
    end(scan);
    decoder_free(scan->learned);
    places_free(scan->places);
    monitor_free(scan->monitor);
    free(scan);
}

/* --- For others --- */

bool scan_learn(struct scan *scan, const struct decoder **out)
{
    if (scan->thread == NULL && !scan->has_learned) {
        (void)scan_step(scan);
    }
    monitor_lock(scan->monitor);
    if (!scan->has_learned) {
        (void)monitor_wait(scan->monitor, PATIENCE_NS);
    }
    const bool has_learned = scan->has_learned;
    *out = scan->learned;
    monitor_unlock(scan->monitor);
    return has_learned;
}

bool scan_range(struct scan *scan, int64_t *first, int64_t *last)
{
    monitor_lock(scan->monitor);
    const bool has_range = scan->has_range;
    *first = scan->first;
    *last = scan->last;
    monitor_unlock(scan->monitor);
    return has_range;
}

bool scan_leads(struct scan *scan, int64_t frame, int64_t *begin)
{
    monitor_lock(scan->monitor);
    const lum_index_entry *entry = places_find(scan->places, frame);
    *begin = entry != NULL ? entry->number : 0;
    monitor_unlock(scan->monitor);
    return entry != NULL;
}

bool scan_go(struct scan *scan, lum_capture *capture, struct decoder *decoder,
             int64_t frame)
{
    monitor_lock(scan->monitor);
    const bool is_there = places_go(scan->places, capture, decoder, frame);
    monitor_unlock(scan->monitor);
    return is_there;
}

void scan_drop_places(struct scan *scan)
{
    monitor_lock(scan->monitor);
    places_end(scan->places);
    if (scan->places != NULL) {
        lum_index_clear(&scan->places->place.index);
    }
    monitor_unlock(scan->monitor);
}
