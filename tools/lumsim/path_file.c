#include "lum/frame/poses.h"
#include "moving.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Frames may end so much after the last pose. */
#define SLACK_S 1e-3

#define FRAMES     3
#define FRAMES_MAX 1e6

/* Copied out of what was read; never freed, as all that options have. */
static bool take_poses(const lum_poses *read, size_t count, lum_path *out)
{
    int64_t first_ns = 0;
    lum_pose *poses = calloc(count, sizeof *poses);
    double *times_s = calloc(count, sizeof *times_s);
    if (poses == NULL || times_s == NULL) {
        free(poses);
        free(times_s);
        (void)fputs("lumsim: --path: not enough memory\n", stderr);
        return false;
    }
    lum_poses_get(read, 0, &first_ns, NULL);
    for (size_t i = 0; i < count; i++) {
        int64_t time_ns = 0;
        lum_poses_get(read, i, &time_ns, &poses[i]);
        times_s[i] = (double)(time_ns - first_ns) * 1e-9;
    }
    out->poses = poses;
    out->times_s = times_s;
    out->count = count;
    return true;
}

/* If nothing is said of frames, a capture has as many as there are poses. */
static bool check_length(struct options *o)
{
    const lum_path *path = &o->render.place.path;
    const double lasts_s = path->times_s[path->count - 1];
    const double most = floor((lasts_s + SLACK_S) * o->render.rate_hz);
    if (o->frames == 0) {
        const double usual = o->mode == MODE_FILE ? FRAMES_MAX : FRAMES;
        o->frames = (int64_t)fmax(1.0, fmin(most, usual));
    }
    const double needed_s = (double)o->frames / o->render.rate_hz;
    if (needed_s <= lasts_s + SLACK_S) {
        return true;
    }
    (void)fprintf(stderr,
                  "lumsim: --path %s: its poses last %.6g s, and %" PRId64
                  " frames %.6g s; right is --frames %.0f at most\n",
                  o->moving.path, lasts_s, o->frames, needed_s, most);
    return false;
}

bool moving_load(struct options *o)
{
    lum_path *path = &o->render.place.path;
    lum_poses_info info = {.struct_size = sizeof info};
    lum_poses *read = NULL;
    lum_error error = {""};
    if (path->kind != LUM_PATH_POSES) {
        return true;
    }
    if (lum_poses_read(o->moving.path, NULL, NULL, &read, &error) != 0) {
        (void)fprintf(stderr, "lumsim: --path: %s\n", error.text);
        return false;
    }
    (void)lum_poses_get_info(read, &info);
    const bool is_taken = take_poses(read, info.count, path);
    lum_poses_free(read);
    return is_taken && check_length(o);
}
