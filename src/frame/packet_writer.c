/* Packets of lines, in the order in which a sensor would have sent them, into a
 * capture; and what a reader makes of them. */
#include "lum/frame/packet_writer.h"

#include "packet_cut.h"

#include "base/grow.h"
#include "base/sized.h"
#include "capture/demux_state.h"
#include "lum/wire.h"

#include <stdlib.h>
#include <string.h>

#define CLIENT      0x0a2a0001u /* 10.42.0.1 */
#define CLIENT_PORT 50000u

/* Frames of a sensor that may overlap. */
#define FRAMES_KEPT 4u

/* A packet that waits for those before it. */
typedef struct waiting {
    uint64_t order;
    uint64_t sequence; /* in which it was added */
    uint64_t frame;    /* that it is of, by lum_packet_writer_end_frame() */
    int64_t arrival_ns;
    uint64_t ticks; /* of its clock, extended */
    size_t len;
    uint8_t bytes[];
} waiting;

typedef struct queue {
    waiting **at;
    size_t count;
    size_t room;
} queue;

/* Packets of a sensor whose order is known, or those where it is not. */
typedef struct stream {
    uint32_t sensor;
    bool has_order;
    queue fresh; /* of the frame that is being added */
    queue older;
    bool has_low;
    uint64_t low_order; /* of the first of the frame before */
    int64_t low_ns;
    int64_t newest_ns; /* of what was written */
    bool has_clock;
    int64_t clock_us; /* of the line before */
    bool has_ticks;   /* of its sensor: its first stream has them */
    uint64_t ticks;   /* of the packet before */
} stream;

#define STREAMS_MAX (2u * LUM_DEMUX_SENSORS_MAX)

struct lum_packet_writer {
    lum_layout layout;
    lum_capture_writer *file;
    lum_demux *reader;
    bool is_accepted; /* by the reader: the packet at hand */
    uint64_t strays;  /* of the reader */
    lum_cut cut;
    stream streams[STREAMS_MAX];
    size_t stream_count;
    uint64_t frame;
    uint64_t sequence;
    lum_packet_writer_counters counters;
};

/* --- Queues --- */

static bool push(queue *q, waiting *packet)
{
    waiting **at =
        lum_grown((void *)q->at, q->count, 1, sizeof(waiting *), &q->room);
    if (at == NULL) {
        return false;
    }
    q->at = at;
    q->at[q->count++] = packet;
    return true;
}

static void clear(queue *q)
{
    for (size_t i = 0; i < q->count; i++) {
        free(q->at[i]);
    }
    free(q->at);
    *q = (queue){NULL, 0, 0};
}

static int compare(uint64_t a, uint64_t b)
{
    return a < b ? -1 : a > b;
}

static int compare_order(const void *a, const void *b)
{
    const waiting *p = *(waiting *const *)a;
    const waiting *q = *(waiting *const *)b;
    return p->order != q->order ? compare(p->order, q->order)
                                : compare(p->sequence, q->sequence);
}

static int compare_arrival(const void *a, const void *b)
{
    const waiting *p = *(waiting *const *)a;
    const waiting *q = *(waiting *const *)b;
    return p->arrival_ns != q->arrival_ns
               ? (p->arrival_ns < q->arrival_ns ? -1 : 1)
               : compare(p->sequence, q->sequence);
}

static int compare_in(const stream *s, const waiting *a, const waiting *b)
{
    return s->has_order ? compare_order(&a, &b) : compare_arrival(&a, &b);
}

/* --- A packet into the file --- */

static void note_accepted(void *context, const lum_demux_taken *packet)
{
    lum_packet_writer *w = context;
    w->is_accepted = w->is_accepted || packet->result == LUM_OK;
}

/* What a reader makes of it. */
static int judge(lum_packet_writer *w, const lum_datagram *d, lum_error *error)
{
    const lum_record record = {.time_ns = d->time_ns,
                               .payload = d->payload,
                               .len = d->len,
                               .source = d->source,
                               .destination = d->destination,
                               .source_port = d->source_port,
                               .destination_port = d->destination_port,
                               .kind = LUM_RECORD_DATAGRAM};
    lum_result r = LUM_OK;
    w->is_accepted = false;
    do {
        r = lum_demux_push(w->reader, &record, NULL);
    } while (r > 0);
    return r == LUM_E_SPACE ? lum_error_set(error, "out of memory") : 0;
}

