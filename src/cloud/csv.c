/* The format CSV. */
#include "text_columns.h"
#include "writer_internal.h"

static int begin(lum_writer *writer, lum_error *error)
{
    char header[512 + LUM_WRITER_EXTRA_MAX * (LUM_WRITER_EXTRA_NAME_MAX + 1u)] =
        "";
    size_t n = 0;
    const unsigned count = lum_writer_column_count(writer);
    for (unsigned i = 0; i < count; i++) {
        const char *name = lum_writer_column(writer, i).name;
        const size_t len = strlen(name);
        memcpy(header + n, name, len);
        n += len;
        header[n++] = i + 1u < count ? ',' : '\n';
    }
    return lum_writer_put_comment(writer, error) != 0
               ? -1
               : lum_sink_write(writer->sink, header, n, error);
}

static char *put_rows(char *p, void *context, const lum_sample *samples,
                      size_t n)
{
    static const lum_text_style style = {',', false};
    return lum_put_text_rows(p, context, samples, n, style);
}

static int add(lum_writer *writer, const lum_line_samples *line,
               lum_error *error)
{
    lum_writer_text text;
    return lum_writer_text_begin(&text, writer, line, ',')
               ? lum_writer_put(writer, line, LUM_WRITER_TEXT_ROOM, put_rows,
                                &text.line, error)
               : lum_writer_put_chosen(writer, line, true, ',', error);
}

const lum_format_ops lum_csv_ops = {.name = "CSV",
                                    .ending = ".csv",
                                    .columns = &lum_csv_columns,
                                    .has_parts = true,
                                    .begin = begin,
                                    .add = add};
