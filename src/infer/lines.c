#include "lines.h"

#include "fields.h"

#include <stdlib.h>
#include <string.h>

#define BITS (8u * LUM_INFER_HEAD_BYTES)

/* Beginnings of lines that are looked at. */
#define STARTS_MAX 6000u

/* A bit that tells two eyes apart is set in this share of lines at least. */
#define EYE_MIN 0.1

/* The lowest bit of a line number changes with most lines of an eye. */
#define TOGGLE_MIN 0.6

/* A line number has this many bits at least: with fewer, any two bits count. */
#define LINE_BITS 3u

/* Bits that 640 lines need. */
#define FULL_BITS 10u

/* A bit that is 1 but in this share of lines is none of a number. */
#define ALWAYS 0.03

/* A line number is rather a field of its own than the upper bits of one. */
#define LIKES_WHOLE 0.04

/* An eye is rather told by bits that nothing else changes beside. */
#define BUSY_EYE 0.1

/* A sensor has two eyes: one alone must explain more by this. */
#define TWO_EYES 0.1

/* Lines of two eyes take turns; this share of lines follows the other eye's at
 * least. */
#define TURNS_MIN 0.4

/* Most ways of telling eyes apart. */
#define SPLITS_MAX 48u

/* How a line number goes on, for both eyes. */
typedef struct steps {
    size_t all;  /* steps from a line to the next */
    size_t one;  /* by 1 */
    size_t down; /* to a lower number, where elevations begin again */
} steps;

typedef struct finder {
    lum_infer_state *state;
    const lum_infer_packet **starts; /* the first angle packet of each line */
    size_t count;
    int *steps;                  /* room for twice as many */
    int height;                  /* by which elevations differ */
    unsigned splits[SPLITS_MAX]; /* bits that may tell the eyes apart; BITS:
                                    there is one eye */
    size_t split_count;
    lum_infer_bits eye_like; /* bits that are as the split is */
} finder;

/* A reading of eye and line. */
typedef struct reading {
    lum_field line;
    unsigned bit;
    unsigned lowest; /* where the line's lowest bit stands */
    double score;
    steps steps;
} reading;

/* --- Beginnings of lines --- */

static unsigned bit_of(const lum_infer_packet *packet, unsigned bit)
{
    return bit >= BITS ? 0u : packet->bytes[bit / 8u] >> bit % 8u & 1u;
}

static void find_starts(finder *f)
{
    int low = INT16_MAX;
    int high = INT16_MIN;
    const lum_field first = f->state->field[LUM_FIELD_FIRST_SAMPLE_INDEX].field;
    for (size_t i = 0; i < f->state->good.count && f->count < STARTS_MAX; i++) {
        const lum_infer_packet *p = f->state->good.at[i];
        if (p->kind == LUM_INFER_ANGLES &&
            lum_infer_value(p->bytes, first) == 0) {
            f->starts[f->count] = p;
            f->count++;
            low = p->calm < low ? p->calm : low;
            high = p->calm > high ? p->calm : high;
        }
    }
    f->height = high - low;
}

/* Whether two bits tell the same packets apart. */
static bool is_same_split(const finder *f, unsigned a, unsigned b)
{
    size_t same = 0;
    for (size_t i = 0; i < f->count; i++) {
        same += bit_of(f->starts[i], a) == bit_of(f->starts[i], b);
    }
    return same * 100 > f->count * 95 || same * 100 < f->count * 5;
}

static double share_of_ones(const finder *f, unsigned bit)
{
    size_t n = 0;
    for (size_t i = 0; i < f->count; i++) {
        n += bit_of(f->starts[i], bit);
    }
    return f->count == 0 ? 0.0 : (double)n / (double)f->count;
}

static bool is_used(const lum_infer_state *state, unsigned bit)
{
    return (state->used.byte[bit / 8u] >> bit % 8u & 1u) != 0;
}

