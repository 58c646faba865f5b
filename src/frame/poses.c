/* Poses over time: checked as they are added, looked up. */
#include "poses_internal.h"

#include "base/grow.h"
#include "base/sized.h"

#include <errno.h>
#include <float.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define STEPS 4u /* from the last look-up, before a search */

#define ORIGIN_STEP_M 1000.0 /* for a person to remember */

/* Within it nothing that drives goes jump_m. */
#define JUMP_NS INT64_C(100000000)

/* Of times that are no seconds, each 1000 times smaller. */
#define UNITS 3u
static const char *const units[UNITS] = {"milliseconds", "microseconds",
                                         "nanoseconds"};

typedef struct label {
    char text[300];
} label;

static label label_of(const lum_poses_mark *mark)
{
    label out;
    if (mark->name == NULL) {
        (void)snprintf(out.text, sizeof out.text, "pose %zu", mark->number);
    } else {
        (void)snprintf(out.text, sizeof out.text, "%.250s: line %zu",
                       mark->name, mark->number);
    }
    return out;
}

static const char *line_or_pose(const lum_poses_mark *mark)
{
    return mark->name == NULL ? "pose" : "line";
}

static double seconds(int64_t ns)
{
    return (double)ns * 1e-9;
}

/* --- Making --- */

static int fail_memory(lum_error *error)
{
    errno = ENOMEM;
    (void)lum_error_set(error, "poses: out of memory");
    return -1;
}

static int check_options(const lum_poses_options *o, lum_error *error)
{
    errno = EINVAL;
    if (o->clock != LUM_POSES_BY_SIZE && o->clock != LUM_POSES_SENSOR &&
        o->clock != LUM_POSES_UTC) {
        return lum_error_set(
            error,
            "poses: the option clock is %d; use a value of lum_poses_clock",
            (int)o->clock);
    }
    if (o->gap_ns < 0) {
        return lum_error_set(error,
                             "poses: the option gap_ns is %" PRId64
                             "; use more than 0, or 0 for the usual one",
                             o->gap_ns);
    }
    if (!(o->jump_m >= 0.0)) {
        return lum_error_set(error,
                             "poses: the option jump_m is %g; use more than 0, "
                             "or 0 for the usual one",
                             o->jump_m);
    }
    return 0;
}

lum_poses *lum_poses_begin(const lum_poses_options *options, lum_error *error)
{
    lum_poses_options o = {.struct_size = sizeof o};
    if (options != NULL &&
        (lum_sized_take(&o, sizeof o, options, "the options of poses",
                        "lum_poses_options", error) != 0 ||
         check_options(&o, error) != 0)) {
        return NULL;
    }
    lum_poses *poses = calloc(1, sizeof *poses);
    if (poses == NULL) {
        (void)fail_memory(error);
        return NULL;
    }
    poses->gap_ns = o.gap_ns > 0 ? o.gap_ns : LUM_POSES_GAP_NS;
    poses->jump_m = o.jump_m > 0.0 ? o.jump_m : LUM_POSES_JUMP_M;
    poses->info.struct_size = sizeof poses->info;
    poses->info.clock = o.clock;
    return poses;
}

void lum_poses_free(lum_poses *poses)
{
    if (poses != NULL) {
        free(poses->times);
        free(poses->poses);
        free(poses);
    }
}

static int make_room(lum_poses *p, lum_error *error)
{
    size_t room = p->room;
    int64_t *times =
        lum_grown(p->times, p->info.count, 1, sizeof *times, &room);
    if (times == NULL) {
        return fail_memory(error);
    }
    p->times = times;
    lum_pose *poses =
        lum_grown(p->poses, p->info.count, 1, sizeof *poses, &p->room);
    if (poses == NULL) {
        return fail_memory(error);
    }
    p->poses = poses;
    return 0;
}

