#include "picture.h"

void picture_drop(struct picture *picture)
{
    for (size_t i = 0; i < picture->count; i++) {
        frame_release(picture->frames[i]);
    }
    *picture = (struct picture){0};
}

uint64_t picture_cut(const struct picture *picture)
{
    uint64_t most = 0;
    for (size_t i = 0; i < picture->count; i++) {
        const struct frame *frame = picture->frames[i];
        const uint64_t cut = frame != NULL ? frame_cut(frame) : 0;
        most = cut > most ? cut : most;
    }
    return most;
}

void picture_seal(struct picture *picture, int64_t complete_ns, uint64_t shown)
{
    struct frame_head head = {
        .frame = picture->frame,
        .clock_us = picture->clock_us,
        .utc_ns = picture->arrival_ns > 0 ? picture->arrival_ns : 0,
        .complete_ns = complete_ns,
        .lines = picture->lines,
        .lost_words = picture->lost_words,
        .sensor = picture->sensor,
        .shown = shown};
    for (size_t i = 0; i < picture->count; i++) {
        head.edges = picture->views[i].edges;
        head.smooth = picture->views[i].smooth;
        if (picture->frames[i] != NULL) {
            frame_seal(picture->frames[i], &head);
        }
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
