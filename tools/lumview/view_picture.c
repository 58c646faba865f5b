#include "view_picture.h"

#include "lum/smooth.h"

#include <string.h>

bool views_follow(lum_framer *framer, struct feed_views *now,
                  const struct feed_views *wanted)
{
    lum_view out[FEED_VIEWS_MAX];
    size_t i = 0;
    while (i < wanted->count && feed_views_find(now, &wanted->at[i]) == i) {
        i++;
    }
    if (i == wanted->count && i == now->count) {
        return true;
    }
    *now = *wanted;
    for (i = 0; i < now->count; i++) {
        lum_view_default(&out[i]);
        out[i].selection.edges = now->at[i].edges;
        out[i].smooth_window = now->at[i].smooth;
        out[i].smooth_order = LUM_SMOOTH_ORDER(now->at[i].smooth);
        out[i].columns = LUM_PACKED_COLUMNS;
    }
    return lum_framer_set_views(framer, out, now->count, NULL) == 0;
}

static void take_views(struct picture *p, const lum_framer *framer)
{
    lum_view view = {.struct_size = sizeof view};
    size_t *count = &p->views.count;
    while (lum_framer_frame_view(framer, *count, &view)) {
        const lum_frame *frame = lum_framer_frame(framer, *count);
        lum_frame_info info = {.struct_size = sizeof info};
        (void)lum_frame_get_info(frame, &info);
        p->cut = info.points_cut > p->cut ? info.points_cut : p->cut;
        p->views.at[*count] =
            (struct feed_view){view.selection.edges, view.smooth_window};
        p->points[0][(*count)++] = lum_frame_keep(frame);
    }
}

/* What was under way when the stream was joined or left is not lost. */
static struct feed_loss loss_of(const lum_frame_info *info)
{
    if (info->is_first || info->is_last) {
        return (struct feed_loss){.pauses = info->has_pause ? 1u : 0u};
    }
    return (struct feed_loss){.words = info->lost_words,
                              .lines =
                                  (uint64_t)info->lines_missing[LUM_EYE_BLUE] +
                                  info->lines_missing[LUM_EYE_GREEN] +
                                  info->lines_missing_angles +
                                  info->lines_late + info->lines_cut,
                              .pauses = info->has_pause ? 1u : 0u};
}

void picture_take(struct picture *picture, const lum_framer *framer)
{
    lum_frame_info info = {.struct_size = sizeof info};
    (void)lum_frame_get_info(lum_framer_frame(framer, 0), &info);
    *picture = (struct picture){.frame = info.number,
                                .arrival_ns = info.times.begin_arrival_ns,
                                .begin_utc_ns = info.times.begin_utc_ns,
                                .utc_error_ns = info.times.utc_error_ns,
                                .clock_us = info.times.begin_clock_us,
                                .lines = info.lines[LUM_EYE_BLUE] +
                                         info.lines[LUM_EYE_GREEN],
                                .lost_words = info.lost_words,
                                .loss = loss_of(&info),
                                .sensor = info.sensor};
    take_views(picture, framer);
}

static void release_points(struct picture *p, size_t view)
{
    for (size_t i = 0; i < PICTURE_PARTS_MAX; i++) {
        lum_frame_release(p->points[i][view]);
        p->points[i][view] = NULL;
    }
    lum_frame_release(p->second[view]);
    p->second[view] = NULL;
}

void picture_drop(struct picture *picture)
{
    for (size_t i = 0; i < picture->views.count; i++) {
        frame_release(picture->frames[i]);
        release_points(picture, i);
    }
    *picture = (struct picture){0};
}

/* Arrivals of 0 are those of packets without a time, to which nothing can be
 * fitted. */
static void tell_time(const struct picture *p, lum_packed_head *head)
{
    if (p->arrival_ns <= 0) {
        head->time = LUM_PACKED_TIME_UNKNOWN;
    } else if (p->begin_utc_ns <= 0) {
        head->time = LUM_PACKED_TIME_ARRIVAL;
        head->utc_ns = p->arrival_ns;
    } else {
        head->time = LUM_PACKED_TIME_FITTED;
        head->utc_ns = p->begin_utc_ns;
        head->utc_error_ns = p->utc_error_ns;
    }
}

static bool take_points(const lum_frame *points, lum_packed_part *out)
{
    out->struct_size = sizeof *out;
    return lum_packed_part_of(points, out) == LUM_OK;
}

