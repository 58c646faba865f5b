/* bench_map CAPTURE [MINUTES [OUT [MIB]]]: points a second into a map of 0.1 m,
 * along an open road: the frames of a capture of a street, moved forwards by 1
 * m a frame and turned a little, each otherwise. Prints a line, with the memory
 * that the process took. OUT gets the raw voxels; the tables take MIB. What is
 * measured is the map, so the frames are read before. */
#define _POSIX_C_SOURCE 200809L
#include "datagrams.h"

#include "lum/frame/reader.h"
#include "lum/map/map.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#define FRAMES_MAX  60u
#define A_MINUTE    600u /* frames */
#define VOXELS_ONCE 4096u
#define FRAME_NS    INT64_C(100000000)

struct scan {
    size_t count;
    float *x;
    float *y;
    float *z;
    float *width;
    float *time;
};

struct street {
    struct scan scans[FRAMES_MAX];
    size_t count;
    struct scan moved; /* the frame that is added */
    size_t room;
};

/* An argument, or what it is without one. */
static unsigned number(int argc, char **argv, int i, unsigned otherwise)
{
    char *end = NULL;
    const unsigned long n = i < argc ? strtoul(argv[i], &end, 10) : otherwise;
    if (i < argc && (*end != '\0' || n == 0 || n > 1000000u)) {
        stop("a number from 1 on is expected");
    }
    return (unsigned)n;
}

static float *copy(const float *from, size_t n)
{
    float *to = allocate((n + 1u) * sizeof *to);
    if (from != NULL) {
        memcpy(to, from, n * sizeof *to);
    }
    return to;
}

static void keep(struct street *street, const lum_frame *frame)
{
    const size_t n = lum_frame_count(frame);
    struct scan *scan = &street->scans[street->count++];
    scan->count = n;
    scan->x = copy(lum_frame_floats(frame, LUM_COLUMN_X), n);
    scan->y = copy(lum_frame_floats(frame, LUM_COLUMN_Y), n);
    scan->z = copy(lum_frame_floats(frame, LUM_COLUMN_Z), n);
    scan->width = copy(lum_frame_floats(frame, LUM_COLUMN_PULSE_WIDTH), n);
    scan->time = copy(lum_frame_floats(frame, LUM_COLUMN_TIME), n);
    street->room = n > street->room ? n : street->room;
}

static void move(struct street *street, const struct scan *scan, unsigned frame)
{
    const float turn = 0.001f * (float)(frame % 7u);
    const float c = cosf(turn);
    const float s = sinf(turn);
    const float side = 0.013f * (float)(frame % 31u);
    for (size_t i = 0; i < scan->count; i++) {
        street->moved.x[i] = c * scan->x[i] - s * scan->y[i];
        street->moved.y[i] = s * scan->x[i] + c * scan->y[i] + side;
        street->moved.z[i] = scan->z[i] + 0.1f * side;
    }
}

static void drive(lum_map *map, struct street *street, unsigned frames)
{
    lum_error error = {""};
    for (unsigned i = 0; i < frames; i++) {
        const struct scan *scan = &street->scans[i % street->count];
        move(street, scan, i);
        const lum_map_points points = {.struct_size = sizeof points,
                                       .count = scan->count,
                                       .x = street->moved.x,
                                       .y = street->moved.y,
                                       .z = street->moved.z,
                                       .pulse_width = scan->width,
                                       .time = scan->time,
                                       .time_ns = i * FRAME_NS,
                                       .origin = {i * 1.0, 0, 0}};
        if (lum_map_add(map, &points, &error) != 0) {
            stop(error.text);
        }
    }
}

static void write_all(lum_map *map, FILE *out)
{
    static lum_map_voxel voxels[VOXELS_ONCE];
    lum_error error = {""};
    size_t n = 1;
    while (n > 0) {
        if (lum_map_next(map, voxels, VOXELS_ONCE, &n, &error) != 0) {
            stop(error.text);
        }
        if (out != NULL && fwrite(voxels, sizeof *voxels, n, out) != n) {
            stop("cannot write");
        }
    }
}

static void report(lum_map *map, unsigned frames, double begin, double added)
{
    lum_map_counters c = {.struct_size = sizeof c};
    struct rusage usage;
    if (lum_map_count(map, &c) != 0) {
        stop("no counters");
    }
    (void)getrusage(RUSAGE_SELF, &usage);
    const double end = now_s();
    (void)printf(
        "%u frames, %.0f M points: %.1f M points/s added, %.1f with the "
        "voxels given out; %.1f M voxels of %llu tiles, %.0f MB spooled, "
        "tables of %.0f MB at most, the process %.0f MB, processor %.1f s of "
        "%.1f s\n",
        frames, (double)c.points * 1e-6,
        (double)c.points / (added - begin) * 1e-6,
        (double)c.points / (end - begin) * 1e-6, (double)c.voxels * 1e-6,
        (unsigned long long)c.tiles, (double)c.spooled * 1e-6,
        (double)c.memory_most * 1e-6, (double)usage.ru_maxrss * 1.024e-3,
        processor_s(), end - begin);
}

static void read_street(const char *path, struct street *street)
{
    lum_view view;
    lum_view_default(&view);
    view.columns = LUM_COLUMNS_XYZ | LUM_COLUMN_BIT(LUM_COLUMN_PULSE_WIDTH) |
                   LUM_COLUMN_BIT(LUM_COLUMN_TIME);
    const lum_framer_options framer = {
        .struct_size = sizeof framer, .views = &view, .view_count = 1};
    const lum_reader_options options = {
        .struct_size = sizeof options, .path = path, .framer = &framer};
    lum_reader *reader = NULL;
    const lum_frame *frame = NULL;
    lum_error error = {""};
    int status = lum_reader_open(&options, &reader, &error);
    while (status >= 0 && street->count < FRAMES_MAX &&
           (status = lum_reader_next_frame(reader, &frame, &error)) > 0) {
        keep(street, frame);
    }
    if (status < 0 || street->count == 0) {
        stop(status < 0 ? error.text : "no frame in the capture");
    }
    lum_reader_close(reader);
    street->moved.x = copy(NULL, street->room);
    street->moved.y = copy(NULL, street->room);
    street->moved.z = copy(NULL, street->room);
}

int main(int argc, char **argv)
{
    static struct street street;
    lum_map *map = NULL;
    lum_error error = {""};
    if (argc < 2 || argc > 5) {
        stop("usage: bench_map CAPTURE [MINUTES [OUT [MIB]]]");
    }
    const unsigned minutes = number(argc, argv, 2, 10);
    FILE *out = argc > 3 ? fopen(argv[3], "wb") : NULL;
    const lum_map_options options = {
        .struct_size = sizeof options,
        .voxel = 0.1,
        .memory = (uint64_t)number(argc, argv, 4, 768) << 20,
        .spool = argc > 3 ? argv[3] : "./bench_map",
        .has_thread = true};
    read_street(argv[1], &street);
    if (lum_map_new(&options, &map, &error) != 0) {
        stop(error.text);
    }
    const double begin = now_s();
    drive(map, &street, minutes * A_MINUTE);
    const double added = now_s();
    write_all(map, out);
    if (out != NULL && fclose(out) != 0) {
        stop("cannot write");
    }
    report(map, minutes * A_MINUTE, begin, added);
    lum_map_free(map);
    return 0;
}
