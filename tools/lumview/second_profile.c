#include "second_profile.h"

#include "lum/frame/framer.h"

#include <stdlib.h>

struct second {
    lum_framer *framer;
    struct feed_views views; /* of the next frames */
    struct picture newest;
};

struct second *second_new(const lum_framer_options *options)
{
    struct second *s = calloc(1, sizeof *s);
    if (s == NULL) {
        return NULL;
    }
    if (lum_framer_new(options, &s->framer, NULL) != 0 ||
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

void second_set_interface(struct second *second, const char *name)
{
    lum_framer_set_interface(second->framer, name);
}

enum decoded second_push(struct second *second, const lum_record *record,
                         const struct feed_views *views)
{
    if (!views_follow(second->framer, &second->views, views)) {
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
    for (size_t i = 0; i < picture->views.count; i++) {
        const lum_frame *points = picture_points(newest, &picture->views.at[i]);
        picture->second[i] = points != NULL ? lum_frame_keep(points) : NULL;
    }
}
