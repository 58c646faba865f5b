#include "cloud.h"

#include "packets.h"

#include <stdlib.h>
#include <string.h>

/* docs/protocol.md, section 6: "Reassembly". */
#define PIXELS     1000u
#define OPEN_LINES 4u
#define REACH      8
#define GAP_US     INT64_C(100000)
#define SPAN_US    INT64_C(2000)
#define WORDS      16384u

#define GROUP 24u
#define BIT_M 0.00195 /* section 7: a bit of the time of flight */

typedef struct line {
    int64_t number, clock_us, low_us;
    unsigned accepted;
    int64_t frame;
    bool has_angle[PIXELS], has_word[PIXELS];
    unsigned angles, held, end, count;
    uint32_t words[WORDS];
} line;

typedef struct closed {
    int64_t number, clock_us;
} closed;

typedef struct eye {
    bool has_newest, has_candidate, has_low, is_broken, has_frame, has_wrapped;
    int64_t newest_us, candidate_us, low_us;
    line *open[OPEN_LINES];
    unsigned open_count;
    closed closed[REACH];
    unsigned closed_count;
    int64_t frame, top, previous_top, gap, since_wrap;
} eye;

typedef struct packet {
    unsigned tag, eye, count, first;
    int64_t line;
    uint32_t raw_clock;
    const uint8_t *samples;
} packet;

typedef struct model {
    struct cloud *out;
    bool has_clock;
    int64_t clock_us;
    uint32_t raw_clock;
    eye eyes[2];
    bool *frames; /* that had a line; from FRAMES_BELOW below 0 */
    bool is_beyond;
} model;

#define FRAMES       100000
#define FRAMES_BELOW 8

static void *must(void *memory)
{
    if (memory == NULL) {
        abort();
    }
    return memory;
}

/* --- A line that closes --- */

static void take_word(model *m, const line *l, uint32_t word)
{
    const uint32_t raw = word >> 12;
    const int32_t flight =
        (int32_t)raw - ((raw & 0x80000u) != 0 ? 0x100000 : 0);
    if (!l->has_angle[word & 0x3ffu]) {
        m->out->no_angle++;
    } else if (flight <= 0) {
        m->out->no_range++;
    } else if ((word & 0x400u) != 0) { /* a rising edge */
        m->out->points++;
        m->out->range_m += flight * BIT_M;
    }
}

static void note_frame(model *m, int64_t frame)
{
    const int64_t at = frame + FRAMES_BELOW;
    if (at < 0 || at >= FRAMES) {
        m->is_beyond = true;
    } else if (!m->frames[at]) {
        m->frames[at] = true;
        m->out->frames++;
    }
}

static void close_first(model *m, eye *e)
{
    line *l = e->open[0];
    e->open_count--;
    memmove(e->open, e->open + 1, e->open_count * sizeof(line *));
    if (e->closed_count == REACH) {
        memmove(e->closed, e->closed + 1, (REACH - 1) * sizeof e->closed[0]);
        e->closed_count--;
    }
    e->closed[e->closed_count++] = (closed){l->number, l->clock_us};
    if (l->accepted >= 2) {
        e->low_us = e->has_low && e->low_us > l->low_us ? e->low_us : l->low_us;
        e->has_low = true;
    } else {
        l->frame = e->has_frame ? e->frame : 1;
    }
    m->out->lines++;
    m->out->missing_angles += l->angles < PIXELS ? 1 : 0;
    m->out->words += l->count;
    m->out->lost_words += l->end > l->held ? l->end - l->held : 0;
    note_frame(m, l->frame);
    for (unsigned i = 0; i < l->count; i++) {
        take_word(m, l, l->words[i]);
    }
    free(l);
}

/* --- Frames --- */

static void new_frame(model *m, eye *e, const eye *other, int64_t l,
                      int64_t gap)
{
    m->out->skipped += (uint64_t)e->gap;
    e->frame++;
    if (other->has_frame && llabs(l - other->top) <= REACH &&
        e->frame < other->frame) {
        e->frame = other->frame;
    }
    e->top = l;
    e->gap = gap;
}

static int64_t first_frame(eye *e, const eye *other, int64_t l)
{
    const int64_t o = other->top;
    e->has_frame = true;
    e->is_broken = false;
    e->frame = !other->has_frame       ? 1
               : llabs(l - o) <= REACH ? other->frame
               : l > o                 ? other->frame - 1
                                       : other->frame + 1;
    e->top = l;
    return e->frame;
}

