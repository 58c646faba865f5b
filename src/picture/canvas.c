/* A picture in memory that cairo draws. */
#include "picture_internal.h"

#include <cairo.h>
#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdlib.h>

/* Letters that are part of cairo: they look the same on every machine and need
 * no installed font. */
#define LETTERS "@cairo:medium"

/* One thread draws at a time. Texts share cairo's fonts, and cairo 1.16 has a
 * race if threads make the same font at once (found by ThreadSanitizer). */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

struct lum_canvas {
    int width;
    int height;
    uint32_t *pixels; /* 0xrrggbb; the surface draws into it */
    cairo_surface_t *surface;
    cairo_t *cairo;
};

/* The look of text must not depend on the machine's settings. */
static void choose_letters(cairo_t *cairo)
{
    cairo_font_options_t *options = cairo_font_options_create();
    cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
    cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
    cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
    cairo_set_font_options(cairo, options);
    cairo_font_options_destroy(options);
    cairo_select_font_face(cairo, LETTERS, CAIRO_FONT_SLANT_NORMAL,
                           CAIRO_FONT_WEIGHT_NORMAL);
}

lum_canvas *lum_canvas_new(int width, int height)
{
    const size_t n = (size_t)width * (size_t)height;
    const int stride = cairo_format_stride_for_width(CAIRO_FORMAT_RGB24, width);
    lum_canvas *canvas = malloc(sizeof *canvas);
    uint32_t *pixels = calloc(n, sizeof *pixels);
    if (canvas == NULL || pixels == NULL) {
        free(canvas);
        free(pixels);
        return NULL;
    }
    canvas->width = width;
    canvas->height = height;
    canvas->pixels = pixels;
    (void)pthread_mutex_lock(&lock);
    canvas->surface = cairo_image_surface_create_for_data(
        (unsigned char *)pixels, CAIRO_FORMAT_RGB24, width, height, stride);
    canvas->cairo = cairo_create(canvas->surface);
    choose_letters(canvas->cairo);
    (void)pthread_mutex_unlock(&lock);
    return canvas;
}

void lum_canvas_free(lum_canvas *canvas)
{
    if (canvas != NULL) {
        (void)pthread_mutex_lock(&lock);
        cairo_destroy(canvas->cairo);
        cairo_surface_destroy(canvas->surface);
        (void)pthread_mutex_unlock(&lock);
        free(canvas->pixels);
        free(canvas);
    }
}

static uint32_t *pixel_at(const lum_canvas *canvas, int x, int y)
{
    return x >= 0 && x < canvas->width && y >= 0 && y < canvas->height
               ? &canvas->pixels[(size_t)y * (size_t)canvas->width + (size_t)x]
               : NULL;
}

void lum_canvas_set(lum_canvas *canvas, int x, int y, lum_rgb colour)
{
    uint32_t *pixel = pixel_at(canvas, x, y);
    if (pixel != NULL) {
        *pixel = (uint32_t)colour.r << 16 | (uint32_t)colour.g << 8 | colour.b;
    }
}

/* Of 0xrrggbb. */
static lum_rgb split(uint32_t value)
{
    return (lum_rgb){(uint8_t)(value >> 16), (uint8_t)(value >> 8),
                     (uint8_t)value};
}

lum_rgb lum_canvas_get(const lum_canvas *canvas, int x, int y)
{
    const uint32_t *pixel = pixel_at(canvas, x, y);
    return split(pixel != NULL ? *pixel : 0);
}

static void use_colour(lum_canvas *canvas, lum_rgb colour, double cover)
{
    cairo_set_source_rgba(canvas->cairo, colour.r / 255.0, colour.g / 255.0,
                          colour.b / 255.0, cover);
}

/* Only cairo may use the pixels between begin_drawing() and end_drawing(). */
static void begin_drawing(lum_canvas *canvas)
{
    (void)pthread_mutex_lock(&lock);
    cairo_surface_mark_dirty(canvas->surface);
}

static void end_drawing(lum_canvas *canvas)
{
    cairo_surface_flush(canvas->surface);
    (void)pthread_mutex_unlock(&lock);
}

void lum_canvas_fill(lum_canvas *canvas, lum_box box, lum_rgb colour)
{
    begin_drawing(canvas);
    use_colour(canvas, colour, 1.0);
    cairo_rectangle(canvas->cairo, box.x, box.y, box.width, box.height);
    cairo_fill(canvas->cairo);
    end_drawing(canvas);
}

void lum_canvas_circle(lum_canvas *canvas, lum_box box, float x, float y,
                       float radius, lum_rgb colour)
{
    const double turn = 6.283185307179586;
    cairo_t *cairo = canvas->cairo;
    begin_drawing(canvas);
    cairo_save(cairo);
    cairo_rectangle(cairo, box.x, box.y, box.width, box.height);
    cairo_clip(cairo);
    cairo_new_path(cairo);
    cairo_arc(cairo, (double)x, (double)y, (double)radius, 0.0, turn);
    use_colour(canvas, colour, 1.0);
    cairo_set_line_width(cairo, 1.0);
    cairo_stroke(cairo);
    cairo_restore(cairo);
    end_drawing(canvas);
}

