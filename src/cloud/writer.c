#define _POSIX_C_SOURCE 200809L

#include "base/sized.h"
#include "writer_internal.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define BATCH 128u /* rows that are made between two looks at the sink */

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
    [LUM_FORMAT_CSV] = &lum_csv_ops, [LUM_FORMAT_PLY] = &lum_ply_ops,
    [LUM_FORMAT_PCD] = &lum_pcd_ops, [LUM_FORMAT_LAS] = &lum_las_ops,
    [LUM_FORMAT_XYZ] = &lum_xyz_ops, [LUM_FORMAT_PNG] = &no_picture,
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
    if (!writer->ops->count_in_header || writer->rehearses ||
        writer->was_rehearsed || lum_sink_seekable(writer->sink)) {
        return 0;
    }
    errno = ESPIPE;
    return lum_error_set(
        error,
        "%s: %s begins with the number of points, which is not known yet, and "
        "this output cannot seek; write to a file, or choose csv or xyz",
        lum_sink_name(writer->sink), writer->ops->name);
}

static int open_format(const char *path, lum_writer *writer, lum_error *error)
{
    if (keep_comment(writer, path, error) != 0 ||
        lum_sink_open(path, &writer->sink, error) != 0 ||
        check_output(writer, error) != 0) {
        return -1;
    }
    const int result = writer->ops->begin(writer, error);
    writer->options.projector = NULL;
    writer->options.rehearsal = NULL;
    return result;
}

static int open_writer(const char *path, const lum_writer_options *options,
                       bool rehearses, lum_writer **out, lum_error *error)
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
    writer->rehearses = rehearses;
    if (options->rehearsal != NULL) {
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
                      bool rehearses, lum_writer **out, lum_error *error)
{
    lum_writer_options known;
    return lum_sized_take(&known, sizeof known, options, "the writer's options",
                          "lum_writer_options", error) == 0
               ? open_writer(path, &known, rehearses, out, error)
               : -1;
}

int lum_writer_open(const char *path, const lum_writer_options *options,
                    lum_writer **out, lum_error *error)
{
    return open_known(path, options, false, out, error);
}

int lum_writer_rehearse(const lum_writer_options *options, lum_writer **out,
                        lum_error *error)
{
    return open_known("/dev/null", options, true, out, error);
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
         writer->ops->add(writer, &known, &writer->failure) != 0)) {
        return remember(writer, error);
    }
    writer->points += known.count;
    return 0;
}

uint64_t lum_writer_bytes(const lum_writer *writer)
{
    return lum_sink_bytes(writer->sink);
}

int lum_writer_flush(lum_writer *writer, lum_error *error)
{
    if (writer->failed || lum_sink_flush(writer->sink, &writer->failure) != 0) {
        return remember(writer, error);
    }
    return 0;
}

static int check_count(const lum_writer *writer, lum_error *error)
{
    if (!writer->was_rehearsed || writer->rehearsed == writer->points) {
        return 0;
    }
    errno = EINVAL;
    return lum_error_set(error,
                         "%s: %" PRIu64 " points were rehearsed and %" PRIu64
                         " came; the source has changed meanwhile",
                         lum_sink_name(writer->sink), writer->rehearsed,
                         writer->points);
}

static int finish_format(lum_writer *writer, lum_error *error)
{
    if (check_count(writer, error) != 0) {
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
