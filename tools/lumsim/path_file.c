#include "lum/frame/poses.h"
#include "moving.h"
#include "rig.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Frames may end so much after the last pose. */
#define SLACK_S 1e-3

#define FRAMES     3
#define FRAMES_MAX 1e6

/* Copied out of what was read. */
static bool take_poses(const lum_poses *read, const lum_poses_info *info,
                       struct options *o)
{
    struct moving_options *m = &o->moving;
    lum_path *path = &o->render.place.path;
    m->given = calloc(info->count, sizeof *m->given);
    m->given_s = calloc(info->count, sizeof *m->given_s);
    if (m->given == NULL || m->given_s == NULL) {
        (void)fputs("lumsim: --path: not enough memory\n", stderr);
        return false;
    }
    for (size_t i = 0; i < info->count; i++) {
        int64_t time_ns = 0;
        lum_poses_get(read, i, &time_ns, &m->given[i]);
        m->given_s[i] = (double)(time_ns - info->first_ns) * 1e-9;
    }
    path->poses = m->given;
    path->times_s = m->given_s;
    path->count = info->count;
    return true;
}

/* A path has an end, and is known all the way. */
static bool check_poses(const struct options *o, const lum_poses_info *info)
{
    if (info->count < 2) {
        (void)fprintf(stderr,
                      "lumsim: --path %s: it has one pose, and a path needs "
                      "two or more; for a sensor that stands still use "
                      "--pose\n",
                      o->moving.path);
        return false;
    }
    if (info->gaps > 0) {
        (void)fprintf(
            stderr,
            "lumsim: --path %s: between its poses %zu gap%s longer "
            "than %g s, the longest from %.3f to %.3f s; right are "
            "poses that are nearer to each other\n",
            o->moving.path, info->gaps, info->gaps == 1 ? " is" : "s are",
            (double)LUM_POSES_GAP_NS * 1e-9, (double)info->gap_from_ns * 1e-9,
            (double)info->gap_to_ns * 1e-9);
        return false;
    }
    return true;
}

/* If nothing is said of frames, a capture has as many as the poses last. */
static bool check_length(struct options *o)
{
    const lum_path *path = &o->render.place.path;
    const double all_s = path->times_s[path->count - 1];
    const double lasts_s =
        all_s - rig_late_s(o, (int64_t)(all_s * o->render.rate_hz));
    const double most = floor((lasts_s + SLACK_S) * o->render.rate_hz);
    if (o->frames == 0) {
        const double usual = o->mode == MODE_FILE ? FRAMES_MAX : FRAMES;
        o->frames = (int64_t)fmax(1.0, fmin(most, usual));
    }
    const double needed_s = (double)o->frames / o->render.rate_hz;
    if (needed_s <= lasts_s + SLACK_S) {
        return true;
    }
    if (most < 1.0) {
        (void)fprintf(stderr,
                      "lumsim: --path %s: its poses last %.6g s, and one frame "
                      "%.6g s; right are poses that last longer, or a higher "
                      "--rate\n",
                      o->moving.path, all_s,
                      1.0 / o->render.rate_hz + all_s - lasts_s);
        return false;
    }
    (void)fprintf(stderr,
                  "lumsim: --path %s: its poses last %.6g s, and %" PRId64
                  " frames %.6g s; right is --frames %.0f at most\n",
                  o->moving.path, all_s, o->frames, needed_s + all_s - lasts_s,
                  most);
    return false;
}

bool moving_load(struct options *o)
{
    lum_poses_info info = {.struct_size = sizeof info};
    lum_poses *read = NULL;
    lum_error error = {""};
    if (o->render.place.path.kind != LUM_PATH_POSES) {
        return true;
    }
    if (lum_poses_read(o->moving.path, NULL, NULL, &read, &error) != 0) {
        (void)fprintf(stderr, "lumsim: --path: %s; right is " MOVING_PATH "\n",
                      error.text);
        return false;
    }
    (void)lum_poses_get_info(read, &info);
    const bool is_taken = check_poses(o, &info) && take_poses(read, &info, o);
    lum_poses_free(read);
    return is_taken && check_length(o);
}