/* In order, and in a size that seconds can have. */
static int check_time(const lum_poses *p, int64_t time_ns,
                      const lum_poses_mark *mark, const lum_poses_mark *before,
                      lum_error *error)
{
    const label here = label_of(mark);
    if (time_ns > LUM_POSES_TIME_MAX_NS || time_ns < -LUM_POSES_TIME_MAX_NS) {
        return lum_error_set(error,
                             "%s: its time is %g s, which is 140 years or more "
                             "from 0; times are seconds",
                             here.text, seconds(time_ns));
    }
    if (p->info.count == 0) {
        return 0;
    }
    const int64_t last_ns = p->times[p->info.count - 1u];
    if (time_ns == last_ns) {
        return lum_error_set(error,
                             "%s has the time of %s %zu, %.9f s: remove one of "
                             "the two",
                             here.text, line_or_pose(mark), before->number,
                             seconds(time_ns));
    }
    if (time_ns < last_ns) {
        return lum_error_set(error,
                             "%s is out of order: its time is %.9f s, that of "
                             "%s %zu is %.9f s; sort the poses by time",
                             here.text, seconds(time_ns), line_or_pose(mark),
                             before->number, seconds(last_ns));
    }
    return 0;
}

/* Normalised, if it is nearly so already. */
static int check_turn(lum_pose *pose, const lum_poses_mark *mark,
                      lum_error *error)
{
    const double *q = pose->turn;
    const double length = hypot(hypot(q[0], q[1]), hypot(q[2], q[3]));
    const label here = label_of(mark);
    if (!(fabs(length + pose->at[0] + pose->at[1] + pose->at[2]) <= DBL_MAX)) {
        return lum_error_set(
            error,
            "%s: a number is infinite or not a number; leave such poses out",
            here.text);
    }
    if (fabs(length - 1.0) > LUM_POSES_UNIT_ERROR ||
        !lum_pose_normalize(pose)) {
        return lum_error_set(error,
                             "%s: the quaternion's length is %g; use 1, as qx "
                             "qy qz qw with w last, not angles",
                             here.text, length);
    }
    return 0;
}

static double distance(const double a[3], const double b[3])
{
    return hypot(hypot(a[0] - b[0], a[1] - b[1]), a[2] - b[2]);
}

/* The earliest pose from which time_ns is no more than JUMP_NS; or else the
 * last one. */
static size_t find_recent(lum_poses *p, int64_t time_ns)
{
    const int64_t span = p->gap_ns < JUMP_NS ? p->gap_ns : JUMP_NS;
    while (p->recent + 1u < p->info.count &&
           time_ns - p->times[p->recent] > span) {
        p->recent++;
    }
    return p->recent;
}

static int check_jump(lum_poses *p, int64_t time_ns, const lum_pose *pose,
                      const lum_poses_mark *mark, lum_error *error)
{
    const size_t n = p->info.count;
    if (n == 0 || time_ns - p->times[n - 1u] > p->gap_ns) {
        return 0;
    }
    const size_t recent = find_recent(p, time_ns);
    const size_t from =
        distance(pose->at, p->poses[n - 1u].at) > p->jump_m ? n - 1u : recent;
    const double jump = distance(pose->at, p->poses[from].at);
    if (jump <= p->jump_m) {
        return 0;
    }
    const label here = label_of(mark);
    return lum_error_set(
        error,
        "%s is %.1f m away from the pose %.3f s before: more than %g m; use "
        "metres: are x, y and z millimetres? If not, leave wrong poses out",
        here.text, jump, seconds(time_ns - p->times[from]), p->jump_m);
}

int lum_poses_add(lum_poses *p, int64_t time_ns, const lum_pose *pose,
                  const lum_poses_mark *mark, const lum_poses_mark *before,
                  lum_error *error)
{
    lum_pose unit = *pose;
    if (check_time(p, time_ns, mark, before, error) != 0 ||
        check_turn(&unit, mark, error) != 0 ||
        check_jump(p, time_ns, &unit, mark, error) != 0) {
        errno = EINVAL;
        return -1;
    }
    if (make_room(p, error) != 0) {
        return -1;
    }
    p->times[p->info.count] = time_ns;
    p->poses[p->info.count++] = unit;
    return 0;
}

static void find_box(lum_poses *p)
{
    lum_poses_info *info = &p->info;
    memcpy(info->min, p->poses[0].at, sizeof info->min);
    memcpy(info->max, p->poses[0].at, sizeof info->max);
    for (size_t i = 1; i < info->count; i++) {
        for (int k = 0; k < 3; k++) {
            info->min[k] = fmin(info->min[k], p->poses[i].at[k]);
            info->max[k] = fmax(info->max[k], p->poses[i].at[k]);
        }
    }
}

