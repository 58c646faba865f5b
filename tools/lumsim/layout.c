#include "layout.h"

#include "sim/packets.h"

#include <stdio.h>

const char *layout_source(const struct options *o)
{
    if (set_keys_first(&o->set, true) != NULL) {
        return "--set";
    }
    return o->profile != NULL ? o->profile : o->replay.path;
}

static bool complain(const struct options *o, const char *why)
{
    (void)fprintf(stderr, "lumsim: %s: %s\n", layout_source(o), why);
    return false;
}

/* The first field that is too narrow, by the bits that its numbers need. */
static bool refuse_field(const struct options *o, unsigned field)
{
    static const char *const names[LUM_GROUP_FIELDS] = {
        [LUM_FIELD_TAG] = "tag",
        [LUM_FIELD_EYE] = "eye",
        [LUM_FIELD_LINE] = "line",
        [LUM_FIELD_NUM_SAMPLES] = "num_samples",
        [LUM_FIELD_FIRST_SAMPLE_INDEX] = "first_sample_index",
        [LUM_FIELD_TIMESTAMP] = "timestamp"};
    const lum_field *f = &o->render.layout.profile.group[field];
    char why[160];
    (void)snprintf(why, sizeof why,
                   "group.%s is too narrow for what it has to hold: it has %u "
                   "bit%s and needs %u",
                   names[field], f->bits > 0 ? f->bits : 8u * f->bytes,
                   f->bits == 1 ? "" : "s",
                   lum_packets_bits(field, o->render.lines));
    return complain(o, why);
}

bool layout_take(struct options *o, const lum_profile *profile)
{
    lum_render_options *r = &o->render;
    if (lum_layout_init(&r->layout, profile, NULL, NULL) != LUM_OK) {
        return complain(o, "this layout cannot be");
    }
    const unsigned narrow = lum_packets_narrow(&r->layout, r->lines);
    return narrow == LUM_GROUP_FIELDS || refuse_field(o, narrow);
}