/* Returns its strays. */
static uint64_t count_dropped(lum_packet_writer *w)
{
    lum_demux_counters total = {.struct_size = sizeof total};
    lum_packet_writer_counters *c = &w->counters;
    (void)lum_demux_total(w->reader, &total);
    c->late = total.assembly.late;
    c->duplicate = total.assembly.duplicate;
    c->conflict = total.assembly.conflict;
    c->no_room = total.assembly.no_room;
    return total.assembly.stray;
}

/* The stream that has the clock of a stream's sensor. */
static stream *clock_of(lum_packet_writer *w, stream *s)
{
    for (size_t i = 0; i < w->stream_count; i++) {
        if (w->streams[i].sensor == s->sensor) {
            return &w->streams[i];
        }
    }
    return s;
}

/* A packet into the file. is_stray: whether a reader drops it as such. */
static int write_once(lum_packet_writer *w, const lum_datagram *d,
                      bool *is_stray, lum_error *error)
{
    if (judge(w, d, error) != 0) {
        return -1;
    }
    w->counters.packets++;
    *is_stray = false;
    if (!w->is_accepted) {
        const uint64_t strays = count_dropped(w);
        *is_stray = strays > w->strays;
        w->strays = strays;
    }
    return lum_capture_writer_add(w->file, d, error);
}

/* A reader takes a clock for the nearest that it can stand for. */
static void note_clock(lum_packet_writer *w, stream *clock, uint64_t ticks)
{
    if (clock->has_ticks &&
        lum_cut_extend(&w->layout, clock->ticks, ticks) != ticks) {
        w->counters.clock_jumps++;
    }
    clock->has_ticks = true;
    clock->ticks = ticks;
}

static int write_packet(lum_packet_writer *w, stream *s, const waiting *packet,
                        lum_error *error)
{
    const lum_datagram d = {.time_ns = packet->arrival_ns,
                            .payload = packet->bytes,
                            .len = packet->len,
                            .source = s->sensor,
                            .destination = CLIENT,
                            .source_port = LUM_PORT,
                            .destination_port = CLIENT_PORT};
    bool is_stray = false;
    int result = write_once(w, &d, &is_stray, error);
    if (result != 0) {
        return -1;
    }
    if (is_stray) { /* the second one may prove the jump */
        w->counters.repeated++;
        result = write_once(w, &d, &is_stray, error);
    }
    if (is_stray) {
        w->counters.stray++;
    } else {
        note_clock(w, clock_of(w, s), packet->ticks);
    }
    return result;
}

/* --- The order of packets --- */

/* Of all streams the one whose next packet came first. NULL: none is left. */
static stream *find_next(lum_packet_writer *w, const size_t *next)
{
    stream *best = NULL;
    int64_t best_ns = 0;
    for (size_t i = 0; i < w->stream_count; i++) {
        stream *s = &w->streams[i];
        if (next[i] == s->older.count) {
            continue;
        }
        const int64_t ns = s->older.at[next[i]]->arrival_ns;
        const int64_t at = ns > s->newest_ns ? ns : s->newest_ns;
        if (best == NULL || at < best_ns) {
            best = s;
            best_ns = at;
        }
    }
    if (best != NULL) {
        best->newest_ns = best_ns;
    }
    return best;
}

static void sort(stream *s)
{
    qsort(s->older.at, s->older.count, sizeof(waiting *),
          s->has_order ? compare_order : compare_arrival);
}

/* Packets of frames below one. */
static size_t count_below(const lum_packet_writer *w, uint64_t frame)
{
    size_t n = 0;
    for (size_t i = 0; i < w->stream_count; i++) {
        const queue *q = &w->streams[i].older;
        for (size_t k = 0; k < q->count; k++) {
            n += q->at[k]->frame < frame ? 1u : 0u;
        }
    }
    return n;
}

/* What was written goes; the rest moves down. */
static void drop_written(lum_packet_writer *w, const size_t *next)
{
    for (size_t i = 0; i < w->stream_count; i++) {
        queue *q = &w->streams[i].older;
        for (size_t k = 0; k < next[i]; k++) {
            free(q->at[k]);
        }
        q->count -= next[i];
        if (q->count > 0 && next[i] > 0) {
            memmove(q->at, q->at + next[i], q->count * sizeof(waiting *));
        }
    }
}

