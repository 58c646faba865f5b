/* The frames of a sensor that are under way: finds, begins and drops them,
 * and adds a line's points to each view of a frame. */
#include "framer_internal.h"

/* --- Which there are --- */

lum_draft *lum_drafts_find(lum_drafts *drafts, int64_t number)
{
    for (size_t i = 0; i < LUM_DRAFTS_MAX; i++) {
        lum_draft *d = &drafts->draft[i];
        if (d->is_used && d->number == number) {
            return d;
        }
    }
    return NULL;
}

lum_draft *lum_drafts_find_unused(lum_drafts *drafts)
{
    for (size_t i = 0; i < LUM_DRAFTS_MAX; i++) {
        if (!drafts->draft[i].is_used) {
            return &drafts->draft[i];
        }
    }
    return NULL;
}

lum_draft *lum_drafts_find_lowest(lum_drafts *drafts)
{
    lum_draft *lowest = NULL;
    for (size_t i = 0; i < LUM_DRAFTS_MAX; i++) {
        lum_draft *d = &drafts->draft[i];
        if (d->is_used && (lowest == NULL ||
                           lum_frame_is_before(d->number, lowest->number))) {
            lowest = d;
        }
    }
    return lowest;
}

/* --- Begin and end --- */

bool lum_draft_begin(lum_draft *draft, int64_t number,
                     const lum_checked_views *views, lum_frame_pool *pool,
                     const size_t *recent_points)
{
    const size_t view_count = views != NULL ? views->count : 0;
    const size_t frame_count = view_count > 0 ? view_count : 1u;
    draft->number = number;
    draft->views.count = 0;
    if (view_count > 0) {
        draft->views = *views;
    }
    for (size_t i = 0; i < frame_count; i++) {
        draft->frames[i] = lum_frame_begin(
            pool, view_count > 0 ? views->view[i].asked.columns : 0,
            recent_points != NULL ? recent_points[i] : 0);
        if (draft->frames[i] == NULL) {
            lum_draft_drop(draft);
            return false;
        }
        draft->frame_count = i + 1u;
    }
    draft->is_used = true;
    return true;
}

void lum_draft_drop(lum_draft *draft)
{
    for (size_t i = 0; i < draft->frame_count; i++) {
        lum_frame_release(draft->frames[i]);
        draft->frames[i] = NULL;
    }
    draft->frame_count = 0;
    draft->is_used = false;
}

void lum_drafts_drop_below(lum_drafts *drafts, int64_t number)
{
    for (size_t i = 0; i < LUM_DRAFTS_MAX; i++) {
        if (drafts->draft[i].is_used && drafts->draft[i].number < number) {
            lum_draft_drop(&drafts->draft[i]);
        }
    }
}

/* A frame with few points among others says little about the next one. */
void lum_drafts_note_sizes(lum_drafts *drafts, const lum_draft *draft)
{
    for (size_t i = 0; i < draft->frame_count; i++) {
        const size_t count = lum_frame_count(draft->frames[i]);
        const size_t half = drafts->recent_points[i] / 2u;
        drafts->recent_points[i] = count > half ? count : half;
    }
}

/* --- A line --- */

/* While a frame moves, nobody writes into it. */
static bool reserve(const lum_draft *draft, const lum_line_points *line,
                    lum_line_threads *threads)
{
    const uint32_t points = line->line->word_count;
    for (size_t i = 0; i < draft->frame_count; i++) {
        lum_frame *frame = draft->frames[i];
        if (!lum_frame_reserve_row(frame) ||
            (frame->raw != NULL &&
             !lum_raw_store_reserve(frame->raw, line->line, line->packets))) {
            return false;
        }
        if (!lum_frame_claim_room(frame, points)) {
            lum_line_threads_settle(threads);
            if (!lum_frame_relocate(frame, points)) {
                return false;
            }
        }
    }
    return true;
}

/* Have others make the points, if their number is known. The view is that of a
 * draft, and so lives as long as its frame is under way. */
static bool give_to_threads(lum_line_threads *threads, lum_line_points *line,
                            const lum_checked_view *view, lum_frame *frame)
{
    uint64_t n = 0;
    if (threads == NULL || view->asked.columns == 0 ||
        !lum_line_points_are_known(line, view, &n) || n == 0 ||
        n > lum_frame_points_left(frame)) {
        return false;
    }
    const lum_frame_part part = lum_line_points_part(line, view, false);
    const lum_line_task task = {.line = part.line,
                                .selection = part.selection,
                                .smooth =
                                    view->window != 0 ? &view->smooth : NULL,
                                .places = lum_frame_next_places(frame)};
    if (!lum_line_threads_give(threads, &task)) {
        return false;
    }
    lum_frame_add_made(frame, &part, (size_t)n);
    return true;
}

/* A line that was cut off is in no row of the frame. */
static void add_raw(lum_frame *frame, const lum_line_points *line)
{
    if (frame->raw != NULL && frame->info.lines_cut == 0) {
        lum_raw_store_add(frame->raw, line->projector, line->line,
                          line->packets);
    }
}

bool lum_draft_add(lum_draft *draft, lum_line_points *line,
                   lum_line_threads *threads, bool makes_points)
{
    static const lum_checked_view lines_alone = {.window = 0};
    if (!makes_points) {
        const lum_frame_part part =
            lum_line_points_part(line, &lines_alone, false);
        if (!lum_frame_reserve_row(draft->frames[0])) {
            return false;
        }
        lum_frame_add(draft->frames[0], &part);
        return true;
    }
    if (!reserve(draft, line, threads)) {
        return false;
    }
    for (size_t i = 0; i < draft->frame_count; i++) {
        const lum_checked_view *view =
            draft->views.count > 0 ? &draft->views.view[i] : &lines_alone;
        if (!give_to_threads(threads, line, view, draft->frames[i])) {
            const lum_frame_part part = lum_line_points_part(line, view, true);
            lum_frame_add(draft->frames[i], &part);
        }
        add_raw(draft->frames[i], line);
    }
    lum_line_points_forget(line); /* the draft's views may go */
    return true;
}
