/* Which lines of an eye fit to those before, by clock and number. One that does
 * not tells nothing alone: its clock or its number may be corrupt. The lines
 * behind it confirm it. */
#include "pause.h"

/* Of long times, a share is not clearly more, as the period is not exact. */
#define LINES_SHARE 24

/* Lines that agree before a pause is told: the first one behind it counts. */
#define CONFIRM 3u

/* The period is learned anew after so many lines that fit nothing. */
#define STRANGE_MAX 32u

/* A host's clock that went on by so much more than the sensor's. */
#define DOUBT_US 1000000

/* --- What the assembler counts as skipped, and what only the clock shows ---
 */

/* By how much a line lets the gap of its frame grow. */
static int64_t skipped(const lum_pause_place *at, const lum_pause_line *b,
                       bool is_break)
{
    if (lum_pause_turns(at->frame, b->frame) > 0) {
        return is_break ? 0 : b->number;
    }
    return b->frame == at->frame && b->number > at->top
               ? (int64_t)b->number - (int64_t)at->top - 1
               : 0;
}

static lum_pause_place place_of(const lum_pause_place *at,
                                const lum_pause_line *b)
{
    const bool is_new = lum_pause_turns(at->frame, b->frame) > 0;
    const bool is_top =
        is_new || (b->frame == at->frame && b->number > at->top);
    return (lum_pause_place){.line = *b,
                             .frame = is_new ? b->frame : at->frame,
                             .top = is_top ? b->number : at->top};
}

/* How long nothing came before a line. A clock that jumped tells it only as far
 * as the host's clock agrees: the sensor may have started again. */
static int64_t silence_us(const lum_pause_line *a, const lum_pause_line *b,
                          bool is_break)
{
    const int64_t by_clock = lum_pause_between_us(a, b);
    const int64_t by_host =
        lum_pause_minus(b->arrival_ns, a->arrival_ns) / 1000;
    const bool is_doubtful =
        is_break && (by_clock <= 0 || (by_host > 0 && by_clock > DOUBT_US &&
                                       (by_clock - DOUBT_US) / 2 > by_host));
    const int64_t us = is_doubtful ? by_host : by_clock;
    return us < LUM_PAUSE_TIME_MAX_US ? us : LUM_PAUSE_TIME_MAX_US;
}

/* Lines that the clock shows to be missing before a line, and its number does
 * not. */
static int64_t unseen(const lum_pause_eye *e, const lum_pause_place *at,
                      const lum_pause_line *b, bool is_break)
{
    const int64_t us = silence_us(&at->line, b, is_break);
    return lum_pause_scan_lines(&e->scan, &at->line, b, us) -
           skipped(at, b, is_break);
}

/* Whether they are clearly more than none. */
static bool is_clear(const lum_pause_eye *e, const lum_pause_clock *clock,
                     const lum_pause_line *a, const lum_pause_line *b,
                     int64_t lines)
{
    const int64_t share_us = lum_pause_between_us(a, b) / LINES_SHARE;
    const int64_t us = lum_pause_scan_us(&e->scan, lines);
    return lines >= LUM_PAUSE_LINES_MIN && us >= share_us &&
           us > 2 * clock->tick_us + clock->least_us;
}

/* --- Lines that fit --- */

static bool is_turn(const lum_pause_place *at, const lum_pause_line *b)
{
    return lum_pause_turns(at->frame, b->frame) == 1 &&
           b->number < at->line.number;
}

static void learn_turn(lum_pause_eye *e, const lum_pause_line *b, bool is_pause,
                       lum_pause_found *out)
{
    const int64_t lines =
        lum_pause_scan_turn(&e->scan, &e->last.line, b, is_pause);
    if (lines > 0) {
        out->turn_lines = lines;
        out->turn_us = e->scan.first_us;
    }
}

static void accept(lum_pause_eye *e, const lum_pause_line *b,
                   lum_pause_found *out)
{
    if (is_turn(&e->last, b)) {
        learn_turn(e, b, false, out);
    }
    out->lines += unseen(e, &e->last, b, false);
    lum_pause_scan_follow(&e->scan, &e->last.line, b);
    e->last = place_of(&e->last, b);
    e->next_count = 0;
    e->strange = 0;
}

/* --- Lines that do not fit yet --- */

