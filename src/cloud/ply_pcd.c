/* PLY and PCD: rows in binary and in ascii, behind a header that is written
 * again, at the same length, once the count is known. */
#include "le.h"
#include "text_columns.h"
#include "writer_internal.h"

#include "lum/version.h"

#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#define LINE_BYTES 17u /* timestamp, frame, eye, line */
#define ROW_BYTES  52u

#define HEADER_BYTES 2048u /* without its comment and extra columns */
#define EXTRA_BYTES  64u   /* of each of these */
#define PREFIX_BYTES 8u    /* the most of a comment's line */

LUM_PRINTF(2, 3)
static void print(lum_cloud_text *out, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    const int n =
        vsnprintf(out->at + out->len, out->room - out->len, format, arguments);
    va_end(arguments);
    out->len += n > 0 ? (size_t)n : 0u;
}

/* The lines of the options' comment, each behind a prefix. */
static void print_comment(lum_cloud_text *out,
                          const lum_writer_options *options, const char *prefix)
{
    const char *p = options->comment;
    while (p != NULL && *p != '\0') {
        const size_t n = strcspn(p, "\n");
        print(out, "%s%.*s\n", prefix, (int)n, p);
        p += n + (p[n] != '\0' ? 1u : 0u);
    }
}

static const char *clock_of(const lum_writer_options *options)
{
    return options->utc ? "since 1970-01-01 UTC" : "of the sensor's clock";
}

static void print_voxels(lum_cloud_text *out, const lum_writer_options *options)
{
    const double *at = options->origin;
    print(out,
          "metres from %.3f %.3f %.3f; intensity is the pulse width "
          "in ns; timestamp in us %s; points: of the voxel\n",
          at[0], at[1], at[2], clock_of(options));
}

/* What the columns are in. */
static void print_units(lum_cloud_text *out, const lum_writer *writer)
{
    if (writer->options.voxels) {
        print_voxels(out, &writer->options);
        return;
    }
    if (writer->preset != NULL) {
        print(out, "the fields and units of %s\n", writer->preset->name);
        return;
    }
    print(out,
          "metres, degrees; intensity is the pulse width in ns; "
          "timestamp in us %s\n",
          clock_of(&writer->options));
}

static int count_digits(uint64_t count)
{
    int digits = 1;
    for (; count >= 10u; count /= 10u) {
        digits++;
    }
    return digits;
}

/* For its lines, each after its prefix. */
static size_t comment_room(const char *comment)
{
    size_t n = 0;
    for (const char *p = comment; p != NULL && *p != '\0'; p++) {
        n += 1u + (*p == '\n' ? PREFIX_BYTES : 0u);
    }
    return n + PREFIX_BYTES + 1u;
}

/* Some readers fail at leading zeros or blanks around a number, so a comment
 * fills the space that the number leaves of 20 digits. */
static int put_header(lum_writer *writer, bool again, lum_error *error)
{
    const uint64_t count =
        writer->was_rehearsed ? writer->rehearsed : writer->points;
    lum_cloud_text text = {.room = HEADER_BYTES +
                                   writer->extras.count * EXTRA_BYTES +
                                   comment_room(writer->options.comment)};
    text.at = malloc(text.room);
    if (text.at == NULL) {
        errno = ENOMEM;
        return lum_error_set(error, "%s: no memory for its header",
                             lum_sink_name(writer->sink));
    }
    writer->ops->header(&text, writer, count,
                        (int)writer->ops->mentions *
                            (20 - count_digits(count)));
    const int result =
        again ? lum_sink_patch(writer->sink, 0, text.at, text.len, error)
              : lum_sink_write(writer->sink, text.at, text.len, error);
    const int code = errno;
    free(text.at);
    errno = code;
    return result;
}

static int begin(lum_writer *writer, lum_error *error)
{
    return put_header(writer, false, error);
}

static int finish(lum_writer *writer, lum_error *error)
{
    return writer->was_rehearsed || writer->options.organized
               ? 0
               : put_header(writer, true, error);
}

static char *put_ascii_rows(char *p, void *context, const lum_sample *samples,
                            size_t n)
{
    static const lum_text_style style = {' ', true};
    return lum_put_text_rows(p, context, samples, n, style);
}

static int add_ascii(lum_writer *writer, const lum_line_samples *line,
                     lum_error *error)
{
    lum_writer_text text;
    return lum_writer_text_begin(&text, writer, line, ' ')
               ? lum_writer_put(writer, line, LUM_WRITER_TEXT_ROOM,
                                put_ascii_rows, &text.line, error)
               : lum_writer_put_chosen(writer, line, true, ' ', error);
}

/* What rows of a line share. */
struct shared {
    unsigned char line[LINE_BYTES];
    const lum_extras *extras;
    const lum_line_samples *of;
};

static unsigned char *put_binary_row(unsigned char *p,
                                     const struct shared *shared,
                                     const lum_sample *s)
{
    p = lum_put_f32(p, s->x);
    p = lum_put_f32(p, s->y);
    p = lum_put_f32(p, s->z);
    p = lum_put_f32(p, s->pulse_width);
    p = lum_put_f32(p, s->range);
    p = lum_put_f32(p, s->azimuth);
    p = lum_put_f32(p, s->elevation);
    memcpy(p, shared->line, LINE_BYTES);
    p += LINE_BYTES;
    p = lum_put_le16(p, s->pixel);
    p = lum_put_le16(p, s->return_number);
    p = lum_put_le16(p, s->number_of_returns);
    p = lum_put_u8(p, s->edge);
    return lum_extras_put(p, shared->extras, shared->of->extra,
                          (size_t)(s - shared->of->samples));
}

