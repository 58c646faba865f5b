#include "sight.h"

#include "rotation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Within a section the sensor moves by at most this, if a section is not a
 * line. */
#define SECTION_M 0.5

/* A sensor whose vertical is nearer to it than this is level; then what it sees
 * is limited by azimuths, with this margin, if they are at most so wide to
 * either side. Cosine; radians. */
#define LEVEL  0.9998
#define MARGIN 0.06
#define WIDEST 1.5

/* Rounding, and a clock of microseconds. */
#define SLACK_M 0.002

/* From one pixel whose pose is computed to the next; between them it is
 * linear. */
#define KNOT_PIXELS 25u

/* --- Making and freeing --- */

/* Eyes at the same place share a scene. */
static void share_scenes(lum_sight *s)
{
    const float *blue = s->mounts[LUM_EYE_BLUE];
    const float *green = s->mounts[LUM_EYE_GREEN];
    const bool same =
        blue[0] == green[0] && blue[1] == green[1] && blue[2] == green[2];
    s->scene_of[LUM_EYE_BLUE] = LUM_EYE_BLUE;
    s->scene_of[LUM_EYE_GREEN] = same ? LUM_EYE_BLUE : LUM_EYE_GREEN;
}

/* The largest azimuth in the frame of the sensor, to either side. */
static double find_half_view(const lum_scan *scan)
{
    double most = 0.0;
    lum_scan_line line;
    lum_random random;
    lum_random_init(&random, 0, 0);
    for (uint32_t i = 0; i < LUM_EYES * scan->lines; i++) {
        lum_scan_compute(scan, i % LUM_EYES, i / LUM_EYES, &random, &line);
        for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
            const float *d = line.direction[p];
            most = fmax(most, fabs(atan2((double)d[1], (double)d[0])));
        }
    }
    return most;
}

/* How far the sensor is from what follows the path. */
static double lever_of(const lum_place_options *options)
{
    const double *at = options->on_vehicle.at;
    return options->is_on_vehicle ? hypot(hypot(at[0], at[1]), at[2]) : 0.0;
}

void lum_sight_init(lum_sight *out, const lum_place_options *options,
                    uint64_t seed, const lum_scan *scan, double rate_hz,
                    double begin_s)
{
    memset(out, 0, sizeof *out);
    out->lines = scan->lines;
    out->rate_hz = rate_hz;
    out->begin_s = begin_s;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        memcpy(out->mounts[eye], lum_scan_mount(scan, eye),
               sizeof out->mounts[eye]);
    }
    share_scenes(out);
    lum_place_init(&out->place, options, seed);
    if (lum_place_moves(&out->place)) {
        out->half_view = find_half_view(scan);
        out->fastest =
            lum_path_fastest(&out->place.options.path, lever_of(options));
    }
}

static void free_kept(lum_sight *s, unsigned eye)
{
    for (uint32_t i = 0; s->kept[eye] != NULL && i < s->lines; i++) {
        free(s->kept[eye][i].hits);
    }
    free(s->kept[eye]);
    s->kept[eye] = NULL;
}

void lum_sight_free(lum_sight *sight)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        lum_scene_free(&sight->scenes[eye]);
        free_kept(sight, eye);
    }
    free(sight->work.hits);
    sight->work.hits = NULL;
    sight->frame = 0;
}

const lum_place *lum_sight_place(const lum_sight *sight)
{
    return &sight->place;
}

/* --- Looking --- */

/* Without memory for lines to be kept, each frame is looked at. */
static lum_result make_room(lum_sight *s)
{
    if (s->work.hits == NULL) {
        s->work.hits =
            malloc(LUM_SCENE_HITS_MAX * LUM_LINE_PIXELS * sizeof *s->work.hits);
    }
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        if (s->kept[eye] == NULL && lum_place_is_still(&s->place)) {
            s->kept[eye] = calloc(s->lines, sizeof *s->kept[eye]);
        }
    }
    return s->work.hits != NULL ? LUM_OK : LUM_E_SPACE;
}

