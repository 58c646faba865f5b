#include "lum/picture/picture.h"

#include "cloud/writer_internal.h"
#include "picture_internal.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#define WIDTH  1600
#define HEIGHT 1200
#define MARGIN 20

static const lum_box panels[LUM_EYES] = {
    [LUM_EYE_GREEN] = {MARGIN, 88, 770, 380},
    [LUM_EYE_BLUE] = {WIDTH - MARGIN - 770, 88, 770, 380},
};
static const char *const titles[LUM_EYES] = {
    [LUM_EYE_GREEN] = "GREEN EYE (LOOKS LEFT)",
    [LUM_EYE_BLUE] = "BLUE EYE (LOOKS RIGHT)",
};
static const lum_box ground = {MARGIN, 536, 1420, HEIGHT - 536 - MARGIN};
static const lum_box bar = {1470, 580, 28, HEIGHT - 580 - 2 * MARGIN};

static int begin(lum_writer *writer, lum_error *error)
{
    lum_raster *raster =
        lum_writer_new_state(writer, sizeof(lum_raster), error);
    if (raster == NULL) {
        return -1;
    }
    lum_raster_begin(raster, writer->options.projector);
    return 0;
}

static int add(lum_writer *writer, const lum_line_samples *line,
               lum_error *error)
{
    (void)error;
    lum_raster_add(writer->state, line);
    return 0;
}

/* From what 2 % fall short of to what 2 % exceed. */
static lum_depth find_depth(const lum_raster *raster)
{
    lum_depth depth = {lum_raster_range(raster, 0.02),
                       lum_raster_range(raster, 0.98)};
    if (depth.near_m < 0.5f) {
        depth.near_m = 0.5f;
    }
    if (depth.far_m < 2.0f * depth.near_m) {
        depth.far_m = 2.0f * depth.near_m;
    }
    return depth;
}

static void draw(lum_canvas *canvas, const lum_raster *raster)
{
    char title[96];
    const lum_depth depth = find_depth(raster);
    const lum_box all = {0, 0, WIDTH, HEIGHT};
    lum_canvas_fill(canvas, all, lum_paper);
    (void)snprintf(title, sizeof title, "LUMINAR MODEL G2: %" PRIu64 " POINTS",
                   raster->points);
    lum_canvas_text(canvas, MARGIN, 20, 3, lum_ink, title);
    for (int i = 0; i < LUM_EYES; i++) {
        lum_canvas_text(canvas, panels[i].x, panels[i].y - 22, 2, lum_ink,
                        titles[i]);
        lum_draw_panorama(canvas, panels[i], &raster->eye[i], depth);
    }
    lum_canvas_text(canvas, ground.x, ground.y - 22, 2, lum_ink,
                    "FROM ABOVE: X UP, Y TO THE LEFT");
    lum_draw_ground(canvas, ground, raster, depth);
    lum_canvas_text(canvas, bar.x, bar.y - 28, 2, lum_ink, "RANGE");
    lum_draw_scale(canvas, bar, depth);
}

static int finish(lum_writer *writer, lum_error *error)
{
    lum_canvas canvas = {WIDTH, HEIGHT, NULL};
    canvas.rgb = malloc(sizeof *canvas.rgb * WIDTH * HEIGHT);
    if (canvas.rgb == NULL) {
        lum_error_set(error, "%s: no memory for the picture",
                      lum_sink_name(writer->sink));
        errno = ENOMEM;
        return -1;
    }
    draw(&canvas, writer->state);
    const int result = lum_canvas_write(&canvas, writer->sink, error);
    const int code = errno;
    free(canvas.rgb);
    errno = code;
    return result;
}

static const lum_format_ops png = {.name = "PNG",
                                   .ending = ".png",
                                   .begin = begin,
                                   .add = add,
                                   .finish = finish};

const lum_format_ops *lum_picture_format(void)
{
    return &png;
}