static struct frame *make(const struct picture *p, struct frame_pool *pool,
                          const lum_packed_head *head, size_t view)
{
    lum_packed_part parts[PICTURE_PARTS_MAX];
    size_t count = p->parts > 0 ? p->parts : 1u;
    for (size_t i = 0; i < count; i++) {
        if (!take_points(p->points[i][view], &parts[i])) {
            return NULL;
        }
        if (p->parts > 0) {
            parts[i].frame = p->part[i].frame;
            parts[i].sensor = p->part[i].sensor;
        }
    }
    if (p->second[view] != NULL &&
        !take_points(p->second[view], &parts[count++])) {
        return NULL;
    }
    return frame_make(pool, head, parts, count);
}

void picture_seal(struct picture *picture, struct frame_pool *pool,
                  int64_t complete_ns, uint64_t shown)
{
    lum_packed_head head = {.struct_size = sizeof head,
                            .frame = picture->frame,
                            .clock_us = picture->clock_us,
                            .complete_ns = complete_ns,
                            .lines = picture->lines,
                            .lost_words = picture->lost_words,
                            .sensor = picture->sensor,
                            .shown = shown,
                            .is_rig = picture->parts > 0};
    tell_time(picture, &head);
    for (size_t i = 0; i < picture->views.count; i++) {
        head.edges = (uint8_t)picture->views.at[i].edges;
        head.smooth = (uint8_t)picture->views.at[i].smooth;
        picture->frames[i] = make(picture, pool, &head, i);
        release_points(picture, i);
    }
}

const lum_frame *picture_points(const struct picture *picture,
                                const struct feed_view *view)
{
    const size_t i = feed_views_find(&picture->views, view);
    return i < picture->views.count ? picture->points[0][i] : NULL;
}

struct frame *picture_find(const struct picture *picture,
                           const struct feed_view *view)
{
    const size_t i = feed_views_find(&picture->views, view);
    return i < picture->views.count ? picture->frames[i] : NULL;
}

bool picture_has(const struct picture *picture, const struct feed_views *views)
{
    for (size_t i = 0; i < views->count; i++) {
        if (feed_views_find(&picture->views, &views->at[i]) ==
            picture->views.count) {
            return false;
        }
    }
    return true;
}

/* The first that is not before the number. */
static size_t trail_place(const struct trail *trail, int64_t number)
{
    size_t i = 0;
    while (i < trail->count && trail->pictures[i].frame < number) {
        i++;
    }
    return i;
}

/* Release so many from one on. */
static void trail_drop(struct trail *trail, size_t at, size_t count)
{
    struct picture *pictures = trail->pictures;
    for (size_t i = at; i < at + count; i++) {
        picture_drop(&pictures[i]);
    }
    memmove(pictures + at, pictures + at + count,
            (trail->count - at - count) * sizeof *pictures);
    trail->count -= count;
}

void trail_put(struct trail *trail, struct picture *picture)
{
    const bool is_in = trail_find(trail, picture->frame) != NULL;
    if (is_in || trail->count == FEED_FRAMES_MAX) {
        trail_drop(trail, is_in ? trail_place(trail, picture->frame) : 0, 1);
    }
    const size_t at = trail_place(trail, picture->frame);
    memmove(trail->pictures + at + 1, trail->pictures + at,
            (trail->count - at) * sizeof *picture);
    trail->pictures[at] = *picture;
    trail->count++;
    *picture = (struct picture){0};
}

void trail_cut(struct trail *trail, int64_t first, int64_t before)
{
    const size_t end = trail_place(trail, before);
    trail_drop(trail, end, trail->count - end);
    trail_drop(trail, 0, trail_place(trail, first));
}

const struct picture *trail_find(const struct trail *trail, int64_t number)
{
    const size_t i = trail_place(trail, number);
    return i < trail->count && trail->pictures[i].frame == number
               ? &trail->pictures[i]
               : NULL;
}

void trail_shed(struct trail *trail, const struct feed_views *views)
{
    for (size_t i = trail->count; i-- > 0;) {
        if (!picture_has(&trail->pictures[i], views)) {
            trail_drop(trail, i, 1);
        }
    }
}

bool trail_has(const struct trail *trail, const struct feed_views *views)
{
    size_t i = 0;
    while (i < trail->count && picture_has(&trail->pictures[i], views)) {
        i++;
    }
    return i == trail->count;
}
