/* Points moved by poses. Time is cut into pieces, in each of which a point's
 * matrix is a linear function of its time. */
#include "lum/frame/move.h"

#include "base/sized.h"
#include "points/motion.h"
#include "poses_internal.h"

#include <errno.h>
#include <math.h>
#include <string.h>

#define CELLS 12
#define BLOCK 512u /* points that are looked at while they are in the cache */

/* The bound of lum/frame/move.h, of which matrices take this part. */
#define ERROR_M    0.9e-4
#define REACH_M    100.0
#define PIECES_MAX 1e6

#define SECONDS_MAX 1e6f  /* from the begin, that can be added to times */
#define FOREVER_S   1e30f /* finite, for it is multiplied by a slope of 0 */

#define HALF_PI 1.57079632679489661923

/* Points of these times, in seconds from the begin, have these matrices. */
typedef struct piece {
    lum_motion motion;
    lum_poses_place place;
    bool is_known; /* else its points become NaN */
} piece;

/* Between two neighbouring poses. */
typedef struct interval {
    size_t first; /* the pose; `count` of the poses: none yet */
    double pieces;
} interval;

typedef struct mover {
    const lum_poses *poses;
    int64_t begin_ns;
    bool clamps;
    bool has_start; /* the moment that is moved to has a pose */
    lum_pose back;  /* from the world to there */
    double origin[3];
    size_t near;
    interval interval;
    int64_t end_ns; /* of the last piece, with its matrix there */
    double end[CELLS];
} mover;

/* --- Pieces --- */

static float to_s(const mover *m, int64_t ns)
{
    return (float)((double)(ns - m->begin_ns) * 1e-9);
}

static void matrix_of(const mover *m, const lum_pose *pose, double out[CELLS])
{
    const lum_pose moved = lum_pose_compose(&m->back, pose);
    lum_pose_matrix(&moved, out);
    for (int row = 0; row < 3; row++) {
        out[4 * row + 3] -= m->origin[row];
    }
}

/* One pose for all of these times. */
static void stand(mover *m, const lum_pose *pose, float from_s, float end_s,
                  piece *out)
{
    double matrix[CELLS];
    out->motion.from_s = from_s;
    out->motion.to_s = end_s;
    matrix_of(m, pose, matrix);
    for (int i = 0; i < CELLS; i++) {
        out->motion.matrix[i] = (float)matrix[i];
        out->motion.slope[i] = 0.0f;
    }
}

/* Into how many pieces of time. A matrix between two of a turn by an angle a is
 * short by a^2/8 of a point's distance, and by a/8 of the way. */
static double count_pieces(const lum_pose *a, const lum_pose *b)
{
    const double angle = lum_pose_angle(a, b);
    const double way =
        HALF_PI * hypot(hypot(a->at[0] - b->at[0], a->at[1] - b->at[1]),
                        a->at[2] - b->at[2]);
    const double n =
        ceil(sqrt(angle * (REACH_M * angle + way) / (8.0 * ERROR_M)));
    return n < 1.0 ? 1.0 : n < PIECES_MAX ? n : PIECES_MAX;
}

static int64_t bound_of(const mover *m, double k)
{
    const int64_t *times = &m->poses->times[m->interval.first];
    return k >= m->interval.pieces
               ? times[1]
               : times[0] + (int64_t)((double)(times[1] - times[0]) * k /
                                      m->interval.pieces);
}

static void matrix_at(const mover *m, int64_t ns, double out[CELLS])
{
    const size_t i = m->interval.first;
    const int64_t *times = &m->poses->times[i];
    const lum_pose pose = lum_pose_between(
        &m->poses->poses[i], &m->poses->poses[i + 1u],
        (double)(ns - times[0]) / (double)(times[1] - times[0]));
    matrix_of(m, &pose, out);
}

/* The piece of a time between two poses; first: the one before it. */
static void go(mover *m, size_t first, int64_t ns, piece *out)
{
    const int64_t *times = &m->poses->times[first];
    double begin[CELLS];
    if (m->interval.first != first) {
        m->interval =
            (interval){first, count_pieces(&m->poses->poses[first],
                                           &m->poses->poses[first + 1u])};
    }
    double k = floor((double)(ns - times[0]) / (double)(times[1] - times[0]) *
                     m->interval.pieces);
    k -= bound_of(m, k) > ns ? 1.0 : 0.0;
    k += bound_of(m, k + 1.0) <= ns ? 1.0 : 0.0;
    const int64_t from_ns = bound_of(m, k);
    const int64_t end_ns = bound_of(m, k + 1.0);
    if (from_ns == m->end_ns) {
        memcpy(begin, m->end, sizeof begin);
    } else {
        matrix_at(m, from_ns, begin);
    }
    matrix_at(m, end_ns, m->end);
    m->end_ns = end_ns;
    out->motion.from_s = to_s(m, from_ns);
    out->motion.to_s = to_s(m, end_ns);
    const double a_second = 1e9 / (double)(end_ns - from_ns);
    for (int i = 0; i < CELLS; i++) {
        out->motion.matrix[i] = (float)begin[i];
        out->motion.slope[i] = (float)((m->end[i] - begin[i]) * a_second);
    }
}

