#include "look.h"

#define LONG_AGO (INT64_MIN / 4)

void look_init(look *l)
{
    *l = (look){.point_ms = LONG_AGO,
                .whole_ms = LONG_AGO,
                .spoilt_ms = LONG_AGO,
                .frame = UINT32_MAX};
}

/* Frame numbers go round after 2^32. */
static bool is_next(const look *l, uint32_t frame)
{
    return frame != l->frame && frame - l->frame <= UINT32_MAX / 2u;
}

static bool is_whole(const lum_line *line)
{
    return line->angle_count == LUM_LINE_PIXELS && line->lost_words == 0;
}

/* A line that comes out of order does not count: so none counts twice, also in
 * a frame whose end was not noticed. */
static bool counts(const look *l, const lum_line *line, int64_t measured_ms)
{
    return (uint32_t)line->frame == l->frame && is_whole(line) &&
           measured_ms > l->spoilt_ms &&
           (l->count == 0 || line->number > l->top);
}

void look_take(look *l, const lum_line *line, int64_t measured_ms,
               uint32_t lines)
{
    if (is_next(l, (uint32_t)line->frame)) {
        l->frame = (uint32_t)line->frame;
        l->begun_ms = measured_ms;
        l->count = 0;
    }
    if (!counts(l, line, measured_ms)) {
        return;
    }
    if (measured_ms < l->begun_ms) {
        l->begun_ms = measured_ms;
    }
    l->top = line->number;
    l->count++;
    if (l->count == lines) {
        l->whole_ms = l->begun_ms;
    }
}

void look_see(look *l, int64_t measured_ms)
{
    if (measured_ms > l->point_ms) {
        l->point_ms = measured_ms;
    }
}

void look_spoil(look *l, int64_t now_ms)
{
    l->spoilt_ms = now_ms;
}

uint32_t look_lasts(const look *l, uint32_t silence_ms, uint32_t hold_ms,
                    int64_t now_ms)
{
    const int64_t seeing_ms = l->point_ms + (int64_t)silence_ms - now_ms;
    const int64_t whole_ms = l->whole_ms + (int64_t)hold_ms - now_ms;
    const int64_t lasts_ms = seeing_ms < whole_ms ? seeing_ms : whole_ms;

    return lasts_ms > 0 ? (uint32_t)lasts_ms : 0;
}
