/* Fields that an identity gives away: tag, num_samples, first_sample_index. */
#include "fields.h"

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

/* Packets that what is left of first_sample_index is tried on: one after the
 * other, since each begins where another one ended. */
#define CHAIN 4000u

/* Packets of angles in which one of three beginnings must have come. */
#define ANGLES_MIN 60u

/* Readings that are kept beside each other. */
#define CANDIDATES 4u

/* Fields with other values differ in more than this share of packets:
 * corruption spoils fewer. */
#define OTHER 0.01

/* Shares as near as this are as good. */
#define NEAR 0.005

/* Says whether a value explains a packet. */
typedef bool (*explains)(const lum_infer_state *state,
                         const lum_infer_packet *packet, uint64_t value);

/* Says whether a field can be, or with how many more bits. */
typedef bool (*can_be)(const lum_infer_state *state, lum_field field);

/* The share of packets that a field explains. */
typedef double (*measure)(const lum_infer_state *state, lum_field field);

typedef struct candidate {
    lum_field field;
    double share;   /* of packets that it explains */
    bool is_enough; /* it can be the field; else only a rival of it */
} candidate;

/* A search for a field. Candidates have other values than each other. */
typedef struct search {
    const lum_infer_state *state;
    explains is;
    can_be can;     /* NULL: all can */
    measure share;  /* NULL: of packets that it explains by itself */
    unsigned least; /* bits */
    unsigned bytes; /* that it usually has */
    candidate best[CANDIDATES];
    size_t count;
} search;

/* --- What explains a packet --- */

/* The share of packets, or of every stride-th, that a field explains. */
static double share(const lum_infer_state *state, lum_field field, explains is,
                    size_t stride)
{
    size_t n = 0;
    size_t good = 0;
    for (size_t i = 0; i < state->good.count; i = lum_infer_next(i, stride)) {
        const lum_infer_packet *p = state->good.at[i];
        n++;
        good += is(state, p, lum_infer_value(p->bytes, field));
    }
    return n == 0 ? 0.0 : (double)good / (double)n;
}

