#include "pause.h"

#include <string.h>

/* Fewer lines than this are not clearly more; of long times, a share, as the
 * period is not exact. */
#define LINES_MIN   5
#define LINES_SHARE 24

/* Of arrivals. */
#define ARRIVAL_LEAST_US 1000000

/* Lines that the period is the mean of: at most so many. */
#define WINDOW_LINES 256

/* The period is learned anew after so many lines that fit nothing. */
#define STRANGE_MAX 32u

/* The assembler counts lines as skipped up to a reach of reordering later. */
#define FRESH_LINES 40u

/* Longer times are not computed with: 17 years. Nor is more than that, or a
 * longer period. */
#define TIME_MAX_US   (INT64_C(1) << 49)
#define LINES_MAX     (INT64_C(1) << 30)
#define PERIOD_MAX_US (INT64_C(1) << 20)
#define TURNS_MAX     100

/* Of an index; clocks of lines lie within it. */
#define CLOCK_MAX_US (INT64_C(1) << 62)

/* --- Small things --- */

static int64_t clamp(int64_t x, int64_t most)
{
    return x > most ? most : x < -most ? -most : x;
}

/* Whatever they are. */
static int64_t minus(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a - (uint64_t)b);
}

static int64_t between_us(const lum_pause_line *a, const lum_pause_line *b)
{
    return clamp(minus(b->clock_us, a->clock_us), TIME_MAX_US);
}

static int64_t span_us(const lum_pause_eye *e, int64_t lines)
{
    return clamp(lines, LINES_MAX) * e->sum_us / e->sum_lines;
}

/* How many periods a time is, rounded. */
static int64_t periods(const lum_pause_eye *e, int64_t us)
{
    const int64_t half = us < 0 ? -e->sum_us / 2 : e->sum_us / 2;
    return (us * e->sum_lines + half) / e->sum_us;
}

static int64_t steps(const lum_pause_line *a, const lum_pause_line *b)
{
    return (int64_t)b->number - (int64_t)a->number;
}

/* What is still no more than usual. */
static int64_t slack_us(const lum_pause *p, const lum_pause_eye *e)
{
    const int64_t lines_us = span_us(e, 2 * LINES_MIN - 1) / 2;
    return (lines_us > p->least_us ? lines_us : p->least_us) + p->tick_us;
}

void lum_pause_init(lum_pause *p, uint32_t gap_us, const lum_profile *profile)
{
    memset(p, 0, sizeof *p);
    p->by_arrival = profile->group[LUM_FIELD_TIMESTAMP].bytes == 0;
    p->gap_us = p->by_arrival ? INT64_MAX : (int64_t)gap_us;
    p->least_us = p->by_arrival ? ARRIVAL_LEAST_US : 0;
    p->tick_us =
        p->by_arrival ? 0 : ((int64_t)profile->clock_unit_ns + 999) / 1000;
}

/* --- Whether clock and number of two lines agree --- */

/* From the first line of a sweep to that of the next. from: a line of it. */
static int64_t sweep_us(const lum_pause_eye *e, uint32_t from)
{
    const uint32_t lines =
        e->has_turn && e->sweep > from ? e->sweep : from + UINT32_C(1);
    return span_us(e, lines) + e->turn_us;
}

/* Sweeps that end between lines of two frames, as frames tell it. A straggler
 * is of an earlier frame. */
static int32_t turns(uint32_t from, uint32_t to)
{
    const int32_t n = (int32_t)(to - from);
    return n > 0 ? n : 0;
}

/* How much later the second comes than its number says. frame: that of the
 * first. */
static int64_t excess_us(const lum_pause_eye *e, const lum_pause_line *a,
                         uint32_t frame, const lum_pause_line *b)
{
    const int64_t n = turns(frame, b->frame);
    return between_us(a, b) - span_us(e, steps(a, b)) -
           (n < TURNS_MAX ? n : TURNS_MAX) * sweep_us(e, a->number);
}

