#include "true_points.h"

#include "../common/provenance.h"
#include "cloud/le.h"

#include "lum/frame/reader.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HEAD_BYTES 192u /* a multiple of 64, as NumPy makes them */
#define FORE_BYTES 10u  /* magic, version, length */
#define ROW_BYTES  20u

/* Points on the way into an array. */
struct rows {
    char *bytes;
    size_t count;
    size_t room; /* rows */
};

static void write_head(size_t count, char *out)
{
    const int n =
        snprintf(out + FORE_BYTES, HEAD_BYTES - FORE_BYTES,
                 "{'descr': [('frame', '<f8'), ('x', '<f4'), ('y', '<f4'), "
                 "('z', '<f4')], 'fortran_order': False, 'shape': (%zu,), }",
                 count);
    memcpy(out, "\x93NUMPY\x01\x00", 8);
    (void)lum_put_le16((unsigned char *)out + 8, HEAD_BYTES - FORE_BYTES);
    memset(out + FORE_BYTES + n, ' ', HEAD_BYTES - FORE_BYTES - (size_t)n);
    out[HEAD_BYTES - 1u] = '\n';
}

static int make_room(struct rows *rows, size_t more, lum_error *error)
{
    if (rows->count + more > TRUTH_POINTS_MAX) {
        return lum_error_set(error,
                             "it has more than %u points, and the page keeps "
                             "all true ones: cut some frames out of it, with "
                             "lumdump --frames",
                             TRUTH_POINTS_MAX);
    }
    if (rows->count + more <= rows->room) {
        return 0;
    }
    const size_t room = 2u * rows->room + more;
    char *bytes = realloc(rows->bytes, HEAD_BYTES + room * ROW_BYTES);
    if (bytes == NULL) {
        return lum_error_set(error, "out of memory");
    }
    rows->bytes = bytes;
    rows->room = room;
    return 0;
}

static int add_line(lum_framer *framer, struct rows *rows, lum_error *error)
{
    const lum_sample *samples = NULL;
    const size_t count = lum_framer_line_samples(framer, 0, &samples);
    const double frame = (double)lum_framer_line(framer)->frame;
    if (make_room(rows, count, error) != 0) {
        return -1;
    }
    unsigned char *at =
        (unsigned char *)rows->bytes + HEAD_BYTES + rows->count * ROW_BYTES;
    for (size_t i = 0; i < count; i++) {
        at = lum_put_f64(at, frame);
        at = lum_put_f32(at, samples[i].x);
        at = lum_put_f32(at, samples[i].y);
        at = lum_put_f32(at, samples[i].z);
    }
    rows->count += count;
    return 0;
}

static int add_lines(lum_reader *reader, struct rows *rows, lum_error *error)
{
    lum_framer_event event = LUM_FRAMER_NONE;
    int status = make_room(rows, 1, error) == 0 ? 1 : -1;
    while (status > 0 &&
           (status = lum_reader_next(reader, &event, error)) > 0) {
        status = add_line(lum_reader_framer(reader), rows, error) == 0 ? 1 : -1;
    }
    return status;
}

static int open_reader(const struct options *o, const struct geometry *geometry,
                       const struct sources *sources, lum_reader **out,
                       lum_error *error)
{
    lum_layout layout;
    lum_projector projector;
    lum_view view;
    lum_view_default(&view);
    if (geometry_make(geometry, &layout, &projector, error) != 0) {
        return -1;
    }
    const lum_framer_options framer = {.struct_size = sizeof framer,
                                       .layout = &layout,
                                       .projector = &projector,
                                       .views = &view,
                                       .view_count = 1,
                                       .wants = LUM_WANT_LINES,
                                       .only_first = !o->sensor.is_given,
                                       .has_sensor = o->sensor.is_given,
                                       .sensor = o->sensor.address};
    const lum_reader_options options = {.struct_size = sizeof options,
                                        .paths = sources->paths,
                                        .path_count = sources->count,
                                        .framer = &framer};
    return lum_reader_open(&options, out, error);
}

static int read_sources(const struct options *o, const struct geometry *loaded,
                        const struct sources *sources, struct truth *out,
                        lum_error *error)
{
    struct provenance_source said = {.path = NULL};
    struct geometry geometry = *loaded;
    struct rows rows = {.bytes = NULL};
    lum_reader *reader = NULL;
    provenance_ask("lumview", sources, o->quiet, &geometry, &said);
    const bool is_read =
        geometry_set(&geometry, &o->set, error) == 0 &&
        open_reader(o, &geometry, sources, &reader, error) == 0 &&
        add_lines(reader, &rows, error) == 0;
    lum_reader_close(reader);
    if (!is_read || rows.bytes == NULL) {
        free(rows.bytes);
        return -1;
    }
    write_head(rows.count, rows.bytes);
    *out = (struct truth){rows.bytes, HEAD_BYTES + rows.count * ROW_BYTES};
    return 0;
}

int truth_read(const struct options *options, const struct geometry *geometry,
               const char *const *paths, size_t count, struct truth *out,
               lum_error *error)
{
    lum_error why = {""};
    struct sources sources;
    if (options->rig_path != NULL) {
        return lum_error_set(error,
                             "true points of a capture are seen from its "
                             "sensor, those of a rig from the vehicle: give "
                             "an array instead");
    }
    const int result =
        sources_init(&sources, paths, count, &why) == 0 &&
                sources_check_folders(&sources, &why) == 0 &&
                read_sources(options, geometry, &sources, out, &why) == 0
            ? 0
            : lum_error_set(error, "ground truth: %s", why.text);
    sources_free(&sources);
    return result;
}
