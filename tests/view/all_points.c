/* All that a capture gives, line by line and before anything is rounded for the
 * page: so tests compare it with what lumdump writes. */
#include "../../tools/common/geometry.h"
#include "../../tools/lumview/wasm/inputs.h"

#include "lum/frame/reader.h"

#include <stdint.h>

static lum_reader *reader;
static const lum_line *line;
static const lum_sample *samples;

static int open_reader(unsigned edges, bool has_sensor, uint32_t sensor,
                       lum_error *error)
{
    const struct inputs *in = inputs_look();
    struct geometry geometry;
    lum_layout layout;
    lum_projector projector;
    lum_view view;
    lum_view_default(&view);
    view.selection.edges = (lum_edges)edges;
    if (geometry_load(in->names[INPUT_CALIBRATION], in->names[INPUT_PROFILE],
                      NULL, &geometry, error) != 0 ||
        geometry_make(&geometry, &layout, &projector, error) != 0) {
        return -1;
    }
    const lum_framer_options framer = {.struct_size = sizeof framer,
                                       .layout = &layout,
                                       .projector = &projector,
                                       .views = &view,
                                       .view_count = 1,
                                       .wants = LUM_WANT_LINES,
                                       .has_sensor = has_sensor,
                                       .sensor = sensor};
    const lum_reader_options options = {.struct_size = sizeof options,
                                        .paths =
                                            (const char *const *)in->captures,
                                        .path_count = in->capture_count,
                                        .framer = &framer};
    return lum_reader_open(&options, &reader, error);
}

/* Begin to read the captures. edges: ::lum_edges; sensor: its address, 0: all.
 * 0, or -1 with an error. */
EXPORTED(points_open) int points_open(unsigned edges, uint32_t sensor);
int points_open(unsigned edges, uint32_t sensor)
{
    lum_reader_close(reader);
    reader = NULL;
    return open_reader(edges, sensor != 0, sensor, inputs_error());
}

/* The next line's points; -1: there is none; -2: with an error. */
EXPORTED(points_next) int points_next(void);
int points_next(void)
{
    lum_framer_event event = LUM_FRAMER_NONE;
    const int status = lum_reader_next(reader, &event, inputs_error());
    if (status <= 0) {
        return status < 0 ? -2 : -1;
    }
    lum_framer *framer = lum_reader_framer(reader);
    line = lum_framer_line(framer);
    return (int)lum_framer_line_samples(framer, 0, &samples);
}

/* Where they are: each a lum_sample. */
EXPORTED(points_samples) const lum_sample *points_samples(void);
const lum_sample *points_samples(void)
{
    return samples;
}

/* What the line says of all of them. */
EXPORTED(points_clock) double points_clock(void);
double points_clock(void)
{
    return (double)line->clock_us;
}

EXPORTED(points_frame) double points_frame(void);
double points_frame(void)
{
    return (double)line->frame;
}

EXPORTED(points_line) double points_line(void);
double points_line(void)
{
    return (double)line->number;
}

EXPORTED(points_eye) unsigned points_eye(void);
unsigned points_eye(void)
{
    return line->eye;
}
