#include "group.h"

#include "fields.h"
#include "samples.h"

#include <string.h>

#define TAG_ANGLES 2u
#define TAG_RANGES 3u

/* The pixels that packets of angles begin with. */
#define CUT_1 334u
#define CUT_2 668u

/* Packets that all fields are tried on, and those that what is left is tried
 * on. */
#define TRIAL  200u
#define ENOUGH 2000u

/* What an identity holds for at least: corruption spoils a few, trailing bytes
 * or a stray packet some more. */
#define MOST 0.85

/* Says whether a value explains a packet. */
typedef bool (*explains)(const lum_infer_state *state,
                         const lum_infer_packet *packet, uint64_t value);

/* The share of packets, or of every stride-th, that a field explains. */
static double share(const lum_infer_state *state, lum_field field, explains is,
                    size_t stride)
{
    size_t n = 0;
    size_t good = 0;
    for (size_t i = 0; i < state->good.count; i += stride) {
        const lum_infer_packet *p = state->good.at[i];
        n++;
        good += is(state, p, lum_infer_value(p->bytes, field));
    }
    return n == 0 ? 0.0 : (double)good / (double)n;
}

static bool is_tag(const lum_infer_state *state, const lum_infer_packet *packet,
                   uint64_t value)
{
    (void)state;
    return value ==
           (packet->kind == LUM_INFER_ANGLES ? TAG_ANGLES : TAG_RANGES);
}

static bool is_count(const lum_infer_state *state,
                     const lum_infer_packet *packet, uint64_t value)
{
    const uint32_t room = lum_infer_room(packet, state->samples.at);
    /* Bytes may follow the samples; angles come as 334, 334, 332. */
    return value == room ||
           (packet->kind == LUM_INFER_ANGLES && value < room &&
            (value == CUT_1 || value == LUM_LINE_PIXELS - CUT_2));
}

static bool is_first(const lum_infer_state *state,
                     const lum_infer_packet *packet, uint64_t value)
{
    (void)state;
    return packet->kind == LUM_INFER_ANGLES
               ? value == 0 || value == CUT_1 || value == CUT_2
               : value < UINT64_C(16384);
}

/* All three beginnings come, and about as often. */
static bool has_cuts(const lum_infer_state *state, lum_field field)
{
    size_t n[3] = {0, 0, 0};
    for (size_t i = 0; i < state->good.count; i++) {
        const lum_infer_packet *p = state->good.at[i];
        if (p->kind == LUM_INFER_ANGLES) {
            const uint64_t value = lum_infer_value(p->bytes, field);
            n[0] += value == 0;
            n[1] += value == CUT_1;
            n[2] += value == CUT_2;
        }
    }
    return n[0] * 2 > n[1] && n[1] * 2 > n[2] && n[2] * 2 > n[0];
}

/* The share of range packets that begin with word 0, or where another one of
 * the last few ended. */
static double chain(const lum_infer_state *state, lum_field field)
{
    uint64_t ends[8] = {0};
    size_t n = 0;
    size_t good = 0;
    for (size_t i = 0; i < state->good.count; i++) {
        const lum_infer_packet *p = state->good.at[i];
        if (p->kind != LUM_INFER_RANGES) {
            continue;
        }
        const uint64_t value = lum_infer_value(p->bytes, field);
        bool follows = value == 0;
        for (unsigned k = 0; k < 8; k++) {
            follows = follows || value == ends[k];
        }
        good += follows;
        ends[n % 8] = value + lum_infer_room(p, state->samples.at);
        n++;
    }
    return n == 0 ? 1.0 : (double)good / (double)n;
}

/* How much is against a field that explains as much as another: whole bytes
 * are likelier than bits of them, and two bytes hold every count. */
