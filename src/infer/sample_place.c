/* Angles and ranges by what they look like, and where samples begin. */
#include "fields.h"

#include <stdlib.h>
#include <string.h>

#define SAMPLE_BYTES 4u
#define PHASES       4u
#define ORDERS       2u

/* Fewer samples tell nothing about their kind. */
#define WORDS_MIN  6u
#define ANGLES_MIN 16u

/* Enough packets to tell the order and the place. */
#define TRIAL 2000u

/* Samples that tell their noise. */
#define NOISE 64u

/* A share of packets that loss, disorder and corruption leave, and that
 * nothing else reaches. */
#define MOST 0.85

/* The two values of an angle sample, and how they change. */
typedef struct series {
    int first;
    int last;
    int low;
    int high;
    int64_t path; /* sum of all steps, without their sign */
    int64_t bend; /* sum of what steps differ by, without sign */
} series;

/* --- What samples look like --- */

static unsigned read_16(const uint8_t *p, bool is_big)
{
    return is_big ? (unsigned)p[0] << 8 | p[1] : (unsigned)p[1] << 8 | p[0];
}

static int read_i16(const uint8_t *p, bool is_big)
{
    const int value = (int)read_16(p, is_big);
    return value < 0x8000 ? value : value - 0x10000;
}

static uint32_t read_word(const uint8_t *p, bool is_big)
{
    const uint32_t one = read_16(p, is_big);
    const uint32_t two = read_16(p + 2, is_big);
    return is_big ? one << 16 | two : two << 16 | one;
}

uint32_t lum_infer_room(const lum_infer_packet *packet, unsigned samples_at)
{
    return packet->len < samples_at ? 0
                                    : (packet->len - samples_at) / SAMPLE_BYTES;
}

/* Samples from an offset on that were kept. */
static size_t kept(const lum_infer_packet *packet, unsigned at)
{
    return packet->kept < at ? 0 : (packet->kept - at) / SAMPLE_BYTES;
}

static bool is_ranges(const lum_infer_packet *packet, unsigned at, bool is_big)
{
    const size_t n = kept(packet, at);
    size_t good = 0;
    size_t rising = 0;
    uint32_t before = 0;
    uint32_t first = 0;
    for (size_t i = 0; i < n; i++) {
        const uint32_t word =
            read_word(packet->bytes + at + SAMPLE_BYTES * i, is_big);
        const uint32_t pixel = word & 0x3ffu;
        good += (word & 0x800u) == 0 && pixel < LUM_LINE_PIXELS;
        rising += pixel >= before;
        first = i == 0 ? pixel : first;
        before = pixel;
    }
    return n >= WORDS_MIN && before > first && good * 100 >= n * 95 &&
           rising * 100 >= n * 95;
}

static void add(series *s, size_t i, int value, int *step)
{
    const int change = value - s->last;
    if (i == 0) {
        *s = (series){value, value, value, value, 0, 0};
        return;
    }
    s->path += abs(change);
    s->bend += i > 1 ? abs(change - *step) : 0;
    s->low = value < s->low ? value : s->low;
    s->high = value > s->high ? value : s->high;
    s->last = value;
    *step = change;
}

static size_t follow(const lum_infer_packet *packet, unsigned at, bool is_big,
                     size_t most, series out[2])
{
    const size_t all = kept(packet, at);
    const size_t n = all < most ? all : most;
    int step[2] = {0, 0};
    memset(out, 0, 2 * sizeof *out);
    for (size_t i = 0; i < n; i++) {
        const uint8_t *p = packet->bytes + at + SAMPLE_BYTES * i;
        add(&out[0], i, read_i16(p, is_big), &step[0]);
        add(&out[1], i, read_i16(p + 2, is_big), &step[1]);
    }
    return n;
}

/* It goes one way, by more than its noise. */
static bool is_sweep(const series *s, size_t n)
{
    const int64_t way = abs(s->last - s->first);
    return 2 * way >= s->path && s->path * 4 >= (int64_t)n;
}

/* Beside a sweep it stands still. */
static bool is_calm(const series *s, const series *sweep)
{
    return s->path <= sweep->path &&
           (int64_t)(s->high - s->low) * 4 <= sweep->high - sweep->low;
}

