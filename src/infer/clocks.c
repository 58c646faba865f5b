/* Chooses the clock: at first its bits alone; once other fields are known,
 * the whole field, and which others may be it. */
#include "fields.h"
#include "ticks.h"

#include <math.h>
#include <stdlib.h>

/* Fewer packets tell no clock. */
#define CLOCK_MIN 16u

/* Another clock is about as fine with this many bits fewer that change. */
#define FINE_BITS 3u

/* Two clocks whose times differ by less, as a share of what they span, are
 * the same. */
#define SAME 0.001

/* --- Times of a clock --- */

/* Times of a field's ticks at the beginnings of lines. */
static void get_times(lum_infer_ticks *t, lum_field field, double unit_ns,
                      double *out)
{
    (void)lum_infer_extend(t, field);
    for (size_t i = 0; i < t->start_count; i++) {
        out[i] = unit_ns * (double)t->ticks[t->starts[i]];
    }
}

/* How far a field's times are from those of the best, in ticks.sorted. */
static void compare_times(lum_infer_search *s, lum_field field,
                          uint32_t unit_ns)
{
    double *apart = s->ticks.sorted;
    get_times(&s->ticks, field, unit_ns, apart);
    for (size_t i = 0; i < s->ticks.start_count; i++) {
        apart[i] -= s->times[i];
    }
}

static bool is_same_time(lum_infer_search *s, const lum_infer_candidate *c)
{
    lum_infer_ticks *t = &s->ticks;
    compare_times(s, c->field, c->unit_ns);
    return lum_infer_deviation(t->sorted, t->start_count) < SAME * t->span_ns;
}

/* Whether a field gives the times of the best at all lines, but for corrupt
 * ones. Bytes that count on as the lower ones wrap do; others, which change
 * when they like, do not. */
static bool is_always_same(lum_infer_search *s, lum_field field)
{
    const lum_infer_ticks *t = &s->ticks;
    size_t off = 0;
    compare_times(s, field, s->best.unit_ns);
    for (size_t i = 0; i < t->start_count; i++) {
        off += fabs(t->sorted[i]) > SAME * t->span_ns;
    }
    return off * 100 < t->start_count;
}

/* --- Eight bytes or four of them --- */

/* The clock's eight bytes of four, or its lower four of eight. */
static lum_field resized(lum_field clock)
{
    const bool is_big = clock.order == LUM_ORDER_BIG;
    lum_field out = clock;
    if (clock.bytes == 8) {
        out.bytes = 4;
        out.at = (uint8_t)(clock.at + (is_big ? 4u : 0u));
    } else {
        out.bytes = 8;
        out.at = (uint8_t)(clock.at - (is_big ? 4u : 0u));
    }
    return out;
}

/* The first byte of those of eight that are above four. */
static unsigned above_of(lum_field eight)
{
    return eight.at + (eight.order == LUM_ORDER_BIG ? 0u : 4u);
}

/* Whether eight bytes stand in the header, those above four being of no other
 * field. */
static bool has_room(const lum_infer_search *s, lum_field eight)
{
    const lum_infer_state *state = s->ticks.state;
    const unsigned above = above_of(eight);
    if (eight.at < LUM_INFER_FIELDS_AT || eight.at + 8u > state->samples.at) {
        return false;
    }
    for (unsigned at = above; at < above + 4u; at++) {
        if (state->used.byte[at] != 0) {
            return false;
        }
    }
    return true;
}

/* Whether those above four do not change. */
static bool is_steady(const lum_infer_search *s, lum_field eight)
{
    const unsigned first = 8u * above_of(eight);
    for (unsigned bit = first; bit < first + 32u; bit++) {
        if (lum_infer_is_varying(s, bit)) {
            return false;
        }
    }
    return true;
}

/* Four bytes that count on in four more, which bear anything: a clock of
 * eight. */
static void take_upper(lum_infer_search *s)
{
    const lum_field clock = s->best.field;
    const lum_field eight = resized(clock);
    if (clock.bytes != 4 || clock.bits != 0 || !has_room(s, eight) ||
        is_steady(s, eight)) {
        return;
    }
    get_times(&s->ticks, s->best.field, s->best.unit_ns, s->times);
    if (is_always_same(s, eight)) {
        s->best.field = eight;
    }
}

/* While what is above four bytes does not change, four and eight are the same
 * clock. */
static void find_resized(lum_infer_search *s, lum_field *equal)
{
    const lum_field clock = s->best.field;
    const lum_field other = resized(clock);
    const bool is_four = clock.bytes == 4;
    if (equal->bytes > 0 || clock.bits != 0 ||
        (is_four ? !has_room(s, other) : clock.bytes != 8)) {
        return;
    }
    if (is_steady(s, is_four ? other : clock) && is_always_same(s, other)) {
        *equal = other;
    }
}

/* --- Other clocks --- */

/* Whether a clock is none that the best one has bits of, and about as good a
 * clock by itself. */
static bool is_rival(const lum_infer_search *s, const lum_infer_candidate *c)
{
    return !lum_infer_share_bits(c->field, s->best.field) &&
           c->varying + FINE_BITS >= s->best.varying &&
           (c->is_round || !s->best.is_round) &&
           (!c->fit.is_counter || s->best.fit.is_counter);
}

