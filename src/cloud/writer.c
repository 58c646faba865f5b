#define _POSIX_C_SOURCE 200809L

#include "base/sized.h"
#include "part.h"
#include "writer_internal.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define BATCH 128u /* rows that are made between two looks at the sink */

/* --- Formats --- */

static int refuse_picture(lum_writer *writer, lum_error *error)
{
    errno = ENOTSUP;
    return lum_error_set(error,
                         "%s: the program that writes it has nothing that "
                         "draws pictures; choose another format",
                         lum_sink_name(writer->sink));
}

/* Where the caller names nothing that draws. */
static const lum_format_ops no_picture = {
    .name = "PNG", .ending = ".png", .begin = refuse_picture};

static const lum_format_ops *const formats[LUM_FORMATS] = {
    [LUM_FORMAT_CSV] = &lum_csv_ops,   [LUM_FORMAT_PLY] = &lum_ply_ops,
    [LUM_FORMAT_PCD] = &lum_pcd_ops,   [LUM_FORMAT_LAS] = &lum_las_ops,
    [LUM_FORMAT_XYZ] = &lum_xyz_ops,   [LUM_FORMAT_PNG] = &no_picture,
    [LUM_FORMAT_MCAP] = &lum_mcap_ops,
};

int lum_format_from_name(const char *name, lum_format *out)
{
    const char *slash = strrchr(name, '/');
    const char *ending = strrchr(slash != NULL ? slash : name, '.');
    if (ending == NULL) {
        return -1;
    }
    for (int i = 0; i < LUM_FORMATS; i++) {
        if (strcasecmp(ending, formats[i]->ending) == 0) {
            *out = (lum_format)i;
            return 0;
        }
    }
    return -1;
}

bool lum_format_needs_count(lum_format format)
{
    return (unsigned)format < LUM_FORMATS && formats[format]->count_in_header;
}

bool lum_format_has_columns(lum_format format)
{
    return (unsigned)format < LUM_FORMATS && formats[format]->columns != NULL;
}

bool lum_format_has_frames(lum_format format)
{
    return (unsigned)format < LUM_FORMATS &&
           formats[format]->begin_frame != NULL;
}

bool lum_format_has_parts(lum_format format)
{
    return (unsigned)format < LUM_FORMATS && formats[format]->has_parts;
}

int lum_writer_check_columns(const char *names, lum_error *error)
{
    lum_column_list list;
    return lum_column_list_read(names, &list, error);
}

/* --- For the formats --- */

void *lum_writer_new_state(lum_writer *writer, size_t n, lum_error *error)
{
    writer->state = calloc(1, n);
    if (writer->state == NULL) {
        lum_error_set(error, "%s: no memory for %zu bytes to write %s",
                      lum_sink_name(writer->sink), n, writer->ops->name);
        errno = ENOMEM;
    }
    return writer->state;
}

int lum_writer_put(lum_writer *writer, const lum_line_samples *line,
                   size_t room, lum_put_rows *put, void *context,
                   lum_error *error)
{
    const lum_sample *next = line->samples;
    size_t left = line->count;
    while (left > 0) {
        const size_t n = left < BATCH ? left : BATCH;
        char *p = lum_sink_reserve(writer->sink, n * room, error);
        if (p == NULL) {
            return -1;
        }
        lum_sink_commit(writer->sink, (size_t)(put(p, context, next, n) - p));
        next += n;
        left -= n;
    }
    return 0;
}

static bool has_times(const lum_writer *writer)
{
    return writer->preset != NULL
               ? lum_preset_has_times(writer->preset)
               : lum_column_list_has(&writer->columns, LUM_FILE_TIME);
}

unsigned lum_writer_column_count(const lum_writer *writer)
{
    return writer->preset != NULL ? writer->preset->count
                                  : writer->columns.count;
}

lum_file_column_spec lum_writer_column(const lum_writer *writer, unsigned i)
{
    if (writer->preset == NULL) {
        return lum_file_column_specs[writer->columns.at[i]];
    }
    const lum_preset_field *f = &writer->preset->fields[i];
    const lum_field_type_spec *type = &lum_field_types[f->type];
    return (lum_file_column_spec){f->name,   f->name,     type->ply,
                                  type->pcd, type->bytes, true};
}