/* @return 0: no angles; 1: the first value sweeps; 2: the second. */
static int sweeping(const lum_infer_packet *packet, unsigned at, bool is_big,
                    series out[2])
{
    const size_t n = follow(packet, at, is_big, SIZE_MAX, out);
    if (n < ANGLES_MIN) {
        return 0;
    }
    for (int i = 0; i < 2; i++) {
        if (is_sweep(&out[i], n) && is_calm(&out[1 - i], &out[i])) {
            return i + 1;
        }
    }
    return 0;
}

static lum_infer_kind kind_of(const lum_infer_packet *packet, unsigned at,
                              bool is_big)
{
    series s[2];
    return is_ranges(packet, at, is_big)          ? LUM_INFER_RANGES
           : sweeping(packet, at, is_big, s) != 0 ? LUM_INFER_ANGLES
                                                  : LUM_INFER_UNKNOWN;
}

/* --- Their order and phase --- */

/* The first offset of a phase from which on all is samples. */
static unsigned behind_head(unsigned phase)
{
    return LUM_INFER_SAMPLES_AT_MAX + phase % PHASES;
}

typedef struct tally {
    size_t angles;
    size_t ranges;
} tally;

static void count(const lum_infer_packets *packets, unsigned phase, bool is_big,
                  tally *out)
{
    const unsigned at = behind_head(phase);
    const size_t stride = packets->count / TRIAL + 1;
    *out = (tally){0, 0};
    for (size_t i = 0; i < packets->count; i = lum_infer_next(i, stride)) {
        const lum_infer_kind kind = kind_of(packets->at[i], at, is_big);
        out->ranges += kind == LUM_INFER_RANGES;
        out->angles += kind == LUM_INFER_ANGLES;
    }
}

/* Angles look the same when they are read from their second value on; ranges,
 * or else the lengths, tell which it is. */
static size_t weight(const lum_infer_packets *packets, unsigned phase,
                     const tally *t)
{
    size_t equal = 0;
    const size_t stride = packets->count / TRIAL + 1;
    for (size_t i = 0; i < packets->count; i = lum_infer_next(i, stride)) {
        equal += packets->at[i]->len % SAMPLE_BYTES == phase;
    }
    return t->angles * 4 + t->ranges * 8 + (t->angles > 0 ? equal : 0);
}

bool lum_infer_find_samples(lum_infer_state *state)
{
    size_t best = 0;
    unsigned best_phase = 0;
    bool best_order = false;
    for (unsigned i = 0; i < PHASES * ORDERS; i++) {
        const unsigned phase = i % PHASES;
        tally t;
        count(&state->all, phase, i >= PHASES, &t);
        const size_t w = weight(&state->all, phase, &t);
        if (t.angles + t.ranges > 0 && w > best) {
            best = w;
            best_phase = phase;
            best_order = i >= PHASES;
        }
    }
    state->samples.at = best_phase;
    state->samples.is_big = best_order;
    if (best == 0) {
        return false;
    }
    for (size_t i = 0; i < state->all.count; i++) {
        lum_infer_packet *p = state->all.at[i];
        p->kind = (uint8_t)kind_of(p, behind_head(best_phase), best_order);
    }
    return true;
}

/* --- Where they begin, and what they reach --- */

/* Whether a pair at an offset goes on where the ones behind it point. */
static bool continues(const lum_infer_packet *p, unsigned probe, bool is_big,
                      const series s[2], size_t n)
{
    for (unsigned i = 0; i < 2; i++) {
        const uint8_t *b = p->bytes + probe + 2 * i;
        const int zero = read_i16(b, is_big);
        const int one = read_i16(b + SAMPLE_BYTES, is_big);
        const int two = read_i16(b + 2 * SAMPLE_BYTES, is_big);
        const int64_t noise = s[i].bend / (int64_t)(n + 1u) + 1;
        if (abs(zero - 2 * one + two) > 8 * noise + 8) {
            return false;
        }
    }
    return true;
}

/* The share of angle packets whose samples go on at an offset. */
static double share_at(const lum_infer_packets *packets, unsigned probe,
                       bool is_big)
{
    const unsigned behind = behind_head(probe % PHASES);
    const size_t stride = packets->count / TRIAL + 1;
    size_t angles = 0;
    size_t good = 0;
    for (size_t i = 0; i < packets->count; i = lum_infer_next(i, stride)) {
        const lum_infer_packet *p = packets->at[i];
        series s[2];
        if (p->kind == LUM_INFER_ANGLES) {
            const size_t n = follow(p, behind, is_big, NOISE, s);
            angles++;
            good += continues(p, probe, is_big, s, n);
        }
    }
    return angles == 0 ? 0.0 : (double)good / (double)angles;
}

