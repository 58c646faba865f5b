/* What all formats use to write: puts a line's rows, in the columns of the
 * file, and the lines of its comment into the sink. */
#include "writer_internal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define BATCH 128u /* rows that are made between two looks at the sink */

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
    const lum_extras *extras = &writer->extras;
    const unsigned at = writer->columns.at[i];
    if (writer->preset == NULL && at < LUM_FILE_COLUMNS) {
        return lum_file_column_specs[at];
    }
    if (writer->preset == NULL) {
        const unsigned k = at - LUM_FILE_COLUMNS;
        const lum_number_spec *number = &lum_number_types[extras->type[k]];
        return (lum_file_column_spec){extras->name[k], extras->name[k],
                                      number->ply,     number->pcd,
                                      number->bytes,   false};
    }
    const lum_preset_field *f = &writer->preset->fields[i];
    const lum_number_spec *type = &lum_number_types[f->type];
    return (lum_file_column_spec){f->name,   f->name,     type->ply,
                                  type->pcd, type->bytes, true};
}

bool lum_writer_text_begin(lum_writer_text *out, const lum_writer *writer,
                           const lum_line_samples *line, char separator)
{
    const lum_extras *extras = &writer->extras;
    if (writer->has_chosen ||
        !lum_extras_are_same(extras, line->extra, line->count)) {
        return false;
    }
    lum_text_line_begin(&out->line, line, separator);
    if (extras->count > 0) {
        char *end = lum_extras_print(out->tail, extras, line->extra, separator);
        *end = '\n';
        out->line.tail = out->tail;
        out->line.tail_bytes = (size_t)(end - out->tail) + 1u;
    }
    return true;
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
    lum_file_rows_begin(&rows, &writer->columns, &writer->extras, line,
                        separator);
    return lum_writer_put(writer, line, LUM_FILE_ROW_ROOM,
                          is_text ? lum_file_rows_put_text
                                  : lum_file_rows_put_binary,
                          &rows, error);
}

int lum_writer_put_comment(lum_writer *writer, lum_error *error)
{
    const char *p = writer->options.comment;
    while (p != NULL && *p != '\0') {
        const size_t n = strcspn(p, "\n");
        if (lum_sink_write(writer->sink, "# ", 2, error) != 0 ||
            lum_sink_write(writer->sink, p, n, error) != 0 ||
            lum_sink_write(writer->sink, "\n", 1, error) != 0) {
            return -1;
        }
        p += n + (p[n] != '\0' ? 1u : 0u);
    }
    return 0;
}