int lum_writer_put_chosen(lum_writer *writer, const lum_line_samples *line,
                          bool is_text, char separator, lum_error *error)
{
    lum_file_rows rows;
    lum_preset_line of_preset = {writer->preset, line, separator};
    if (line->times == NULL && has_times(writer)) {
        errno = EINVAL;
        return lum_error_set(error,
                             "%s: a line without times, and the file "
                             "has a column of them",
                             lum_sink_name(writer->sink));
    }
    if (writer->preset != NULL) {
        return lum_writer_put(writer, line, LUM_FILE_ROW_ROOM,
                              is_text ? lum_preset_put_text
                                      : lum_preset_put_binary,
                              &of_preset, error);
    }
    lum_file_rows_begin(&rows, &writer->columns, line, separator);
    return lum_writer_put(writer, line, LUM_FILE_ROW_ROOM,
                          is_text ? lum_file_rows_put_text
                                  : lum_file_rows_put_binary,
                          &rows, error);
}

/* A line's end ends it; behind the last there may be none. */
static size_t line_bytes(const char *line)
{
    return strcspn(line, "\n");
}

int lum_writer_put_comment(lum_writer *writer, lum_error *error)
{
    const char *p = writer->options.comment;
    while (p != NULL && *p != '\0') {
        const size_t n = line_bytes(p);
        if (lum_sink_write(writer->sink, "# ", 2, error) != 0 ||
            lum_sink_write(writer->sink, p, n, error) != 0 ||
            lum_sink_write(writer->sink, "\n", 1, error) != 0) {
            return -1;
        }
        p += n + (p[n] != '\0' ? 1u : 0u);
    }
    return 0;
}

/* --- Opening --- */

/* No line is empty or too long for readers, and nothing ends a header but what
 * the format writes. */
static bool is_comment(const char *text)
{
    const char *p = text;
    while (*p != '\0') {
        const size_t n = line_bytes(p);
        if (n == 0 || n > LUM_WRITER_COMMENT_LINE_MAX) {
            return false;
        }
        for (size_t i = 0; i < n; i++) {
            if (p[i] < ' ' || p[i] > '~') {
                return false;
            }
        }
        p += n + (p[n] != '\0' ? 1u : 0u);
    }
    return (size_t)(p - text) <= LUM_WRITER_COMMENT_BYTES_MAX;
}

static int keep_comment(lum_writer *writer, const char *path, lum_error *error)
{
    const char *comment = writer->options.comment;
    if (comment == NULL) {
        return 0;
    }
    if (!is_comment(comment)) {
        errno = EINVAL;
        return lum_error_set(error,
                             "%s: a comment is lines of 1 to %u printable "
                             "ASCII characters, at most %u in all",
                             path, LUM_WRITER_COMMENT_LINE_MAX,
                             LUM_WRITER_COMMENT_BYTES_MAX);
    }
    writer->comment = strdup(comment);
    writer->options.comment = writer->comment;
    if (writer->comment == NULL) {
        lum_error_set(error, "%s: no memory to open it", path);
        errno = ENOMEM;
        return -1;
    }
    return 0;
}

/* Those of the format, or those that are asked for. */
static int choose_columns(lum_writer *writer, const char *path,
                          lum_error *error)
{
    const char *names = writer->options.columns;
    const lum_column_list *own = writer->ops->columns;
    lum_error why = {""};
    writer->options.columns = NULL;
    if (names == NULL) {
        writer->columns = own != NULL ? *own : (lum_column_list){0};
        return 0;
    }
    writer->has_chosen = true;
    if (own == NULL) {
        errno = EINVAL;
        return lum_error_set(error, "%s: the columns of %s cannot be chosen",
                             path, writer->ops->name);
    }
    return lum_column_list_read(names, &writer->columns, &why) == 0
               ? 0
               : lum_error_set(error, "%s: %s", path, why.text);
}

bool lum_format_has_presets(lum_format format)
{
    return lum_format_has_columns(format) || format == LUM_FORMAT_MCAP;
}

