/* The points of one line at a time: counted, as samples, or for a frame; each
 * as a view selects and smooths them. */
#ifndef LUM_FRAME_LINE_POINTS_H
#define LUM_FRAME_LINE_POINTS_H

#include "frame_internal.h"

#include "lum/frame/framer.h"
#include "lum/smooth.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Views that a caller asked for, once they are checked. */
typedef struct lum_checked_view {
    lum_view asked;
    uint32_t window; /* of its smoothing; 0: none */
    lum_smooth smooth;
} lum_checked_view;

typedef struct lum_checked_views {
    lum_checked_view view[LUM_VIEWS_MAX];
    size_t count;
} lum_checked_views;

typedef struct lum_line_points {
    lum_projector projector;
    const lum_line *line;
    uint64_t rising; /* words that give a point; set by _count() */
    uint64_t falling;
    lum_point_losses losses;
    lum_line smoothed;                   /* the line, as a view smooths it */
    const lum_checked_view *smoothed_by; /* NULL: by none yet */
    lum_angle angles[LUM_LINE_PIXELS];
    lum_column_work work;
    const lum_checked_view *sampled_by; /* NULL: there are no samples of it */
    size_t sample_count;
} lum_line_points;

/* Take another line, which lives until the next one or the end. */
void lum_line_points_begin(lum_line_points *points, const lum_line *line);

/* Count the points of the line before any selection, and the words that give
 * none. */
void lum_line_points_count(lum_line_points *points);

/* How many of them a view selects; NULL: rising edges. */
uint64_t lum_line_points_select(lum_line_points *points,
                                const lum_checked_view *view);

/* The samples of the line in a view, which live until the next call. */
size_t lum_line_points_sample(lum_line_points *points,
                              const lum_checked_view *view);

/* Whether a view has as many points as its edges have words, so that they are
 * counted before they are made; n gets their number. */
bool lum_line_points_are_known(const lum_line_points *points,
                               const lum_checked_view *view, uint64_t *n);

/* What a frame of this view takes of the line, which is smoothed for it now, or
 * by who makes the points. */
lum_frame_part lum_line_points_part(lum_line_points *points,
                                    const lum_checked_view *view,
                                    bool is_smoothed);

/* Views may go: nothing of them is remembered. */
void lum_line_points_forget(lum_line_points *points);

#endif