/* Whether a bit changes among the lines of an eye. */
static bool is_restless(const finder *f, unsigned bit, unsigned eye_bit)
{
    size_t n[2] = {0, 0};
    size_t ones[2] = {0, 0};
    for (size_t i = 0; i < f->count; i++) {
        const unsigned eye = bit_of(f->starts[i], eye_bit);
        n[eye]++;
        ones[eye] += bit_of(f->starts[i], bit);
    }
    bool is = false;
    for (unsigned eye = 0; eye < 2; eye++) {
        const size_t rare =
            ones[eye] * 2 > n[eye] ? n[eye] - ones[eye] : ones[eye];
        is = is || rare * 20 > n[eye];
    }
    return is;
}

/* --- Bits that may tell eyes apart --- */

/* Bits of a bit's byte that change within eyes. */
static unsigned neighbours_of(const finder *f, unsigned bit, unsigned eye_bit)
{
    unsigned n = 0;
    for (unsigned b = 0; b < 8; b++) {
        n += is_restless(f, bit - bit % 8u + b, eye_bit);
    }
    return n;
}

static unsigned neighbours(const finder *f, unsigned bit)
{
    return neighbours_of(f, bit, bit);
}

/* Where a bit is among those that are known, as itself or as one that tells the
 * same; as many as are known: nowhere. */
static size_t known_split(const finder *f, unsigned bit)
{
    size_t k = 1;
    while (k < f->split_count && !is_same_split(f, f->splits[k], bit)) {
        k++;
    }
    return k;
}

/* Of bits that tell the same, the one with the fewest others beside it that
 * change stands for all. */
static void find_splits(finder *f)
{
    f->splits[0] = BITS;
    f->split_count = 1;
    for (unsigned bit = 8u * LUM_INFER_FIELDS_AT;
         bit < 8u * f->state->samples.at; bit++) {
        const double ones = share_of_ones(f, bit);
        if (ones < EYE_MIN || ones > 1.0 - EYE_MIN || is_used(f->state, bit)) {
            continue;
        }
        const size_t k = known_split(f, bit);
        if (k == f->split_count && k < SPLITS_MAX) {
            f->splits[k] = bit;
            f->split_count++;
        } else if (k < f->split_count &&
                   neighbours(f, bit) < neighbours(f, f->splits[k])) {
            f->splits[k] = bit;
        }
    }
}

/* The share of lines of an eye in which a bit differs from the line before. */
static double toggles(const finder *f, unsigned eye_bit, unsigned bit)
{
    const lum_infer_packet *last[2] = {NULL, NULL};
    size_t n = 0;
    size_t changed = 0;
    for (size_t i = 0; i < f->count; i++) {
        const lum_infer_packet *p = f->starts[i];
        const unsigned eye = bit_of(p, eye_bit);
        if (last[eye] != NULL && last[eye]->sensor == p->sensor) {
            n++;
            changed += bit_of(last[eye], bit) != bit_of(p, bit);
        }
        last[eye] = p;
    }
    return n == 0 ? 0.0 : (double)changed / (double)n;
}

/* --- Line numbers --- */

static steps walk(const finder *f, unsigned eye_bit, lum_field line)
{
    const lum_infer_packet *last[2] = {NULL, NULL};
    uint64_t number[2] = {0, 0};
    steps s = {0, 0, 0};
    for (size_t i = 0; i < f->count; i++) {
        const lum_infer_packet *p = f->starts[i];
        const unsigned eye = bit_of(p, eye_bit);
        const uint64_t now = lum_infer_value(p->bytes, line);
        if (last[eye] != NULL && last[eye]->sensor == p->sensor) {
            s.all++;
            s.one += now == number[eye] + 1u;
            s.down += now < number[eye] &&
                      abs(p->calm - last[eye]->calm) * 2 > f->height;
        }
        last[eye] = p;
        number[eye] = now;
    }
    return s;
}

static double score_of(steps s)
{
    return s.all == 0 ? 0.0 : (double)(s.one + s.down) / (double)s.all;
}

static bool tells_eye(const finder *f, unsigned bit)
{
    return (f->eye_like.byte[bit / 8u] >> bit % 8u & 1u) != 0;
}