static bool agree(const lum_pause *p, const lum_pause_eye *e,
                  const lum_pause_line *a, uint32_t frame,
                  const lum_pause_line *b)
{
    const int64_t slack = slack_us(p, e);
    const int64_t excess = excess_us(e, a, frame, b);
    return excess >= -slack && excess <= slack;
}

/* --- What the assembler counts as skipped --- */

/* By how much a line lets the gap of its frame grow. */
static int64_t skipped(const lum_pause_eye *e, const lum_pause_line *b,
                       bool is_break)
{
    if (turns(e->frame, b->frame) > 0) {
        return is_break ? 0 : b->number;
    }
    if (b->frame != e->frame || b->number == e->top) {
        return 0;
    }
    if (b->number > e->top) {
        return (int64_t)b->number - (int64_t)e->top - 1;
    }
    return e->gap > 0 ? -1 : 0;
}

static void number(lum_pause_eye *e, const lum_pause_line *b, bool is_break)
{
    const bool is_new = turns(e->frame, b->frame) > 0;
    const int64_t grown = skipped(e, b, is_break);
    e->gap = (uint32_t)((is_new ? 0 : (int64_t)e->gap) + grown);
    if (is_new || (b->frame == e->frame && b->number > e->top)) {
        e->top = b->number;
    }
    e->frame = is_new ? b->frame : e->frame;
}

/* --- Pauses are told --- */

static void mark(lum_pause *p, unsigned eye, uint32_t frame, int64_t lines)
{
    lum_pause_frame *f = NULL;
    for (unsigned i = 0; i < LUM_PAUSE_FRAMES; i++) {
        if (p->frames[i].eyes != 0 && p->frames[i].frame == frame) {
            f = &p->frames[i];
        }
    }
    if (f == NULL) {
        f = &p->frames[p->frames_next];
        p->frames_next = (uint8_t)((p->frames_next + 1u) % LUM_PAUSE_FRAMES);
        *f = (lum_pause_frame){.frame = frame};
    }
    f->eyes = (uint8_t)(f->eyes | 1u << eye);
    f->lines[eye] += (uint64_t)lines;
}

/* Of an eye that paused alone. Earlier ones were handed out meanwhile. */
static void mark_between(lum_pause *p, unsigned eye, uint32_t before,
                         uint32_t behind)
{
    for (uint32_t back = 1; back < LUM_PAUSE_FRAMES; back++) {
        if (turns(before, behind - back) > 0) {
            mark(p, eye, behind - back, 0);
        }
    }
}

/* Frames that have lines on both sides, or lack their end by it. */
static void mark_frames(lum_pause *p, unsigned eye, const lum_pause_line *b,
                        int64_t lines)
{
    const lum_pause_eye *e = &p->eye[eye];
    const int64_t end = (int64_t)e->sweep - 1 - (int64_t)e->last.number;
    if (turns(e->frame, b->frame) == 0) {
        mark(p, eye, e->frame, lines);
        if (b->frame != e->frame) {
            mark(p, eye, b->frame, 0);
        }
        return;
    }
    mark_between(p, eye, e->frame, b->frame);
    if (!e->has_turn) {
        mark(p, eye, e->frame, lines);
    } else if (end > 0) {
        mark(p, eye, e->frame, end < lines ? end : lines);
    }
}

static void count_lines(lum_pause *p, unsigned eye, int64_t lines)
{
    p->lines[eye] += (uint64_t)lines;
    p->counts.lines += p->is_counted ? (uint64_t)lines : 0;
}

static int64_t length_us(const lum_pause *p)
{
    return p->to_us - p->from_us;
}

static void uncount(lum_pause *p)
{
    p->has_pause = false;
    p->counts.pauses -= p->is_counted ? 1u : 0;
    p->counts.paused_us -= p->is_counted ? (uint64_t)length_us(p) : 0;
}

/* Numbers showed later that these lines are not missing beside them. */
static void take_back(lum_pause *p, unsigned eye, int64_t lines)
{
    const int64_t had = (int64_t)p->lines[eye];
    if (!p->has_pause || !p->has_eye[eye]) {
        return;
    }
    if (had - lines >= LINES_MIN) {
        count_lines(p, eye, -lines);
        return;
    }
    count_lines(p, eye, -had);
    p->has_eye[eye] = false;
    if (!p->has_eye[LUM_EYE_BLUE] && !p->has_eye[LUM_EYE_GREEN]) {
        uncount(p);
    }
}