static void tell(lum_pause_eye *e, lum_pause_found *out)
{
    const lum_pause_line *b = &e->doubted;
    const int64_t us = silence_us(&e->last.line, b, e->is_break) -
                       lum_pause_scan_us(&e->scan, 1);
    const int64_t all = unseen(e, &e->last, b, e->is_break);
    const int64_t lines = all > 0 ? all : 0;
    const int64_t end = (int64_t)e->scan.sweep - 1 - e->last.line.number;
    out->has_pause = true;
    out->is_break = e->is_break;
    out->from_us = b->clock_us - (us > 0 ? us : 0);
    out->to_us = b->clock_us;
    out->before = e->last.frame;
    out->behind = b->frame;
    out->lines += lines;
    out->lines_before = lum_pause_turns(out->before, out->behind) == 0 ||
                                e->scan.sweep == 0 || end > lines
                            ? lines
                        : end > 0 ? end
                                  : 0;
}

static void confirm(lum_pause_eye *e, lum_pause_found *out)
{
    tell(e, out);
    if (!e->is_break && is_turn(&e->last, &e->doubted)) {
        learn_turn(e, &e->doubted, true, out);
    }
    out->lines += e->next_lines;
    e->last = e->next;
    e->next_count = 0;
    e->is_break = false;
    e->strange = 0;
}

static void doubt(lum_pause_eye *e, const lum_pause_clock *clock,
                  const lum_pause_line *b, lum_pause_found *out)
{
    const int64_t lines = e->next_count > 0 ? unseen(e, &e->next, b, false) : 0;
    e->strange++;
    if (e->next_count > 0 && b->clock_us >= e->next.line.clock_us &&
        !is_clear(e, clock, &e->next.line, b, lines)) {
        e->next_count++;
        e->next_lines += lines;
        e->next = place_of(&e->next, b);
    } else {
        e->next_count = 1;
        e->next_lines = 0;
        e->doubted = *b;
        e->next = place_of(&e->last, b);
    }
    if (e->next_count == CONFIRM) {
        confirm(e, out);
    }
}

/* Whether the clock has jumped before a line; an assembler of packets drops all
 * others that are so far away. */
static bool breaks(lum_pause_eye *e, const lum_pause_clock *clock,
                   const lum_pause_line *b)
{
    const int64_t lead = lum_pause_minus(b->clock_us, e->highest_us);
    const bool is_break = lead > clock->gap_us || lead < -clock->gap_us;
    if (is_break || lead > 0) {
        e->highest_us = b->clock_us;
    }
    return is_break;
}

static void take_fitted(lum_pause_eye *e, const lum_pause_clock *clock,
                        const lum_pause_line *b, bool is_decided,
                        lum_pause_found *out)
{
    if (!e->has_last) {
        e->has_last = is_decided;
        e->highest_us = b->clock_us;
        e->last = (lum_pause_place){*b, b->frame, b->number};
        return;
    }
    if (breaks(e, clock, b)) {
        out->breaks++;
        e->is_break = true;
        e->next_count = 0;
    }
    if (!is_decided) {
        return;
    }
    const bool is_back = b->clock_us < e->last.line.clock_us;
    if (e->is_break ||
        is_clear(e, clock, &e->last.line, b, unseen(e, &e->last, b, false))) {
        doubt(e, clock, b, out);
    } else if (is_back) {
        e->strange++; /* overtaken, or corrupt */
    } else {
        accept(e, b, out);
    }
    if (e->strange >= STRANGE_MAX) {
        *e = (lum_pause_eye){.highest_us = e->highest_us};
    }
}

/* --- Before the period is known --- */

static bool has_period(const lum_pause_eye *e)
{
    return e->scan.sum_lines > 0;
}

static void learn(lum_pause_eye *e, const lum_pause_clock *clock,
                  lum_pause_found *out)
{
    const unsigned n = e->sample_count;
    if (!lum_pause_scan_begin(&e->scan, e->sample, n)) {
        return;
    }
    e->sample_count = 0;
    for (unsigned i = 0; i < n; i++) {
        take_fitted(e, clock, &e->sample[i], true, out);
    }
}

/* Lines of one tick of a coarse clock tell nothing but the first. */
static void take_sample(lum_pause_eye *e, const lum_pause_clock *clock,
                        const lum_pause_line *b, lum_pause_found *out)
{
    if (e->sample_count > 0 &&
        e->sample[e->sample_count - 1u].clock_us == b->clock_us) {
        return;
    }
    if (e->sample_count == LUM_PAUSE_SAMPLES) {
        e->sample_count--;
        for (unsigned i = 0; i < e->sample_count; i++) {
            e->sample[i] = e->sample[i + 1u];
        }
    }
    e->sample[e->sample_count++] = *b;
    if (e->sample_count == LUM_PAUSE_SAMPLES) {
        learn(e, clock, out);
    }
}