/* The left end of a text. */
static double begin_of(const lum_style *style, int x, double width)
{
    switch (style->align) {
    case LUM_ALIGN_MIDDLE:
        return (double)x - width / 2.0;
    case LUM_ALIGN_RIGHT:
        return (double)x - width;
    case LUM_ALIGN_LEFT:
    default:
        return (double)x;
    }
}

void lum_canvas_text(lum_canvas *canvas, const lum_style *style, int x, int y,
                     const char *text)
{
    cairo_t *cairo = canvas->cairo;
    cairo_text_extents_t whole;
    cairo_text_extents_t digit;
    begin_drawing(canvas);
    cairo_set_font_size(cairo, (double)style->size);
    cairo_text_extents(cairo, text, &whole);
    cairo_text_extents(cairo, "0", &digit);
    const double left = begin_of(style, x, whole.x_advance);
    const double room = (double)style->size * 0.25;
    use_colour(canvas, style->back, (double)style->cover);
    cairo_rectangle(cairo, left - room, y - digit.height / 2.0 - room,
                    whole.x_advance + 2.0 * room, digit.height + 2.0 * room);
    cairo_fill(cairo);
    use_colour(canvas, style->colour, 1.0);
    cairo_move_to(cairo, left, y - digit.y_bearing - digit.height / 2.0);
    cairo_show_text(cairo, text);
    cairo_new_path(cairo);
    end_drawing(canvas);
}

static uint8_t mix(uint8_t a, uint8_t b, float part)
{
    return (uint8_t)((float)a + ((float)b - (float)a) * part + 0.5f);
}

/* Viridis of Smith and van der Walt (CC0): 33 of its 256 colours, the same as
 * those of lumview's page. */
static const uint32_t viridis[] = {
    0x440154, 0x470d60, 0x48186a, 0x482374, 0x472d7b, 0x453681, 0x424086,
    0x3f4989, 0x3b528b, 0x375a8d, 0x33638d, 0x2f6a8e, 0x2c728e, 0x297a8e,
    0x26818e, 0x23898e, 0x21908c, 0x1f988b, 0x1f9f88, 0x21a685, 0x28ae80,
    0x31b57b, 0x3ebc74, 0x4cc26c, 0x5dc963, 0x6ece58, 0x82d34c, 0x96d83f,
    0xabdc32, 0xc0df24, 0xd5e21a, 0xeae51a, 0xfde725,
};

/* Its darkest part would not show on the dark ground. */
#define DARK 0.12f

lum_rgb lum_colour(float part)
{
    const int last = (int)(sizeof viridis / sizeof viridis[0]) - 1;
    const float inside = !(part > 0.0f) ? 0.0f : part > 1.0f ? 1.0f : part;
    const float at = (DARK + (1.0f - DARK) * inside) * (float)last;
    const int i = at >= (float)last ? last - 1 : (int)at;
    const float rest = at - (float)i;
    const lum_rgb a = split(viridis[i]);
    const lum_rgb b = split(viridis[i + 1]);
    return (lum_rgb){mix(a.r, b.r, rest), mix(a.g, b.g, rest),
                     mix(a.b, b.b, rest)};
}

lum_rgb lum_label_colour(float label)
{
    /* of Okabe and Ito, which colour-blind people can tell apart */
    static const lum_rgb colours[] = {
        {230, 159, 0}, {86, 180, 233}, {0, 158, 115},   {240, 228, 66},
        {0, 114, 178}, {213, 94, 0},   {204, 121, 167}, {230, 230, 230},
    };
    const int n = (int)(sizeof colours / sizeof colours[0]);
    const int rest = (int)fmodf(label, (float)n);
    return colours[rest < 0 ? rest + n : rest];
}

lum_rgb lum_shade(lum_rgb colour, float light)
{
    return (lum_rgb){mix(0, colour.r, light), mix(0, colour.g, light),
                     mix(0, colour.b, light)};
}

/* Where a PNG is written, and the result. */
typedef struct output {
    lum_sink *sink;
    lum_error *error;
    bool failed;
    int code; /* its errno */
} output;

static cairo_status_t take_bytes(void *closure, const unsigned char *bytes,
                                 unsigned n)
{
    output *out = closure;
    if (lum_sink_write(out->sink, bytes, n, out->error) == 0) {
        return CAIRO_STATUS_SUCCESS;
    }
    out->failed = true;
    out->code = errno;
    return CAIRO_STATUS_WRITE_ERROR;
}

int lum_canvas_write(const lum_canvas *canvas, lum_sink *sink, lum_error *error)
{
    output out = {sink, error, false, 0};
    cairo_status_t status = cairo_status(canvas->cairo);
    if (status == CAIRO_STATUS_SUCCESS) {
        status = cairo_surface_write_to_png_stream(canvas->surface, take_bytes,
                                                   &out);
    }
    if (status == CAIRO_STATUS_SUCCESS) {
        return 0;
    }
    if (!out.failed) {
        lum_error_set(error, "%s: cairo: %s", lum_sink_name(sink),
                      cairo_status_to_string(status));
        out.code = status == CAIRO_STATUS_NO_MEMORY ? ENOMEM : EIO;
    }
    errno = out.code;
    return -1;
}
