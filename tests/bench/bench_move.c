/* bench_move CAPTURE...: every frame of a capture with columns x y z, with
 * time too, and moved into the world besides, by poses of 100 Hz on a circle of
 * 8 m at 10 m/s: rounds in turn, one thread, processor time as ratios to the
 * first. */
#include "datagrams.h"

#include "lum/frame/move.h"
#include "lum/frame/reader.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define RADIUS_M 8.0
#define TURN     1.25 /* radians a second */
#define STEP_NS  10000000

enum work {
    XYZ,
    TIMES,
    MOVED,
    WORKS
};

struct places {
    float *x;
    float *y;
    float *z;
    size_t room;
};

static void move(const lum_frame *frame, const lum_poses *poses,
                 struct places *to)
{
    const lum_move_options options = {
        .struct_size = sizeof options, .poses = poses, .to = LUM_MOVE_TO_WORLD};
    lum_move_counts counts = {0};
    lum_error error = {""};
    if (lum_frame_count(frame) > to->room) {
        free(to->x);
        to->room = 2u * lum_frame_count(frame);
        to->x = allocate(3u * to->room * sizeof(float));
        to->y = to->x + to->room;
        to->z = to->y + to->room;
    }
    if (lum_frame_move(frame, &options, to->x, to->y, to->z, &counts, &error) !=
        0) {
        stop(error.text);
    }
    if (lum_move_counts_without(&counts) > 0) {
        stop("points have no pose");
    }
}

static lum_reader *open_reader(const char *path, enum work work)
{
    lum_view view;
    lum_view_default(&view);
    view.columns =
        LUM_COLUMNS_XYZ | (work != XYZ ? LUM_COLUMN_BIT(LUM_COLUMN_TIME) : 0u);
    const lum_framer_options framer = {.struct_size = sizeof framer,
                                       .views = &view,
                                       .view_count = 1,
                                       .threads = 1};
    const lum_reader_options options = {
        .struct_size = sizeof options, .path = path, .framer = &framer};
    lum_reader *reader = NULL;
    lum_error error = {""};
    if (lum_reader_open(&options, &reader, &error) != 0) {
        stop(error.text);
    }
    return reader;
}

/* Poses for all of it; without an output the times alone. */
static lum_poses *make_poses(const char *path)
{
    lum_reader *reader = open_reader(path, XYZ);
    const lum_frame *frame = NULL;
    lum_error error = {""};
    lum_frame_info info = {.struct_size = sizeof info};
    int64_t first = INT64_MAX;
    int64_t last = INT64_MIN;
    while (lum_reader_next_frame(reader, &frame, &error) > 0) {
        (void)lum_frame_get_info(frame, &info);
        const lum_frame_times *t = &info.times;
        first = t->begin_clock_us < first ? t->begin_clock_us : first;
        last = t->end_clock_us > last ? t->end_clock_us : last;
    }
    lum_reader_close(reader);
    if (first > last) {
        stop("the capture has no frame");
    }
    const size_t n = (size_t)((last - first) * 1000 / STEP_NS) + 3u;
    int64_t *times = allocate(n * sizeof *times);
    lum_pose *list = allocate(n * sizeof *list);
    lum_poses *poses = NULL;
    for (size_t i = 0; i < n; i++) {
        const double angle = TURN * (double)i * STEP_NS * 1e-9;
        times[i] = first * 1000 + (int64_t)i * STEP_NS;
        list[i] =
            (lum_pose){{RADIUS_M * sin(angle), -RADIUS_M * cos(angle), 0.0},
                       {0.0, 0.0, sin(angle / 2.0), cos(angle / 2.0)}};
    }
    if (lum_poses_new(times, list, n, NULL, &poses, &error) != 0) {
        stop(error.text);
    }
    free(times);
    free(list);
    return poses;
}

/* Seconds of this process. */
static double run(const char *path, enum work work, const lum_poses *poses,
                  struct places *to, size_t *points)
{
    lum_error error = {""};
    const lum_frame *frame = NULL;
    const double begin = processor_s();
    lum_reader *reader = open_reader(path, work);
    int status = 0;
    *points = 0;
    while ((status = lum_reader_next_frame(reader, &frame, &error)) > 0) {
        *points += lum_frame_count(frame);
        if (work == MOVED) {
            move(frame, poses, to);
        }
    }
    lum_reader_close(reader);
    if (status < 0) {
        stop(error.text);
    }
    return processor_s() - begin;
}

static void measure(const char *path)
{
    double seconds[WORKS][ROUNDS];
    struct places to = {NULL, NULL, NULL, 0};
    size_t points = 0;
    lum_poses *poses = make_poses(path);
    for (unsigned round = 0; round < ROUNDS; round++) {
        for (unsigned work = 0; work < WORKS; work++) {
            seconds[work][round] =
                run(path, (enum work)work, poses, &to, &points);
        }
    }
    const double xyz = median(seconds[XYZ]);
    (void)printf("%s: %.0f M points/s in frames of x y z; with time %.3f, "
                 "moved into the world %.3f times the processor time\n",
                 path, (double)points / xyz * 1e-6,
                 median(seconds[TIMES]) / xyz, median(seconds[MOVED]) / xyz);
    free(to.x);
    lum_poses_free(poses);
}

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++) {
        measure(argv[i]);
    }
    return 0;
}
