#include "voxels.h"

#include "base/system.h"
#include "frame_lines.h"
#include "lum/map/map.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#define AT_ONCE 4096u /* voxels */

/* Bytes of a voxel in a file: of LAS, and of others at least. */
#define LAS_BYTES   34u
#define OTHER_BYTES 28u

/* Voxels from 0 to the end of the tiles. */
#define REACH 2147483648.0

struct voxels {
    const struct options *options;
    bool is_map;     /* of all frames, and not of each */
    lum_map *map;    /* NULL: between two frames */
    unsigned sensor; /* of the frame; 0: of all */
    struct voxel_counts counts;
    bool is_writing; /* all frames came */
    lum_map_voxel read[AT_ONCE];
    lum_sample samples[AT_ONCE];
    uint32_t points[AT_ONCE];
    int64_t times_ns[AT_ONCE];
};

static int fail_memory(lum_error *error)
{
    errno = ENOMEM;
    return lum_error_set(error, "--voxel: out of memory");
}

/* How what the library asks for is asked for here. */
static int advise(const struct voxels *v, lum_error *error)
{
    const int code = errno;
    if (code == ENOSPC) {
        const lum_error why = *error;
        (void)lum_error_set(error, "%s, such as --voxel %g", why.text,
                            2.0 * v->options->cloud.voxel);
    }
    errno = code;
    return -1;
}

/* --- From the beginning to the end --- */

static int begin_map(struct voxels *v, lum_error *error)
{
    const char *name = v->options->outputs[0].name;
    const lum_map_options options = {
        .struct_size = sizeof options,
        .voxel = v->options->cloud.voxel,
        .spool = strcmp(name, "-") == 0 ? "./lumdump" : name,
        .has_thread = v->is_map};
    return v->map != NULL ? 0 : lum_map_new(&options, &v->map, error);
}

int voxels_new(const struct options *options, struct voxels **out,
               lum_error *error)
{
    struct voxels *v = calloc(1, sizeof *v);
    if (v == NULL) {
        return fail_memory(error);
    }
    v->options = options;
    v->is_map = options_makes_map(options);
    v->counts.size = options->cloud.voxel;
    *out = v;
    return begin_map(v, error);
}

void voxels_free(struct voxels *v)
{
    const int code = errno;
    if (v != NULL) {
        lum_map_free(v->map);
        free(v);
    }
    errno = code;
}

/* --- Voxels to outputs --- */

static int put(struct voxels *v, size_t n, int64_t frame,
               struct outputs *outputs, lum_error *error)
{
    const double *origin = v->options->about.origin;
    for (size_t i = 0; i < n; i++) {
        const lum_map_voxel *from = &v->read[i];
        v->samples[i] = (lum_sample){.x = (float)(from->x - origin[0]),
                                     .y = (float)(from->y - origin[1]),
                                     .z = (float)(from->z - origin[2]),
                                     .pulse_width = from->pulse_width,
                                     .return_number = 1,
                                     .number_of_returns = 1};
        v->points[i] = from->count;
        v->times_ns[i] = from->time_ns;
    }
    const lum_line_samples line = {.struct_size = sizeof line,
                                   .samples = v->samples,
                                   .count = n,
                                   .frame = frame,
                                   .counts = v->points,
                                   .times_ns = v->times_ns};
    return outputs_act(
        outputs,
        &(struct action){.kind = ADD_LINE, .sensor = v->sensor, .line = &line},
        error);
}

static int put_some(struct voxels *v, int64_t frame, struct outputs *outputs,
                    bool *is_done, lum_error *error)
{
    size_t n = 0;
    if (lum_map_next(v->map, v->read, AT_ONCE, &n, error) != 0) {
        return -1;
    }
    *is_done = n < AT_ONCE;
    return n > 0 ? put(v, n, frame, outputs, error) : 0;
}

/* What the map of this moment has taken, on top of those before. */
static void note(struct voxels *v)
{
    lum_map_counters c = {.struct_size = sizeof c};
    if (lum_map_count(v->map, &c) != 0) {
        return;
    }
    v->counts.points += c.points;
    v->counts.voxels += c.voxels;
    v->counts.not_finite += c.not_finite;
    v->counts.out_of_range += c.out_of_range;
    v->counts.spooled += c.spooled;
}

/* A frame on its own. */
static int put_frame(struct voxels *v, int64_t frame, struct outputs *outputs,
                     lum_error *error)
{
    bool is_done = false;
    while (!is_done) {
        if (put_some(v, frame, outputs, &is_done, error) != 0) {
            return -1;
        }
    }
    note(v);
    lum_map_free(v->map);
    v->map = NULL;
    return 0;
}