static void begin(lum_pause *p, int64_t from_us, int64_t to_us)
{
    p->has_pause = true;
    p->is_counted = true;
    p->from_us = from_us;
    p->to_us = to_us;
    memset(p->has_eye, 0, sizeof p->has_eye);
    memset(p->lines, 0, sizeof p->lines);
    p->counts.pauses++;
    p->counts.paused_us += (uint64_t)length_us(p);
    for (unsigned i = 0; i < LUM_EYES; i++) {
        p->eye[i].is_first_turn = false; /* it is a pause for good */
    }
}

/* Both eyes pause together. */
static void join(lum_pause *p, unsigned eye, int64_t from_us, int64_t to_us)
{
    const int64_t slack = slack_us(p, &p->eye[eye]);
    if (p->has_pause && !p->has_eye[eye] && from_us <= p->to_us + slack &&
        p->from_us <= to_us + slack) {
        const int64_t before = length_us(p);
        p->from_us = from_us < p->from_us ? from_us : p->from_us;
        p->to_us = to_us > p->to_us ? to_us : p->to_us;
        p->counts.paused_us +=
            p->is_counted ? (uint64_t)(length_us(p) - before) : 0;
    } else {
        begin(p, from_us, to_us);
    }
    p->has_eye[eye] = true;
}

/* How long nothing came before a line. A clock that jumped tells it only as far
 * as the host's clock agrees: the sensor may have started again. */
static int64_t silence_us(const lum_pause_eye *e, const lum_pause_line *b,
                          bool is_break)
{
    const int64_t by_clock = between_us(&e->last, b);
    const int64_t by_host =
        clamp(minus(b->arrival_ns, e->last.arrival_ns) / 1000, TIME_MAX_US);
    const bool is_doubtful =
        is_break &&
        (by_clock <= 0 ||
         (by_host > 0 && by_clock > 2 * by_host + ARRIVAL_LEAST_US));
    const int64_t us = is_doubtful ? by_host : by_clock;
    return us > 0 ? us : 0;
}

/* Without what the mirror takes to turn. */
static int64_t scanned_us(const lum_pause_eye *e, const lum_pause_line *b,
                          int64_t us)
{
    if (!e->has_turn || e->is_first_turn || e->turn_us == 0) {
        return us;
    }
    const int64_t sweep = sweep_us(e, e->last.number);
    const int64_t rest = us - span_us(e, steps(&e->last, b));
    const int64_t n = (rest + sweep / 2) / sweep;
    return n > 0 ? us - n * e->turn_us : us;
}

/* Lines that the clock shows to be missing before a line, but not its number.
 */
static int64_t missing(const lum_pause_eye *e, const lum_pause_line *b,
                       bool is_break)
{
    const int64_t us = silence_us(e, b, is_break);
    return periods(e, scanned_us(e, b, us)) - 1 - skipped(e, b, is_break);
}

static bool is_clear(const lum_pause *p, const lum_pause_eye *e,
                     const lum_pause_line *b, int64_t lines)
{
    const int64_t all = periods(e, between_us(&e->last, b));
    return lines >= LINES_MIN && lines >= all / LINES_SHARE &&
           span_us(e, lines) > 2 * p->tick_us + p->least_us;
}

static void tell(lum_pause *p, unsigned eye, const lum_pause_line *b,
                 bool is_break, int64_t lines)
{
    lum_pause_eye *e = &p->eye[eye];
    const int64_t us = silence_us(e, b, is_break) - span_us(e, 1);
    lines = lines > 0 ? lines : 0;
    join(p, eye, b->clock_us - (us > 0 ? us : 0), b->clock_us);
    count_lines(p, eye, lines);
    mark_frames(p, eye, b, lines);
    e->fresh = FRESH_LINES;
}