static void measure_angles(const lum_infer_samples *m, lum_infer_packet *p)
{
    series s[2];
    p->sweeps = (uint8_t)sweeping(p, m->at, m->is_big, s);
    for (unsigned i = 0; i < 2; i++) {
        p->first[i] = (int16_t)s[i].first;
        p->low[i] = (int16_t)s[i].low;
        p->high[i] = (int16_t)s[i].high;
    }
}

/* The value that sweeps in most packets is that of all: in the others a sample
 * is corrupt. */
static void tell_sweep(lum_infer_state *state)
{
    lum_infer_samples *m = &state->samples;
    size_t n[3] = {0, 0, 0};
    for (size_t i = 0; i < state->data.count; i++) {
        lum_infer_packet *p = state->data.at[i];
        if (p->kind == LUM_INFER_ANGLES) {
            measure_angles(m, p);
            n[p->sweeps]++;
        }
    }
    m->angles = n[1] + n[2];
    m->is_el_first = n[2] > n[1];
    for (size_t i = 0; i < state->data.count; i++) {
        lum_infer_packet *p = state->data.at[i];
        p->calm = p->first[m->is_el_first ? 0 : 1];
    }
}

static int low_of(const lum_infer_packet *p)
{
    return p->low[p->sweeps - 1u];
}

static int high_of(const lum_infer_packet *p)
{
    return p->high[p->sweeps - 1u];
}

static int calm_of(const lum_infer_packet *p)
{
    return p->calm;
}

/* The value that as many packets of angles are below, by halving its range. */
static int nth(const lum_infer_state *state, size_t n,
               int (*of)(const lum_infer_packet *))
{
    const unsigned sweeps = state->samples.is_el_first ? 2u : 1u;
    int low = INT16_MIN;
    int high = INT16_MAX;
    while (low < high) {
        const int middle = low + (high - low) / 2;
        size_t below = 0;
        for (size_t i = 0; i < state->data.count; i++) {
            const lum_infer_packet *p = state->data.at[i];
            below += p->kind == LUM_INFER_ANGLES && p->sweeps == sweeps &&
                     of(p) <= middle;
        }
        if (below > n) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    return low;
}

/* What angles reach, but for a packet in a hundred at each end, which may be
 * corrupt. */
static void stretch(lum_infer_state *state, size_t angles)
{
    lum_infer_samples *m = &state->samples;
    const size_t odd = angles < 3 ? 0 : 1 + angles / 100;
    const size_t last = angles < 3 ? 0 : angles - 1 - odd;
    m->low[0] = nth(state, odd, low_of);
    m->high[0] = nth(state, last, high_of);
    m->low[1] = nth(state, odd, calm_of);
    m->high[1] = nth(state, last, calm_of);
}

static double share_of(size_t n, size_t all)
{
    return all == 0 ? 0.0 : (double)n / (double)all;
}

static void measure(lum_infer_state *state)
{
    lum_infer_samples *m = &state->samples;
    const unsigned sweeps = m->is_el_first ? 2u : 1u;
    size_t cut = 0;
    size_t equal = 0;
    size_t usual = 0;
    for (size_t i = 0; i < state->data.count; i++) {
        const lum_infer_packet *p = state->data.at[i];
        const uint32_t room = lum_infer_room(p, m->at);
        const bool is_angles = p->kind == LUM_INFER_ANGLES && p->sweeps > 0;
        equal += (p->len - m->at) % SAMPLE_BYTES == 0;
        m->ranges += p->kind == LUM_INFER_RANGES;
        cut += is_angles && (room == 334 || room == 332);
        usual += is_angles && p->sweeps == sweeps;
    }
    m->cut = share_of(cut, m->angles);
    m->equal = share_of(equal, state->data.count);
    stretch(state, usual);
}

void lum_infer_place_samples(lum_infer_state *state)
{
    lum_infer_samples *m = &state->samples;
    unsigned at = LUM_INFER_SAMPLES_AT_MAX;
    at -= (at - m->at) % PHASES;
    m->smooth = share_at(&state->data, at, m->is_big);
    m->before = 0.0;
    while (at >= LUM_INFER_FIELDS_AT + SAMPLE_BYTES) {
        const double share =
            share_at(&state->data, at - SAMPLE_BYTES, m->is_big);
        if (share < MOST) {
            m->before = share;
            break;
        }
        m->smooth = share;
        at -= SAMPLE_BYTES;
    }
    m->at = at;
    tell_sweep(state);
    measure(state);
}