/* Fields that give the same times, and the best one of other times. */
static void find_rivals(lum_infer_search *s, lum_infer_state *state)
{
    lum_infer_choice *clock = &state->field[LUM_FIELD_TIMESTAMP];
    get_times(&s->ticks, s->best.field, s->best.unit_ns, s->times);
    for (size_t i = 0; i < s->count; i++) {
        const lum_infer_candidate *c = &s->all[i];
        if (!is_rival(s, c)) {
            continue;
        }
        if (is_same_time(s, c)) {
            state->clock.equal = c->field;
        } else if (1.0 - c->badness > clock->second) {
            clock->second = 1.0 - c->badness;
            clock->rival = c->field;
            state->clock.rival_unit_ns = c->unit_ns;
        }
    }
    find_resized(s, &state->clock.equal);
}

/* --- Without a clock --- */

/* Whether a byte differs at most lines from the line before of its eye. */
static bool is_changing(const lum_infer_search *s, unsigned at)
{
    const lum_infer_state *state = s->ticks.state;
    const lum_field eye = state->field[LUM_FIELD_EYE].field;
    int last[2] = {-1, -1};
    size_t changed = 0;
    for (size_t i = 0; i < s->ticks.start_count; i++) {
        const uint8_t *bytes = s->ticks.packets[s->ticks.starts[i]]->bytes;
        const unsigned which =
            eye.bytes > 0 &&
            lum_infer_value(bytes, eye) == state->readings.best.eye_value[1];
        changed += last[which] >= 0 && last[which] != bytes[at];
        last[which] = bytes[at];
    }
    return changed * 2 > s->ticks.start_count;
}

/* A byte that may be a clock which wraps between lines: it is of no field,
 * numbers no lines and counts no packets. */
static void find_unread(const lum_infer_search *s, lum_infer_state *state)
{
    const lum_infer_bits lines = lum_infer_bits_of(state->readings.equal_line);
    for (unsigned at = LUM_INFER_FIELDS_AT; at < state->samples.at; at++) {
        const unsigned known =
            state->used.byte[at] | lines.byte[at] | s->counts.byte[at];
        if (known == 0 && is_changing(s, at)) {
            state->clock.unread_at = at;
            return;
        }
    }
}

/* --- Both passes --- */

/* The bits of the clock that change, and those of its lowest byte below them:
 * a clock of round steps leaves its lowest bits as they are. */
static void mark_bits(const lum_infer_search *s, lum_infer_clock *out)
{
    const lum_field field = s->best.field;
    bool is_below = true;
    out->whole = lum_infer_bits_of(field);
    for (unsigned i = 0; i < 8u * field.bytes; i++) {
        const unsigned bit = lum_infer_bit_at(field, i);
        is_below = is_below && i < 8 && !lum_infer_is_varying(s, bit);
        out->varying.byte[bit / 8u] |=
            (uint8_t)(is_below || lum_infer_is_varying(s, bit) ? 1u << bit % 8u
                                                               : 0u);
    }
}

static void take_clock(const lum_infer_search *s, lum_infer_state *state)
{
    lum_infer_choice *choice = &state->field[LUM_FIELD_TIMESTAMP];
    lum_infer_clock *clock = &state->clock;
    clock->has_times = s->ticks.has_times;
    clock->span_ns = s->ticks.has_times ? s->ticks.span_ns : 0.0;
    clock->unit_ns = 1000;
    if (s->best.field.bytes > 0) {
        choice->field = s->best.field;
        choice->share = 1.0 - s->best.badness;
        lum_infer_add_bits(&state->used, choice->field);
        clock->tick_ns = s->best.fit.tick_ns;
        clock->spread = s->best.fit.spread;
        clock->unit_ns = s->best.unit_ns;
        clock->is_unit_told = s->best.is_unit_told;
    }
}

static void search(lum_infer_search *s, lum_infer_state *state)
{
    if (s->ticks.count >= CLOCK_MIN) {
        lum_infer_search_clocks(s);
    }
    const bool is_any = s->best.field.bytes > 0;
    if (s->is_first) {
        if (is_any) {
            mark_bits(s, &state->clock);
        }
        return;
    }
    take_upper(s);
    take_clock(s, state);
    if (is_any) {
        find_rivals(s, state);
    } else if (s->ticks.has_times) {
        find_unread(s, state);
    }
    lum_infer_measure_lines(state, &s->ticks);
}

static int run(lum_infer_state *state, bool is_first)
{
    lum_infer_search s = {.is_first = is_first, .best = {.badness = 1.0}};
    const bool has_ticks = lum_infer_find_ticks(state, &s.ticks) == 0;
    s.all = malloc(LUM_INFER_WHOLE_MAX * sizeof *s.all);
    s.times = malloc((s.ticks.count + 1u) * sizeof *s.times);
    const bool failed = !has_ticks || s.all == NULL || s.times == NULL;
    if (!failed) {
        search(&s, state);
    }
    lum_infer_free_ticks(&s.ticks);
    free(s.all);
    free(s.times);
    return failed ? -1 : 0;
}

int lum_infer_follow_time(lum_infer_state *state)
{
    return run(state, true);
}

int lum_infer_find_clock(lum_infer_state *state)
{
    return run(state, false);
}