static bool is_straggler(eye *e, int64_t l)
{
    if (!e->has_wrapped) {
        return false;
    }
    e->since_wrap++;
    return l > e->top + REACH && e->since_wrap < REACH &&
           l >= e->previous_top - REACH;
}

static int64_t decide_frame(model *m, unsigned which, int64_t l)
{
    eye *e = &m->eyes[which];
    const eye *other = &m->eyes[1 - which];
    const bool is_close = other->has_frame && llabs(l - other->top) <= REACH;
    if (!e->has_frame) {
        return first_frame(e, other, l);
    }
    if (e->is_broken) {
        e->is_broken = false;
        new_frame(m, e, other, l, 0);
        e->has_wrapped = false;
        return e->frame;
    }
    if (l < e->top - REACH || (is_close && other->frame > e->frame)) {
        e->previous_top = e->top;
        new_frame(m, e, other, l, l);
        e->has_wrapped = true;
        e->since_wrap = 0;
        return e->frame;
    }
    if (is_straggler(e, l)) {
        return e->frame - 1;
    }
    if (l > e->top) {
        e->gap += l - e->top - 1;
        e->top = l;
    } else if (l < e->top && e->gap > 0) {
        e->gap--;
    }
    return e->frame;
}

/* --- A packet and its line --- */

/* Rule 2; false: a stray. */
static bool is_near(model *m, eye *e, int64_t clock_us)
{
    if (!e->has_newest || llabs(clock_us - e->newest_us) <= GAP_US) {
        e->newest_us =
            !e->has_newest || clock_us > e->newest_us ? clock_us : e->newest_us;
        e->has_candidate = e->has_newest ? false : e->has_candidate;
        e->has_newest = true;
        return true;
    }
    if (!e->has_candidate || llabs(clock_us - e->candidate_us) > GAP_US) {
        e->has_candidate = true;
        e->candidate_us = clock_us;
        return false;
    }
    while (e->open_count > 0) {
        close_first(m, e);
    }
    e->closed_count = 0;
    e->has_low = false;
    e->newest_us = clock_us;
    e->is_broken = true;
    e->has_candidate = false;
    return true;
}

static bool is_late(const eye *e, int64_t number, int64_t clock_us)
{
    for (unsigned i = 0; i < e->closed_count; i++) {
        if (e->closed[i].number == number &&
            llabs(clock_us - e->closed[i].clock_us) <= SPAN_US) {
            return true;
        }
    }
    return e->has_low && clock_us < e->low_us;
}

static line *open_line(eye *e, int64_t number, int64_t clock_us)
{
    line *l = must(calloc(1, sizeof *l));
    l->number = number;
    l->clock_us = clock_us;
    e->open[e->open_count++] = l;
    return l;
}

/* Rule 3; NULL: the packet is late. */
static line *line_of(model *m, eye *e, const packet *p, int64_t clock_us)
{
    unsigned at = 0;
    while (at < e->open_count && e->open[at]->number != p->line) {
        at++;
    }
    if (at == e->open_count) {
        if (is_late(e, p->line, clock_us)) {
            return NULL;
        }
        if (e->open_count == OPEN_LINES) {
            close_first(m, e);
        }
        return open_line(e, p->line, clock_us);
    }
    if (llabs(clock_us - e->open[at]->clock_us) <= SPAN_US) {
        return e->open[at];
    }
    if (clock_us < e->open[at]->clock_us) {
        return NULL;
    }
    for (unsigned i = 0; i <= at; i++) {
        close_first(m, e);
    }
    return open_line(e, p->line, clock_us);
}

/* How many of a packet's pixels a line has already. */
struct known {
    unsigned old, all;
};

static bool is_doubled(model *m, struct known k)
{
    const bool is_all = k.all > 0 && k.old == k.all;
    m->out->duplicate += is_all ? 1 : 0;
    m->out->conflict += !is_all && k.old > 0 ? 1 : 0;
    return k.old > 0;
}