static int choose_preset(lum_writer *writer, const char *path, lum_error *error)
{
    const char *name = writer->options.preset;
    lum_error why = {""};
    writer->options.preset = NULL;
    if (name == NULL) {
        return 0;
    }
    if (writer->has_chosen || !lum_format_has_presets(writer->options.format)) {
        errno = EINVAL;
        return lum_error_set(error, "%s: %s", path,
                             writer->has_chosen
                                 ? "a preset and columns exclude each other"
                                 : "presets are of CSV, PLY, PCD and MCAP");
    }
    writer->has_chosen = true;
    writer->preset = lum_preset_find(name, &why);
    return writer->preset != NULL
               ? 0
               : lum_error_set(error, "%s: %s", path, why.text);
}

static int check_organized(const lum_writer *writer, const char *path,
                           lum_error *error)
{
    if (!writer->options.organized || writer->ops->can_organize) {
        return 0;
    }
    errno = EINVAL;
    return lum_error_set(error, "%s: %s has no rows of pixels; PCD does", path,
                         writer->ops->name);
}

/* Remember the first failure: whatever is called next repeats it. */
static int remember(lum_writer *writer, lum_error *error)
{
    const int code = errno;
    if (!writer->failed) {
        writer->failed = true;
        writer->failure_code = code;
    }
    if (error != NULL) {
        *error = writer->failure;
    }
    errno = writer->failure_code;
    return -1;
}

static int check_output(const lum_writer *writer, lum_error *error)
{
    if (!writer->ops->count_in_header || writer->rehearses || writer->is_part ||
        writer->was_rehearsed || writer->options.organized ||
        lum_sink_seekable(writer->sink)) {
        return 0;
    }
    errno = ESPIPE;
    return lum_error_set(
        error,
        "%s: %s begins with the number of points, which is not known yet, and "
        "this output cannot seek; write to a file, or choose csv or xyz",
        lum_sink_name(writer->sink), writer->ops->name);
}

/* A recording stays, whatever becomes of the rest. */
static int open_sink(const char *path, lum_writer *writer, lum_error *error)
{
    const lum_mcap_options *mcap = writer->options.mcap;
    if (writer->is_part) {
        return lum_sink_open_memory(path, &writer->sink, error);
    }
    const bool grows = writer->ops == &lum_mcap_ops && !writer->rehearses &&
                       mcap != NULL && mcap->is_growing;
    return grows ? lum_sink_open_growing(path, &writer->sink, error)
                 : lum_sink_open(path, &writer->sink, error);
}

static int open_format(const char *path, lum_writer *writer, lum_error *error)
{
    if (keep_comment(writer, path, error) != 0 ||
        choose_columns(writer, path, error) != 0 ||
        choose_preset(writer, path, error) != 0 ||
        check_organized(writer, path, error) != 0 ||
        open_sink(path, writer, error) != 0 ||
        check_output(writer, error) != 0) {
        return -1;
    }
    const int result =
        writer->options.organized ? 0 : writer->ops->begin(writer, error);
    writer->options.projector = NULL;
    writer->options.rehearsal = NULL;
    writer->options.mcap = NULL;
    return result;
}

/* What a writer is opened for. */
enum use {
    TO_WRITE,
    TO_REHEARSE,
    TO_BE_PART
};

static int open_writer(const char *path, const lum_writer_options *options,
                       enum use use, lum_writer **out, lum_error *error)
{
    if ((unsigned)options->format >= LUM_FORMATS) {
        errno = EINVAL;
        return lum_error_set(error, "%s: format %d is none; 0 to %d are", path,
                             (int)options->format, LUM_FORMATS - 1);
    }
    lum_writer *writer = calloc(1, sizeof *writer);
    if (writer == NULL) {
        lum_error_set(error, "%s: no memory to open it", path);
        errno = ENOMEM;
        return -1;
    }
    writer->ops = options->format == LUM_FORMAT_PNG && options->picture != NULL
                      ? options->picture
                      : formats[options->format];
    writer->options = *options;
    writer->rehearses = use == TO_REHEARSE;
    writer->is_part = use == TO_BE_PART;
    if (options->rehearsal != NULL && !writer->is_part) {
        writer->was_rehearsed = true;
        writer->rehearsed = options->rehearsal->points;
    }
    if (open_format(path, writer, error) != 0) {
        const int code = errno;
        lum_writer_abort(writer);
        errno = code;
        return -1;
    }
    *out = writer;
    return 0;
}

