/* A capture to points: capture_to_points CAPTURE. Needs lumsdk::capture and
 * lumsdk::points. */
#include "lum/capture/demux.h"
#include "lum/points.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

static lum_sample samples[LUM_LINE_WORDS_MAX];
static lum_return returns[LUM_LINE_WORDS_MAX];
static lum_sample_workspace workspace = {.returns = returns};
static lum_projector projector;
static uint64_t count;
static double low[3] = {INFINITY, INFINITY, INFINITY};
static double high[3] = {-INFINITY, -INFINITY, -INFINITY};

static void take_line(const lum_line *line)
{
    lum_selection all;
    lum_point_losses losses = {0, 0};
    lum_selection_default(&all);
    const size_t n = lum_samples_compute(&projector, line, &all, &workspace,
                                         samples, &losses);
    for (size_t i = 0; i < n; i++) {
        const double at[3] = {samples[i].x, samples[i].y, samples[i].z};
        for (unsigned axis = 0; axis < 3; axis++) {
            low[axis] = fmin(low[axis], at[axis]);
            high[axis] = fmax(high[axis], at[axis]);
        }
        if (count++ < 3) {
            (void)printf("%.3f %.3f %.3f\n", at[0], at[1], at[2]);
        }
    }
}

/* 0, or -1 when the capture breaks off; what came before has been taken. */
static int read_all(lum_capture *capture, lum_demux *demux, lum_error *error)
{
    lum_record record;
    lum_result r = LUM_OK;
    int status = 0;
    while (r == LUM_OK &&
           (status = lum_capture_next(capture, &record, error)) == 1) {
        while ((r = lum_demux_push(demux, &record, NULL)) > 0) {
            if (r == LUM_LINE_READY) {
                take_line(lum_assembler_line(lum_demux_current(demux)));
            }
        }
    }
    while ((r = lum_demux_flush(demux)) > 0) {
        if (r == LUM_LINE_READY) {
            take_line(lum_assembler_line(lum_demux_current(demux)));
        }
    }
    return status == 1 ? lum_error_set(error, "no memory") : status;
}

static void print_result(void)
{
    (void)printf("%" PRIu64 " points\n", count);
    for (unsigned i = 0; count > 0 && i < 3; i++) {
        (void)printf("%c %.3f to %.3f\n", "xyz"[i], low[i], high[i]);
    }
}

int main(int argc, char **argv)
{
    lum_error error = {"no memory"};
    lum_demux_options options = {.has_sensor = false};
    lum_calibration calibration;
    lum_capture *capture = NULL;
    if (argc != 2) {
        (void)fputs("usage: capture_to_points CAPTURE\n", stderr);
        return 2;
    }
    lum_calibration_default(&calibration);
    lum_layout_default(&options.layout);
    lum_assembler_config_default(&options.config);
    lum_demux *demux = lum_demux_new(&options);
    const bool done =
        demux != NULL &&
        lum_projector_init(&projector, &calibration, &options.layout) == 0 &&
        lum_capture_open(argv[1], &capture, &error) == 0 &&
        read_all(capture, demux, &error) == 0;
    if (!done) {
        (void)fprintf(stderr, "capture_to_points: %s\n", error.text);
    }
    if (capture != NULL) {
        print_result();
    }
    lum_capture_close(capture);
    lum_demux_free(demux);
    return done && fflush(stdout) == 0 ? 0 : 1;
}
