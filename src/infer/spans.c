/* How long lines last. */
#include "fields.h"
#include "ticks.h"

/* Lines of which packets may come in any order. */
#define OPEN 8u

/* The default of line_span_us, and its step. */
#define LEAST_US 2000.0
#define STEP_US  100.0

/* A line some of whose packets came. */
typedef struct span {
    uint64_t line;
    uint64_t eye;
    int64_t low; /* ticks of its packets */
    int64_t high;
    size_t packets; /* 0: there is no line */
    size_t touched; /* when the last one came */
} span;

typedef struct spans {
    span open[OPEN];
    int64_t far;     /* ticks that two packets of a line are never apart */
    double *lengths; /* of lines that are over, in ticks */
    size_t count;
} spans;

static void end_span(spans *s, span *of)
{
    if (of->packets > 1) {
        s->lengths[s->count++] = (double)(of->high - of->low);
    }
    of->packets = 0;
}

/* The line that a packet is of, or else the one that has waited longest,
 * closed. */
static span *find(spans *s, uint64_t line, uint64_t eye, int64_t ticks)
{
    span *oldest = &s->open[0];
    for (unsigned i = 0; i < OPEN; i++) {
        span *of = &s->open[i];
        if (of->packets > 0 && of->line == line && of->eye == eye &&
            ticks - of->low < s->far && of->high - ticks < s->far) {
            return of;
        }
        if (of->packets == 0 ||
            (oldest->packets > 0 && of->touched < oldest->touched)) {
            oldest = of;
        }
    }
    end_span(s, oldest);
    *oldest = (span){.line = line, .eye = eye, .low = ticks, .high = ticks};
    return oldest;
}

static void follow(spans *s, const lum_infer_ticks *t)
{
    const lum_field line = t->state->field[LUM_FIELD_LINE].field;
    const lum_field eye = t->state->field[LUM_FIELD_EYE].field;
    for (size_t i = 0; i < t->count; i++) {
        const uint8_t *bytes = t->packets[i]->bytes;
        span *of =
            find(s, lum_infer_value(bytes, line),
                 eye.bytes == 0 ? 0 : lum_infer_value(bytes, eye), t->ticks[i]);
        of->low = t->ticks[i] < of->low ? t->ticks[i] : of->low;
        of->high = t->ticks[i] > of->high ? t->ticks[i] : of->high;
        of->packets++;
        of->touched = i;
    }
    for (unsigned i = 0; i < OPEN; i++) {
        end_span(s, &s->open[i]);
    }
}

/* Twice as long as lines last, but still less than lines of two frames are
 * apart. */
static uint32_t span_of(double line_us)
{
    const double twice = 2.0 * line_us;
    if (twice <= LEAST_US) {
        return (uint32_t)LEAST_US;
    }
    return twice >= LUM_INFER_GAP_US - STEP_US
               ? (uint32_t)(LUM_INFER_GAP_US - STEP_US)
               : (uint32_t)(twice / STEP_US + 1.0) * (uint32_t)STEP_US;
}

void lum_infer_measure_lines(lum_infer_state *state, lum_infer_ticks *t)
{
    spans s = {.lengths = t->sorted};
    const lum_field clock = state->field[LUM_FIELD_TIMESTAMP].field;
    if (clock.bytes > 0 && t->count > 0) {
        (void)lum_infer_extend(t, clock);
        s.far = (int64_t)(LUM_INFER_GAP_US * 1000.0 / state->clock.unit_ns) + 1;
        follow(&s, t);
    }
    /* A tenth of the lines may have a packet whose clock is corrupt. */
    if (s.count > 0) {
        state->line_us = lum_infer_quantile(s.lengths, s.count, 0.9) *
                         state->clock.unit_ns / 1000.0;
    }
    state->line_span_us = span_of(state->line_us);
}