static unsigned cost(lum_field field, unsigned bytes)
{
    unsigned c = field.bytes == bytes ? 0 : field.bytes == 2 * bytes ? 1 : 3;
    if (field.bits != 0) {
        c += 4;
        c += field.low != 0;
        c += (field.low + field.bits) % 8 != 0;
        c += (field.low % 4u + field.bits % 4u) != 0 ? 2 : 0;
    }
    return c;
}

/* Take a field in place of the one that was best. */
static void offer(lum_infer_choice *best, lum_field field, double of_it,
                  unsigned bytes)
{
    const bool is_better = best->field.bytes == 0 ||
                           of_it > best->share + 0.005 ||
                           (of_it > best->share - 0.005 &&
                            cost(field, bytes) < cost(best->field, bytes));
    if (is_better) {
        best->field = field;
        best->share = of_it;
    }
}

/* Remember the best field that explains too little. */
static void rival(lum_infer_choice *best, lum_field field, double of_it)
{
    if (of_it > best->second) {
        best->second = of_it;
        best->rival = field;
    }
}

/* Try a whole field, and each run of its bits of at least a length. */
static void try_bits(const lum_infer_state *state, lum_field field,
                     unsigned least, explains is, lum_infer_choice *best,
                     unsigned bytes)
{
    const unsigned all = 8u * field.bytes;
    const size_t stride = state->good.count / TRIAL + 1;
    for (unsigned low = 0; low + least <= all; low++) {
        for (unsigned bits = least; low + bits <= all; bits++) {
            lum_field f = field;
            f.low = (uint8_t)low;
            f.bits = bits == all ? 0 : (uint8_t)bits;
            if (!lum_infer_is_free(state, f)) {
                break;
            }
            const double trial = share(state, f, is, stride);
            if (trial < MOST) {
                rival(best, f, trial);
                break;
            }
            const double of_it =
                share(state, f, is, state->good.count / ENOUGH + 1);
            if (of_it >= MOST) {
                offer(best, f, of_it, bytes);
            }
        }
    }
}

void lum_infer_find_tag(lum_infer_state *state)
{
    lum_infer_choice *best = &state->field[LUM_FIELD_TAG];
    if (state->is_tag_type) {
        best->field = (lum_field){.at = 8, .bytes = 1};
        best->share = share(state, best->field, is_tag, 1);
        return;
    }
    for (unsigned at = LUM_INFER_FIELDS_AT; at < state->samples.at; at++) {
        const lum_field byte = {.at = (uint8_t)at, .bytes = 1};
        try_bits(state, byte, 2, is_tag, best, 1);
    }
    if (best->field.bytes > 0) {
        lum_infer_take(state, best->field);
    }
}

void lum_infer_find_num_samples(lum_infer_state *state)
{
    lum_infer_choice *best = &state->field[LUM_FIELD_NUM_SAMPLES];
    lum_field whole[LUM_INFER_WHOLE_MAX];
    const size_t n = lum_infer_whole(state, whole);
    for (size_t i = 0; i < n; i++) {
        if (whole[i].bytes > 1) {
            try_bits(state, whole[i], 9, is_count, best, 2);
        }
    }
    if (best->field.bytes > 0) {
        lum_infer_take(state, best->field);
    }
}

void lum_infer_find_first(lum_infer_state *state)
{
    lum_infer_choice *best = &state->field[LUM_FIELD_FIRST_SAMPLE_INDEX];
    lum_infer_choice tried;
    lum_field whole[LUM_INFER_WHOLE_MAX];
    const size_t n = lum_infer_whole(state, whole);
    for (size_t i = 0; i < n; i++) {
        memset(&tried, 0, sizeof tried);
        if (whole[i].bytes > 1) {
            try_bits(state, whole[i], 10, is_first, &tried, 2);
        }
        if (tried.field.bytes > 0 && has_cuts(state, tried.field)) {
            const double linked = chain(state, tried.field);
            offer(best, tried.field, tried.share * (0.5 + linked / 2), 2);
        }
    }
    if (best->field.bytes > 0) {
        lum_infer_take(state, best->field);
    }
}