/* Returns the shortest step. */
static int64_t find_gaps(lum_poses *p)
{
    int64_t shortest = INT64_MAX;
    int64_t longest = 0;
    for (size_t i = 1; i < p->info.count; i++) {
        const int64_t step = p->times[i] - p->times[i - 1u];
        shortest = step < shortest ? step : shortest;
        p->info.gaps += step > p->gap_ns ? 1u : 0u;
        if (step > p->gap_ns && step > longest) {
            longest = step;
            p->info.gap_from_ns = p->times[i - 1u];
            p->info.gap_to_ns = p->times[i];
        }
    }
    return shortest;
}

/* If nothing is between any two, the unit is likely to be another one. */
static int refuse_steps(const lum_poses *p, const char *name, int64_t step,
                        lum_error *error)
{
    unsigned unit = 0;
    for (int64_t as = step / 1000; unit < UNITS - 1u && as > p->gap_ns;
         as /= 1000) {
        unit++;
    }
    errno = EINVAL;
    return lum_error_set(
        error,
        "%s: all poses are %g s apart or more, and points are placed only "
        "between poses up to %g s apart: if the times are %s, convert them to "
        "seconds; otherwise add poses",
        name != NULL ? name : "poses", seconds(step), seconds(p->gap_ns),
        units[unit]);
}

int lum_poses_end(lum_poses *p, const char *name, lum_error *error)
{
    lum_poses_info *info = &p->info;
    if (info->count == 0) {
        errno = EINVAL;
        return lum_error_set(error, "%s: has no poses; at least one is needed",
                             name != NULL ? name : "poses");
    }
    info->first_ns = p->times[0];
    info->last_ns = p->times[info->count - 1u];
    if (info->clock == LUM_POSES_BY_SIZE) {
        info->clock = info->first_ns > LUM_POSES_UTC_NS ? LUM_POSES_UTC
                                                        : LUM_POSES_SENSOR;
    }
    find_box(p);
    const int64_t step = find_gaps(p);
    return info->count > 1 && info->gaps == info->count - 1u
               ? refuse_steps(p, name, step, error)
               : 0;
}

int lum_poses_new(const int64_t *times_ns, const lum_pose *poses, size_t count,
                  const lum_poses_options *options, lum_poses **out,
                  lum_error *error)
{
    lum_poses *p = lum_poses_begin(options, error);
    int result = p != NULL ? 0 : -1;
    for (size_t i = 0; i < count && result == 0; i++) {
        const lum_poses_mark mark = {NULL, i};
        const lum_poses_mark before = {NULL, i - 1u};
        result =
            lum_poses_add(p, times_ns[i], &poses[i], &mark, &before, error);
    }
    if (result != 0 || lum_poses_end(p, NULL, error) != 0) {
        lum_poses_free(p);
        return -1;
    }
    *out = p;
    return 0;
}

/* --- Looking up --- */

lum_result lum_poses_get_info(const lum_poses *poses, lum_poses_info *out)
{
    return lum_sized_fill(out, &poses->info, sizeof poses->info) ? LUM_OK
                                                                 : LUM_E_VALUE;
}

void lum_poses_get(const lum_poses *poses, size_t i, int64_t *time_ns,
                   lum_pose *out)
{
    if (time_ns != NULL) {
        *time_ns = poses->times[i];
    }
    if (out != NULL) {
        *out = poses->poses[i];
    }
}

bool lum_poses_origin(const lum_poses *poses, double out[3])
{
    const lum_poses_info *info = &poses->info;
    bool is_far = false;
    for (int i = 0; i < 3; i++) {
        is_far = is_far || info->max[i] > LUM_POSES_FAR_M ||
                 info->min[i] < -LUM_POSES_FAR_M;
    }
    for (int i = 0; i < 3; i++) {
        const double middle = 0.5 * info->min[i] + 0.5 * info->max[i];
        out[i] = is_far ? round(middle / ORIGIN_STEP_M) * ORIGIN_STEP_M +
                              0.0 /* and no -0 */
                        : 0.0;
    }
    return is_far;
}

