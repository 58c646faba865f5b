#include "world.h"

#include "conclude.h"

#include <math.h>
#include <stdio.h>

static bool is_bare(const struct options *o, size_t i)
{
    return !options_has_comment(o, o->outputs[i].format);
}

static bool has_offset(const struct options *o, size_t i)
{
    return o->outputs[i].format == (unsigned)LUM_FORMAT_LAS;
}

static bool has_only_comment(const struct options *o, size_t i)
{
    return !options_is_recording(o, i) && !has_offset(o, i);
}

/* How an output says what the origin is. */
static const char *name_places(const struct options *o)
{
    return !options_any(o, has_offset) ? "a comment of the file gives it"
           : options_any(o, has_only_comment)
               ? "las has it as its offset, other files in a comment"
               : "the file has it as its offset, so that readers add it";
}

static int refuse_bare(const struct options *o, const double origin[3],
                       lum_error *error)
{
    size_t i = 0;
    while (!is_bare(o, i)) {
        i++;
    }
    return lum_error_set(error,
                         "%s: the poses are farther than 5 km from 0, so x, y "
                         "and z are relative to the origin %.0f %.0f %.0f, and "
                         "nothing in the file would say so: give --comments, "
                         "or write .las, .ply or .pcd",
                         o->outputs[i].name, origin[0], origin[1], origin[2]);
}

/* Even a good origin is far from the ends of a long way. */
static void warn_of_width(const struct options *o, const struct motion *motion)
{
    const double far_m = motion_farthest(motion);
    if (far_m > LUM_POSES_FAR_M) {
        const float at = (float)far_m;
        conclude_warn(o,
                      "%s: poses are up to %.1f km from the origin: there x, y "
                      "and z, which are floats, have steps of %.2g mm; poses "
                      "of a shorter part of the drive give smaller ones",
                      motion_name(motion), far_m * 1e-3,
                      1e3 * ((double)nextafterf(at, INFINITY) - (double)at));
    }
}

int world_begin(struct options *o, const struct motion *motion,
                lum_error *error)
{
    double *origin = o->about.origin;
    if (!motion_origin(motion, origin)) {
        return 0;
    }
    if (fabs(origin[0]) + fabs(origin[1]) + fabs(origin[2]) > 0.0) {
        if (options_any(o, is_bare)) {
            return refuse_bare(o, origin, error);
        }
        struct filter *f = &o->filters.list[o->filters.count++];
        (void)snprintf(f->text, sizeof f->text, "origin=%.0f,%.0f,%.0f",
                       origin[0], origin[1], origin[2]);
        conclude_warn(o,
                      "the poses are farther than 5 km from 0: x, y and z are "
                      "relative to the origin %.0f %.0f %.0f; %s",
                      origin[0], origin[1], origin[2], name_places(o));
    }
    warn_of_width(o, motion);
    return 0;
}