static int open_known(const char *path, const lum_writer_options *options,
                      enum use use, lum_writer **out, lum_error *error)
{
    lum_writer_options known;
    lum_mcap_options mcap;
    if (lum_sized_take(&known, sizeof known, options, "the writer's options",
                       "lum_writer_options", error) != 0) {
        return -1;
    }
    if (known.mcap != NULL) {
        if (lum_sized_take(&mcap, sizeof mcap, known.mcap,
                           "the options of MCAP", "lum_mcap_options",
                           error) != 0) {
            return -1;
        }
        known.mcap = &mcap;
    }
    return open_writer(path, &known, use, out, error);
}

int lum_writer_open(const char *path, const lum_writer_options *options,
                    lum_writer **out, lum_error *error)
{
    return open_known(path, options, TO_WRITE, out, error);
}

int lum_writer_rehearse(const lum_writer_options *options, lum_writer **out,
                        lum_error *error)
{
    return open_known("/dev/null", options, TO_REHEARSE, out, error);
}

/* The file has the header. */
int lum_writer_open_part(const char *path, const lum_writer_options *options,
                         lum_writer **out, lum_error *error)
{
    if (!lum_format_has_parts(options->format) || options->organized) {
        errno = EINVAL;
        return lum_error_set(error, "%s: it cannot be made of parts", path);
    }
    if (open_known(path, options, TO_BE_PART, out, error) != 0) {
        return -1;
    }
    lum_writer_clear_part(*out);
    return 0;
}

/* --- Lines --- */

static int begin_rows(lum_writer *writer, uint32_t rows, lum_error *error)
{
    if (!writer->options.organized || writer->has_rows ||
        rows > LUM_WRITER_ROWS_MAX) {
        errno = EINVAL;
        return lum_error_set(
            error, "%s: %lu rows: %s", lum_sink_name(writer->sink),
            (unsigned long)rows,
            !writer->options.organized ? "the file is not organised"
            : writer->has_rows         ? "it has begun, and holds one frame"
                                       : "there are too many");
    }
    writer->has_rows = true;
    writer->rows = rows;
    return writer->ops->begin(writer, error);
}

int lum_writer_set_rows(lum_writer *writer, uint32_t rows, lum_error *error)
{
    return writer->failed || begin_rows(writer, rows, &writer->failure) != 0
               ? remember(writer, error)
               : 0;
}

static int check_row(const lum_writer *writer, const lum_line_samples *line,
                     lum_error *error)
{
    if (!writer->options.organized ||
        (writer->has_rows && line->count == LUM_LINE_PIXELS &&
         writer->points < (uint64_t)LUM_LINE_PIXELS * writer->rows)) {
        return 0;
    }
    errno = EINVAL;
    return lum_error_set(error,
                         "%s: a line of %zu points: the file is of %lu rows of "
                         "%u, and has %" PRIu64 " points",
                         lum_sink_name(writer->sink), line->count,
                         (unsigned long)writer->rows, LUM_LINE_PIXELS,
                         writer->points);
}

int lum_writer_add(lum_writer *writer, const lum_line_samples *line,
                   lum_error *error)
{
    lum_line_samples known;
    if (lum_sized_take(&known, sizeof known, line, "the line",
                       "lum_line_samples", error) != 0) {
        return -1;
    }
    if (writer->failed ||
        (known.count > 0 &&
         (check_row(writer, &known, &writer->failure) != 0 ||
          writer->ops->add(writer, &known, &writer->failure) != 0))) {
        return remember(writer, error);
    }
    writer->points += known.count;
    return 0;
}

/* --- Parts --- */

uint64_t lum_writer_part_points(const lum_writer *part)
{
    return part->points;
}

void lum_writer_clear_part(lum_writer *part)
{
    lum_sink_clear(part->sink);
    part->points = 0;
}

int lum_writer_add_part(lum_writer *writer, lum_writer *part, lum_error *error)
{
    const uint64_t points = part->points;
    const bool fails = writer->failed || lum_sink_move(writer->sink, part->sink,
                                                       &writer->failure) != 0;
    const int code = errno;
    lum_writer_clear_part(part);
    errno = code;
    if (fails) {
        return remember(writer, error);
    }
    writer->points += points;
    return 0;
}

/* --- Frames and status --- */

