/* A source and a framer: frames or lines out, with the flush. */
#include "reader_internal.h"

#include "base/sized.h"
#include "capture/capture_internal.h"
#include "capture/demux_state.h"
#include "framer_state.h"

#include <stdlib.h>

/* Bytes of payload that take a fraction of a millisecond; reading a clock for
 * each record would take longer than the record. A record counts as at least so
 * many. */
#define WORK_BYTES   65536u
#define RECORD_BYTES 512u

static unsigned count_given(const lum_reader_options *o)
{
    return (o->path != NULL ? 1u : 0u) + (o->source != NULL ? 1u : 0u) +
           (o->records != NULL ? 1u : 0u) + (o->path_count != 0 ? 1u : 0u);
}

/* --- Opening --- */

/* A source that asks and is told no ends the reading too. */
static bool ask(void *context)
{
    lum_reader *r = context;
    return lum_go_on_ask(&r->go_on);
}

/* Records of the caller may come slowly, so each is looked at. */
static void begin_records(lum_reader *r)
{
    r->work_bytes = 0;
    if (r->source.set_go_on != NULL && r->go_on.function != NULL) {
        r->source.set_go_on(r->source.context, ask, r);
    }
}

static int open_framer(lum_reader *r, const lum_reader_options *o,
                       lum_error *error)
{
    lum_framer_options options = {.struct_size = sizeof options};
    if (o->framer != NULL && lum_sized_take(&options, sizeof options, o->framer,
                                            "the framer's options",
                                            "lum_framer_options", error) != 0) {
        return -1;
    }
    /* a capture has taken them apart */
    options.records_are_single |= o->records == NULL;
    return lum_framer_new(&options, &r->framer, error);
}

static bool has_stopped(const lum_reader *r)
{
    return r->go_on.has_stopped;
}

/* The caller's source of bytes is taken over, also on failure. */
static int open_all(lum_reader *r, const lum_reader_options *o,
                    lum_error *error)
{
    r->go_on = (lum_go_on){.function = o->go_on, .context = o->go_on_context};
    if (count_given(o) != 1u || !lum_go_on_ask(&r->go_on)) {
        lum_source_close(o->source);
        return has_stopped(r)
                   ? lum_go_on_fail(error)
                   : lum_error_set(error, "a reader needs one source: a path, "
                                          "paths, bytes or records");
    }
    r->work_bytes = WORK_BYTES;
    if (o->records != NULL) {
        begin_records(r);
    } else if (lum_reader_open_source(r, o, error) != 0) {
        return has_stopped(r) ? lum_go_on_fail(error) : -1;
    }
    r->place.keeps_index = o->keeps_index && r->capture != NULL &&
                           lum_capture_can_seek(r->capture);
    return open_framer(r, o, error);
}

int lum_reader_open(const lum_reader_options *options, lum_reader **out,
                    lum_error *error)
{
    lum_reader_options o;
    lum_record_source source = {.struct_size = sizeof source};
    *out = NULL;
    if (lum_sized_take(&o, sizeof o, options, "the reader's options",
                       "lum_reader_options", error) != 0) {
        return -1;
    }
    if (o.records != NULL && lum_sized_take(&source, sizeof source, o.records,
                                            "the source of records",
                                            "lum_record_source", error) != 0) {
        lum_source_close(o.source);
        return -1;
    }
    lum_reader *r = calloc(1, sizeof *r);
    if (r == NULL) {
        lum_source_close(o.source);
        if (source.close != NULL) {
            source.close(source.context);
        }
        return lum_error_set(error, "out of memory");
    }
    r->source = source;
    if (open_all(r, &o, error) != 0) {
        lum_reader_close(r);
        return -1;
    }
    *out = r;
    return 0;
}

void lum_reader_close(lum_reader *reader)
{
    if (reader == NULL) {
        return;
    }
    lum_reader_close_source(reader);
    lum_place_free(&reader->place);
    lum_framer_free(reader->framer);
    free(reader);
}

/* --- Reading --- */

/* At its end a source may have given up fragments, which are counted too; a
 * source that reports none has given up none. */
