/* Points of a line to columns: what frames are made with. Each number is the
 * one that lum_samples_compute() gives, bit by bit, whichever columns are asked
 * for; what is not asked for costs nothing. */
#ifndef LUM_POINTS_COLUMNS_H
#define LUM_POINTS_COLUMNS_H

#include "lum/points.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Where a line's points go; NULL: not asked for. The rest has room for
 * line->word_count numbers. */
typedef struct lum_column_places {
    float *x;
    float *y;
    float *z;
    float *range;
    float *azimuth;
    float *elevation;
    float *pulse_width;
    uint16_t *pixel;
    uint16_t *return_number;
    uint16_t *number_of_returns;
    uint8_t *edge;
    uint8_t *strongest;
} lum_column_places;

/* Working memory: of a line, for all that is asked of it. The arrays that are
 * pointed to hold as many entries as a line can have words; the caller's. */
typedef struct lum_column_work {
    lum_sample_workspace samples; /* its returns are the caller's */
    lum_sample *sample;
    uint8_t *strongest; /* of each word */
    uint16_t *pixel;    /* for a caller who needs pixels and has no column */
    bool has_directions;
    bool has_degrees;
    bool has_returns;
    bool has_strongest;
    float azimuth[LUM_LINE_PIXELS]; /* degrees */
    float elevation[LUM_LINE_PIXELS];
} lum_column_work;

/* A line, and what lum_points_count() says of it. */
typedef struct lum_column_line {
    const lum_projector *projector;
    const lum_line *line;
    uint64_t rising;
    uint64_t falling;
} lum_column_line;

/* Another line comes, or the same with other angles. */
void lum_column_work_begin(lum_column_work *work);

/* The points of a line that a selection asks for, in the words' order. How many
 * there are; linear. */
size_t lum_columns_compute(const lum_column_line *line,
                           const lum_selection *selection,
                           lum_column_work *work,
                           const lum_column_places *places);

#endif