/* Whether i is the first one that is not before the time. */
static bool is_first(const lum_poses *p, size_t i, int64_t time_ns)
{
    return (i == 0 || p->times[i - 1u] < time_ns) &&
           (i == p->info.count || p->times[i] >= time_ns);
}

static size_t search(const lum_poses *p, int64_t time_ns)
{
    size_t from = 0;
    size_t to = p->info.count;
    while (from < to) {
        const size_t middle = from + (to - from) / 2u;
        if (p->times[middle] < time_ns) {
            from = middle + 1u;
        } else {
            to = middle;
        }
    }
    return from;
}

size_t lum_poses_find(const lum_poses *p, int64_t time_ns, size_t *near)
{
    if (near == NULL || *near > p->info.count) {
        const size_t found = search(p, time_ns);
        if (near != NULL) {
            *near = found;
        }
        return found;
    }
    size_t i = *near;
    for (unsigned step = 0; step < STEPS && !is_first(p, i, time_ns); step++) {
        if (i < p->info.count && p->times[i] < time_ns) {
            i++;
        } else {
            i--;
        }
    }
    *near = is_first(p, i, time_ns) ? i : search(p, time_ns);
    return *near;
}

/* A time that is at no pose; i: of the next pose. */
static lum_poses_place at_between(const lum_poses *p, size_t i, int64_t part,
                                  lum_pose *out)
{
    const int64_t whole = p->times[i] - p->times[i - 1u];
    if (whole > p->gap_ns) {
        const bool is_early = part < whole - part;
        *out = p->poses[is_early ? i - 1u : i];
        return (is_early ? part : whole - part) <= LUM_POSES_SLACK_NS
                   ? LUM_POSES_INSIDE
                   : LUM_POSES_IN_GAP;
    }
    *out = lum_pose_between(&p->poses[i - 1u], &p->poses[i],
                            (double)part / (double)whole);
    return LUM_POSES_INSIDE;
}

lum_poses_place lum_poses_at(const lum_poses *p, int64_t time_ns, size_t *near,
                             lum_pose *out)
{
    const size_t i = lum_poses_find(p, time_ns, near);
    if (i == p->info.count) {
        *out = p->poses[i - 1u];
        return time_ns - LUM_POSES_SLACK_NS <= p->info.last_ns
                   ? LUM_POSES_INSIDE
                   : LUM_POSES_AFTER;
    }
    if (p->times[i] == time_ns) {
        *out = p->poses[i];
        return LUM_POSES_INSIDE;
    }
    if (i == 0) {
        *out = p->poses[0];
        return time_ns >= p->info.first_ns - LUM_POSES_SLACK_NS
                   ? LUM_POSES_INSIDE
                   : LUM_POSES_BEFORE;
    }
    return at_between(p, i, time_ns - p->times[i - 1u], out);
}

/* --- Of another drive --- */

static bool overlap(const lum_poses_info *info, int64_t scale, int64_t from_ns,
                    int64_t to_ns)
{
    return info->first_ns / scale <= to_ns && info->last_ns / scale >= from_ns;
}

int lum_poses_check_span(const lum_poses *poses, const char *name,
                         int64_t from_ns, int64_t to_ns, lum_error *error)
{
    const lum_poses_info *info = &poses->info;
    int64_t scale = 1000;
    unsigned unit = 0;
    if (overlap(info, 1, from_ns, to_ns)) {
        return 0;
    }
    while (unit < UNITS && !overlap(info, scale, from_ns, to_ns)) {
        unit++;
        scale *= 1000;
    }
    errno = EINVAL;
    return lum_error_set(
        error,
        "%s: its poses are from %.3f to %.3f s %s, the points from %.3f to "
        "%.3f s; are %s%s?",
        name, seconds(info->first_ns), seconds(info->last_ns),
        info->clock == LUM_POSES_UTC ? "UTC" : "of the sensor's clock",
        seconds(from_ns), seconds(to_ns),
        unit < UNITS ? "its times " : "they from another drive",
        unit < UNITS ? units[unit] : "");
}