/* What is for a field among those that count alike: whole fields of two bytes
 * are the usual ones. */
static unsigned plainness(const finder *f, lum_field field)
{
    const unsigned bits = field.bits == 0 ? 8u * field.bytes : field.bits;
    unsigned p = bits >= FULL_BITS ? 256u : 0u;
    p += field.bits == 0 ? 128u : field.low == 0 ? 64u + bits : bits;
    p += field.bytes == 2 ? 6u : field.bytes == 4 ? 4u : 2u;
    p +=
        field.order == f->state->field[LUM_FIELD_FIRST_SAMPLE_INDEX].field.order
            ? 96u
            : 0u;
    /* The eye as the highest bit above the number is a usual thing. */
    p += field.bits != 0 && field.low + bits + 1u == 8u * field.bytes &&
                 tells_eye(f, lum_infer_bit_at(field, field.low + bits))
             ? 192u
             : 0u;
    return p;
}

static void better(const finder *f, reading *best, const reading *r)
{
    const bool is_same = r->lowest == best->lowest && r->bit == best->bit;
    const double near = is_same ? 0.004 : 0.0;
    if (r->score > best->score + near ||
        (is_same && r->steps.one > best->steps.one) ||
        (is_same && r->steps.one == best->steps.one &&
         plainness(f, r->line) > plainness(f, best->line))) {
        *best = *r;
    }
}

/* Bits that differ by eye, and by nothing else. */
static void find_eye_like(finder *f, unsigned eye_bit)
{
    memset(&f->eye_like, 0, sizeof f->eye_like);
    for (unsigned bit = 8u * LUM_INFER_FIELDS_AT;
         eye_bit < BITS && bit < 8u * f->state->samples.at; bit++) {
        if (is_same_split(f, eye_bit, bit) && share_of_ones(f, bit) > 0.02 &&
            share_of_ones(f, bit) < 0.98) {
            f->eye_like.byte[bit / 8u] |= (uint8_t)(1u << bit % 8u);
        }
    }
}

/* A bit that is always 1, in a byte that never changes, is none of a number. */
static bool is_set_still(const finder *f, unsigned bit, unsigned eye_bit)
{
    return share_of_ones(f, bit) > 1.0 - ALWAYS &&
           neighbours_of(f, bit, eye_bit) == 0;
}

/* A number does not end below a bit that changes from line to line. */
static bool goes_on(const finder *f, lum_field base, unsigned bit,
                    unsigned eye_bit)
{
    if (bit >= 8u * base.bytes) {
        return false;
    }
    const unsigned at = lum_infer_bit_at(base, bit);
    return !is_used(f->state, at) && is_restless(f, at, eye_bit);
}

/* Nor does it begin above one. */
static bool is_inside(const finder *f, lum_field base, unsigned low,
                      unsigned eye_bit)
{
    if (low == 0) {
        return false;
    }
    const unsigned below = lum_infer_bit_at(base, low - 1u);
    return !is_used(f->state, below) && is_restless(f, below, eye_bit);
}

/* All fields of a base whose lowest bit is this one. */
static void try_base(const finder *f, lum_field base, unsigned low,
                     unsigned eye_bit, reading *best)
{
    const unsigned all = 8u * base.bytes;
    if (is_inside(f, base, low, eye_bit)) {
        return;
    }
    for (unsigned bits = 1; low + bits <= all; bits++) {
        const unsigned top = lum_infer_bit_at(base, low + bits - 1u);
        if (is_used(f->state, top) || tells_eye(f, top) ||
            is_set_still(f, top, eye_bit)) {
            break;
        }
        if (bits < LINE_BITS || goes_on(f, base, low + bits, eye_bit)) {
            continue;
        }
        reading r = {.line = base, .bit = eye_bit};
        r.line.low = (uint8_t)low;
        r.line.bits = bits == all ? 0 : (uint8_t)bits;
        r.lowest = lum_infer_bit_at(base, low);
        r.steps = walk(f, eye_bit, r.line);
        r.score = score_of(r.steps) - (low != 0 ? LIKES_WHOLE : 0.0);
        better(f, best, &r);
    }
}

