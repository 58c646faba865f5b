/* How an eye scans: the period of its lines, the lines of a sweep, and what the
 * mirror takes to turn. */
#include "pause.h"

/* Lines that the period is the mean of: at most so many. */
#define WINDOW_LINES  256
#define LINES_MAX     (INT64_C(1) << 30)
#define PERIOD_MAX_US (INT64_C(1) << 20)

static int64_t clamp(int64_t x, int64_t most)
{
    return x > most ? most : x < -most ? -most : x;
}

int64_t lum_pause_minus(int64_t a, int64_t b)
{
    return (int64_t)((uint64_t)a - (uint64_t)b);
}

int64_t lum_pause_between_us(const lum_pause_line *a, const lum_pause_line *b)
{
    return clamp(lum_pause_minus(b->clock_us, a->clock_us),
                 LUM_PAUSE_TIME_MAX_US);
}

uint32_t lum_pause_turns(uint32_t from, uint32_t to)
{
    const int32_t n = (int32_t)(to - from);
    return n > 0 ? (uint32_t)n : 0;
}

static int64_t steps(const lum_pause_line *a, const lum_pause_line *b)
{
    return (int64_t)b->number - (int64_t)a->number;
}

bool lum_pause_scan_begin(lum_pause_scan *s, const lum_pause_line *lines,
                          unsigned count)
{
    int64_t ns[LUM_PAUSE_SAMPLES];
    unsigned n = 0;
    for (unsigned i = 1; i < count; i++) {
        const int64_t us = lum_pause_between_us(&lines[i - 1u], &lines[i]);
        const int64_t numbers = steps(&lines[i - 1u], &lines[i]);
        if (numbers <= 0 || us <= 0 || us > PERIOD_MAX_US) {
            continue;
        }
        unsigned at = n++;
        for (; at > 0 && ns[at - 1u] > us * 1000 / numbers; at--) {
            ns[at] = ns[at - 1u];
        }
        ns[at] = us * 1000 / numbers;
    }
    if (n < 3u || ns[n / 2u] <= 0) {
        return false;
    }
    s->sum_us = (ns[n / 2u] * 8 + 999) / 1000;
    s->sum_lines = 8;
    return true;
}

int64_t lum_pause_scan_us(const lum_pause_scan *s, int64_t lines)
{
    return clamp(lines, LINES_MAX) * s->sum_us / s->sum_lines;
}

/* Rounded. */
static int64_t periods(const lum_pause_scan *s, int64_t all_us)
{
    const int64_t us = clamp(all_us, LUM_PAUSE_TIME_MAX_US);
    const int64_t half = us < 0 ? -s->sum_us / 2 : s->sum_us / 2;
    return (us * s->sum_lines + half) / s->sum_us;
}

int64_t lum_pause_scan_lines(const lum_pause_scan *s, const lum_pause_line *a,
                             const lum_pause_line *b, int64_t us)
{
    const int64_t sweep_us = lum_pause_scan_us(s, s->sweep) + s->turn_us;
    const int64_t rest = us - lum_pause_scan_us(s, steps(a, b));
    const int64_t turns =
        s->turn_us > 0 && rest > 0 ? (rest + sweep_us / 2) / sweep_us : 0;
    return periods(s, us - turns * s->turn_us) - 1;
}

void lum_pause_scan_follow(lum_pause_scan *s, const lum_pause_line *a,
                           const lum_pause_line *b)
{
    if (steps(a, b) != 1) {
        return;
    }
    s->sum_us += lum_pause_between_us(a, b);
    s->sum_lines++;
    if (s->sum_lines >= WINDOW_LINES) {
        s->sum_us = (s->sum_us + 1) / 2;
        s->sum_lines = (s->sum_lines + 1) / 2;
    }
}

/* The period is not exact: one of nothing may seem to be less. */
static int64_t least_turn_us(int64_t a, int64_t b)
{
    const int64_t least = a < b ? a : b;
    return least > 0 ? least : 0;
}

/* The shortest turn that was seen is one with all lines. */
int64_t lum_pause_scan_turn(lum_pause_scan *s, const lum_pause_line *a,
                            const lum_pause_line *b, bool is_pause)
{
    const uint32_t lines = a->number + 1u;
    const int64_t us = lum_pause_between_us(a, b) -
                       lum_pause_scan_us(s, b->number + INT64_C(1));
    const int64_t few_us = lum_pause_scan_us(s, LUM_PAUSE_LINES_MIN);
    int64_t told = 0;
    if (s->sweep == 0) {
        s->is_first_turn = is_pause;
        s->first_us = b->clock_us;
        s->turn_us = is_pause && us > 0 ? us : 0;
    } else if (is_pause) {
        return 0;
    } else if (s->turn_us > 0) {
        told = s->is_first_turn && us > s->turn_us - few_us
                   ? periods(s, s->turn_us)
                   : 0;
        s->turn_us = least_turn_us(s->turn_us, us);
        s->is_first_turn = false;
    }
    if (lines > s->sweep || s->sweep - lines >= LUM_PAUSE_LINES_MIN) {
        s->sweep = lines;
    }
    return told;
}

void lum_pause_scan_pack(lum_pause_scan *s, lum_pack *pack)
{
    lum_pack_i64(pack, &s->sum_us);
    lum_pack_i64(pack, &s->sum_lines);
    lum_pack_u32(pack, &s->sweep);
    lum_pack_i64(pack, &s->turn_us);
    lum_pack_bool(pack, &s->is_first_turn);
    lum_pack_i64(pack, &s->first_us);
    const bool is_nothing = s->sum_us == 0 && s->sum_lines == 0;
    const bool is_period = s->sum_us > 0 && s->sum_lines > 0 &&
                           s->sum_lines <= WINDOW_LINES &&
                           s->sum_us / s->sum_lines <= PERIOD_MAX_US;
    if (!lum_pack_check(pack, (is_nothing || is_period) && s->turn_us >= 0 &&
                                  s->turn_us <= 4 * LUM_PAUSE_TIME_MAX_US)) {
        *s = (lum_pause_scan){.sum_us = 0};
    }
}
