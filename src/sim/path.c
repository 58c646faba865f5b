#include "path.h"

#include <math.h>

double lum_course_length(const lum_course *course)
{
    double sum = 0.0;
    for (size_t i = 0; i < course->count; i++) {
        sum += course->pieces[i].length_m;
    }
    return sum;
}

/* --- Along a course --- */

typedef struct heading {
    double x;
    double y;
    double yaw; /* radians */
} heading;

static heading go(heading h, double length, double radius)
{
    if (radius == 0.0) {
        h.x += length * cos(h.yaw);
        h.y += length * sin(h.yaw);
        return h;
    }
    const double yaw = h.yaw + length / radius;
    h.x += radius * (sin(yaw) - sin(h.yaw));
    h.y -= radius * (cos(yaw) - cos(h.yaw));
    h.yaw = yaw;
    return h;
}

/* In the same round, the same numbers, so that rounds are alike. */
static heading along(const lum_course *course, double s)
{
    const double length = lum_course_length(course);
    heading h = {course->at[0], course->at[1], 0.0};
    if (length > 0.0) {
        s -= length * floor(s / length);
    }
    for (size_t i = 0; i < course->count; i++) {
        const lum_path_piece *p = &course->pieces[i];
        if (s <= p->length_m) {
            return go(h, s, p->radius_m);
        }
        h = go(h, p->length_m, p->radius_m);
        s -= p->length_m;
    }
    return length > 0.0 ? (heading){course->at[0], course->at[1], 0.0}
                        : go(h, s, 0.0);
}

/* Metres of stop-and-go at 1 m/s. */
static double crawl(double time_s)
{
    const double quarter = LUM_PATH_CYCLE_S / 4.0;
    const double cycle = floor(time_s / LUM_PATH_CYCLE_S);
    const double t = time_s - cycle * LUM_PATH_CYCLE_S;
    const double before = cycle * 2.0 * quarter;
    if (t < quarter) {
        return before + t * t / (2.0 * quarter);
    }
    if (t < 2.0 * quarter) {
        return before + 0.5 * quarter + (t - quarter);
    }
    const double left = 3.0 * quarter - t;
    return before + 2.0 * quarter -
           (left > 0.0 ? left * left / (2.0 * quarter) : 0.0);
}

/* --- Given poses --- */

static lum_pose among(const lum_path *p, double time_s)
{
    size_t low = 0;
    size_t high = p->count - 1;
    if (!(time_s > p->times_s[0])) {
        return p->poses[0];
    }
    if (!(time_s < p->times_s[high])) {
        return p->poses[high];
    }
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (p->times_s[middle] <= time_s) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return lum_pose_between(&p->poses[low], &p->poses[high],
                            (time_s - p->times_s[low]) /
                                (p->times_s[high] - p->times_s[low]));
}

static double distance(const lum_pose *a, const lum_pose *b)
{
    double square = 0.0;
    for (int i = 0; i < 3; i++) {
        square += (b->at[i] - a->at[i]) * (b->at[i] - a->at[i]);
    }
    return sqrt(square);
}

/* A screw is longer than the line between its ends, but by less than this for
 * turns of up to half a round. */
#define SCREW 1.6

static double fastest_of(const lum_path *p, double lever_m)
{
    double fastest = 0.0;
    for (size_t i = 1; i < p->count; i++) {
        const lum_pose *a = &p->poses[i - 1];
        const lum_pose *b = &p->poses[i];
        const double way =
            SCREW * distance(a, b) + lever_m * lum_pose_angle(a, b);
        const double speed = way / (p->times_s[i] - p->times_s[i - 1]);
        fastest = speed > fastest ? speed : fastest;
    }
    return fastest;
}

/* Radians for each metre. */
static double sharpest_of(const lum_course *course)
{
    double sharpest = 0.0;
    for (size_t i = 0; i < course->count; i++) {
        const double radius = fabs(course->pieces[i].radius_m);
        sharpest = radius > 0.0 ? fmax(sharpest, 1.0 / radius) : sharpest;
    }
    return sharpest;
}

/* --- Both --- */

lum_pose lum_path_at(const lum_path *path, double time_s)
{
    if (path->kind == LUM_PATH_POSES) {
        return among(path, time_s);
    }
    const double s =
        path->velocity_m_s *
        (path->kind == LUM_PATH_STOP_AND_GO ? crawl(time_s) : time_s);
    const heading h = along(&path->course, s);
    return (lum_pose){{h.x, h.y, path->course.at[2]},
                      {0.0, 0.0, sin(0.5 * h.yaw), cos(0.5 * h.yaw)}};
}

double lum_path_fastest(const lum_path *path, double lever_m)
{
    return path->kind == LUM_PATH_POSES
               ? fastest_of(path, lever_m)
               : path->velocity_m_s *
                     (1.0 + lever_m * sharpest_of(&path->course));
}