/* --- What is learned --- */

/* Of the end of a sweep: how many lines it has, and how long the mirror takes
 * to turn. */
static void learn_turn(lum_pause *p, unsigned eye, const lum_pause_line *b)
{
    lum_pause_eye *e = &p->eye[eye];
    const int64_t slack = slack_us(p, e);
    const uint32_t lines = e->last.number + 1u;
    const int64_t sweep =
        between_us(&e->last, b) - span_us(e, steps(&e->last, b));
    const int64_t turn = sweep - span_us(e, lines);
    if (!e->has_turn) {
        e->has_turn = true;
        e->sweep = lines;
        e->turn_us = turn > slack ? turn : 0;
        e->is_first_turn = turn > slack;
        return;
    }
    if (excess_us(e, &e->last, e->frame, b) > slack) {
        return;
    }
    if (e->is_first_turn && turn >= e->turn_us - slack) {
        take_back(p, eye, INT64_MAX);
    }
    e->is_first_turn = false;
    e->sweep = lines > e->sweep ? lines : e->sweep;
    if (sweep < span_us(e, e->sweep) - slack) {
        e->sweep = lines;
    }
    const int64_t rest = sweep - span_us(e, e->sweep);
    e->turn_us = rest > slack ? rest : 0;
}

static void learn_period(lum_pause_eye *e, const lum_pause_line *b)
{
    const int64_t n = steps(&e->last, b);
    if (b->frame != e->last.frame || n <= 0 || n > LINES_MIN) {
        return;
    }
    e->sum_us += between_us(&e->last, b);
    e->sum_lines += n;
    if (e->sum_lines >= WINDOW_LINES) {
        e->sum_us = (e->sum_us + 1) / 2;
        e->sum_lines = (e->sum_lines + 1) / 2;
    }
    e->has_period = e->sum_us / e->sum_lines <= PERIOD_MAX_US;
}

/* --- Lines that fit, and lines that do not yet --- */

/* A line that is the next one. is_behind: of one that was doubted. */
static void accept(lum_pause *p, unsigned eye, const lum_pause_line *b,
                   bool is_break, bool is_behind)
{
    lum_pause_eye *e = &p->eye[eye];
    const bool is_turn = !is_break && turns(e->frame, b->frame) == 1 &&
                         b->number < e->last.number;
    const bool is_first = is_turn && !e->has_turn;
    if (is_turn && !is_first) {
        learn_turn(p, eye, b);
    }
    const int64_t lines = missing(e, b, is_break);
    if (is_break || (!is_behind && is_clear(p, e, b, lines))) {
        tell(p, eye, b, is_break, lines);
    } else if (lines <= -LINES_MIN && e->fresh > 0) {
        take_back(p, eye, -lines);
    }
    if (is_first) {
        learn_turn(p, eye, b);
    } else if (!is_turn && !is_break && agree(p, e, &e->last, e->frame, b)) {
        learn_period(e, b);
    }
    number(e, b, is_break);
    e->fresh = (uint8_t)(e->fresh > 0 ? e->fresh - 1u : 0);
    e->last = *b;
}

static void confirm(lum_pause *p, unsigned eye)
{
    lum_pause_eye *e = &p->eye[eye];
    const unsigned n = e->next_count;
    const bool is_break = e->is_break;
    e->next_count = 0;
    e->is_break = false;
    e->strange = 0;
    for (unsigned i = 0; i < n; i++) {
        accept(p, eye, &e->next[i], is_break && i == 0, i > 0);
    }
}

/* A line that does not fit, after others that did not. */
static void doubt(lum_pause *p, unsigned eye, const lum_pause_line *b)
{
    lum_pause_eye *e = &p->eye[eye];
    const lum_pause_line *before =
        e->next_count > 0 ? &e->next[e->next_count - 1u] : NULL;
    const bool fits = before != NULL &&
                      (e->is_break || agree(p, e, before, before->frame, b));
    if (fits && b->clock_us < before->clock_us) {
        return; /* overtaken */
    }
    e->strange++;
    if (!fits && e->next_count > 1u) {
        e->next_count--;
        return;
    }
    e->next[fits ? e->next_count : 0u] = *b;
    e->next_count = (uint8_t)(fits ? e->next_count + 1u : 1u);
    if (e->next_count == LUM_PAUSE_CONFIRM) {
        confirm(p, eye);
    }
}

