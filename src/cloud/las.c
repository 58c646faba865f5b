/* The format LAS 1.4: its header, its records of variable length, and
 * points. */
#include "le.h"
#include "writer_internal.h"

#include "lum/version.h"

#include <errno.h>

#define HEADER_BYTES     375u
#define VLR_HEAD_BYTES   54u
#define DESCRIPTOR_BYTES 192u
#define POINT_BYTES      30u /* of format 6 */
#define COMMENT_ID       1u  /* of the user lumsdk */
#define RETURNS          15u /* a point holds numbers up to this */
#define EXTRAS           11u
#define EXTRA_BYTES      32u
#define OWN_BYTES        (8u * LUM_WRITER_EXTRA_MAX) /* of the caller's own */
#define VOXEL_BYTES      4u                          /* of extras of a voxel */

#define SCALE       0.0001       /* metres a unit */
#define SCALE_VOXEL 0.001        /* of voxels, whose coordinates are large */
#define LIMIT_UNITS 2147480000.0 /* that 32 bits hold */
#define WIDTH_UNITS 100.0        /* of intensity in a nanosecond */

#define ENCODING_GPS 0x01u /* adjusted standard GPS time */
#define ENCODING_WKT 0x10u /* point format 6 demands it */

/* 1970 to 1980-01-06, plus the 1e9 of adjusted time, less 18 leap seconds. */
#define UNIX_TO_ADJUSTED_S INT64_C(1315964782)

#define US_IN_SECOND 1000000
#define NS_IN_SECOND 1000000000

static const char about[] =
    "Points of a Luminar Model G2: metres, x forward, y left, z up. intensity: "
    "pulse width in units of 0.01 ns, 655.35 ns or more as 65535. gps_time: "
    "adjusted standard GPS time (UTC + 18 s) if the global encoding says so, "
    "else seconds of the sensor's clock. return_number and number_of_returns "
    "above 15 stand as 15; the extra bytes hold them whole. scanner_channel: "
    "0 blue eye, 1 green eye. scan_angle: azimuth.";

typedef struct extra {
    const char *name;
    const char *description;
    uint8_t type; /* 1, 3, 5: unsigned of 1, 2, 4 bytes; 6: int; 9: float */
} extra;

/* In the order of a point's extra bytes. */
static const extra point_extras[EXTRAS] = {
    {"range", "metres from the eye", 9},
    {"azimuth", "degrees, of the eye", 9},
    {"elevation", "degrees, of the eye", 9},
    {"pulse_width", "nanoseconds, 0 if unknown", 9},
    {"frame", "number of the frame", 6},
    {"line", "number of the line", 5},
    {"pixel", "of the line, 0 to 999", 3},
    {"full_return_number", "from 1, of the edge", 3},
    {"full_number_of_returns", "of the pixel and edge", 3},
    {"eye", "0 blue, 1 green", 1},
    {"edge", "1 rising, 0 falling", 1},
};

/* Of voxels. */
static const extra voxel_extras[] = {
    {"points", "of the voxel", 5},
};

typedef struct las {
    double scale; /* metres a unit */
    const extra *extras;
    uint16_t extra_count;
    uint16_t extra_bytes; /* of a point, with the caller's own */
    float min[3];
    float max[3];
    uint64_t by_return[RETURNS];
} las;

/* What the points of a line share. */
typedef struct las_line {
    unsigned char time[8];
    unsigned char frame_line[8];
    uint8_t eye;
    const lum_writer *writer;
    const lum_line_samples *samples;
} las_line;

/* --- The header --- */

static int32_t units(float metres, double scale)
{
    const double scaled = (double)metres / scale;
    return (int32_t)(scaled + (scaled < 0 ? -0.5 : 0.5));
}

static unsigned char *put_text(unsigned char *p, const char *text, size_t n)
{
    const size_t length = strlen(text);
    memset(p, 0, n);
    memcpy(p, text, length < n ? length : n);
    return p + n;
}

static unsigned char *put_zeros(unsigned char *p, size_t n)
{
    memset(p, 0, n);
    return p + n;
}

static size_t comment_bytes(const lum_writer *writer)
{
    return writer->options.comment != NULL ? strlen(writer->options.comment)
                                           : 0u;
}

