#define _POSIX_C_SOURCE 200809L /* strcasecmp */
#include "moving.h"

#include "../common/option_table.h"
#include "standing.h"

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
                        "'%.200s': labels are an array of NumPy; right is a "
                        "file whose name ends in .npy",
                        text);
    return false;
}

void moving_free(struct options *o)
{
    free(o->moving.given);
    free(o->moving.given_s);
}

static bool refuse(const char *why)
{
    (void)fprintf(stderr, "lumsim: %s\n", why);
    return false;
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
        return refuse(kind == LUM_PATH_NONE
                          ? "--velocity is that of --path straight, circle, "
                            "eight or stop-and-go; name one"
                          : "--velocity does not go with --path FILE: the "
                            "times of its poses say how fast the sensor is");
    }
    if (kind == LUM_PATH_NONE) {
        return true;
    }
    if (place->has_pose) {
        return refuse("--path and --pose: with one the sensor moves, with the "
                      "other it stands still; choose");
    }
    if (!o->moving.has_velocity) {
        place->path.velocity_m_s = usual_velocity(place->kind);
    }
    return check_place(o);
}

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
