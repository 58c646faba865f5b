/* What a framer projects: lines of the frames that are asked for, and no
 * others. Built with the functions that project wrapped. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drive.h"

#include "lum/frame/framer.h"
#include "lum/points.h"

#define LINES  12u
#define FRAMES 6u
#define ASKED  4

size_t __real_lum_samples_compute(const lum_projector *projector,
                                  const lum_line *line,
                                  const lum_selection *selection,
                                  lum_sample_workspace *workspace,
                                  lum_sample *out, lum_point_losses *losses);
size_t __wrap_lum_samples_compute(const lum_projector *projector,
                                  const lum_line *line,
                                  const lum_selection *selection,
                                  lum_sample_workspace *workspace,
                                  lum_sample *out, lum_point_losses *losses);
void __real_lum_directions_compute(const lum_projector *projector,
                                   const lum_line *line, lum_direction *out);
void __wrap_lum_directions_compute(const lum_projector *projector,
                                   const lum_line *line, lum_direction *out);

static unsigned projected; /* lines */

static void note(const lum_line *line)
{
    assert_int_equal(line->frame, ASKED);
    projected++;
}

size_t __wrap_lum_samples_compute(const lum_projector *projector,
                                  const lum_line *line,
                                  const lum_selection *selection,
                                  lum_sample_workspace *workspace,
                                  lum_sample *out, lum_point_losses *losses)
{
    note(line);
    return __real_lum_samples_compute(projector, line, selection, workspace,
                                      out, losses);
}

void __wrap_lum_directions_compute(const lum_projector *projector,
                                   const lum_line *line, lum_direction *out)
{
    note(line);
    __real_lum_directions_compute(projector, line, out);
}

static uint64_t take(lum_framer *framer, lum_framer_event event)
{
    const lum_sample *samples = NULL;
    return event == LUM_FRAMER_LINE
               ? lum_framer_line_samples(framer, 0, &samples)
               : 0;
}

/* Returns the points of all lines that come out. */
static uint64_t points_of(lum_framer *framer)
{
    static struct drive_line packets;
    lum_framer_event event = LUM_FRAMER_NONE;
    uint64_t points = 0;
    for (uint32_t i = 0; i < FRAMES * LINES; i++) {
        drive_pixels(&packets, LUM_EYE_BLUE, i % LINES, 1000000u + 1000u * i, 0,
                     LUM_LINE_PIXELS);
        for (size_t k = 0; k < packets.count; k++) {
            const lum_record record =
                drive_record(&packets, k, DRIVE_SENSOR, i);
            while ((event = lum_framer_push(framer, &record, NULL)) !=
                   LUM_FRAMER_NONE) {
                points += take(framer, event);
            }
        }
    }
    while ((event = lum_framer_flush(framer)) != LUM_FRAMER_NONE) {
        points += take(framer, event);
    }
    return points;
}

static void assert_only_asked(const lum_view *view)
{
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .views = view,
                                        .view_count = 1,
                                        .wants = (unsigned)LUM_WANT_LINES |
                                                 (unsigned)LUM_WANT_FRAMES,
                                        .has_range = true,
                                        .frame_first = ASKED,
                                        .frame_last = ASKED};
    lum_framer *framer = NULL;
    lum_framer_counters counters = {.struct_size = sizeof counters};
    projected = 0;
    assert_int_equal(lum_framer_new(&options, &framer, NULL), 0);
    assert_int_equal(points_of(framer), LINES * LUM_LINE_PIXELS);
    assert_true(projected >= LINES);
    lum_framer_count(framer, 0, &counters);
    assert_int_equal(counters.points, LINES * LUM_LINE_PIXELS);
    lum_framer_free(framer);
}

static void lines_of_other_frames_are_not_projected(void **state)
{
    lum_view view;
    (void)state;
    lum_view_default(&view);
    assert_only_asked(&view);
    view.columns = LUM_COLUMNS_ALL;
    view.smooth_window = 31;
    view.smooth_order = 2;
    assert_only_asked(&view);
}

static void nor_for_the_sake_of_limits(void **state)
{
    lum_view view;
    (void)state;
    lum_view_default(&view);
    view.selection.returns = LUM_RETURNS_STRONGEST;
    assert_only_asked(&view);
    view.selection.has_range = true;
    view.selection.range_max = 1e6f;
    assert_only_asked(&view);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_of_other_frames_are_not_projected),
        cmocka_unit_test(nor_for_the_sake_of_limits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