static bool put_angles(model *m, line *l, const packet *p)
{
    struct known k = {0, p->count};
    for (unsigned i = 0; i < p->count; i++) {
        k.old += l->has_angle[p->first + i] ? 1 : 0;
    }
    if (is_doubled(m, k)) {
        return false;
    }
    for (unsigned i = 0; i < p->count; i++) {
        l->has_angle[p->first + i] = true;
    }
    l->angles += p->count;
    return true;
}

static bool is_good(uint32_t word)
{
    return (word & 0x800u) == 0 && (word & 0x3ffu) < PIXELS;
}

static bool put_words(model *m, line *l, const packet *p)
{
    struct known k = {0, 0};
    for (unsigned i = 0; i < p->count; i++) {
        const uint32_t word = packets_u32(p->samples + (size_t)4 * i);
        k.all += is_good(word) ? 1 : 0;
        k.old += is_good(word) && l->has_word[word & 0x3ffu] ? 1 : 0;
    }
    if (is_doubled(m, k)) {
        return false;
    }
    if (l->count + k.all > WORDS) {
        m->is_beyond = true;
        return false;
    }
    for (unsigned i = 0; i < p->count; i++) {
        const uint32_t word = packets_u32(p->samples + (size_t)4 * i);
        if (is_good(word)) {
            l->has_word[word & 0x3ffu] = true;
            l->words[l->count++] = word;
        }
    }
    l->held += p->count;
    m->out->bad_words += p->count - k.all;
    const unsigned end = p->first + p->count;
    l->end = end <= WORDS && end > l->end ? end : l->end;
    return true;
}

static void take_packet(model *m, const packet *p)
{
    eye *e = &m->eyes[p->eye];
    const int64_t clock_us =
        m->has_clock ? m->clock_us + (int32_t)(p->raw_clock - m->raw_clock)
                     : (int64_t)p->raw_clock;
    m->out->angle_packets += p->tag == 2 ? 1 : 0;
    m->out->range_packets += p->tag == 3 ? 1 : 0;
    if (!is_near(m, e, clock_us)) {
        m->out->stray++;
        return;
    }
    m->has_clock = true;
    m->clock_us = clock_us;
    m->raw_clock = p->raw_clock;
    line *l = line_of(m, e, p, clock_us);
    if (l == NULL) {
        m->out->late++;
    } else if (p->tag == 2 ? put_angles(m, l, p) : put_words(m, l, p)) {
        l->low_us =
            l->accepted == 0 || clock_us < l->low_us ? clock_us : l->low_us;
        if (++l->accepted == 2) {
            l->frame = decide_frame(m, p->eye, l->number);
        }
    }
}

/* --- A datagram --- */

static void take_bytes(model *m, const uint8_t *at, size_t len)
{
    static const uint8_t begin[] = {0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe,
                                    0x34, 0x12, 8,    0,    0,    0};
    if (len <= sizeof begin || memcmp(at, begin, sizeof begin) != 0) {
        return;
    }
    const size_t count = len >= GROUP ? packets_u16(at + 16) : 0;
    if (count == 0 || len < GROUP + 4 * count || at[13] > 1) {
        m->out->malformed++;
        return;
    }
    const packet p = {at[12],
                      at[13],
                      (unsigned)count,
                      packets_u16(at + 18),
                      packets_u16(at + 14),
                      packets_u32(at + 20),
                      at + GROUP};
    if (p.tag == 2 && p.first + p.count > PIXELS) {
        m->out->malformed++;
    } else if (p.tag == 2 || p.tag == 3) {
        m->out->data++;
        take_packet(m, &p);
    }
}

static void end(model *m)
{
    for (unsigned i = 0; i < 2; i++) {
        while (m->eyes[i].open_count > 0) {
            close_first(m, &m->eyes[i]);
        }
        m->out->skipped += (uint64_t)m->eyes[i].gap;
    }
}

bool cloud_of(const record_tool *tool, uint64_t datagrams, struct cloud *out)
{
    model m = {.out = out};
    const uint8_t *at = tool->kept;
    memset(out, 0, sizeof *out);
    if (tool->is_too_much || tool->kept_count < datagrams) {
        return false;
    }
    m.frames = must(calloc(FRAMES, sizeof *m.frames));
    for (uint64_t i = 0; i < datagrams; i++) {
        const size_t len = packets_u32(at);
        take_bytes(&m, at + 4, len);
        at += 4 + len;
    }
    end(&m);
    free(m.frames);
    return !m.is_beyond;
}