static uint32_t points_at(const lum_writer *writer)
{
    const las *state = writer->state;
    const size_t comment = comment_bytes(writer);
    return HEADER_BYTES + 2u * VLR_HEAD_BYTES + (uint32_t)sizeof about - 1u +
           (state->extra_count + writer->extras.count) * DESCRIPTOR_BYTES +
           (comment > 0 ? VLR_HEAD_BYTES + (uint32_t)comment : 0u);
}

static unsigned char *put_bounds(unsigned char *p, const las *state,
                                 const double origin[3])
{
    const double scale = state->scale;
    for (unsigned i = 0; i < 3; i++) {
        p = lum_put_f64(p, units(state->max[i], scale) * scale + origin[i]);
        p = lum_put_f64(p, units(state->min[i], scale) * scale + origin[i]);
    }
    return p;
}

/* totals: the writer that knows bounds and counts. */
static void make_header(unsigned char out[HEADER_BYTES],
                        const lum_writer *writer, const lum_writer *totals)
{
    const las *state = totals->state;
    unsigned char *p = put_text(out, "LASF", 4);
    p = put_zeros(p, 2); /* source id */
    p = lum_put_le16(p,
                     ENCODING_WKT | (writer->options.utc ? ENCODING_GPS : 0u));
    p = put_zeros(p, 16); /* project id */
    p = lum_put_u8(p, 1);
    p = lum_put_u8(p, 4);
    p = put_text(p, "Luminar Model G2", 32);
    p = put_text(p, "lumsdk " LUM_VERSION, 32);
    p = put_zeros(p, 4); /* no date: equal points make equal files */
    p = lum_put_le16(p, HEADER_BYTES);
    p = lum_put_le32(p, points_at(writer));
    p = lum_put_le32(p, comment_bytes(writer) > 0 ? 3 : 2); /* records */
    p = lum_put_u8(p, 6);
    p = lum_put_le16(p, (uint16_t)(POINT_BYTES + state->extra_bytes));
    p = put_zeros(p, 24); /* legacy counts */
    for (unsigned i = 0; i < 6; i++) {
        p = lum_put_f64(p,
                        i < 3u ? state->scale : writer->options.origin[i - 3u]);
    }
    p = put_bounds(p, state, writer->options.origin);
    p = put_zeros(p, 20); /* no waveforms, no extended records */
    p = lum_put_le64(p, totals->points);
    for (unsigned i = 0; i < RETURNS; i++) {
        p = lum_put_le64(p, state->by_return[i]);
    }
}

static unsigned char *put_vlr_head(unsigned char *p, const char *user,
                                   uint16_t id, size_t length,
                                   const char *description)
{
    p = put_zeros(p, 2);
    p = put_text(p, user, 16);
    p = lum_put_le16(p, id);
    p = lum_put_le16(p, (uint16_t)length);
    return put_text(p, description, 32);
}

static int write_about(lum_writer *writer, lum_error *error)
{
    unsigned char head[VLR_HEAD_BYTES];
    (void)put_vlr_head(head, "LASF_Spec", 3, sizeof about - 1u,
                       "what the fields mean");
    return lum_sink_write(writer->sink, head, sizeof head, error) != 0 ||
                   lum_sink_write(writer->sink, about, sizeof about - 1u,
                                  error) != 0
               ? -1
               : 0;
}

static unsigned char *put_descriptor(unsigned char *p, extra e)
{
    p = put_zeros(p, 2);
    p = lum_put_u8(p, e.type);
    p = lum_put_u8(p, 0); /* no minimum, maximum, scale or offset */
    p = put_text(p, e.name, 32);
    p = put_zeros(p, 124);
    return put_text(p, e.description, 32);
}

static int write_extras(lum_writer *writer, lum_error *error)
{
    const las *state = writer->state;
    const lum_extras *own = &writer->extras;
    unsigned char vlr[VLR_HEAD_BYTES +
                      (EXTRAS + LUM_WRITER_EXTRA_MAX) * DESCRIPTOR_BYTES];
    unsigned char *p = put_vlr_head(vlr, "LASF_Spec", 4,
                                    ((size_t)state->extra_count + own->count) *
                                        DESCRIPTOR_BYTES,
                                    "extra bytes");
    for (unsigned i = 0; i < state->extra_count; i++) {
        p = put_descriptor(p, state->extras[i]);
    }
    for (unsigned i = 0; i < own->count; i++) {
        p = put_descriptor(
            p, (extra){own->name[i], "", lum_number_types[own->type[i]].las});
    }
    return lum_sink_write(writer->sink, vlr, (size_t)(p - vlr), error);
}

