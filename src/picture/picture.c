#include "lum/picture/picture.h"

#include "cloud/writer_internal.h"
#include "picture_internal.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#define WIDTH  1600
#define HEIGHT 1200
#define MARGIN 20
#define LABELS 58 /* for elevations, left of a range image */
#define PANEL  (WIDTH / 2 - MARGIN - LABELS)

static const lum_box panels[LUM_EYES] = {
    [LUM_EYE_GREEN] = {MARGIN + LABELS, 92, PANEL, 372},
    [LUM_EYE_BLUE] = {WIDTH - MARGIN - PANEL, 92, PANEL, 372},
};
static const char *const titles[LUM_EYES] = {
    [LUM_EYE_GREEN] = "Green eye (looks left)",
    [LUM_EYE_BLUE] = "Blue eye (looks right)",
};
static const lum_box ground = {MARGIN, 550, 1420, HEIGHT - 550 - MARGIN};
static const lum_box bar = {1470, 590, 28, HEIGHT - 590 - 2 * MARGIN};

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

/* From the range that 2 % are below to the range that 2 % are above. */
static lum_depth find_depth(const lum_raster *raster)
{
    const float near_m = fmaxf(lum_raster_range(raster, 0.02), 0.5f);
    const float far_m = lum_raster_range(raster, 0.98);
    return (lum_depth){near_m, fmaxf(far_m, 2.0f * near_m)};
}

/* A number with separated thousands. */
static void put_number(char *text, size_t size, uint64_t number)
{
    char digits[24];
    size_t n = 0;
    const int length = snprintf(digits, sizeof digits, "%" PRIu64, number);
    for (int i = 0; i < length && n + 2 < size; i++) {
        if (i > 0 && (length - i) % 3 == 0) {
            text[n++] = ',';
        }
        text[n++] = digits[i];
    }
    text[n] = '\0';
}

static void draw_title(lum_canvas *canvas, uint64_t points)
{
    const lum_style style = {28.0f, LUM_ALIGN_LEFT, lum_ink, lum_paper, 0.0f};
    char number[40];
    char title[96];
    put_number(number, sizeof number, points);
    (void)snprintf(title, sizeof title, "Luminar Model G2: %s point%s", number,
                   points == 1 ? "" : "s");
    lum_canvas_text(canvas, &style, MARGIN, 32, title);
}

/* Above a box: its title at the left, its units at the right. */
static void draw_caption(lum_canvas *canvas, lum_box box, const char *name,
                         const char *units)
{
    const lum_style left = {20.0f, LUM_ALIGN_LEFT, lum_ink, lum_paper, 0.0f};
    const lum_style right = {16.0f, LUM_ALIGN_RIGHT, lum_dim, lum_paper, 0.0f};
    lum_canvas_text(canvas, &left, box.x, box.y - 18, name);
    lum_canvas_text(canvas, &right, box.x + box.width, box.y - 18, units);
}

static void draw(lum_canvas *canvas, const lum_raster *raster)
{
    const lum_depth depth = find_depth(raster);
    const lum_box all = {0, 0, WIDTH, HEIGHT};
    lum_canvas_fill(canvas, all, lum_paper);
    draw_title(canvas, raster->points);
    for (int i = 0; i < LUM_EYES; i++) {
        draw_caption(canvas, panels[i], titles[i],
                     "azimuth and elevation in degrees");
        lum_draw_panorama(canvas, panels[i], &raster->eye[i], depth);
    }
    draw_caption(canvas, ground, "From above", "x up, y to the left");
    lum_draw_ground(canvas, ground, raster, depth);
    draw_caption(canvas, bar, "Range", "");
    lum_draw_scale(canvas, bar, depth);
}

static int finish(lum_writer *writer, lum_error *error)
{
    lum_canvas *canvas = lum_canvas_new(WIDTH, HEIGHT);
    if (canvas == NULL) {
        lum_error_set(error, "%s: no memory for the picture",
                      lum_sink_name(writer->sink));
        errno = ENOMEM;
        return -1;
    }
    draw(canvas, writer->state);
    const int result = lum_canvas_write(canvas, writer->sink, error);
    const int code = errno;
    lum_canvas_free(canvas);
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