/* --- Frames --- */

static int64_t begin_ns(const struct voxels *v, const lum_frame_times *times)
{
    const enum time_base base = v->options->points.time;
    return base == TIME_SENSOR ? times->begin_clock_us * 1000
                               : frame_begin_ns(times, base == TIME_ARRIVAL);
}

/* What has no pose is NaN, and left out by the map. */
int voxels_take(struct voxels *v, const lum_frame *frame,
                const struct moved *moved, unsigned sensor,
                struct outputs *outputs, lum_error *error)
{
    lum_frame_info info = {.struct_size = sizeof info};
    (void)lum_frame_get_info(frame, &info);
    lum_map_points points = {
        .struct_size = sizeof points,
        .count = lum_frame_count(frame),
        .x = lum_frame_floats(frame, LUM_COLUMN_X),
        .y = lum_frame_floats(frame, LUM_COLUMN_Y),
        .z = lum_frame_floats(frame, LUM_COLUMN_Z),
        .pulse_width = lum_frame_floats(frame, LUM_COLUMN_PULSE_WIDTH),
        .time = lum_frame_floats(frame, LUM_COLUMN_TIME),
        .time_ns = begin_ns(v, &info.times)};
    memcpy(points.origin, v->options->about.origin, sizeof points.origin);
    if (points.count == 0) {
        return 0;
    }
    v->sensor = v->is_map ? 0 : sensor;
    if (moved != NULL) {
        v->counts.without_pose += moved->without;
        points.x = moved->x;
        points.y = moved->y;
        points.z = moved->z;
    }
    if (begin_map(v, error) != 0 || lum_map_add(v->map, &points, error) != 0) {
        return advise(v, error);
    }
    return v->is_map ? 0 : put_frame(v, info.number, outputs, error);
}

/* --- The map --- */

/* What of it is on the disk counts twice for a while. */
static int check_place(struct voxels *v, lum_error *error)
{
    lum_map_counters c = {.struct_size = sizeof c};
    for (size_t i = 0; i < v->options->output_count; i++) {
        const struct output_options *o = &v->options->outputs[i];
        uint64_t free_bytes = 0;
        if (strcmp(o->name, "-") == 0 || lum_map_count(v->map, &c) != 0 ||
            !lum_system_free_bytes(o->name, &free_bytes)) {
            continue;
        }
        const uint64_t needed =
            c.voxels_least *
            (o->format == (unsigned)LUM_FORMAT_LAS ? LAS_BYTES : OTHER_BYTES);
        if (needed > free_bytes) {
            errno = ENOSPC;
            return lum_error_set(
                error,
                "%s: the map has at least %" PRIu64 " voxels, %.4g GB, and "
                "%.4g GB are free there: free some, name a file on another "
                "disk, or take larger voxels, such as --voxel %g",
                o->name, c.voxels_least, (double)needed * 1e-9,
                (double)free_bytes * 1e-9, 2.0 * v->options->cloud.voxel);
        }
    }
    return 0;
}

int voxels_check(struct voxels *v, lum_error *error)
{
    lum_map_counters c = {.struct_size = sizeof c};
    if (!v->is_map || lum_map_count(v->map, &c) != 0 || c.points > 0 ||
        c.out_of_range == 0) {
        return 0;
    }
    errno = ERANGE;
    return lum_error_set(error,
                         "--voxel: no point is left for the map: all %" PRIu64
                         " are farther from 0 than %.4g km, where voxels of %g "
                         "m end; use poses in metres",
                         c.out_of_range, v->options->cloud.voxel * REACH * 1e-3,
                         v->options->cloud.voxel);
}

int voxels_write(struct voxels *v, struct outputs *outputs, bool *is_done,
                 lum_error *error)
{
    size_t none = 0;
    *is_done = true;
    if (!v->is_map) {
        return 0;
    }
    if (!v->is_writing && lum_map_next(v->map, v->read, 0, &none, error) != 0) {
        return advise(v, error);
    }
    if (!v->is_writing && check_place(v, error) != 0) {
        return -1;
    }
    v->is_writing = true;
    if (put_some(v, 0, outputs, is_done, error) != 0) {
        return -1;
    }
    if (*is_done) {
        note(v);
    }
    return 0;
}

/* What has no pose is no number in the map. */
void voxels_count(const struct voxels *v, struct voxel_counts *out)
{
    *out = v->counts;
    out->not_finite -= v->counts.without_pose < out->not_finite
                           ? v->counts.without_pose
                           : out->not_finite;
}