static char *put_binary_rows(char *p, void *context, const lum_sample *samples,
                             size_t n)
{
    unsigned char *to = (unsigned char *)p;
    for (size_t i = 0; i < n; i++) {
        to = put_binary_row(to, context, &samples[i]);
    }
    return (char *)to;
}

static int add_binary(lum_writer *writer, const lum_line_samples *line,
                      lum_error *error)
{
    struct shared shared = {.extras = &writer->extras, .of = line};
    unsigned char *p =
        lum_put_f64(shared.line, lum_timestamp_number(line->timestamp_us));
    p = lum_put_le32(p, (uint32_t)line->frame);
    p = lum_put_u8(p, line->eye);
    (void)lum_put_le32(p, line->line);
    return lum_writer_put(writer, line,
                          ROW_BYTES + lum_extras_bytes(&writer->extras),
                          put_binary_rows, &shared, error);
}

/* Numbers that do not fit in 32 bits become the nearest that does. A rehearsal
 * makes no rows: the header tells only how many there are. */
static int add(lum_writer *writer, const lum_line_samples *line,
               lum_error *error)
{
    lum_line_samples clipped = *line;
    if (writer->use == LUM_WRITER_REHEARSAL) {
        return 0;
    }
    clipped.frame = lum_frame_i32(line->frame);
    if (line->line > INT32_MAX) {
        clipped.line = INT32_MAX;
    }
    return writer->options.ascii ? add_ascii(writer, &clipped, error)
           : writer->has_chosen
               ? lum_writer_put_chosen(writer, &clipped, false, ' ', error)
               : add_binary(writer, &clipped, error);
}

/* --- PLY --- */

/* CloudCompare strips "scalar_" and makes a scalar field of what is left. */
static void ply_header(lum_cloud_text *out, const lum_writer *writer,
                       uint64_t count, int padding)
{
    const lum_writer_options *options = &writer->options;
    print(out,
          "ply\nformat %s 1.0\ncomment lumsdk " LUM_VERSION "\n"
          "comment ",
          options->ascii ? "ascii" : "binary_little_endian");
    print_units(out, writer);
    if (lum_column_list_has(&writer->columns, LUM_FILE_TIME)) {
        print(out, "comment time in s from the beginning of the frame\n");
    }
    print_comment(out, options, "comment ");
    print(out, "comment %.*s\nelement vertex %" PRIu64 "\n", padding,
          "...................", count);
    for (unsigned i = 0; i < lum_writer_column_count(writer); i++) {
        const lum_file_column_spec column = lum_writer_column(writer, i);
        print(out, "property %s %s%s\n", column.ply_type,
              column.is_plain ? "" : "scalar_", column.cloud_name);
    }
    print(out, "end_header\n");
}

const lum_format_ops lum_ply_ops = {.name = "PLY",
                                    .ending = ".ply",
                                    .count_in_header = true,
                                    .columns = &lum_cloud_columns,
                                    .has_parts = true,
                                    .header = ply_header,
                                    .mentions = 1u,
                                    .begin = begin,
                                    .add = add,
                                    .finish = finish};

/* --- PCD --- */

/* One line of the header, an item for each column. */
static void list(lum_cloud_text *out, const lum_writer *writer, const char *key,
                 char what)
{
    print(out, "%s", key);
    for (unsigned i = 0; i < lum_writer_column_count(writer); i++) {
        const lum_file_column_spec column = lum_writer_column(writer, i);
        if (what == 'N') {
            print(out, " %s", column.cloud_name);
        } else if (what == 'T') {
            print(out, " %c", column.pcd_type);
        } else {
            print(out, " %u", what == 'S' ? column.bytes : 1u);
        }
    }
    print(out, "\n");
}

/* How large it is; an organised cloud is as many rows of pixels. */
static void print_size(lum_cloud_text *out, const lum_writer *writer,
                       uint64_t count)
{
    const bool has_rows = writer->options.organized;
    const uint64_t width = has_rows ? LUM_LINE_PIXELS : count;
    const uint64_t height = has_rows ? writer->rows : 1u;
    print(out,
          "WIDTH %" PRIu64 "\nHEIGHT %" PRIu64 "\n"
          "VIEWPOINT 0 0 0 1 0 0 0\n"
          "POINTS %" PRIu64 "\nDATA %s\n",
          width, height, has_rows ? width * height : count,
          writer->options.ascii ? "ascii" : "binary");
}

static void pcd_header(lum_cloud_text *out, const lum_writer *writer,
                       uint64_t count, int padding)
{
    const lum_writer_options *options = &writer->options;
    print(out, "# .PCD v0.7 - Point Cloud Data file format\n"
               "# lumsdk " LUM_VERSION "; ");
    print_units(out, writer);
    if (lum_column_list_has(&writer->columns, LUM_FILE_TIME)) {
        print(out, "# time in s from the beginning of the frame\n");
    }
    print_comment(out, options, "# ");
    if (options->organized) {
        print(out, "# organised: a row is a line, eye after eye, a "
                   "column a pixel; NaN where there is no point\n");
    } else {
        print(out, "# %.*s\n", padding,
              "......................................");
    }
    print(out, "VERSION 0.7\n");
    list(out, writer, "FIELDS", 'N');
    list(out, writer, "SIZE", 'S');
    list(out, writer, "TYPE", 'T');
    list(out, writer, "COUNT", 'C');
    print_size(out, writer, count);
}

const lum_format_ops lum_pcd_ops = {.name = "PCD",
                                    .ending = ".pcd",
                                    .count_in_header = true,
                                    .columns = &lum_cloud_columns,
                                    .can_organize = true,
                                    .has_parts = true,
                                    .header = pcd_header,
                                    .mentions = 2u,
                                    .begin = begin,
                                    .add = add,
                                    .finish = finish};
