/* A frame as a grid of lines and pixels. */
#include "frame_internal.h"

#include <math.h>

/* A requested grid: of indices, or of a column's numbers. */
struct grid {
    const lum_frame *frame;
    unsigned eye;
    uint32_t rows;
    uint32_t returns;
    lum_column column;
    uint32_t *indices; /* one of these two */
    float *floats;
};

static bool is_possible(const struct grid *g)
{
    const lum_columns needed =
        LUM_COLUMN_BIT(LUM_COLUMN_PIXEL) | LUM_COLUMN_BIT(g->column);
    return g->eye < LUM_EYES && g->returns > 0 &&
           (g->frame->mask & needed) == needed;
}

float lum_frame_number(const lum_frame *frame, lum_column column, size_t i)
{
    const void *at = frame->store.columns[column].at;
    switch (lum_column_get_type(column)) {
    case LUM_TYPE_UINT32:
        return (float)((const uint32_t *)at)[i];
    case LUM_TYPE_UINT16:
        return (float)((const uint16_t *)at)[i];
    case LUM_TYPE_UINT8:
        return (float)((const uint8_t *)at)[i];
    case LUM_TYPE_FLOAT:
    default:
        return ((const float *)at)[i];
    }
}

static void put_missing(const struct grid *g, size_t cell)
{
    if (g->indices != NULL) {
        g->indices[cell] = LUM_FRAME_MISSING;
    } else {
        g->floats[cell] = NAN;
    }
}

static void put_point(const struct grid *g, size_t cell, uint32_t point)
{
    if (g->indices != NULL) {
        g->indices[cell] = point;
    } else {
        g->floats[cell] = lum_frame_number(g->frame, g->column, point);
    }
}

static bool is_missing(const struct grid *g, size_t cell)
{
    return g->indices != NULL ? g->indices[cell] == LUM_FRAME_MISSING
                              : isnan(g->floats[cell]) != 0;
}

static size_t cells_of_row(const struct grid *g)
{
    return (size_t)LUM_LINE_PIXELS * g->returns;
}

static bool is_empty(const struct grid *g, uint32_t row)
{
    const size_t end = cells_of_row(g) * (row + (size_t)1u);
    size_t cell = cells_of_row(g) * row;
    while (cell < end && is_missing(g, cell)) {
        cell++;
    }
    return cell == end;
}

/* The points of a line stand by pixel. */
static void put_line(const struct grid *g, const lum_frame_line *line)
{
    const uint16_t *pixels = g->frame->store.columns[LUM_COLUMN_PIXEL].at;
    const size_t row = cells_of_row(g) * line->number;
    uint32_t before = LUM_LINE_PIXELS;
    uint32_t k = 0;
    for (uint32_t i = 0; i < line->point_count; i++) {
        const uint32_t point = line->first_point + i;
        const uint32_t pixel = pixels[point];
        k = pixel == before ? k + 1u : 0u;
        before = pixel;
        if (k < g->returns) {
            put_point(g, row + (size_t)pixel * g->returns + k, point);
        }
    }
}

static bool put_grid(const struct grid *g)
{
    if (!is_possible(g)) {
        return false;
    }
    const size_t cells = cells_of_row(g) * g->rows;
    for (size_t i = 0; i < cells; i++) {
        put_missing(g, i);
    }
    for (size_t i = 0; i < g->frame->row_count; i++) {
        const lum_frame_line *line = &g->frame->store.rows[i];
        if (line->eye == g->eye && line->number < g->rows &&
            is_empty(g, line->number)) {
            put_line(g, line);
        }
    }
    return true;
}

bool lum_frame_grid_index(const lum_frame *frame, unsigned eye, uint32_t rows,
                          uint32_t returns, uint32_t *out)
{
    return put_grid(&(struct grid){.frame = frame,
                                   .eye = eye,
                                   .rows = rows,
                                   .returns = returns,
                                   .column = LUM_COLUMN_PIXEL,
                                   .indices = out});
}

bool lum_frame_grid_floats(const lum_frame *frame, lum_column column,
                           unsigned eye, uint32_t rows, uint32_t returns,
                           float *out)
{
    return (unsigned)column < LUM_COLUMN_COUNT &&
           put_grid(&(struct grid){.frame = frame,
                                   .eye = eye,
                                   .rows = rows,
                                   .returns = returns,
                                   .column = column,
                                   .floats = out});
}
