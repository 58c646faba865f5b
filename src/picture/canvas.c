#include "canvas.h"

#include <errno.h>
#include <png.h>
#include <stdlib.h>
#include <string.h>

#define GLYPH_COLUMNS 5

/* Seven rows a glyph, the highest of five bits on the left. */
static const struct glyph {
    char character;
    uint8_t rows[LUM_GLYPH_HEIGHT];
} glyphs[] = {
    {'0', {0x0e, 0x11, 0x13, 0x15, 0x19, 0x11, 0x0e}},
    {'1', {0x04, 0x0c, 0x04, 0x04, 0x04, 0x04, 0x0e}},
    {'2', {0x0e, 0x11, 0x01, 0x02, 0x04, 0x08, 0x1f}},
    {'3', {0x1f, 0x02, 0x04, 0x02, 0x01, 0x11, 0x0e}},
    {'4', {0x02, 0x06, 0x0a, 0x12, 0x1f, 0x02, 0x02}},
    {'5', {0x1f, 0x10, 0x1e, 0x01, 0x01, 0x11, 0x0e}},
    {'6', {0x06, 0x08, 0x10, 0x1e, 0x11, 0x11, 0x0e}},
    {'7', {0x1f, 0x01, 0x02, 0x04, 0x08, 0x08, 0x08}},
    {'8', {0x0e, 0x11, 0x11, 0x0e, 0x11, 0x11, 0x0e}},
    {'9', {0x0e, 0x11, 0x11, 0x0f, 0x01, 0x02, 0x0c}},
    {'A', {0x0e, 0x11, 0x11, 0x11, 0x1f, 0x11, 0x11}},
    {'B', {0x1e, 0x11, 0x11, 0x1e, 0x11, 0x11, 0x1e}},
    {'C', {0x0e, 0x11, 0x10, 0x10, 0x10, 0x11, 0x0e}},
    {'D', {0x1c, 0x12, 0x11, 0x11, 0x11, 0x12, 0x1c}},
    {'E', {0x1f, 0x10, 0x10, 0x1e, 0x10, 0x10, 0x1f}},
    {'F', {0x1f, 0x10, 0x10, 0x1e, 0x10, 0x10, 0x10}},
    {'G', {0x0e, 0x11, 0x10, 0x17, 0x11, 0x11, 0x0f}},
    {'H', {0x11, 0x11, 0x11, 0x1f, 0x11, 0x11, 0x11}},
    {'I', {0x0e, 0x04, 0x04, 0x04, 0x04, 0x04, 0x0e}},
    {'J', {0x07, 0x02, 0x02, 0x02, 0x02, 0x12, 0x0c}},
    {'K', {0x11, 0x12, 0x14, 0x18, 0x14, 0x12, 0x11}},
    {'L', {0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x1f}},
    {'M', {0x11, 0x1b, 0x15, 0x15, 0x11, 0x11, 0x11}},
    {'N', {0x11, 0x11, 0x19, 0x15, 0x13, 0x11, 0x11}},
    {'O', {0x0e, 0x11, 0x11, 0x11, 0x11, 0x11, 0x0e}},
    {'P', {0x1e, 0x11, 0x11, 0x1e, 0x10, 0x10, 0x10}},
    {'Q', {0x0e, 0x11, 0x11, 0x11, 0x15, 0x12, 0x0d}},
    {'R', {0x1e, 0x11, 0x11, 0x1e, 0x14, 0x12, 0x11}},
    {'S', {0x0f, 0x10, 0x10, 0x0e, 0x01, 0x01, 0x1e}},
    {'T', {0x1f, 0x04, 0x04, 0x04, 0x04, 0x04, 0x04}},
    {'U', {0x11, 0x11, 0x11, 0x11, 0x11, 0x11, 0x0e}},
    {'V', {0x11, 0x11, 0x11, 0x11, 0x11, 0x0a, 0x04}},
    {'W', {0x11, 0x11, 0x11, 0x15, 0x15, 0x15, 0x0a}},
    {'X', {0x11, 0x11, 0x0a, 0x04, 0x0a, 0x11, 0x11}},
    {'Y', {0x11, 0x11, 0x11, 0x0a, 0x04, 0x04, 0x04}},
    {'Z', {0x1f, 0x01, 0x02, 0x04, 0x08, 0x10, 0x1f}},
    {'.', {0x00, 0x00, 0x00, 0x00, 0x00, 0x0c, 0x0c}},
    {',', {0x00, 0x00, 0x00, 0x00, 0x0c, 0x04, 0x08}},
    {':', {0x00, 0x0c, 0x0c, 0x00, 0x0c, 0x0c, 0x00}},
    {'-', {0x00, 0x00, 0x00, 0x1f, 0x00, 0x00, 0x00}},
    {'(', {0x02, 0x04, 0x08, 0x08, 0x08, 0x04, 0x02}},
    {')', {0x08, 0x04, 0x02, 0x02, 0x02, 0x04, 0x08}},
    {'/', {0x00, 0x01, 0x02, 0x04, 0x08, 0x10, 0x00}},
    {'m', {0x00, 0x00, 0x1a, 0x15, 0x15, 0x15, 0x15}},
    {'^', {0x0c, 0x12, 0x12, 0x0c, 0x00, 0x00, 0x00}},
};

