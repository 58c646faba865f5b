#include "second.h"

#include "lum/frame/framer.h"

#include <stdlib.h>
#include <string.h>

struct second {
    lum_framer *framer;
    struct feed_view views[FEED_VIEWS_MAX]; /* of the next frames */
    size_t view_count;
    struct picture newest;
};

struct second *second_new(const struct decoder_options *options)
{
    struct second *s = calloc(1, sizeof *s);
    if (s == NULL) {
        return NULL;
    }
    const lum_framer_options framer = {.struct_size = sizeof framer,
                                       .layout = options->second_layout,
                                       .projector = options->second_projector,
                                       .wants = LUM_WANT_FRAMES,
                                       .only_first = true,
                                       .has_sensor = options->has_sensor,
                                       .sensor = options->sensor,
                                       .port = options->port,
                                       .records_are_single = true,
                                       .sensor_interface = options->interface,
                                       .points_max = FRAME_POINTS_MAX};
    if (lum_framer_new(&framer, &s->framer, NULL) != 0 ||
        lum_framer_set_views(s->framer, NULL, 0, NULL) != 0) {
        second_free(s);
        return NULL;
    }
    return s;
}

void second_free(struct second *second)
{
    if (second == NULL) {
        return;
    }
    picture_drop(&second->newest);
    lum_framer_free(second->framer);
    free(second);
}

static bool follow_views(struct second *s, const struct feed_view *views,
                         size_t count)
{
    if (count == s->view_count && views_are_same(views, s->views, count)) {
        return true;
    }
    memcpy(s->views, views, count * sizeof *views);
    s->view_count = count;
    return views_set(s->framer, views, count);
}

void second_set_interface(struct second *second, const char *name)
{
    lum_framer_set_interface(second->framer, name);
}

enum decoded second_push(struct second *second, const lum_record *record,
                         const struct feed_view *views, size_t count)
{
    if (!follow_views(second, views, count)) {
        return DECODED_FAILED;
    }
    const lum_framer_event event =
        record != NULL ? lum_framer_push(second->framer, record, NULL)
                       : lum_framer_flush(second->framer);
    if (event == LUM_FRAMER_FRAME) {
        picture_drop(&second->newest);
        picture_take(&second->newest, second->framer);
        return DECODED_FRAME;
    }
    return event == LUM_FRAMER_NONE ? DECODED_ALL : DECODED_FAILED;
}

void second_join(const struct second *second, struct picture *picture)
{
    const struct picture *newest = &second->newest;
    if (newest->sensor != picture->sensor) {
        return;
    }
    for (size_t i = 0; i < picture->count; i++) {
        const lum_frame *points = picture_points(newest, &picture->views[i]);
        picture->second[i] = points != NULL ? lum_frame_keep(points) : NULL;
    }
}