/* The best line number whose lowest bit is this one. */
static reading try_lowest(const finder *f, unsigned lowest, unsigned eye_bit)
{
    lum_field whole[LUM_INFER_WHOLE_MAX];
    const size_t n = lum_infer_whole(f->state, whole);
    reading best = {.score = 0.0, .bit = eye_bit, .lowest = lowest};
    for (size_t i = 0; i < n; i++) {
        for (unsigned low = lowest % 8u; low < 8u * whole[i].bytes; low += 8) {
            if (lum_infer_bit_at(whole[i], low) == lowest) {
                try_base(f, whole[i], low, eye_bit, &best);
            }
        }
    }
    return best;
}

/* Whether the byte of an eye's bit has others that change from line to line,
 * and are no part of a field that is known. */
static bool is_busy(const finder *f, const reading *r)
{
    const lum_infer_bits line = lum_infer_bits_of(r->line);
    const unsigned at = r->bit / 8u;
    const unsigned known = line.byte[at] | f->state->used.byte[at];
    for (unsigned b = 0; b < 8; b++) {
        if ((known >> b & 1u) == 0 && is_restless(f, 8u * at + b, r->bit)) {
            return true;
        }
    }
    return false;
}

/* Whether two readings number most lines alike, and give them the same eyes. */
static bool is_alike(const finder *f, const reading *a, const reading *b)
{
    size_t same = 0;
    if (a->lowest != b->lowest || a->line.bytes == 0) {
        return false;
    }
    for (size_t i = 0; i < f->count; i++) {
        same += bit_of(f->starts[i], a->bit) == bit_of(f->starts[i], b->bit);
    }
    return same * 10 > f->count * 8 || same * 10 < f->count * 2;
}

static void rank(const finder *f, const reading *r, reading *best,
                 reading *second)
{
    const bool is_same = is_alike(f, r, best);
    if (is_same) {
        *best = r->score > best->score ? *r : *best;
    } else if (r->line.bytes > 0 &&
               (best->line.bytes == 0 || r->score > best->score)) {
        *second = *best;
        *best = *r;
    } else if (r->line.bytes > 0 && r->score > second->score) {
        *second = *r;
    }
}

/* --- Readings of both --- */

static int compare(const void *a, const void *b)
{
    const int x = *(const int *)a;
    const int y = *(const int *)b;
    return (x > y) - (x < y);
}

/* How far apart in elevation lines of one number of both eyes are, against the
 * next lines of an eye: about half, if there is only one eye, whose lines were
 * dealt to two. */
static bool is_interleaved(const finder *f, const reading *r)
{
    int *near = f->steps;
    int *next = f->steps + f->count;
    size_t n = 0;
    for (size_t i = 2; i < f->count; i++) {
        const lum_infer_packet *const *p = &f->starts[i - 2];
        const unsigned eye = bit_of(p[0], r->bit);
        if (eye != bit_of(p[1], r->bit) && eye == bit_of(p[2], r->bit) &&
            lum_infer_value(p[0]->bytes, r->line) ==
                lum_infer_value(p[1]->bytes, r->line)) {
            near[n] = abs(p[1]->calm - p[0]->calm);
            next[n] = abs(p[2]->calm - p[0]->calm);
            n++;
        }
    }
    if (n == 0) {
        return false;
    }
    qsort(near, n, sizeof *near, compare);
    qsort(next, n, sizeof *next, compare);
    return near[n / 2] * 100 > next[n / 2] * 35 &&
           near[n / 2] * 100 < next[n / 2] * 65;
}

/* Whether both eyes take turns. */
static bool takes_turns(const finder *f, unsigned eye_bit)
{
    size_t n = 0;
    for (size_t i = 1; i < f->count; i++) {
        n += bit_of(f->starts[i], eye_bit) != bit_of(f->starts[i - 1], eye_bit);
    }
    return (double)n > TURNS_MIN * (double)f->count;
}