static lum_result set_scenes(lum_sight *s, int64_t frame)
{
    if (s->frame == frame || (s->frame != 0 && lum_place_is_still(&s->place))) {
        return LUM_OK;
    }
    const double time_s = s->begin_s + (double)(frame - 1) / s->rate_hz;
    s->frame = 0;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        if (s->scene_of[eye] == eye &&
            lum_scene_set(&s->scenes[eye], &s->place, time_s, s->mounts[eye]) !=
                0) {
            return LUM_E_SPACE;
        }
    }
    s->frame = frame;
    return make_room(s);
}

/* Returns how many hits. */
static size_t cast(lum_sight *s, unsigned eye, const lum_scan_line *scan)
{
    const lum_scene *scene = &s->scenes[s->scene_of[eye]];
    size_t count = 0;
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
        float d[3];
        lum_place_turn(&s->place, scan->direction[p], d);
        const lum_ray ray = lum_ray_make(d);
        const size_t n = lum_scene_cast(scene, &ray, &s->work.hits[count]);
        s->work.counts[p] = (uint8_t)n;
        count += n;
    }
    return count;
}

static void keep(const lum_sight_line *work, size_t count, lum_sight_line *out)
{
    lum_hit *hits = malloc((count + 1) * sizeof *hits);
    if (hits != NULL) {
        *out = *work;
        out->hits = hits;
        memcpy(hits, work->hits, count * sizeof *hits);
    }
}

/* --- Looking from a sensor that moves --- */

static double line_duration(const lum_sight *s)
{
    return 1.0 / s->rate_hz / (double)s->lines;
}

static double mount_length(const lum_sight *s)
{
    double longest = 0.0;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        double square = 0.0;
        for (int i = 0; i < 3; i++) {
            square += (double)s->mounts[eye][i] * (double)s->mounts[eye][i];
        }
        longest = fmax(longest, sqrt(square));
    }
    return longest;
}

static double turned_by(double from, double to)
{
    return to - from - LUM_FULL_TURN * floor((to - from) / LUM_FULL_TURN + 0.5);
}

/* The heading; false if it is not level. */
static bool find_heading(const lum_pose *pose, double *out)
{
    double m[12];
    lum_pose_matrix(pose, m);
    *out = atan2(m[4], m[0]);
    return m[10] > LEVEL;
}

/* What the lines of a section see, if the sensor stays level and does not look
 * back; else all. */
static void limit_view(const lum_sight *s, double begin_s, double line_s,
                       uint32_t lines, lum_sight_view *out)
{
    double first = 0.0;
    double half = 0.0;
    lum_pose pose = lum_place_pose(&s->place, begin_s);
    bool is_level = find_heading(&pose, &first);
    for (uint32_t i = 1; i <= lines; i++) {
        double heading = 0.0;
        pose = lum_place_pose(&s->place, begin_s + line_s * i);
        is_level = find_heading(&pose, &heading) && is_level;
        half = fmax(half, fabs(turned_by(first, heading)));
    }
    half += s->half_view + MARGIN;
    if (!is_level || half > WIDEST) {
        return;
    }
    for (int i = 0; i < 2; i++) {
        const double side = i == 0 ? 1.0 : -1.0;
        out->edge[i][0] = (float)(side * sin(first + side * half));
        out->edge[i][1] = (float)(-side * cos(first + side * half));
    }
}

/* Sections are parts of a frame, so that a line is the same whatever was looked
 * at before. */
static lum_result set_section(lum_sight *s, int64_t frame, uint32_t line)
{
    const double lines = (double)s->lines;
    const double way = ceil(s->fastest / s->rate_hz / SECTION_M);
    const double count = fmax(1.0, fmin(way, lines));
    const double part = floor((double)line * count / lines);
    const int64_t number = (frame - 1) * (int64_t)s->lines + (int64_t)part + 1;
    const double line_s = line_duration(s);
    lum_section now = {.time_s = s->begin_s +
                                 ((double)(frame - 1) + (part + 0.5) / count) /
                                     s->rate_hz,
                       .half_s = (0.5 / count + 1.0 / lines) / s->rate_hz};
    if (s->section_number == number) {
        return LUM_OK;
    }
    s->section_number = 0;
    now.view.reach_m =
        (float)(s->fastest * now.half_s + mount_length(s) + SLACK_M);
    const lum_pose pose = lum_place_pose(&s->place, now.time_s);
    memcpy(now.view.at, pose.at, sizeof now.view.at);
    limit_view(s, now.time_s - now.half_s, line_s,
               (uint32_t)ceil(2.0 * now.half_s / line_s), &now.view);
    if (lum_scene_set_section(&s->scenes[0], &s->place, &now) != 0) {
        return LUM_E_SPACE;
    }
    s->section = now;
    s->section_number = number;
    return make_room(s);
}