int lum_writer_begin_frame(lum_writer *writer, int64_t utc_ns, lum_error *error)
{
    if (writer->failed ||
        (writer->ops->begin_frame != NULL &&
         writer->ops->begin_frame(writer, utc_ns, &writer->failure) != 0)) {
        return remember(writer, error);
    }
    return 0;
}

int lum_writer_end_frame(lum_writer *writer, lum_error *error)
{
    if (writer->failed ||
        (writer->ops->end_frame != NULL &&
         writer->ops->end_frame(writer, &writer->failure) != 0)) {
        return remember(writer, error);
    }
    return 0;
}

int lum_writer_add_status(lum_writer *writer, const lum_writer_status *status,
                          lum_error *error)
{
    lum_writer_status known;
    if (lum_sized_take(&known, sizeof known, status, "the status",
                       "lum_writer_status", error) != 0) {
        return -1;
    }
    if (writer->failed ||
        (writer->ops->add_status != NULL &&
         writer->ops->add_status(writer, &known, &writer->failure) != 0)) {
        return remember(writer, error);
    }
    return 0;
}

int lum_writer_add_datagram(lum_writer *writer,
                            const lum_writer_datagram *datagram,
                            lum_error *error)
{
    if (writer->failed ||
        (writer->ops->add_datagram != NULL &&
         writer->ops->add_datagram(writer, datagram, &writer->failure) != 0)) {
        return remember(writer, error);
    }
    return 0;
}

/* --- The output --- */

uint64_t lum_writer_bytes(const lum_writer *writer)
{
    return lum_sink_bytes(writer->sink);
}

static int flush(lum_writer *writer, lum_error *error)
{
    return writer->ops->flush != NULL ? writer->ops->flush(writer, error)
                                      : lum_sink_flush(writer->sink, error);
}

int lum_writer_flush(lum_writer *writer, lum_error *error)
{
    if (writer->failed || flush(writer, &writer->failure) != 0) {
        return remember(writer, error);
    }
    return 0;
}

int lum_writer_check(lum_writer *writer, lum_error *error)
{
    return writer->sink != NULL ? lum_sink_check(writer->sink, error) : 0;
}

/* --- The end --- */

/* One without a frame has no rows. */
static int finish_rows(lum_writer *writer, lum_error *error)
{
    const uint64_t wanted = (uint64_t)LUM_LINE_PIXELS * writer->rows;
    if (!writer->options.organized) {
        return 0;
    }
    if (!writer->has_rows) {
        return begin_rows(writer, 0, error);
    }
    if (writer->points == wanted) {
        return 0;
    }
    errno = EINVAL;
    return lum_error_set(error,
                         "%s: %" PRIu64 " points of an organised file of "
                         "%" PRIu64,
                         lum_sink_name(writer->sink), writer->points, wanted);
}

static int check_count(const lum_writer *writer, lum_error *error)
{
    if (!writer->was_rehearsed || writer->rehearsed == writer->points) {
        return 0;
    }
    errno = EINVAL;
    return lum_error_set(error,
                         "%s: %" PRIu64 " points were rehearsed and %" PRIu64
                         " came; the source has changed in between",
                         lum_sink_name(writer->sink), writer->rehearsed,
                         writer->points);
}

static int finish_format(lum_writer *writer, lum_error *error)
{
    if (check_count(writer, error) != 0 || finish_rows(writer, error) != 0) {
        return -1;
    }
    return writer->ops->finish != NULL ? writer->ops->finish(writer, error) : 0;
}

static void destroy(lum_writer *writer)
{
    if (writer->ops->release != NULL && writer->state != NULL) {
        writer->ops->release(writer);
    }
    free(writer->state);
    free(writer->comment);
    free(writer);
}

int lum_writer_close(lum_writer *writer, lum_error *error)
{
    if (writer->failed || finish_format(writer, &writer->failure) != 0) {
        (void)remember(writer, error);
        const int code = errno;
        lum_writer_abort(writer);
        errno = code;
        return -1;
    }
    const int result = lum_sink_close(writer->sink, error);
    const int code = errno;
    destroy(writer);
    errno = code;
    return result;
}

void lum_writer_abort(lum_writer *writer)
{
    if (writer == NULL) {
        return;
    }
    lum_sink_abort(writer->sink);
    destroy(writer);
}