static void forget(lum_pause_eye *e)
{
    *e = (lum_pause_eye){.highest_us = e->highest_us};
}

/* Whether the clock has jumped before a line; an assembler of packets drops all
 * others that are so far away. */
static bool breaks(lum_pause *p, lum_pause_eye *e, const lum_pause_line *b)
{
    const int64_t lead = minus(b->clock_us, e->highest_us);
    const bool is_break = lead > p->gap_us || lead < -p->gap_us;
    if (is_break || lead > 0) {
        e->highest_us = b->clock_us;
    }
    return is_break;
}

static void take_fitted(lum_pause *p, unsigned eye, const lum_pause_line *b,
                        bool is_decided)
{
    lum_pause_eye *e = &p->eye[eye];
    if (!e->has_last && is_decided) {
        e->has_last = true;
        e->gap = 0;
        e->highest_us = b->clock_us;
        e->last = *b;
        e->frame = b->frame;
        e->top = b->number;
        return;
    }
    if (e->has_last && breaks(p, e, b)) {
        p->counts.breaks++;
        e->is_break = true;
        e->next_count = 0;
    }
    if (!is_decided) {
        return;
    }
    const bool fits = !e->is_break && agree(p, e, &e->last, e->frame, b);
    if (fits && b->clock_us < e->last.clock_us) {
        return; /* overtaken */
    }
    if (!fits || is_clear(p, e, b, missing(e, b, false))) {
        doubt(p, eye, b);
    } else {
        e->next_count = 0;
        e->strange = 0;
        accept(p, eye, b, false, false);
    }
    if (e->strange >= STRANGE_MAX) {
        forget(e);
    }
}

/* --- Before the period is known --- */

/* The middle one of the steps from line to line. */
static bool find_period(lum_pause_eye *e)
{
    int64_t ns[LUM_PAUSE_SAMPLES];
    unsigned n = 0;
    for (unsigned i = 1; i < e->sample_count; i++) {
        const lum_pause_line *a = &e->sample[i - 1u];
        const lum_pause_line *b = &e->sample[i];
        const int64_t us = between_us(a, b);
        if (b->frame != a->frame || steps(a, b) <= 0 || us <= 0 ||
            us > PERIOD_MAX_US) {
            continue;
        }
        const int64_t step = us * 1000 / steps(a, b);
        unsigned at = n++;
        for (; at > 0 && ns[at - 1u] > step; at--) {
            ns[at] = ns[at - 1u];
        }
        ns[at] = step;
    }
    if (n < 3u || ns[n / 2u] <= 0) {
        return false;
    }
    e->sum_us = (ns[n / 2u] * 8 + 999) / 1000;
    e->sum_lines = 8;
    e->has_period = true;
    return true;
}

static void learn(lum_pause *p, unsigned eye)
{
    lum_pause_eye *e = &p->eye[eye];
    lum_pause_line sample[LUM_PAUSE_SAMPLES];
    const unsigned n = e->sample_count;
    if (!find_period(e)) {
        return;
    }
    memcpy(sample, e->sample, sizeof sample);
    e->sample_count = 0;
    for (unsigned i = 0; i < n; i++) {
        take_fitted(p, eye, &sample[i], true);
    }
}

/* Lines of one tick of a coarse clock tell nothing but the first. */
static void take_sample(lum_pause *p, unsigned eye, const lum_pause_line *b)
{
    lum_pause_eye *e = &p->eye[eye];
    if (e->sample_count > 0 &&
        e->sample[e->sample_count - 1u].clock_us == b->clock_us) {
        return;
    }
    if (e->sample_count == LUM_PAUSE_SAMPLES) {
        e->sample_count--;
        memmove(e->sample, e->sample + 1, e->sample_count * sizeof *b);
    }
    e->sample[e->sample_count++] = *b;
    if (e->sample_count == LUM_PAUSE_SAMPLES) {
        learn(p, eye);
    }
}

