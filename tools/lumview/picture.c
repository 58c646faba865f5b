#include "picture.h"

void picture_drop(struct picture *picture)
{
    for (size_t i = 0; i < picture->count; i++) {
        frame_release(picture->frames[i]);
        lum_frame_release(picture->points[i]);
    }
    *picture = (struct picture){0};
}

/* Arrivals of 0 are those of packets without a time, to which nothing can be
 * fitted. */
static struct frame_moment moment_of(const struct picture *picture)
{
    if (picture->arrival_ns <= 0) {
        return (struct frame_moment){.kind = FRAME_TIME_UNKNOWN};
    }
    if (picture->begin_utc_ns <= 0) {
        return (struct frame_moment){.kind = FRAME_TIME_ARRIVAL,
                                     .utc_ns = picture->arrival_ns};
    }
    return (struct frame_moment){.kind = FRAME_TIME_FITTED,
                                 .utc_ns = picture->begin_utc_ns,
                                 .error_ns = picture->utc_error_ns};
}

void picture_seal(struct picture *picture, struct frame_pool *pool,
                  int64_t complete_ns, uint64_t shown)
{
    struct frame_head head = {.frame = picture->frame,
                              .clock_us = picture->clock_us,
                              .begin = moment_of(picture),
                              .complete_ns = complete_ns,
                              .lines = picture->lines,
                              .lost_words = picture->lost_words,
                              .sensor = picture->sensor,
                              .shown = shown};
    for (size_t i = 0; i < picture->count; i++) {
        head.edges = picture->views[i].edges;
        head.smooth = picture->views[i].smooth;
        picture->frames[i] = frame_make(pool, picture->points[i], &head);
        lum_frame_release(picture->points[i]);
        picture->points[i] = NULL;
    }
}

static size_t find(const struct picture *picture, const struct feed_view *view)
{
    size_t i = 0;
    while (i < picture->count && (picture->views[i].edges != view->edges ||
                                  picture->views[i].smooth != view->smooth)) {
        i++;
    }
    return i;
}

struct frame *picture_find(const struct picture *picture,
                           const struct feed_view *view)
{
    const size_t i = find(picture, view);
    return i < picture->count ? picture->frames[i] : NULL;
}

bool picture_has(const struct picture *picture, const struct feed_view *views,
                 size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (find(picture, &views[i]) == picture->count) {
            return false;
        }
    }
    return true;
}
