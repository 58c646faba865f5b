#define _POSIX_C_SOURCE 200809L /* strcasecmp */
#include "moving.h"

#include "../common/option_table.h"
#include "lum/frame/poses.h"
#include "rig_capture.h"
#include "standing.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const struct option_word kinds[] = {
    {"straight", LUM_PATH_STRAIGHT},
    {"circle", LUM_PATH_CIRCLE},
    {"eight", LUM_PATH_EIGHT},
    {"stop-and-go", LUM_PATH_STOP_AND_GO},
    {NULL, 0}};

bool moving_take_path(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    const struct option_word *word = kinds;
    (void)why;
    while (word->text != NULL && strcmp(word->text, text) != 0) {
        word++;
    }
    o->moving.path = text;
    o->render.place.path.kind =
        word->text != NULL ? (lum_path_kind)word->number : LUM_PATH_POSES;
    return text[0] != '\0';
}

bool moving_take_labels(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    const char *ending = strrchr(text, '.');
    o->moving.labels = text;
    if (ending != NULL && strcasecmp(ending, ".npy") == 0) {
        return true;
    }
    (void)lum_error_set(why,
                        "'%.200s': labels are an array of NumPy; use a file "
                        "whose name ends in .npy",
                        text);
    return false;
}

void moving_free(struct options *o)
{
    free(o->moving.given);
    free(o->moving.given_s);
}

/* Paths that a place has. */
static bool check_place(const struct options *o)
{
    const lum_place_options *place = &o->render.place;
    const char *between = "";
    if (lum_place_has_path(place->kind, place->path.kind)) {
        return true;
    }
    (void)fprintf(stderr, "lumsim: --path %s is not for --scene %s: there, ",
                  o->moving.path, standing_scene(o));
    for (const struct option_word *w = kinds; w->text != NULL; w++) {
        if (lum_place_has_path(place->kind, (lum_path_kind)w->number)) {
            (void)fprintf(stderr, "%s%s", between, w->text);
            between = ", ";
        }
    }
    (void)fputs(" or a file of poses is right\n", stderr);
    return false;
}

static double usual_velocity(lum_place_kind kind)
{
    switch (kind) {
    case LUM_PLACE_ROOM:
        return 0.3;
    case LUM_PLACE_YARD:
        return 1.0;
    case LUM_PLACE_STREET:
    case LUM_PLACE_TOWN:
    default:
        return LUM_STREET_SENSOR_SPEED;
    }
}

bool moving_check(struct options *o)
{
    lum_place_options *place = &o->render.place;
    const lum_path_kind kind = place->path.kind;
    if (o->moving.has_velocity &&
        (kind == LUM_PATH_NONE || kind == LUM_PATH_POSES)) {
        return complain("%s",
                        kind == LUM_PATH_NONE
                            ? "--velocity is that of --path straight, circle, "
                              "eight or stop-and-go; name one"
                            : "--velocity does not go with --path FILE: the "
                              "times of its poses say how fast the sensor is");
    }
    if (kind == LUM_PATH_NONE) {
        return true;
    }
    if (place->has_pose) {
        return complain(
            "--path and --pose: with one the sensor moves, with the "
            "other it stands still; choose");
    }
    if (!o->moving.has_velocity) {
        place->path.velocity_m_s = usual_velocity(place->kind);
    }
    return check_place(o);
}

/* --- The poses of a file --- */

/* Frames may end so much after the last pose. */
#define SLACK_S 1e-3

#define POSES_FRAMES     3
#define POSES_FRAMES_MAX 1e6

/* Copied out of what was read. */
static bool take_poses(const lum_poses *read, const lum_poses_info *info,
                       struct options *o)
{
    struct moving_options *m = &o->moving;
    lum_path *path = &o->render.place.path;
    m->given = calloc(info->count, sizeof *m->given);
    m->given_s = calloc(info->count, sizeof *m->given_s);
    if (m->given == NULL || m->given_s == NULL) {
        return complain("--path: not enough memory");
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
        return complain("--path %s: it has one pose, but a path needs two or "
                        "more; for a sensor that stands still use --pose",
                        o->moving.path);
    }
    if (info->gaps > 0) {
        return complain(
            "--path %s: between its poses %zu gap%s longer than %g s, the "
            "longest from %.3f to %.3f s; use poses closer in time",
            o->moving.path, info->gaps, info->gaps == 1 ? " is" : "s are",
            (double)LUM_POSES_GAP_NS * 1e-9, (double)info->gap_from_ns * 1e-9,
            (double)info->gap_to_ns * 1e-9);
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
        const double usual =
            o->mode == MODE_FILE ? POSES_FRAMES_MAX : POSES_FRAMES;
        o->frames = (int64_t)fmax(1.0, fmin(most, usual));
    }
    const double needed_s = (double)o->frames / o->render.rate_hz;
    if (needed_s <= lasts_s + SLACK_S) {
        return true;
    }
    if (most < 1.0) {
        return complain("--path %s: its poses last %.6g s, and one frame %.6g "
                        "s; use poses that last longer, or a higher --rate",
                        o->moving.path, all_s,
                        1.0 / o->render.rate_hz + all_s - lasts_s);
    }
    return complain("--path %s: its poses last %.6g s, and %" PRId64
                    " frames %.6g s; use --frames %.0f at most",
                    o->moving.path, all_s, o->frames,
                    needed_s + all_s - lasts_s, most);
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
        return complain("--path: %s; use " MOVING_PATH, error.text);
    }
    (void)lum_poses_get_info(read, &info);
    const bool is_taken = check_poses(o, &info) && take_poses(read, &info, o);
    lum_poses_free(read);
    return is_taken && check_length(o);
}

/* --- Where it is --- */

/* How many times of a run are looked at, at least; with more frames, one of
 * each. */
#define LOOKS 2000

bool moving_is_open(const struct options *o)
{
    const lum_render_options *r = &o->render;
    const int64_t frames = o->frames > 0 ? o->frames : FRAMES_USUAL;
    const int64_t looks = frames > LOOKS ? frames : LOOKS;
    const double last_s = (double)frames / r->rate_hz;
    const double begin_s = (double)r->start.late_us * 1e-6;
    lum_place place;
    lum_place_init(&place, &r->place, r->seed);
    for (int64_t i = 0; i <= looks; i++) {
        const double time_s = begin_s + last_s * (double)i / (double)looks;
        if (!standing_see_eyes(o, &place, &time_s)) {
            return false;
        }
    }
    return true;
}

#define DEGREES (180.0 / 3.14159265358979323846)

struct moving_jump moving_find_jump(const struct options *o, unsigned frames)
{
    const lum_render_options *r = &o->render;
    lum_place place;
    lum_place_init(&place, &r->place, r->seed);
    const lum_pose first = lum_place_pose(&place, 0.0);
    const lum_pose last = lum_place_pose(&place, frames / r->rate_hz);
    return (struct moving_jump){
        .metres =
            hypot(hypot(last.at[0] - first.at[0], last.at[1] - first.at[1]),
                  last.at[2] - first.at[2]),
        .degrees = lum_pose_angle(&first, &last) * DEGREES};
}
