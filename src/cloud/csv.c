#include "text_columns.h"
#include "writer_internal.h"

static const char header[] =
    "x,y,z,range,azimuth,elevation,pulse_width,timestamp,frame,eye,line,pixel,"
    "return_number,number_of_returns,edge\n";

static int begin(lum_writer *writer, lum_error *error)
{
    return lum_writer_put_comment(writer, error) != 0
               ? -1
               : lum_sink_write(writer->sink, header, sizeof header - 1u,
                                error);
}

static char *put_rows(char *p, void *context, const lum_sample *samples,
                      size_t n)
{
    for (size_t i = 0; i < n; i++) {
        p = lum_put_text_row(p, context, &samples[i], ',', false);
    }
    return p;
}

static int add(lum_writer *writer, const lum_line_samples *line,
               lum_error *error)
{
    lum_text_line text;
    lum_text_line_begin(&text, line, ',');
    return lum_writer_put(writer, line, LUM_TEXT_ROW_ROOM, put_rows, &text,
                          error);
}

const lum_format_ops lum_csv_ops = {
    .name = "CSV", .ending = ".csv", .begin = begin, .add = add};
