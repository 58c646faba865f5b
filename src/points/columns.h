/* Points of a line to columns, for frames. Each number is the same as that of
 * lum_samples_compute(), bit by bit, whichever columns are requested. Columns
 * that are not requested cost nothing. */
#ifndef LUM_POINTS_COLUMNS_H
#define LUM_POINTS_COLUMNS_H

#include "lum/points.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Where the points of a line are written; NULL: not requested. The others have
 * room for line->word_count numbers. */
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

/* Working memory for one line, for all that is computed from it. The caller
 * owns the arrays; each has as many entries as a line can have words. */
typedef struct lum_column_work {
    lum_sample_workspace samples; /* the caller owns its returns */
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

/* A line, and its result of lum_points_count(). */
typedef struct lum_column_line {
    const lum_projector *projector;
    const lum_line *line;
    uint64_t rising;
    uint64_t falling;
} lum_column_line;

/* Begin another line, or the same line with other angles. */
void lum_column_work_begin(lum_column_work *work);

/* The points of a line that a selection requests, in the order of the words.
 * Returns their number. The time is linear. */
size_t lum_columns_compute(const lum_column_line *line,
                           const lum_selection *selection,
                           lum_column_work *work,
                           const lum_column_places *places);

/* Numbers of a sample that nobody reads, so that they are left unwritten. */
#define LUM_LEAVE_DEGREES 1u /* azimuth and elevation */
#define LUM_LEAVE_RETURNS 2u /* pulse width, return number and their number */
#define LUM_LEAVE_ALL     3u

/* As lum_samples_compute(), which leaves nothing and counts losses. */
size_t lum_samples_make(const lum_projector *projector, const lum_line *line,
                        const lum_selection *selection, unsigned leaves,
                        lum_sample_workspace *workspace, lum_sample *out);

#endif