static int write_comment(lum_writer *writer, lum_error *error)
{
    unsigned char head[VLR_HEAD_BYTES];
    const size_t n = comment_bytes(writer);
    (void)put_vlr_head(head, "lumsdk", COMMENT_ID, n,
                       "where the points come from");
    return n == 0 || (lum_sink_write(writer->sink, head, sizeof head, error) ==
                          0 &&
                      lum_sink_write(writer->sink, writer->options.comment, n,
                                     error) == 0)
               ? 0
               : -1;
}

static int begin(lum_writer *writer, lum_error *error)
{
    unsigned char bytes[HEADER_BYTES];
    las *state = lum_writer_new_state(writer, sizeof *state, error);
    if (state == NULL) {
        return -1;
    }
    const bool is_map = writer->options.voxels;
    state->scale = is_map ? SCALE_VOXEL : SCALE;
    state->extras = is_map ? voxel_extras : point_extras;
    state->extra_count = is_map ? 1u : EXTRAS;
    state->extra_bytes = (uint16_t)((is_map ? VOXEL_BYTES : EXTRA_BYTES) +
                                    lum_extras_bytes(&writer->extras));
    make_header(bytes, writer,
                writer->was_rehearsed ? writer->options.rehearsal : writer);
    return lum_sink_write(writer->sink, bytes, sizeof bytes, error) != 0 ||
                   write_about(writer, error) != 0 ||
                   write_extras(writer, error) != 0 ||
                   write_comment(writer, error) != 0
               ? -1
               : 0;
}

/* --- Points --- */

static uint8_t clip_return(uint16_t number)
{
    return (uint8_t)(number < RETURNS ? number : RETURNS);
}

static uint16_t intensity(float width_ns)
{
    const double scaled = (double)width_ns * WIDTH_UNITS + 0.5;
    return scaled >= 65535.0 ? 65535u : scaled >= 1.0 ? (uint16_t)scaled : 0u;
}

/* In units of 0.006 degree, up to half a turn. */
static uint16_t scan_angle(float azimuth)
{
    const double scaled = (double)azimuth / 0.006;
    if (!(scaled > -30000.0 && scaled < 30000.0)) {
        return (uint16_t)(scaled < 0 ? -30000 : scaled > 0 ? 30000 : 0);
    }
    return (uint16_t)(int16_t)(scaled + (scaled < 0 ? -0.5 : 0.5));
}

/* What all points have. */
static unsigned char *put_core(unsigned char *p, const las_line *line,
                               const lum_sample *s)
{
    const double scale = ((const las *)line->writer->state)->scale;
    p = lum_put_le32(p, (uint32_t)units(s->x, scale));
    p = lum_put_le32(p, (uint32_t)units(s->y, scale));
    p = lum_put_le32(p, (uint32_t)units(s->z, scale));
    p = lum_put_le16(p, intensity(s->pulse_width));
    p = lum_put_u8(p, (uint8_t)(clip_return(s->return_number) |
                                clip_return(s->number_of_returns) << 4));
    p = lum_put_u8(p, (uint8_t)((line->eye & 3u) << 4)); /* scanner channel */
    p = lum_put_le16(p, 0);                              /* class, user data */
    p = lum_put_le16(p, scan_angle(s->azimuth));
    return lum_put_le16(p, 0); /* point source */
}

static double gps_seconds(const lum_writer *writer, int64_t time,
                          int64_t in_second)
{
    const int64_t shift = writer->options.utc ? UNIX_TO_ADJUSTED_S : 0;
    const int64_t seconds = time / in_second - shift;
    return (double)seconds + (double)(time % in_second) / (double)in_second;
}

static unsigned char *put_voxel(unsigned char *p, const las_line *line,
                                const lum_sample *s)
{
    const size_t i = (size_t)(s - line->samples->samples);
    p = put_core(p, line, s);
    p = lum_put_f64(
        p, gps_seconds(line->writer, line->samples->times_ns[i], NS_IN_SECOND));
    return lum_put_le32(p, line->samples->counts[i]);
}