/* Write until no packet of a frame below this one is left. */
static int write_below(lum_packet_writer *w, uint64_t frame, lum_error *error)
{
    size_t next[STREAMS_MAX] = {0};
    size_t left = count_below(w, frame);
    int result = 0;
    for (size_t i = 0; i < w->stream_count; i++) {
        if (w->streams[i].older.count > 0) {
            sort(&w->streams[i]);
        }
    }
    while (left > 0 && result == 0) {
        stream *s = find_next(w, next);
        size_t *at = &next[s - w->streams];
        const waiting *packet = s->older.at[*at];
        result = write_packet(w, s, packet, error);
        if (result == 0) {
            left -= packet->frame < frame ? 1u : 0u;
            (*at)++;
        }
    }
    drop_written(w, next);
    return result;
}

/* --- A line --- */

static stream *stream_of(lum_packet_writer *w, uint32_t sensor, bool has_order)
{
    for (size_t i = 0; i < w->stream_count; i++) {
        stream *s = &w->streams[i];
        if (s->sensor == sensor && s->has_order == has_order) {
            return s;
        }
    }
    if (w->stream_count == STREAMS_MAX) {
        return NULL;
    }
    stream *s = &w->streams[w->stream_count++];
    s->sensor = sensor;
    s->has_order = has_order;
    s->newest_ns = INT64_MIN;
    return s;
}

static int add_packet(lum_packet_writer *w, stream *s, const lum_raw_line *line,
                      const lum_cut_packet *packet, lum_error *error)
{
    const size_t len = lum_cut_bytes(&w->layout, packet);
    const uint64_t line_ticks = lum_cut_ticks(&w->layout, line->clock_us);
    waiting *p = malloc(sizeof *p + len);
    if (p == NULL || !push(&s->fresh, p)) {
        free(p);
        return lum_error_set(error, "out of memory");
    }
    p->order = packet->head.order;
    p->arrival_ns = packet->head.arrival_ns;
    p->sequence = w->sequence++;
    p->frame = w->frame;
    p->ticks = lum_cut_extend(&w->layout, line_ticks, packet->head.clock_raw);
    p->len = len;
    return lum_cut_encode(&w->cut, &w->layout, line, packet, p->bytes, error);
}

static void drop_from(queue *q, size_t count)
{
    while (q->count > count) {
        free(q->at[--q->count]);
    }
}

static int add_line(lum_packet_writer *w, const lum_raw_line *line,
                    lum_error *error)
{
    const bool is_known = line->packet_count > 0;
    stream *s = stream_of(w, line->sensor, is_known);
    if (s == NULL) {
        return lum_error_set(error, "lines of more than %u sensors",
                             LUM_DEMUX_SENSORS_MAX);
    }
    if (lum_cut_line(&w->cut, &w->layout, line, error) != 0) {
        return -1;
    }
    lum_cut_move(&w->cut, &w->layout, line);
    if (lum_cut_check_time(&w->cut, line, error) != 0) {
        return -1;
    }
    const bool keeps_clock =
        !w->cut.is_anew && lum_cut_keeps_clock(&w->layout, line->layout);
    if (lum_cut_check_clock(&w->layout, line,
                            s->has_clock ? &s->clock_us : NULL, error) != 0) {
        return -1;
    }
    const size_t before = s->fresh.count;
    for (size_t i = 0; i < w->cut.count; i++) {
        lum_cut_packet *p = &w->cut.packets[i];
        if (!keeps_clock) {
            p->head.clock_raw = lum_cut_ticks(&w->layout, line->clock_us);
        }
        if (add_packet(w, s, line, p, error) != 0) {
            drop_from(&s->fresh, before);
            return -1;
        }
    }
    s->has_clock = true;
    s->clock_us = line->clock_us;
    w->counters.lines++;
    w->counters.lines_cut_anew += w->cut.is_anew ? 1u : 0u;
    return 0;
}

int lum_packet_writer_add(lum_packet_writer *writer, const lum_raw_line *line,
                          lum_error *error)
{
    lum_raw_line known;
    return lum_sized_take(&known, sizeof known, line, "a line", "lum_raw_line",
                          error) == 0
               ? add_line(writer, &known, error)
               : -1;
}

/* --- A frame --- */

/* Whether it begins before the one before it. */
static bool goes_back(stream *s)
{
    const waiting *low = s->fresh.count > 0 ? s->fresh.at[0] : NULL;
    for (size_t i = 1; i < s->fresh.count; i++) {
        low = compare_in(s, s->fresh.at[i], low) < 0 ? s->fresh.at[i] : low;
    }
    if (low == NULL) {
        return false;
    }
    const bool is_back =
        s->has_low && (s->has_order ? low->order < s->low_order
                                    : low->arrival_ns < s->low_ns);
    s->has_low = true;
    s->low_order = low->order;
    s->low_ns = low->arrival_ns;
    return is_back;
}

