/* A capture to points: capture_to_points CAPTURE. Needs lumsdk::io. */
#include "lum/io/capture.h"
#include "lum/io/demux.h"
#include "lum/points.h"

#include <float.h>
#include <inttypes.h>
#include <stdio.h>

#define FIRST_POINTS 3u

static lum_sample samples[LUM_LINE_WORDS_MAX];
static lum_return returns[LUM_LINE_WORDS_MAX];
static lum_sample_workspace workspace = {.returns = returns};
static uint64_t count;
static float low[3] = {FLT_MAX, FLT_MAX, FLT_MAX};
static float high[3] = {-FLT_MAX, -FLT_MAX, -FLT_MAX};

static void take_point(const lum_sample *s)
{
    const float at[3] = {s->x, s->y, s->z};
    for (unsigned i = 0; i < 3; i++) {
        low[i] = at[i] < low[i] ? at[i] : low[i];
        high[i] = at[i] > high[i] ? at[i] : high[i];
    }
    if (count++ < FIRST_POINTS) {
        (void)printf("%9.3f %9.3f %9.3f  pixel %u, return %u of %u\n",
                     (double)at[0], (double)at[1], (double)at[2],
                     (unsigned)s->pixel, (unsigned)s->return_number,
                     (unsigned)s->number_of_returns);
    }
}

/* An event: a line is ready, or a frame, of which nothing is wanted here. */
static void take_event(const lum_demux *demux, lum_result event,
                       const lum_projector *projector)
{
    lum_selection all;
    lum_point_losses losses = {0, 0};
    if (event != LUM_LINE_READY) {
        return;
    }
    lum_selection_default(&all);
    const lum_line *line = lum_assembler_line(lum_demux_current(demux));
    const size_t n = lum_samples_compute(projector, line, &all, &workspace,
                                         samples, &losses);
    for (size_t i = 0; i < n; i++) {
        take_point(&samples[i]);
    }
}

static int read_all(lum_capture *capture, lum_demux *demux,
                    const lum_projector *projector, lum_error *error)
{
    lum_record record;
    lum_result r = LUM_OK;
    int status = 0;
    while ((status = lum_capture_next(capture, &record, error)) == 1) {
        while ((r = lum_demux_push(demux, &record, NULL)) > 0) {
            take_event(demux, r, projector);
        }
        if (r != LUM_OK) {
            return lum_error_set(error, "out of memory");
        }
    }
    while ((r = lum_demux_flush(demux)) > 0) {
        take_event(demux, r, projector);
    }
    return status;
}

int main(int argc, char **argv)
{
    lum_error error = {""};
    lum_demux_options options = {.has_sensor = false};
    lum_calibration calibration;
    lum_projector projector;
    lum_capture *capture = NULL;
    lum_calibration_default(&calibration);
    lum_layout_default(&options.layout);
    lum_assembler_config_default(&options.config);
    if (argc != 2 || lum_projector_init(&projector, &calibration,
                                        &options.layout) != LUM_OK) {
        (void)fprintf(stderr, "usage: capture_to_points CAPTURE\n");
        return 2;
    }
    lum_demux *demux = lum_demux_new(&options);
    const int failed = demux == NULL ||
                       lum_capture_open(argv[1], &capture, &error) != 0 ||
                       read_all(capture, demux, &projector, &error) != 0;
    lum_capture_close(capture);
    lum_demux_free(demux);
    if (failed) {
        (void)fprintf(stderr, "capture_to_points: %s\n", error.text);
        return 1;
    }
    (void)printf("%" PRIu64 " points\n", count);
    for (unsigned i = 0; count > 0 && i < 3; i++) {
        (void)printf("%c from %.3f to %.3f m\n", "xyz"[i], (double)low[i],
                     (double)high[i]);
    }
    return fflush(stdout) == 0 ? 0 : 1;
}