static unsigned char *put_point(unsigned char *p, const las_line *line,
                                const lum_sample *s)
{
    p = put_core(p, line, s);
    memcpy(p, line->time, sizeof line->time);
    p = lum_put_f32(p + sizeof line->time, s->range);
    p = lum_put_f32(p, s->azimuth);
    p = lum_put_f32(p, s->elevation);
    p = lum_put_f32(p, s->pulse_width);
    memcpy(p, line->frame_line, sizeof line->frame_line);
    p = lum_put_le16(p + sizeof line->frame_line, s->pixel);
    p = lum_put_le16(p, s->return_number);
    p = lum_put_le16(p, s->number_of_returns);
    p = lum_put_u8(p, line->eye);
    p = lum_put_u8(p, s->edge);
    return lum_extras_put(p, &line->writer->extras, line->samples->extra,
                          (size_t)(s - line->samples->samples));
}

static char *put_points(char *p, void *context, const lum_sample *samples,
                        size_t n)
{
    const las_line *line = context;
    const bool is_map = line->writer->options.voxels;
    unsigned char *to = (unsigned char *)p;
    for (size_t i = 0; i < n; i++) {
        to = is_map ? put_voxel(to, line, &samples[i])
                    : put_point(to, line, &samples[i]);
    }
    return (char *)to;
}

/* --- A line --- */

static bool stretch(float *min, float *max, float v, float limit)
{
    *min = v < *min ? v : *min;
    *max = v > *max ? v : *max;
    return v > -limit && v < limit;
}

/* Add a line to bounds and counts; false if a point does not fit. */
static bool survey(las *state, const lum_line_samples *line)
{
    const float limit = (float)(LIMIT_UNITS * state->scale);
    bool fits = true;
    for (size_t i = 0; i < line->count; i++) {
        const lum_sample *s = &line->samples[i];
        fits &= stretch(&state->min[0], &state->max[0], s->x, limit);
        fits &= stretch(&state->min[1], &state->max[1], s->y, limit);
        fits &= stretch(&state->min[2], &state->max[2], s->z, limit);
        const unsigned number = clip_return(s->return_number);
        state->by_return[number > 0 ? number - 1u : 0u]++;
    }
    return fits;
}

static void begin_bounds(las *state, const lum_sample *first)
{
    const float at[3] = {first->x, first->y, first->z};
    memcpy(state->min, at, sizeof at);
    memcpy(state->max, at, sizeof at);
}

static int add(lum_writer *writer, const lum_line_samples *line,
               lum_error *error)
{
    las_line shared;
    las *state = writer->state;
    if (writer->points == 0) {
        begin_bounds(state, &line->samples[0]);
    }
    if (!survey(state, line)) {
        errno = ERANGE;
        return lum_error_set(error,
                             "%s: a point of line %lu, frame %lld, lies "
                             "farther than %.0f m from the origin, which LAS "
                             "cannot hold at a scale of %g m; PLY and PCD can",
                             lum_sink_name(writer->sink),
                             (unsigned long)line->line, (long long)line->frame,
                             LIMIT_UNITS * state->scale, state->scale);
    }
    (void)lum_put_f64(shared.time,
                      gps_seconds(writer, line->timestamp_us, US_IN_SECOND));
    (void)lum_put_le32(
        lum_put_le32(shared.frame_line, (uint32_t)lum_frame_i32(line->frame)),
        line->line);
    shared.eye = line->eye;
    shared.writer = writer;
    shared.samples = line;
    return lum_writer_put(writer, line, POINT_BYTES + EXTRA_BYTES + OWN_BYTES,
                          put_points, &shared, error);
}

static int finish(lum_writer *writer, lum_error *error)
{
    unsigned char bytes[HEADER_BYTES];
    if (writer->was_rehearsed) {
        return 0;
    }
    make_header(bytes, writer, writer);
    return lum_sink_patch(writer->sink, 0, bytes, sizeof bytes, error);
}

const lum_format_ops lum_las_ops = {.name = "LAS",
                                    .ending = ".las",
                                    .count_in_header = true,
                                    .begin = begin,
                                    .add = add,
                                    .finish = finish};
