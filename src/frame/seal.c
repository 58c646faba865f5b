/* A complete frame: the times of its points, and what it lacks. */
#include "frame_internal.h"

#include "points/motion.h"

#include <stdlib.h>

/* A longer line is assumed to be two. */
#define PERIOD_MAX_NS 100000000

/* A clock of 64 bits has room for more than nanoseconds have. Those of two
 * lines have a difference. */
#define CLOCK_MAX_US (INT64_MAX / 4000)

static int by_value(const void *a, const void *b)
{
    const int64_t x = *(const int64_t *)a;
    const int64_t y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

static int64_t line_ns(const lum_frame_line *row, bool has_clock)
{
    const int64_t us = row->clock_us;
    if (!has_clock) {
        return row->arrival_ns;
    }
    return (us > CLOCK_MAX_US    ? CLOCK_MAX_US
            : us < -CLOCK_MAX_US ? -CLOCK_MAX_US
                                 : us) *
           1000;
}

/* The duration of a line: the median time between neighbours, corrected for
 * lost lines. 0: not known. */
static int64_t find_period_ns(const lum_frame *frame, bool has_clock)
{
    const lum_frame_line *before[LUM_EYES] = {NULL, NULL};
    int64_t *periods = frame->store.scratch;
    size_t n = 0;
    for (size_t i = 0; i < frame->row_count; i++) {
        const lum_frame_line *b = &frame->store.rows[i];
        const lum_frame_line *a = before[b->eye];
        before[b->eye] = b;
        if (a != NULL && b->number > a->number &&
            line_ns(b, has_clock) > line_ns(a, has_clock)) {
            periods[n++] = (line_ns(b, has_clock) - line_ns(a, has_clock)) /
                           (b->number - a->number);
        }
    }
    if (n == 0) {
        return 0;
    }
    qsort(periods, n, sizeof *periods, by_value);
    const int64_t median = periods[n / 2u];
    return median < PERIOD_MAX_NS ? median : PERIOD_MAX_NS;
}

/* The column has pixels so far, which an assembler takes below LUM_LINE_PIXELS
 * alone. */
static void set_times(lum_frame *frame, bool has_clock, int64_t begin_ns)
{
    const int64_t period_ns = find_period_ns(frame, has_clock);
    float *times = frame->store.columns[LUM_COLUMN_TIME].at;
    for (size_t i = 0; i < frame->row_count; i++) {
        const lum_frame_line *row = &frame->store.rows[i];
        lum_motion_times(times + row->first_point, row->point_count,
                         line_ns(row, has_clock) - begin_ns, period_ns);
    }
}

uint32_t lum_frame_whole_rows(const lum_frame *frame, unsigned eye)
{
    uint32_t rows = 0;
    for (size_t i = 0; i < frame->row_count; i++) {
        const lum_frame_line *row = &frame->store.rows[i];
        if (row->eye == eye && row->angle_count == LUM_LINE_PIXELS &&
            row->number >= rows && row->number < LUM_FRAME_LINES_MAX) {
            rows = row->number + 1u;
        }
    }
    return rows;
}

/* Line numbers below the end that did not come. A damaged packet can have any
 * number, so only whole lines show where the end is. */
static uint32_t count_missing(const lum_frame *frame, unsigned eye,
                              uint32_t end)
{
    int64_t *numbers = frame->store.scratch;
    uint32_t came = 0;
    size_t n = 0;
    for (size_t i = 0; i < frame->row_count; i++) {
        const lum_frame_line *row = &frame->store.rows[i];
        if (row->eye == eye && row->number < end) {
            numbers[n++] = row->number;
        }
    }
    if (n > 0) {
        qsort(numbers, n, sizeof *numbers, by_value);
    }
    for (size_t i = 0; i < n; i++) {
        came += i == 0 || numbers[i] != numbers[i - 1u] ? 1u : 0u;
    }
    return end - came;
}

static void find_missing(lum_frame *frame, const lum_frame_end *end)
{
    lum_frame_info *info = &frame->info;
    uint64_t missing = 0;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        const uint32_t here = lum_frame_whole_rows(frame, eye);
        const uint32_t before = end->lines_max[eye];
        frame->rows_before[eye] = before;
        info->lines_missing[eye] =
            count_missing(frame, eye, here > before ? here : before);
        missing += info->lines_missing[eye];
    }
    info->lines_late = end->lines_late;
    info->lines_in_pauses = end->lines_in_pauses;
    info->has_pause = end->has_pause;
    info->is_complete = frame->row_count > 0 && missing == 0 &&
                        info->lines_missing_angles == 0 &&
                        info->lost_words == 0 && info->points_cut == 0 &&
                        info->lines_cut == 0 && info->lines_late == 0 &&
                        !info->has_pause;
}

/* Returns when the first line begins; without any, 0. */
static int64_t find_times(lum_frame *frame, bool has_clock)
{
    if (frame->row_count == 0) {
        return 0;
    }
    const lum_frame_line *first = frame->store.rows;
    const lum_frame_line *last = frame->store.rows;
    for (size_t i = 1; i < frame->row_count; i++) {
        const lum_frame_line *row = &frame->store.rows[i];
        first =
            line_ns(row, has_clock) < line_ns(first, has_clock) ? row : first;
        last = line_ns(row, has_clock) > line_ns(last, has_clock) ? row : last;
    }
    frame->info.times = (lum_frame_times){.begin_clock_us = first->clock_us,
                                          .end_clock_us = last->clock_us,
                                          .begin_arrival_ns = first->arrival_ns,
                                          .end_arrival_ns = last->arrival_ns};
    return line_ns(first, has_clock);
}

/* A frame without a line has no begin. */
static void find_utc(lum_frame *frame, const lum_clock_fit *clock)
{
    lum_frame_times *times = &frame->info.times;
    lum_clock_time begin = {0, 0};
    if (clock != NULL && frame->row_count > 0 &&
        lum_clock_fit_utc(clock, times->begin_clock_us, &begin) == LUM_OK) {
        times->begin_utc_ns = begin.utc_ns;
        times->utc_error_ns = begin.error_ns;
    }
}

void lum_frame_seal(lum_frame *frame, const lum_frame_end *end)
{
    frame->info.points = frame->count;
    const int64_t begin_ns = find_times(frame, end->has_clock);
    find_utc(frame, end->clock);
    find_missing(frame, end);
    if (frame->count > 0 &&
        (frame->mask & LUM_COLUMN_BIT(LUM_COLUMN_TIME)) != 0) {
        set_times(frame, end->has_clock, begin_ns);
    }
}
