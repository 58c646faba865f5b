/* The points of one line: how many, and which of them a view selects, smoothed
 * as it asks. */
#include "framer_internal.h"

/* Make `smoothed` the line as a view has it. Views that smooth alike share it.
 */
static void apply_view(lum_line_points *p, const lum_checked_view *view)
{
    const lum_checked_view *before = p->smoothed_by;
    const bool is_same = before != NULL && before->window == view->window &&
                         (view->window == 0 || before->asked.smooth_order ==
                                                   view->asked.smooth_order);
    p->smoothed_by = view;
    if (is_same) {
        return;
    }
    lum_column_work_begin(&p->work);
    p->smoothed = *p->line;
    if (view->window != 0) {
        lum_smooth_line(&view->smooth, p->line, p->angles);
        p->smoothed.angles = p->angles;
    }
}

void lum_line_points_begin(lum_line_points *p, const lum_line *line,
                           const lum_projector *projector)
{
    p->line = line;
    p->projector = projector;
    lum_line_points_forget(p);
}

void lum_line_points_count(lum_line_points *p)
{
    p->losses = (lum_point_losses){0, 0};
    lum_points_count(p->projector, p->line, &p->rising, &p->falling,
                     &p->losses);
}

uint64_t lum_line_points_select(lum_line_points *p,
                                const lum_checked_view *view)
{
    uint64_t n = p->rising;
    return view == NULL || lum_line_points_are_known(p, view, &n)
               ? n
               : lum_line_points_sample(p, view);
}

size_t lum_line_points_sample(lum_line_points *p, const lum_checked_view *view)
{
    if (p->sampled_by != view) {
        apply_view(p, view);
        p->sample_count =
            lum_samples_make(p->projector, &p->smoothed, &view->asked.selection,
                             p->leaves, &p->work.samples, p->work.sample);
        p->sampled_by = view;
    }
    return p->sample_count;
}

bool lum_line_points_are_known(const lum_line_points *p,
                               const lum_checked_view *view, uint64_t *n)
{
    const lum_selection *s = &view->asked.selection;
    const unsigned edges = (unsigned)s->edges;
    if (s->has_range || s->has_box || s->returns != LUM_RETURNS_ALL) {
        return false;
    }
    *n = ((edges & LUM_EDGES_RISING) != 0 ? p->rising : 0) +
         ((edges & LUM_EDGES_FALLING) != 0 ? p->falling : 0);
    return true;
}

lum_frame_part lum_line_points_part(lum_line_points *p,
                                    const lum_checked_view *view,
                                    bool is_smoothed)
{
    if (is_smoothed) {
        apply_view(p, view);
        p->sampled_by = NULL; /* its memory is used for the part */
    }
    return (lum_frame_part){
        .line = {.projector = p->projector,
                 .line = is_smoothed ? &p->smoothed : p->line,
                 .rising = p->rising,
                 .falling = p->falling},
        .selection = &view->asked.selection,
        .work = &p->work,
        .losses = p->losses};
}

void lum_line_points_forget(lum_line_points *p)
{
    p->smoothed_by = NULL;
    p->sampled_by = NULL;
}
