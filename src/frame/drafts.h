/* The frames of one sensor that are under way, each in the views that were
 * requested when it began. A line goes into all views of its frame. */
#ifndef LUM_FRAME_DRAFTS_H
#define LUM_FRAME_DRAFTS_H

#include "crew.h"
#include "frame_internal.h"
#include "line_points.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* An eye may begin a frame before the other has ended the one before. */
#define LUM_DRAFTS_MAX 4u

/* A frame under way. Without views it has one frame without points, for what it
 * lacks. */
typedef struct lum_draft {
    bool is_used;
    int64_t number;
    lum_checked_views views;
    size_t frame_count;
    lum_frame *frames[LUM_VIEWS_MAX];
} lum_draft;

/* Of one sensor; zero before the first line. */
typedef struct lum_drafts {
    lum_draft draft[LUM_DRAFTS_MAX];
    size_t recent_points[LUM_VIEWS_MAX]; /* that frames of a view have */
} lum_drafts;

/* Whether a frame comes before another: numbers continue at 0 after 2^32 - 1.
 */
bool lum_frame_is_before(int64_t a, int64_t b);

/* By its number; one that is not used; the one with the lowest number. NULL:
 * there is none. */
lum_draft *lum_drafts_find(lum_drafts *drafts, int64_t number);
lum_draft *lum_drafts_find_unused(lum_drafts *drafts);
lum_draft *lum_drafts_find_lowest(lum_drafts *drafts);

/* Begin an unused one. views: copied; NULL: none.
 * recent_points: that each view is likely to have; NULL: not known.
 * False: there is no memory, and it stays unused. */
bool lum_draft_begin(lum_draft *draft, int64_t number,
                     const lum_checked_views *views, lum_frame_pool *pool,
                     const size_t *recent_points);

/* Put a line into all its views. crew: makes the points that it can; NULL: the
 * caller makes all. With makes_points false the line is counted alone.
 * False: there is no memory, and the line is in none of the views. */
bool lum_draft_add(lum_draft *draft, lum_line_points *line, lum_crew *crew,
                   bool makes_points);

/* It is whole: remember how many points its views have. */
void lum_drafts_note_sizes(lum_drafts *drafts, const lum_draft *draft);

/* Release its frames; it is unused then. */
void lum_draft_drop(lum_draft *draft);

/* The same of all; of those whose number is below one. */
void lum_drafts_drop(lum_drafts *drafts);
void lum_drafts_drop_below(lum_drafts *drafts, int64_t number);

#endif