/* What is against the eyes of a reading. */
static double weight_against(const finder *f, const reading *r)
{
    if (r->bit == BITS) {
        return TWO_EYES;
    }
    return is_busy(f, r) ? BUSY_EYE : 0.0;
}

static void try_split(const finder *f, unsigned eye_bit, reading *best,
                      reading *second)
{
    for (unsigned bit = 8u * LUM_INFER_FIELDS_AT;
         bit < 8u * f->state->samples.at; bit++) {
        if (is_used(f->state, bit) || tells_eye(f, bit) ||
            toggles(f, eye_bit, bit) < TOGGLE_MIN) {
            continue;
        }
        reading r = try_lowest(f, bit, eye_bit);
        if (eye_bit < BITS && is_interleaved(f, &r)) {
            continue;
        }
        r.score -= weight_against(f, &r);
        rank(f, &r, best, second);
    }
}

/* --- The field of the eye --- */

/* Bits of a byte in which lines of one eye differ among each other. */
static unsigned restless(const finder *f, unsigned at, unsigned eye_bit,
                         unsigned *eye_bits)
{
    unsigned out = 0;
    *eye_bits = 0;
    for (unsigned b = 0; b < 8; b++) {
        const unsigned bit = 8u * at + b;
        size_t n[2] = {0, 0};
        size_t ones[2] = {0, 0};
        for (size_t i = 0; i < f->count; i++) {
            const unsigned eye = bit_of(f->starts[i], eye_bit);
            n[eye]++;
            ones[eye] += bit_of(f->starts[i], bit);
        }
        bool set[2];
        for (unsigned eye = 0; eye < 2; eye++) {
            set[eye] = ones[eye] * 2 > n[eye];
            const size_t odd = set[eye] ? n[eye] - ones[eye] : ones[eye];
            out |= odd * 20 > n[eye] ? 1u << b : 0u;
        }
        *eye_bits |= set[0] != set[1] ? 1u << b : 0u;
    }
    *eye_bits &= ~out;
    return out;
}

static unsigned length_of_run(unsigned mask, unsigned low)
{
    unsigned n = 0;
    while (low + n < 8 && (mask >> (low + n) & 1u) != 0) {
        n++;
    }
    return n;
}

/* The field around the bits by which eyes differ, in one byte. */
static lum_field eye_in_byte(const finder *f, unsigned at, unsigned eye_bit)
{
    unsigned bits = 0;
    const unsigned taken =
        restless(f, at, eye_bit, &bits) | f->state->used.byte[at];
    lum_field out = {.at = (uint8_t)at};
    bits &= ~taken;
    if (bits == 0) {
        return out;
    }
    out.bytes = 1;
    if (taken != 0) {
        const unsigned free = ~taken & 0xffu;
        unsigned low = 0;
        while ((bits >> low & 1u) == 0) {
            low++;
        }
        while (low > 0 && (free >> (low - 1u) & 1u) != 0 && low != 4) {
            low--;
        }
        out.low = (uint8_t)low;
        out.bits = (uint8_t)length_of_run(free, low);
    }
    return out;
}

static unsigned count_bits(unsigned mask)
{
    unsigned n = 0;
    for (; mask != 0; mask &= mask - 1u) {
        n++;
    }
    return n;
}

/* Of all bytes in which eyes differ, the one with most of such bits. */
static lum_field find_eye(const finder *f, unsigned eye_bit)
{
    lum_field best = {.bytes = 0};
    unsigned most = 0;
    for (unsigned at = LUM_INFER_FIELDS_AT; at < f->state->samples.at; at++) {
        unsigned bits = 0;
        const lum_field field = eye_in_byte(f, at, eye_bit);
        const unsigned changing = restless(f, at, eye_bit, &bits);
        const bool is_still =
            (changing & ~(unsigned)f->state->used.byte[at]) == 0;
        const unsigned n = 2u * count_bits(bits) + (field.bits == 0 ? 1u : 0u) +
                           (is_still ? 32u : 0u);
        if (field.bytes > 0 && n > most) {
            most = n;
            best = field;
        }
    }
    return best;
}

