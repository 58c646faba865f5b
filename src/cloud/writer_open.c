/* Opens a writer: checks the options against the format and copies them. It
 * writes a file, a part of one, or only rehearses one. */
#define _POSIX_C_SOURCE 200809L

#include "base/sized.h"
#include "part.h"
#include "writer_internal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* No line is empty or too long for readers, and nothing ends a header but what
 * the format writes. */
static bool is_comment(const char *text)
{
    const char *p = text;
    while (*p != '\0') {
        const size_t n = strcspn(p, "\n");
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

static int refuse(const char *path, const char *why, lum_error *error)
{
    errno = EINVAL;
    return lum_error_set(error, "%s: %s", path, why);
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
    return writer->comment != NULL ? 0 : lum_sink_no_memory(path, error);
}

/* Those of the format and the caller's own, or those that are asked for. */
static int choose_columns(lum_writer *writer, const char *path,
                          lum_error *error)
{
    const char *names = writer->options.columns;
    const lum_column_list *own = writer->ops->columns;
    lum_error why = {""};
    if (lum_extras_take(&writer->extras, writer->options.format,
                        writer->options.extra, writer->options.extra_count,
                        &why) != 0) {
        return refuse(path, why.text, error);
    }
    writer->options.columns = NULL;
    writer->options.extra = NULL;
    if (names == NULL) {
        writer->columns = own != NULL ? *own : (lum_column_list){0};
        lum_column_list_append(&writer->columns, &writer->extras);
        return 0;
    }
    writer->has_chosen = true;
    if (own == NULL) {
        errno = EINVAL;
        return lum_error_set(error, "%s: the columns of %s cannot be chosen",
                             path, writer->ops->name);
    }
    return lum_column_list_read(names, &writer->extras, &writer->columns,
                                &why) == 0
               ? 0
               : refuse(path, why.text, error);
}

static int choose_voxels(lum_writer *writer, const char *path, bool has_preset,
                         lum_error *error)
{
    if (has_preset || writer->has_chosen || writer->options.organized) {
        return refuse(path,
                      "voxels have columns of their own, and no rows: leave "
                      "out columns, preset and organized",
                      error);
    }
    if (!lum_format_has_voxels(writer->options.format)) {
        return refuse(path, "voxels need CSV, PLY, PCD or LAS", error);
    }
    if (writer->ops != &lum_las_ops) {
        writer->has_chosen = true;
        writer->preset = &lum_preset_of_voxels;
    }
    return 0;
}

static int choose_preset(lum_writer *writer, const char *path, lum_error *error)
{
    const char *name = writer->options.preset;
    lum_error why = {""};
    writer->options.preset = NULL;
    if (writer->extras.count > 0 && (name != NULL || writer->options.voxels)) {
        return refuse(path,
                      "presets and voxels take no extra columns: leave out "
                      "extra, or the preset or voxels",
                      error);
    }
    if (writer->options.voxels) {
        return choose_voxels(writer, path, name != NULL, error);
    }
    if (name == NULL) {
        return 0;
    }
    if (writer->has_chosen) {
        return refuse(path, "a preset and columns exclude each other", error);
    }
    if (!lum_format_has_presets(writer->options.format)) {
        return refuse(path, "presets need CSV, PLY, PCD or MCAP", error);
    }
    writer->has_chosen = true;
    writer->preset = lum_preset_find(name, &why);
    return writer->preset != NULL ? 0 : refuse(path, why.text, error);
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

/* A recording stays, whatever becomes of the rest. */
static int open_sink(const char *path, lum_writer *writer, lum_error *error)
{
    const lum_mcap_options *mcap = writer->options.mcap;
    if (writer->use == LUM_WRITER_PART) {
        return lum_sink_open_memory(path, &writer->sink, error);
    }
    const bool grows = writer->ops == &lum_mcap_ops &&
                       writer->use == LUM_WRITER_FILE && mcap != NULL &&
                       mcap->is_growing;
    return grows ? lum_sink_open_growing(path, &writer->sink, error)
                 : lum_sink_open(path, &writer->sink, error);
}

/* Whether the count of points that a header begins with is known, or can be
 * written later. */
static int check_output(const lum_writer *writer, lum_error *error)
{
    if (!writer->ops->count_in_header || writer->use != LUM_WRITER_FILE ||
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
    writer->options.drawing = NULL;
    return result;
}

static int open_writer(const char *path, const lum_writer_options *options,
                       lum_writer_use use, lum_writer **out, lum_error *error)
{
    const lum_format_ops *ops = lum_format_find(options);
    if (ops == NULL) {
        errno = EINVAL;
        return lum_error_set(error,
                             "%s: format %d is unknown; 0 to %d are known",
                             path, (int)options->format, LUM_FORMATS - 1);
    }
    lum_writer *writer = calloc(1, sizeof *writer);
    if (writer == NULL) {
        return lum_sink_no_memory(path, error);
    }
    writer->use = use;
    writer->ops = ops;
    writer->options = *options;
    if (options->rehearsal != NULL && use != LUM_WRITER_PART) {
        writer->was_rehearsed = true;
        writer->rehearsed = options->rehearsal->points;
    }
    if (open_format(path, writer, error) != 0) {
        lum_writer_abort(writer);
        return -1;
    }
    *out = writer;
    return 0;
}

static int open_known(const char *path, const lum_writer_options *options,
                      lum_writer_use use, lum_writer **out, lum_error *error)
{
    lum_writer_options known;
    lum_mcap_options mcap;
    if (lum_sized_take(&known, sizeof known, options, "the writer's options",
                       "lum_writer_options", error) != 0 ||
        (known.mcap != NULL &&
         lum_sized_take(&mcap, sizeof mcap, known.mcap, "the options of MCAP",
                        "lum_mcap_options", error) != 0)) {
        return -1;
    }
    known.mcap = known.mcap != NULL ? &mcap : NULL;
    return open_writer(path, &known, use, out, error);
}

int lum_writer_open(const char *path, const lum_writer_options *options,
                    lum_writer **out, lum_error *error)
{
    return open_known(path, options, LUM_WRITER_FILE, out, error);
}

int lum_writer_rehearse(const lum_writer_options *options, lum_writer **out,
                        lum_error *error)
{
    return open_known("/dev/null", options, LUM_WRITER_REHEARSAL, out, error);
}

/* The file has the header. */
int lum_writer_open_part(const char *path, const lum_writer_options *options,
                         lum_writer **out, lum_error *error)
{
    if (!lum_format_has_parts(options->format) || options->organized) {
        return refuse(path, "it cannot be made of parts", error);
    }
    if (open_known(path, options, LUM_WRITER_PART, out, error) != 0) {
        return -1;
    }
    lum_writer_clear_part(*out);
    return 0;
}