typedef struct span {
    int64_t from_ns;
    int64_t end_ns; /* the first that is not of it */
} span;

/* What lies between two poses, but for what is as near to one as if it were
 * there. i: the second of the two. */
static span find_apart(const lum_poses *p, size_t i)
{
    return (span){
        i > 0 ? p->times[i - 1u] + LUM_POSES_SLACK_NS + 1 : -INT64_MAX,
        i < p->info.count ? p->times[i] - LUM_POSES_SLACK_NS : INT64_MAX};
}

/* Times about this one that have the same pose, of a time that is not between
 * two near poses. i: the first pose that is not before it. */
static span find_span(const lum_poses *p, size_t i, int64_t ns)
{
    span out = find_apart(p, i);
    if (ns < out.from_ns) {
        return (span){p->times[i - 1u], out.from_ns};
    }
    if (ns >= out.end_ns) {
        return (span){out.end_ns, p->times[i]};
    }
    if (i > 0 && i < p->info.count) {
        const int64_t middle =
            p->times[i - 1u] + (p->times[i] - p->times[i - 1u] + 1) / 2;
        *(ns < middle ? &out.end_ns : &out.from_ns) = middle;
    }
    return out;
}

static float bound_s(const mover *m, int64_t ns)
{
    return ns == INT64_MAX    ? FOREVER_S
           : ns == -INT64_MAX ? -FOREVER_S
                              : to_s(m, ns);
}

/* The piece of a time. */
static void find_piece(mover *m, int64_t ns, piece *out)
{
    const lum_poses *p = m->poses;
    lum_pose pose;
    const size_t i = lum_poses_find(p, ns, &m->near);
    const bool is_at = i < p->info.count && p->times[i] == ns;
    const size_t first = is_at ? i : i - 1u; /* wraps before the first */
    if (first < p->info.count - 1u &&
        p->times[first + 1u] - p->times[first] <= p->gap_ns) {
        out->place = LUM_POSES_INSIDE;
        out->is_known = true;
        go(m, first, ns, out);
        return;
    }
    out->place = lum_poses_at(p, ns, &m->near, &pose);
    out->is_known = m->clamps || out->place == LUM_POSES_INSIDE;
    const span span_of = is_at ? (span){ns, ns + 1} : find_span(p, i, ns);
    stand(m, &pose, bound_s(m, span_of.from_ns), bound_s(m, span_of.end_ns),
          out);
}

/* --- Points --- */

/* How many of the first n times are in a piece. */
static size_t count_inside(const float *time, size_t n, const lum_motion *m)
{
    const size_t inside = lum_motion_count(m, time, n);
    size_t i = inside == n ? n : 0;
    while (i < inside && time[i] >= m->from_s && time[i] < m->to_s) {
        i++;
    }
    return i;
}

static void fill(float *out, size_t n, float with)
{
    for (size_t i = 0; i < n; i++) {
        out[i] = with;
    }
}

static void add_up(lum_move_counts *counts, const mover *m, const piece *p,
                   size_t n)
{
    counts->before += p->place == LUM_POSES_BEFORE ? n : 0;
    counts->after += p->place == LUM_POSES_AFTER ? n : 0;
    counts->in_gap += p->place == LUM_POSES_IN_GAP ? n : 0;
    counts->no_start += p->place == LUM_POSES_INSIDE && !m->has_start ? n : 0;
}

struct places {
    float *of[3];
};

static void move_run(const mover *m, const lum_move_points *points,
                     size_t first, size_t n, const piece *p,
                     const struct places *to)
{
    float *const out[3] = {to->of[0] + first, to->of[1] + first,
                           to->of[2] + first};
    if (p->is_known && (m->has_start || m->clamps)) {
        const lum_motion_points from = {points->x + first, points->y + first,
                                        points->z + first,
                                        points->time + first};
        lum_motion_move(&p->motion, &from, n, out);
        return;
    }
    for (int row = 0; row < 3; row++) {
        fill(out[row], n, NAN);
    }
}

static void move_all(mover *m, const lum_move_points *points,
                     const struct places *to, lum_move_counts *counts)
{
    piece p = {.motion = {.from_s = 1.0f}}; /* of no time */
    size_t i = 0;
    counts->points += points->count;
    while (i < points->count) {
        const size_t left = points->count - i;
        size_t n = count_inside(points->time + i, left < BLOCK ? left : BLOCK,
                                &p.motion);
        if (n == 0) {
            const float time = points->time[i];
            n = 1; /* at least, however floats are rounded */
            if (!(fabsf(time) <= SECONDS_MAX)) {
                counts->no_time++;
                for (int row = 0; row < 3; row++) {
                    to->of[row][i] = NAN;
                }
                i++;
                continue;
            }
            find_piece(m, m->begin_ns + llround((double)time * 1e9), &p);
        }
        move_run(m, points, i, n, &p, to);
        add_up(counts, m, &p, n);
        i += n;
    }
}