static bool take_fresh(stream *s)
{
    while (s->fresh.count > 0) {
        if (!push(&s->older, s->fresh.at[s->fresh.count - 1u])) {
            return false;
        }
        s->fresh.count--;
    }
    return true;
}

/* Streams begin anew: what was written says nothing of what comes. */
static int write_all(lum_packet_writer *w, lum_error *error)
{
    const int result = write_below(w, UINT64_MAX, error);
    for (size_t i = 0; i < w->stream_count; i++) {
        w->streams[i].newest_ns = INT64_MIN;
    }
    return result;
}

int lum_packet_writer_end_frame(lum_packet_writer *writer, lum_error *error)
{
    lum_packet_writer *w = writer;
    bool is_back = false;
    for (size_t i = 0; i < w->stream_count; i++) {
        is_back = goes_back(&w->streams[i]) || is_back;
    }
    if (is_back && write_all(w, error) != 0) {
        return -1;
    }
    for (size_t i = 0; i < w->stream_count; i++) {
        if (!take_fresh(&w->streams[i])) {
            return lum_error_set(error, "out of memory");
        }
    }
    w->frame++;
    const uint64_t kept = (uint64_t)FRAMES_KEPT * w->stream_count;
    return w->frame > kept ? write_below(w, w->frame - kept, error) : 0;
}

/* --- Begin and end --- */

static void release(lum_packet_writer *w)
{
    for (size_t i = 0; i < w->stream_count; i++) {
        clear(&w->streams[i].fresh);
        clear(&w->streams[i].older);
    }
    lum_demux_free(w->reader);
    lum_cut_free(&w->cut);
    free(w);
}

static int open_file(lum_packet_writer *w, const char *path,
                     const lum_packet_writer_options *o, lum_error *error)
{
    lum_capture_writer_options file = {.struct_size = sizeof file};
    lum_demux_options reader = {.struct_size = sizeof reader,
                                .layout = w->layout};
    lum_assembler_config_default(&reader.config);
    if (o->file != NULL &&
        lum_sized_take(&file, sizeof file, o->file,
                       "the capture writer's options",
                       "lum_capture_writer_options", error) != 0) {
        return -1;
    }
    file.is_whole = true;
    if (lum_demux_new(&reader, &w->reader, error) != 0) {
        return -1;
    }
    lum_demux_watch(w->reader, note_accepted, w);
    return lum_capture_writer_open_as(path, &file, &w->file, error);
}

int lum_packet_writer_open(const char *path,
                           const lum_packet_writer_options *options,
                           lum_packet_writer **out, lum_error *error)
{
    lum_packet_writer_options o;
    if (lum_sized_take(&o, sizeof o, options, "the packet writer's options",
                       "lum_packet_writer_options", error) != 0) {
        return -1;
    }
    lum_packet_writer *w = calloc(1, sizeof *w);
    if (w == NULL) {
        return lum_error_set(error, "%s: out of memory", path);
    }
    lum_layout_default(&w->layout);
    w->layout = o.layout != NULL ? *o.layout : w->layout;
    w->counters.struct_size = sizeof w->counters;
    if (open_file(w, path, &o, error) != 0) {
        release(w);
        return -1;
    }
    *out = w;
    return 0;
}

lum_result lum_packet_writer_count(const lum_packet_writer *writer,
                                   lum_packet_writer_counters *out)
{
    return lum_sized_fill(out, &writer->counters, sizeof writer->counters)
               ? LUM_OK
               : LUM_E_VALUE;
}

int lum_packet_writer_flush(lum_packet_writer *writer, lum_error *error)
{
    return lum_packet_writer_end_frame(writer, error) == 0
               ? write_all(writer, error)
               : -1;
}

int lum_packet_writer_close(lum_packet_writer *writer, lum_error *error)
{
    if (writer == NULL) {
        return 0;
    }
    if (lum_packet_writer_flush(writer, error) != 0) {
        lum_packet_writer_abort(writer);
        return -1;
    }
    lum_capture_writer *file = writer->file;
    release(writer);
    return lum_capture_writer_close(file, error);
}

void lum_packet_writer_abort(lum_packet_writer *writer)
{
    if (writer != NULL) {
        lum_capture_writer_abort(writer->file);
        release(writer);
    }
}