static double share_of_many(const lum_infer_state *state, lum_field field,
                            explains is)
{
    return share(state, field, is, state->good.count / ENOUGH + 1);
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

/* All three beginnings come, and about as often. Where they do not come with
 * the lowest bits alone, they do not with more. */
static bool has_cuts(const lum_infer_state *state, lum_field field)
{
    size_t n[3] = {0, 0, 0};
    size_t all = 0;
    for (size_t i = 0; i < state->good.count; i++) {
        const lum_infer_packet *p = state->good.at[i];
        if (p->kind == LUM_INFER_ANGLES) {
            const uint64_t value = lum_infer_value(p->bytes, field);
            n[0] += value == 0;
            n[1] += value == CUT_1;
            n[2] += value == CUT_2;
            all++;
            if (all == ANGLES_MIN && (n[1] == 0 || n[2] == 0)) {
                return false;
            }
        }
    }
    return n[0] * 2 > n[1] && n[1] * 2 > n[2] && n[2] * 2 > n[0];
}

/* Of packets of angles, those that begin with a cut; of ranges, those that
 * begin with word 0, or where another one of the last few ended. */
static double share_of_firsts(const lum_infer_state *state, lum_field field)
{
    uint64_t ends[8] = {0};
    size_t n = 0;
    size_t all = 0;
    size_t good = 0;
    for (size_t i = 0; i < state->data.count && i < CHAIN; i++) {
        const lum_infer_packet *p = state->data.at[i];
        const uint64_t value = lum_infer_value(p->bytes, field);
        bool follows = value == 0;
        for (unsigned k = 0; k < 8; k++) {
            follows = follows || value == ends[k];
        }
        all += p->kind != LUM_INFER_UNKNOWN;
        good += p->kind == LUM_INFER_ANGLES
                    ? is_first(state, p, value)
                    : p->kind == LUM_INFER_RANGES && follows;
        /* Of too few samples to tell what they are, as of ranges. */
        if (p->kind != LUM_INFER_ANGLES) {
            ends[n % 8] = value + lum_infer_room(p, state->samples.at);
            n++;
        }
    }
    return all == 0 ? 0.0 : (double)good / (double)all;
}

/* --- Candidates --- */

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

/* Whether two fields have the same values in all packets but a few, or differ
 * in their length alone. */
static bool is_alike(const lum_infer_state *state, lum_field a, lum_field b)
{
    const size_t stride = state->good.count / ENOUGH + 1;
    const double most = OTHER * (double)state->good.count / (double)stride;
    size_t other = 0;
    if (lum_infer_is_nested(a, b)) {
        return true;
    }
    for (size_t i = 0; i < state->good.count; i = lum_infer_next(i, stride)) {
        const uint8_t *bytes = state->good.at[i]->bytes;
        other += lum_infer_value(bytes, a) != lum_infer_value(bytes, b);
        if ((double)other > most) {
            return false;
        }
    }
    return true;
}

/* Whether a number explains more than its own lowest bits do: that is no
 * chance, be it by ever so few packets. */
static bool needs_more_bits(const candidate *a, const candidate *b)
{
    return a->share > b->share &&
           lum_infer_width(a->field) > lum_infer_width(b->field) &&
           lum_infer_is_nested(a->field, b->field);
}

/* Of those that are as good, the plainer one. */
static bool is_better(const search *s, const candidate *a, const candidate *b)
{
    if (needs_more_bits(a, b) || needs_more_bits(b, a)) {
        return a->share > b->share;
    }
    return a->share > b->share + NEAR ||
           (a->share > b->share - NEAR &&
            cost(a->field, s->bytes) < cost(b->field, s->bytes));
}

/* Where one may stand among the candidates: in place of the one with the
 * same values, or of the worst; CANDIDATES: nowhere. */
static size_t place_of(const search *s, const candidate *c)
{
    size_t worst = 0;
    for (size_t k = 0; k < s->count; k++) {
        if (is_alike(s->state, s->best[k].field, c->field)) {
            return is_better(s, c, &s->best[k]) ? k : CANDIDATES;
        }
        worst = s->best[k].share < s->best[worst].share ? k : worst;
    }
    if (s->count < CANDIDATES) {
        return s->count;
    }
    return c->share > s->best[worst].share ? worst : CANDIDATES;
}

/* What is like one that took a place is no other candidate. */
static void drop_alike(search *s, size_t of)
{
    for (size_t k = s->count; k-- > 0;) {
        if (k != of &&
            is_alike(s->state, s->best[k].field, s->best[of].field)) {
            s->count--;
            s->best[k] = s->best[s->count];
            of = of == s->count ? k : of;
        }
    }
}

static void enter(search *s, const candidate *c)
{
    const size_t k = c->share > 0.0 ? place_of(s, c) : CANDIDATES;
    if (k < CANDIDATES) {
        s->best[k] = *c;
        s->count += k == s->count;
        drop_alike(s, k);
    }
}

/* The best that explains enough, and the next best that has other values. */
static lum_infer_choice conclude(const search *s)
{
    lum_infer_choice out = {.share = 0.0};
    size_t first = CANDIDATES;
    for (size_t k = 0; k < s->count; k++) {
        if (s->best[k].is_enough &&
            (first == CANDIDATES ||
             is_better(s, &s->best[k], &s->best[first]))) {
            first = k;
        }
    }
    for (size_t k = 0; k < s->count; k++) {
        if (k != first && s->best[k].share > out.second) {
            out.second = s->best[k].share;
            out.rival = s->best[k].field;
        }
    }
    if (first < CANDIDATES) {
        out.field = s->best[first].field;
        out.share = s->best[first].share;
    }
    return out;
}

/* Try the runs of a field's bits that begin with one, from the least length
 * on. A run that explains too little does not with more bits. */
static void try_runs(search *s, lum_field field, unsigned low)
{
    const unsigned all = 8u * field.bytes;
    const size_t stride = s->state->good.count / TRIAL + 1;
    for (unsigned bits = s->least; low + bits <= all; bits++) {
        lum_field f = field;
        f.low = (uint8_t)low;
        f.bits = bits == all ? 0 : (uint8_t)bits;
        if (!lum_infer_is_free(s->state, f) ||
            (s->can != NULL && !s->can(s->state, f))) {
            return;
        }
        candidate c = {.field = f, .share = share(s->state, f, s->is, stride)};
        c.is_enough = c.share >= MOST;
        if (c.is_enough) {
            c.share = s->share != NULL ? s->share(s->state, f)
                                       : share_of_many(s->state, f, s->is);
        }
        enter(s, &c);
        if (!c.is_enough) {
            return;
        }
    }
}

/* Try a whole field, and each run of its bits. */
static void try_bits(search *s, lum_field field)
{
    for (unsigned low = 0; low + s->least <= 8u * field.bytes; low++) {
        try_runs(s, field, low);
    }
}

/* --- The fields --- */

static void take(lum_infer_state *state, unsigned field, const search *s)
{
    state->field[field] = conclude(s);
    if (state->field[field].field.bytes > 0) {
        lum_infer_add_bits(&state->used, state->field[field].field);
    }
}

/* Try all fields of two bytes or more. */
static void try_whole(search *s)
{
    lum_field whole[LUM_INFER_WHOLE_MAX];
    const size_t n = lum_infer_whole(s->state, whole);
    for (size_t i = 0; i < n; i++) {
        if (whole[i].bytes > 1) {
            try_bits(s, whole[i]);
        }
    }
}

void lum_infer_find_tag(lum_infer_state *state)
{
    search s = {.state = state, .is = is_tag, .least = 2, .bytes = 1};
    const lum_field type = {.at = 8, .bytes = 1};
    if (state->is_tag_type) {
        state->field[LUM_FIELD_TAG].field = type;
        state->field[LUM_FIELD_TAG].share = share_of_many(state, type, is_tag);
        return;
    }
    for (unsigned at = LUM_INFER_FIELDS_AT; at < state->samples.at; at++) {
        try_bits(&s, (lum_field){.at = (uint8_t)at, .bytes = 1});
    }
    take(state, LUM_FIELD_TAG, &s);
}

void lum_infer_find_num_samples(lum_infer_state *state)
{
    search s = {.state = state, .is = is_count, .least = 9, .bytes = 2};
    try_whole(&s);
    take(state, LUM_FIELD_NUM_SAMPLES, &s);
}

static void search_first(lum_infer_state *state)
{
    search s = {.state = state,
                .is = is_first,
                .can = has_cuts,
                .share = share_of_firsts,
                .least = 10,
                .bytes = 2};
    try_whole(&s);
    take(state, LUM_FIELD_FIRST_SAMPLE_INDEX, &s);
}

/* Give back the highest bit of a field. */
static void shorten(lum_infer_state *state, lum_field *field)
{
    const unsigned bits = lum_infer_width(*field) - 1u;
    const unsigned top = lum_infer_bit_at(*field, field->low + bits);
    field->bits = (uint8_t)bits;
    state->used.byte[top / 8u] &= (uint8_t) ~(1u << top % 8u);
}

/* Where all beginnings are even, the lowest bit of first_sample_index is always
 * 0, and may have been taken for the highest one of the field below it. */
void lum_infer_find_first(lum_infer_state *state)
{
    static const unsigned below[] = {LUM_FIELD_TAG, LUM_FIELD_NUM_SAMPLES};
    const lum_field *first = &state->field[LUM_FIELD_FIRST_SAMPLE_INDEX].field;
    search_first(state);
    for (unsigned i = 0; i < 2 && first->bytes == 0; i++) {
        lum_field *field = &state->field[below[i]].field;
        const lum_field before = *field;
        const lum_infer_bits used = state->used;
        if (lum_infer_width(before) > 2) {
            shorten(state, field);
            search_first(state);
        }
        if (first->bytes == 0) {
            *field = before;
            state->used = used;
        }
    }
}
