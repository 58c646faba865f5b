#include "layout.h"

#include "sim/packets.h"

#include <stdio.h>

const char *layout_source(const struct options *o)
{
    if (set_keys_first(&o->set, true) != NULL) {
        return "--set";
    }
    return o->profile != NULL ? o->profile : o->replay;
}

static bool complain(const struct options *o, const char *why)
{
    (void)fprintf(stderr, "lumsim: %s: %s\n", layout_source(o), why);
    return false;
}

bool layout_take(struct options *o, const lum_profile *profile)
{
    lum_render_options *r = &o->render;
    if (lum_layout_init(&r->layout, profile, NULL, NULL) != LUM_OK) {
        return complain(o, "this layout cannot be");
    }
    if (lum_packets_check(&r->layout, r->lines) != LUM_OK) {
        return complain(
            o, "a field of group is too narrow for what it has to hold; line, "
               "num_samples and first_sample_index need 2 bytes");
    }
    return true;
}