void lum_pause_take(lum_pause *p, const lum_line *line, bool is_decided)
{
    lum_pause_eye *e = &p->eye[line->eye];
    const lum_pause_line b = {.clock_us = p->by_arrival ? line->arrival / 1000
                                                        : line->clock_us,
                              .arrival_ns = line->arrival,
                              .number = line->number,
                              .frame = (uint32_t)line->frame};
    if (e->has_period) {
        take_fitted(p, line->eye, &b, is_decided);
    } else if (is_decided) {
        take_sample(p, line->eye, &b);
    }
}

/* --- Ends --- */

void lum_pause_end(lum_pause *p)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        lum_pause_eye *e = &p->eye[eye];
        if (!e->has_period) {
            learn(p, eye);
        }
        if (e->next_count > 1u || (e->next_count > 0 && e->is_break)) {
            confirm(p, eye);
        }
        e->next_count = 0;
    }
}

void lum_pause_join(lum_pause *p)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        p->eye[eye].sample_count = 0;
        p->eye[eye].next_count = 0;
        p->eye[eye].is_break = false;
        p->eye[eye].has_last = false;
    }
}

/* The latest line of an eye; NULL: there is none. */
static const lum_pause_line *newest(const lum_pause_eye *e)
{
    return e->next_count > 0     ? &e->next[e->next_count - 1u]
           : e->sample_count > 0 ? &e->sample[e->sample_count - 1u]
           : e->has_last         ? &e->last
                                 : NULL;
}

/* Whether an eye has stopped before the end of a frame, of which no line is
 * expected any more. */
static bool has_stopped(const lum_pause_eye *e, uint32_t frame)
{
    const lum_pause_line *last = newest(e);
    if (last == NULL || turns(frame, last->frame) > 0) {
        return false;
    }
    return last->frame != frame || !e->has_turn ||
           last->number + UINT64_C(1) < e->sweep;
}

static bool is_wanted(unsigned eyes, unsigned eye)
{
    return (eyes >> eye & 1u) != 0;
}

/* Pauses that are known to lie in a frame. */
static bool take_marks(lum_pause *p, uint32_t frame, unsigned eyes,
                       uint64_t *lines)
{
    for (unsigned i = 0; i < LUM_PAUSE_FRAMES; i++) {
        lum_pause_frame *f = &p->frames[i];
        if (f->eyes != 0 && f->frame == frame) {
            const bool is_marked = (f->eyes & eyes) != 0;
            f->eyes = 0;
            *lines += is_wanted(eyes, LUM_EYE_BLUE) ? f->lines[0] : 0;
            *lines += is_wanted(eyes, LUM_EYE_GREEN) ? f->lines[1] : 0;
            return is_marked;
        }
    }
    return false;
}

bool lum_pause_frame_ends(lum_pause *p, uint32_t frame, unsigned eyes,
                          bool is_end, uint64_t *lines)
{
    bool has_pause = false;
    *lines = 0;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        if (p->eye[eye].next_count > 1u) {
            confirm(p, eye);
        }
        has_pause = has_pause || (is_wanted(eyes, eye) && !is_end &&
                                  has_stopped(&p->eye[eye], frame));
    }
    return take_marks(p, frame, eyes, lines) || has_pause;
}

/* --- As bytes --- */

static void pack_line(lum_pack *p, lum_pause_line *line)
{
    const int64_t most = CLOCK_MAX_US;
    lum_pack_i64(p, &line->clock_us);
    lum_pack_i64(p, &line->arrival_ns);
    lum_pack_u32(p, &line->number);
    lum_pack_u32(p, &line->frame);
    if (!lum_pack_check(p, line->clock_us >= -most && line->clock_us <= most &&
                               line->arrival_ns >= -most &&
                               line->arrival_ns <= most)) {
        *line = (lum_pause_line){.clock_us = 0};
    }
}