void lum_canvas_set(lum_canvas *canvas, int x, int y, lum_rgb colour)
{
    if (x >= 0 && x < canvas->width && y >= 0 && y < canvas->height) {
        canvas->rgb[(size_t)y * (size_t)canvas->width + (size_t)x] = colour;
    }
}

void lum_canvas_fill(lum_canvas *canvas, lum_box box, lum_rgb colour)
{
    for (int y = box.y; y < box.y + box.height; y++) {
        for (int x = box.x; x < box.x + box.width; x++) {
            lum_canvas_set(canvas, x, y, colour);
        }
    }
}

static const struct glyph *find_glyph(char character)
{
    for (size_t i = 0; i < sizeof glyphs / sizeof glyphs[0]; i++) {
        if (glyphs[i].character == character) {
            return &glyphs[i];
        }
    }
    return NULL;
}

static void draw_glyph(lum_canvas *canvas, lum_box cell, lum_rgb colour,
                       const struct glyph *glyph)
{
    for (int i = 0; i < LUM_GLYPH_HEIGHT * GLYPH_COLUMNS; i++) {
        const int row = i / GLYPH_COLUMNS;
        const int column = i % GLYPH_COLUMNS;
        if ((glyph->rows[row] >> (GLYPH_COLUMNS - 1 - column) & 1) != 0) {
            const lum_box dot = {cell.x + column * cell.width,
                                 cell.y + row * cell.height, cell.width,
                                 cell.height};
            lum_canvas_fill(canvas, dot, colour);
        }
    }
}

void lum_canvas_text(lum_canvas *canvas, int x, int y, int scale,
                     lum_rgb colour, const char *text)
{
    for (; *text != '\0'; text++, x += LUM_GLYPH_WIDTH * scale) {
        const struct glyph *glyph = find_glyph(*text);
        if (glyph != NULL) {
            const lum_box cell = {x, y, scale, scale};
            draw_glyph(canvas, cell, colour, glyph);
        }
    }
}

int lum_canvas_text_width(const char *text, int scale)
{
    return (int)strlen(text) * LUM_GLYPH_WIDTH * scale;
}

static uint8_t mix(uint8_t a, uint8_t b, float part)
{
    return (uint8_t)((float)a + ((float)b - (float)a) * part + 0.5f);
}

lum_rgb lum_colour(float part)
{
    static const lum_rgb stops[] = {
        {214, 45, 50},  {247, 135, 45}, {250, 220, 70},  {130, 210, 90},
        {50, 190, 190}, {70, 130, 240}, {150, 105, 225},
    };
    const int last = (int)(sizeof stops / sizeof stops[0]) - 1;
    const float at = !(part > 0.0f) ? 0.0f
                     : part > 1.0f  ? (float)last
                                    : part * (float)last;
    const int i = at >= (float)last ? last - 1 : (int)at;
    const float rest = at - (float)i;
    const lum_rgb colour = {mix(stops[i].r, stops[i + 1].r, rest),
                            mix(stops[i].g, stops[i + 1].g, rest),
                            mix(stops[i].b, stops[i + 1].b, rest)};
    return colour;
}

lum_rgb lum_shade(lum_rgb colour, float light)
{
    const lum_rgb shaded = {mix(0, colour.r, light), mix(0, colour.g, light),
                            mix(0, colour.b, light)};
    return shaded;
}

static int write_png(png_image *image, const lum_canvas *canvas, void *bytes,
                     lum_sink *sink, lum_error *error)
{
    png_alloc_size_t n = PNG_IMAGE_PNG_SIZE_MAX(*image);
    if (png_image_write_to_memory(image, bytes, &n, 0, canvas->rgb, 0, NULL) ==
        0) {
        lum_error_set(error, "%s: libpng: %s", lum_sink_name(sink),
                      image->message);
        errno = EIO;
        return -1;
    }
    return lum_sink_write(sink, bytes, (size_t)n, error);
}

int lum_canvas_write(const lum_canvas *canvas, lum_sink *sink, lum_error *error)
{
    png_image image;
    memset(&image, 0, sizeof image);
    image.version = PNG_IMAGE_VERSION;
    image.width = (png_uint_32)canvas->width;
    image.height = (png_uint_32)canvas->height;
    image.format = PNG_FORMAT_RGB;
    void *bytes = malloc(PNG_IMAGE_PNG_SIZE_MAX(image));
    if (bytes == NULL) {
        lum_error_set(error, "%s: no memory for the picture",
                      lum_sink_name(sink));
        errno = ENOMEM;
        return -1;
    }
    const int result = write_png(&image, canvas, bytes, sink, error);
    const int code = errno;
    free(bytes);
    errno = code;
    return result;
}