void lum_pause_eye_take(lum_pause_eye *e, const lum_pause_clock *clock,
                        const lum_pause_line *line, bool is_decided,
                        lum_pause_found *out)
{
    if (has_period(e)) {
        take_fitted(e, clock, line, is_decided, out);
    } else if (is_decided) {
        take_sample(e, clock, line, out);
    }
}

/* --- Ends --- */

void lum_pause_eye_end(lum_pause_eye *e, const lum_pause_clock *clock,
                       bool is_end, lum_pause_found *out)
{
    if (is_end && !has_period(e)) {
        learn(e, clock, out);
    }
    if (e->next_count > 1u || (is_end && e->next_count > 0 && e->is_break)) {
        confirm(e, out);
    }
}

void lum_pause_eye_join(lum_pause_eye *e)
{
    e->sample_count = 0;
    e->next_count = 0;
    e->is_break = false;
    e->has_last = false;
}

/* The latest line; NULL: there is none. */
static const lum_pause_line *newest(const lum_pause_eye *e)
{
    return e->next_count > 0     ? &e->next.line
           : e->sample_count > 0 ? &e->sample[e->sample_count - 1u]
           : e->has_last         ? &e->last.line
                                 : NULL;
}

bool lum_pause_eye_has_stopped(const lum_pause_eye *e, uint32_t frame)
{
    const lum_pause_line *last = newest(e);
    return last != NULL && lum_pause_turns(frame, last->frame) == 0 &&
           (last->frame != frame || e->scan.sweep == 0 ||
            last->number + UINT64_C(1) < e->scan.sweep);
}

bool lum_pause_eye_doubts(const lum_pause_eye *e, uint32_t frame)
{
    return e->next_count == 1u && e->doubted.frame == frame &&
           lum_pause_turns(frame, e->last.frame) > 0;
}

/* --- As bytes --- */

static bool is_clock(int64_t x)
{
    return x >= -LUM_PAUSE_CLOCK_MAX_US && x <= LUM_PAUSE_CLOCK_MAX_US;
}

static void pack_line(lum_pack *p, lum_pause_line *line)
{
    lum_pack_i64(p, &line->clock_us);
    lum_pack_i64(p, &line->arrival_ns);
    lum_pack_u32(p, &line->number);
    lum_pack_u32(p, &line->frame);
    if (!lum_pack_check(p, is_clock(line->clock_us) &&
                               is_clock(line->arrival_ns))) {
        *line = (lum_pause_line){.clock_us = 0};
    }
}

static void pack_place(lum_pack *p, lum_pause_place *at)
{
    pack_line(p, &at->line);
    lum_pack_u32(p, &at->frame);
    lum_pack_u32(p, &at->top);
}

static bool is_possible(const lum_pause_eye *e)
{
    return (has_period(e) || (e->next_count == 0 && !e->has_last)) &&
           e->next_count < CONFIRM && is_clock(e->highest_us) &&
           e->next_lines >= -LUM_PAUSE_TIME_MAX_US &&
           e->next_lines <= LUM_PAUSE_TIME_MAX_US;
}

void lum_pause_eye_pack(lum_pause_eye *e, lum_pack *p)
{
    lum_pause_scan_pack(&e->scan, p);
    lum_pack_u8(p, &e->sample_count);
    if (!lum_pack_check(p, e->sample_count <= LUM_PAUSE_SAMPLES)) {
        e->sample_count = 0;
    }
    for (unsigned i = 0; i < e->sample_count; i++) {
        pack_line(p, &e->sample[i]);
    }
    lum_pack_bool(p, &e->has_last);
    pack_place(p, &e->last);
    lum_pack_bool(p, &e->is_break);
    lum_pack_u8(p, &e->next_count);
    pack_line(p, &e->doubted);
    pack_place(p, &e->next);
    lum_pack_i64(p, &e->next_lines);
    lum_pack_u8(p, &e->strange);
    lum_pack_i64(p, &e->highest_us);
    if (!lum_pack_check(p, is_possible(e))) {
        *e = (lum_pause_eye){.is_break = false};
    }
}