/* --- Asking --- */

static int64_t bounded(int64_t ns)
{
    return ns > LUM_POSES_TIME_MAX_NS    ? LUM_POSES_TIME_MAX_NS
           : ns < -LUM_POSES_TIME_MAX_NS ? -LUM_POSES_TIME_MAX_NS
                                         : ns;
}

static void prepare(mover *m, const lum_move_points *points,
                    const lum_move_options *o)
{
    *m = (mover){.poses = o->poses,
                 .begin_ns = bounded(points->begin_ns),
                 .clamps = o->clamps,
                 .has_start = true,
                 .back = lum_pose_identity(),
                 .near = SIZE_MAX,
                 .interval = {.first = SIZE_MAX},
                 .end_ns = INT64_MIN};
    if (o->to == LUM_MOVE_TO_WORLD) {
        memcpy(m->origin, o->origin, sizeof m->origin);
        return;
    }
    lum_pose start;
    m->has_start = lum_poses_at(o->poses, bounded(points->start_ns), &m->near,
                                &start) == LUM_POSES_INSIDE;
    m->back = lum_pose_inverse(&start);
}

static int take_options(const lum_move_options *given, lum_move_options *out,
                        lum_error *error)
{
    if (lum_sized_take(out, sizeof *out, given, "the options of moving",
                       "lum_move_options", error) != 0) {
        return -1;
    }
    if (out->to != LUM_MOVE_TO_START && out->to != LUM_MOVE_TO_MIDDLE &&
        out->to != LUM_MOVE_TO_WORLD) {
        errno = EINVAL;
        return lum_error_set(
            error, "moving: the option to is %d; use a value of lum_move_to",
            (int)out->to);
    }
    return 0;
}

int lum_points_move(const lum_move_points *points,
                    const lum_move_options *options, float *x, float *y,
                    float *z, lum_move_counts *counts, lum_error *error)
{
    lum_move_points from;
    lum_move_options o;
    mover m;
    if (lum_sized_take(&from, sizeof from, points, "points to move",
                       "lum_move_points", error) != 0 ||
        take_options(options, &o, error) != 0) {
        return -1;
    }
    prepare(&m, &from, &o);
    move_all(&m, &from, &(struct places){{x, y, z}}, counts);
    return 0;
}

static int64_t ns_of(int64_t us)
{
    return us > LUM_POSES_TIME_MAX_NS / 1000    ? LUM_POSES_TIME_MAX_NS
           : us < -LUM_POSES_TIME_MAX_NS / 1000 ? -LUM_POSES_TIME_MAX_NS
                                                : us * 1000;
}

/* By the poses' clock, when the frame began and where its middle is. */
static void find_moments(const lum_frame_times *times, const lum_poses *poses,
                         lum_move_to to, lum_move_points *out)
{
    const int64_t clock_ns = ns_of(times->begin_clock_us);
    const int64_t half_ns = (ns_of(times->end_clock_us) - clock_ns) / 2;
    out->begin_ns =
        poses->info.clock == LUM_POSES_UTC ? times->begin_utc_ns : clock_ns;
    out->start_ns = out->begin_ns + (to == LUM_MOVE_TO_MIDDLE ? half_ns : 0);
}

int lum_frame_move(const lum_frame *frame, const lum_move_options *options,
                   float *x, float *y, float *z, lum_move_counts *counts,
                   lum_error *error)
{
    lum_move_options o;
    lum_frame_info info = {.struct_size = sizeof info};
    lum_move_points points = {.struct_size = sizeof points,
                              .x = lum_frame_floats(frame, LUM_COLUMN_X),
                              .y = lum_frame_floats(frame, LUM_COLUMN_Y),
                              .z = lum_frame_floats(frame, LUM_COLUMN_Z),
                              .time = lum_frame_floats(frame, LUM_COLUMN_TIME),
                              .count = lum_frame_count(frame)};
    (void)lum_frame_get_info(frame, &info);
    if (take_options(options, &o, error) != 0) {
        return -1;
    }
    errno = EINVAL;
    if (points.x == NULL || points.y == NULL || points.z == NULL ||
        points.time == NULL) {
        return lum_error_set(error, "a frame to be moved needs the columns x, "
                                    "y, z and time: ask for all four");
    }
    if (points.count > 0 && info.times.begin_utc_ns == 0) {
        return lum_error_set(
            error,
            "the frame has no clock: its profile has no timestamp, so its "
            "points have no poses; use a profile with the field timestamp");
    }
    find_moments(&info.times, o.poses, o.to, &points);
    return lum_points_move(&points, &o, x, y, z, counts, error);
}
