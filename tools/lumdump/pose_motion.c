#include "pose_motion.h"

#include "base/text.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CAUSES_BYTES 400u

struct motion {
    const char *name; /* of the poses */
    lum_poses *poses;
    lum_poses_info info;
    lum_move_options options;
    bool has_origin;
    float *places; /* x, y and z */
    size_t room;   /* of each */
    lum_move_counts counts;
    int64_t first_ns; /* of frames with points, by the poses' clock */
    int64_t last_ns;
};

/* --- Making --- */

int motion_new(const struct options *o, struct motion **out, lum_error *error)
{
    *out = NULL;
    if (o->points.motion.poses == NULL) {
        return 0;
    }
    struct motion *m = calloc(1, sizeof *m);
    if (m == NULL) {
        errno = ENOMEM;
        return lum_error_set(error, "out of memory");
    }
    const char *path = o->points.motion.poses;
    m->name = strcmp(path, "-") == 0 ? "standard input" : path;
    m->info.struct_size = sizeof m->info;
    if (lum_poses_read(path, o->points.motion.times, NULL, &m->poses, error) !=
        0) {
        motion_free(m);
        return -1;
    }
    (void)lum_poses_get_info(m->poses, &m->info);
    m->options = (lum_move_options){.struct_size = sizeof m->options,
                                    .poses = m->poses,
                                    .to = o->points.motion.to};
    m->has_origin =
        options_is_in_world(o) && lum_poses_origin(m->poses, m->options.origin);
    motion_restart(m);
    *out = m;
    return 0;
}

void motion_free(struct motion *m)
{
    if (m != NULL) {
        lum_poses_free(m->poses);
        free(m->places);
        free(m);
    }
}

void motion_restart(struct motion *m)
{
    if (m != NULL) {
        m->counts = (lum_move_counts){.points = 0};
        m->first_ns = INT64_MAX;
        m->last_ns = INT64_MIN;
    }
}

bool motion_is_utc(const struct motion *m)
{
    return m != NULL && m->info.clock == LUM_POSES_UTC;
}

/* --- Moving --- */

static int make_room(struct motion *m, size_t points, lum_error *error)
{
    if (points <= m->room) {
        return 0;
    }
    free(m->places);
    m->room = 0;
    m->places = malloc(3u * points * sizeof *m->places);
    if (m->places == NULL) {
        errno = ENOMEM;
        return lum_error_set(error, "out of memory");
    }
    m->room = points;
    return 0;
}

static void note_span(struct motion *m, const lum_frame *frame)
{
    lum_frame_info info = {.struct_size = sizeof info};
    (void)lum_frame_get_info(frame, &info);
    const lum_frame_times *t = &info.times;
    const int64_t first_ns =
        motion_is_utc(m) ? t->begin_utc_ns : t->begin_clock_us * 1000;
    const int64_t last_ns =
        first_ns + (t->end_clock_us - t->begin_clock_us) * 1000;
    if (info.points > 0) {
        m->first_ns = first_ns < m->first_ns ? first_ns : m->first_ns;
        m->last_ns = last_ns > m->last_ns ? last_ns : m->last_ns;
    }
}

int motion_move(struct motion *m, const lum_frame *frame, struct moved *out,
                lum_error *error)
{
    const uint64_t before = lum_move_counts_without(&m->counts);
    if (make_room(m, lum_frame_count(frame), error) != 0) {
        return -1;
    }
    float *x = m->places;
    float *y = m->places != NULL ? x + m->room : NULL;
    float *z = m->places != NULL ? y + m->room : NULL;
    note_span(m, frame);
    *out = (struct moved){.x = x, .y = y, .z = z};
    if (lum_frame_move(frame, &m->options, x, y, z, &m->counts, error) != 0) {
        return -1;
    }
    out->without = (size_t)(lum_move_counts_without(&m->counts) - before);
    return 0;
}

/* --- Asking --- */

const lum_move_counts *motion_counts(const struct motion *m)
{
    return &m->counts;
}

bool motion_origin(const struct motion *m, double out[3])
{
    if (m == NULL || !m->has_origin) {
        return false;
    }
    memcpy(out, m->options.origin, sizeof m->options.origin);
    return true;
}

double motion_farthest(const struct motion *m)
{
    double most = 0.0;
    for (int i = 0; i < 3; i++) {
        most = fmax(most, m->info.max[i] - m->options.origin[i]);
        most = fmax(most, m->options.origin[i] - m->info.min[i]);
    }
    return most;
}

const char *motion_name(const struct motion *m)
{
    return m->name;
}

int motion_check(const struct motion *m, lum_error *error)
{
    const lum_move_counts *c = &m->counts;
    if (c->points == 0 || lum_move_counts_without(c) < c->points) {
        return 0;
    }
    if (lum_poses_check_span(m->poses, m->name, m->first_ns, m->last_ns,
                             error) != 0) {
        return -1;
    }
    errno = EINVAL;
    return lum_error_set(
        error,
        "%s: no point has a pose: all %" PRIu64
        " are in gaps of the poses, or where they begin or end; poses are "
        "needed at most 1 s apart, and when a frame begins",
        m->name, c->points);
}

static void tell_cause(char out[CAUSES_BYTES], uint64_t points,
                       const char *cause)
{
    if (points > 0) {
        lum_text_add(out, CAUSES_BYTES, "%s%" PRIu64 " %s",
                     out[0] != '\0' ? ", " : "", points, cause);
    }
}

bool motion_tell(const struct motion *m, char *out, size_t room)
{
    const lum_move_counts *c = &m->counts;
    char causes[CAUSES_BYTES] = "";
    char gap[120] = "";
    tell_cause(causes, c->before, "before the first one");
    tell_cause(causes, c->after, "after the last one");
    tell_cause(causes, c->in_gap, "in gaps");
    tell_cause(causes, c->no_start,
               "in frames without a pose at their start or middle");
    tell_cause(causes, c->no_time, "without a time");
    if (c->in_gap > 0) {
        (void)snprintf(gap, sizeof gap,
                       "; the longest of %zu gaps is from %.3f to %.3f s",
                       m->info.gaps, (double)m->info.gap_from_ns * 1e-9,
                       (double)m->info.gap_to_ns * 1e-9);
    }
    (void)snprintf(out, room,
                   "%s: %" PRIu64 " of %" PRIu64
                   " points have no pose and are left out: %s%s",
                   m->name, lum_move_counts_without(c), c->points, causes, gap);
    return lum_move_counts_without(c) > 0;
}