static void pack_lines(lum_pack *p, lum_pause_line *lines, uint8_t *count,
                       uint8_t most)
{
    lum_pack_u8(p, count);
    if (!lum_pack_check(p, *count <= most)) {
        *count = 0;
    }
    for (unsigned i = 0; i < *count; i++) {
        pack_line(p, &lines[i]);
    }
}

static bool is_possible(const lum_pause_eye *e)
{
    const bool has_period = e->sum_lines > 0 && e->sum_lines <= WINDOW_LINES &&
                            e->sum_us > 0 &&
                            e->sum_us / e->sum_lines <= PERIOD_MAX_US;
    return (has_period || (!e->has_period && e->next_count == 0)) &&
           e->turn_us >= 0 && e->turn_us < 4 * TIME_MAX_US &&
           e->next_count < LUM_PAUSE_CONFIRM &&
           e->sample_count <= LUM_PAUSE_SAMPLES &&
           e->highest_us >= -CLOCK_MAX_US && e->highest_us <= CLOCK_MAX_US;
}

static void pack_eye(lum_pack *p, lum_pause_eye *e)
{
    lum_pack_bool(p, &e->has_period);
    lum_pack_bool(p, &e->has_last);
    lum_pack_bool(p, &e->has_turn);
    lum_pack_bool(p, &e->is_first_turn);
    lum_pack_bool(p, &e->is_break);
    lum_pack_u8(p, &e->strange);
    lum_pack_u8(p, &e->fresh);
    pack_lines(p, e->sample, &e->sample_count, LUM_PAUSE_SAMPLES);
    pack_lines(p, e->next, &e->next_count, LUM_PAUSE_CONFIRM);
    pack_line(p, &e->last);
    lum_pack_i64(p, &e->highest_us);
    lum_pack_i64(p, &e->sum_us);
    lum_pack_i64(p, &e->sum_lines);
    lum_pack_i64(p, &e->turn_us);
    lum_pack_u32(p, &e->sweep);
    lum_pack_u32(p, &e->frame);
    lum_pack_u32(p, &e->top);
    lum_pack_u32(p, &e->gap);
    if (!lum_pack_check(p, is_possible(e))) {
        forget(e);
    }
}

static void pack_frame(lum_pack *p, lum_pause_frame *f)
{
    lum_pack_u8(p, &f->eyes);
    if (!lum_pack_check(p, f->eyes < 1u << LUM_EYES)) {
        f->eyes = 0;
    }
    if (f->eyes != 0) {
        lum_pack_u32(p, &f->frame);
        lum_pack_u64(p, &f->lines[LUM_EYE_BLUE]);
        lum_pack_u64(p, &f->lines[LUM_EYE_GREEN]);
    }
}

static void pack_latest(lum_pause *p, lum_pack *pack)
{
    lum_pack_bool(pack, &p->has_pause);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        lum_pack_bool(pack, &p->has_eye[eye]);
        lum_pack_u64(pack, &p->lines[eye]);
    }
    lum_pack_i64(pack, &p->from_us);
    lum_pack_i64(pack, &p->to_us);
    if (lum_pack_is_reading(pack)) {
        p->is_counted = false;
        (void)lum_pack_check(
            pack, p->from_us >= -CLOCK_MAX_US && p->from_us <= p->to_us &&
                      p->to_us <= CLOCK_MAX_US &&
                      p->lines[LUM_EYE_BLUE] <= (uint64_t)CLOCK_MAX_US &&
                      p->lines[LUM_EYE_GREEN] <= (uint64_t)CLOCK_MAX_US);
    }
}

void lum_pause_pack(lum_pause *p, lum_pack *pack)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        pack_eye(pack, &p->eye[eye]);
    }
    for (unsigned i = 0; i < LUM_PAUSE_FRAMES; i++) {
        pack_frame(pack, &p->frames[i]);
    }
    pack_latest(p, pack);
    lum_pack_u8(pack, &p->frames_next);
    if (!lum_pack_check(pack, p->frames_next < LUM_PAUSE_FRAMES)) {
        p->frames_next = 0;
    }
}