static void read_record(lum_reader *r)
{
    if (lum_place_approach(r, &r->error) != 0) {
        r->status = -1;
        r->stage = ENDED;
        return;
    }
    lum_record *record = &r->record;
    record->dropped_fragments = 0;
    const int status = r->source.next(r->source.context, record, &r->error);
    if (r->capture != NULL) {
        lum_framer_set_interface(r->framer, lum_capture_interface(r->capture));
    }
    r->stage = PUSHING;
    lum_demux_set_record(lum_framer_sensors(r->framer), ++r->place.records);
    if (status <= 0) {
        const uint32_t dropped = record->dropped_fragments;
        *record = (lum_record){.kind = LUM_RECORD_FRAGMENT,
                               .dropped_fragments = dropped};
        r->status = status;
        r->stage = FLUSHING;
    }
}

/* Whoever says no ends the reading at once: what is under way is dropped. */
static bool goes_on(lum_reader *r)
{
    const size_t bytes = r->record.len;
    r->work += bytes > RECORD_BYTES ? bytes : RECORD_BYTES;
    if (r->work >= r->work_bytes) {
        r->work = 0;
        return lum_go_on_ask(&r->go_on);
    }
    return !has_stopped(r);
}

static lum_framer_event push(lum_reader *r)
{
    const lum_framer_event event = lum_framer_push(r->framer, &r->record, NULL);
    if (event == LUM_FRAMER_NONE) {
        r->stage = READING;
        lum_index_entries_note_record(r);
    }
    return event;
}

static lum_framer_event flush(lum_reader *r)
{
    const lum_framer_event event = lum_framer_flush(r->framer);
    if (event == LUM_FRAMER_NONE) {
        r->stage = ENDED;
        lum_index_entries_note_end(r);
    }
    return event;
}

/* LUM_FRAMER_NONE: go on. */
static lum_framer_event step(lum_reader *r)
{
    switch (r->stage) {
    case READING:
        read_record(r);
        return r->stage == FLUSHING
                   ? lum_framer_push(r->framer, &r->record, NULL)
                   : LUM_FRAMER_NONE;
    case PUSHING:
        return push(r);
    case FLUSHING:
        return flush(r);
    case ENDED:
    default:
        return LUM_FRAMER_NONE;
    }
}

/* --- Events --- */

static lum_framer_event next_event(lum_reader *r)
{
    lum_framer_event e = LUM_FRAMER_NONE;
    while (e == LUM_FRAMER_NONE && r->stage != ENDED && goes_on(r)) {
        e = step(r);
        if (e != LUM_FRAMER_NONE && !lum_seek_shows(r, e)) {
            e = LUM_FRAMER_NONE;
        }
    }
    return e;
}

int lum_reader_next(lum_reader *reader, lum_framer_event *event,
                    lum_error *error)
{
    lum_place_begin(reader);
    const lum_framer_event e = next_event(reader);
    if (has_stopped(reader)) {
        return lum_go_on_fail(error);
    }
    if (e == LUM_FRAMER_FAILED) {
        return lum_error_set(error, "out of memory");
    }
    if (e != LUM_FRAMER_NONE) {
        *event = e;
        return 1;
    }
    return reader->status < 0 ? lum_error_set(error, "%s", reader->error.text)
                              : 0;
}

int lum_reader_next_frame(lum_reader *reader, const lum_frame **out,
                          lum_error *error)
{
    lum_framer_event event = LUM_FRAMER_NONE;
    int status = 0;
    while ((status = lum_reader_next(reader, &event, error)) > 0) {
        if (event == LUM_FRAMER_FRAME) {
            *out = lum_framer_frame(reader->framer, 0);
            return 1;
        }
    }
    return status;
}

lum_framer *lum_reader_framer(lum_reader *reader)
{
    return reader->framer;
}

void lum_reader_progress(const lum_reader *reader, uint64_t *done,
                         uint64_t *total)
{
    *done = 0;
    *total = 0;
    if (reader->source.progress != NULL) {
        reader->source.progress(reader->source.context, done, total);
    }
}

bool lum_reader_remark(const lum_reader *reader, size_t i, lum_error *out)
{
    return lum_capture_remark(reader->capture, lum_framer_demux(reader->framer),
                              0, i, out);
}

uint64_t lum_reader_damaged(const lum_reader *reader, lum_error *error)
{
    return reader->capture != NULL ? lum_capture_damaged(reader->capture, error)
                                   : 0;
}