/* The value that most packets of an eye have. */
static uint32_t usual(const finder *f, lum_field field, unsigned eye_bit,
                      unsigned eye)
{
    size_t n[256] = {0};
    uint32_t best = 0;
    for (size_t i = 0; i < f->count; i++) {
        const lum_infer_packet *p = f->starts[i];
        if (bit_of(p, eye_bit) == eye) {
            n[lum_infer_value(p->bytes, field) & 0xffu]++;
        }
    }
    for (uint32_t v = 1; v < 256; v++) {
        best = n[v] > n[best] ? v : best;
    }
    return best;
}

/* With one eye alone: a byte that is always the same, the usual one or else
 * the first. */
static void take_one_eye(finder *f)
{
    lum_infer_state *state = f->state;
    lum_infer_choice *eye = &state->field[LUM_FIELD_EYE];
    unsigned best = 0;
    for (unsigned i = 0; i <= state->samples.at; i++) {
        const unsigned at = i == 0 ? 13u : i - 1u;
        unsigned bits = 0;
        const bool can = at >= LUM_INFER_FIELDS_AT && at < state->samples.at &&
                         state->used.byte[at] == 0 &&
                         restless(f, at, BITS, &bits) == 0;
        best = can && best == 0 ? at : best;
    }
    state->is_one_eye = true;
    eye->share = 1.0;
    if (best != 0) {
        eye->field = (lum_field){.at = (uint8_t)best, .bytes = 1};
        const uint32_t value = usual(f, eye->field, BITS, 0);
        state->eye_value[LUM_EYE_BLUE] = value == 1 ? 0 : value;
        state->eye_value[LUM_EYE_GREEN] =
            value == 0 || value == 1 ? 1 : value ^ 1u;
        lum_infer_take(state, eye->field);
    }
}

static void take_eyes(finder *f, unsigned eye_bit)
{
    lum_infer_state *state = f->state;
    lum_infer_choice *eye = &state->field[LUM_FIELD_EYE];
    eye->field = find_eye(f, eye_bit);
    eye->share = 1.0;
    if (eye->field.bytes == 0) {
        return;
    }
    const uint32_t a = usual(f, eye->field, eye_bit, 0);
    const uint32_t b = usual(f, eye->field, eye_bit, 1);
    state->eye_value[LUM_EYE_BLUE] = a < b ? a : b;
    state->eye_value[LUM_EYE_GREEN] = a < b ? b : a;
    lum_infer_take(state, eye->field);
}

static void settle(finder *f, const reading *best, const reading *second)
{
    lum_infer_choice *line = &f->state->field[LUM_FIELD_LINE];
    f->state->lines = f->count;
    if (best->line.bytes == 0) {
        return;
    }
    line->field = best->line;
    line->share = score_of(best->steps);
    line->rival = second->line;
    line->second = line->share - (best->score - second->score);
    f->state->line_steps = best->steps.all;
    lum_infer_take(f->state, best->line);
    if (best->bit == BITS) {
        take_one_eye(f);
    } else {
        take_eyes(f, best->bit);
    }
}

int lum_infer_find_lines(lum_infer_state *state)
{
    finder f = {.state = state};
    reading best = {.score = -1.0};
    reading second = {.score = 0.0};
    f.starts = calloc(STARTS_MAX, sizeof(void *));
    f.steps = malloc(2u * STARTS_MAX * sizeof *f.steps);
    if (f.starts == NULL || f.steps == NULL) {
        free(f.starts);
        free(f.steps);
        return -1;
    }
    find_starts(&f);
    find_splits(&f);
    for (size_t i = 0; i < f.split_count; i++) {
        if (f.splits[i] == BITS || takes_turns(&f, f.splits[i])) {
            find_eye_like(&f, f.splits[i]);
            try_split(&f, f.splits[i], &best, &second);
        }
    }
    settle(&f, &best, &second);
    free(f.starts);
    free(f.steps);
    return 0;
}