/* The rotation, and where the eye is, from the section's middle. */
static void find_knot(const lum_sight *s, unsigned eye, const lum_pose *begin,
                      const lum_pose *end, double share, double out[12])
{
    const lum_pose pose = lum_pose_between(begin, end, share);
    lum_pose_matrix(&pose, out);
    for (int i = 0; i < 3; i++) {
        out[4 * i + 3] -= s->section.view.at[i];
        for (int k = 0; k < 3; k++) {
            out[4 * i + 3] += out[4 * i + k] * (double)s->mounts[eye][k];
        }
    }
}

static size_t cast_knot(lum_sight *s, double knots[2][12], double late_s,
                        uint32_t first, const lum_scan_line *scan, size_t count)
{
    const double line_s = line_duration(s);
    for (uint32_t n = 0; n < KNOT_PIXELS; n++) {
        const uint32_t p = first + n;
        const double share = (double)n / KNOT_PIXELS;
        lum_start start = {
            .late_s = (float)(late_s + line_s * (double)p / LUM_LINE_PIXELS)};
        float m[9];
        float d[3];
        for (int i = 0; i < 12; i++) {
            const float at =
                (float)(knots[0][i] + share * (knots[1][i] - knots[0][i]));
            *(i % 4 == 3 ? &start.from[i / 4] : &m[3 * (i / 4) + i % 4]) = at;
        }
        lum_rotation_turn(m, scan->direction[p], d);
        const lum_ray ray = lum_ray_make(d);
        const size_t hits = lum_scene_cast_from(&s->scenes[0], &start, &ray,
                                                &s->work.hits[count]);
        s->work.counts[p] = (uint8_t)hits;
        count += hits;
    }
    return count;
}

/* Between the poses of this line and the next, as one who has only these. */
static void cast_moving(lum_sight *s, unsigned eye, double time_s,
                        const lum_scan_line *scan)
{
    const double line_s = line_duration(s);
    const lum_pose begin = lum_place_pose(&s->place, time_s);
    const lum_pose end = lum_place_pose(&s->place, time_s + line_s);
    double knots[2][12];
    size_t count = 0;
    find_knot(s, eye, &begin, &end, 0.0, knots[1]);
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p += KNOT_PIXELS) {
        memcpy(knots[0], knots[1], sizeof knots[0]);
        find_knot(s, eye, &begin, &end,
                  (double)(p + KNOT_PIXELS) / LUM_LINE_PIXELS, knots[1]);
        count = cast_knot(s, knots, time_s - s->section.time_s, p, scan, count);
    }
}

lum_result lum_sight_look(lum_sight *sight, int64_t frame, uint32_t line,
                          unsigned eye, double time_s,
                          const lum_scan_line *scan, const lum_sight_line **out)
{
    if (lum_place_moves(&sight->place)) {
        if (set_section(sight, frame, line) != LUM_OK) {
            return LUM_E_SPACE;
        }
        cast_moving(sight, eye, time_s, scan);
        *out = &sight->work;
        return LUM_OK;
    }
    if (set_scenes(sight, frame) != LUM_OK) {
        return LUM_E_SPACE;
    }
    lum_sight_line *kept =
        sight->kept[eye] != NULL ? &sight->kept[eye][line] : NULL;
    if (kept != NULL && kept->hits != NULL) {
        *out = kept;
        return LUM_OK;
    }
    const size_t count = cast(sight, eye, scan);
    if (kept != NULL) {
        keep(&sight->work, count, kept);
    }
    *out = &sight->work;
    return LUM_OK;
}
