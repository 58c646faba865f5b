/* The format XYZ: three numbers a line. */
#include "text_columns.h"
#include "writer_internal.h"

#define ROW_ROOM (4u * LUM_DECIMAL_ROOM)

static int begin(lum_writer *writer, lum_error *error)
{
    return lum_writer_put_comment(writer, error);
}

static char *put_rows(char *p, void *context, const lum_sample *samples,
                      size_t n)
{
    (void)context;
    for (size_t i = 0; i < n; i++) {
        p = lum_put_column(p, samples[i].x, LUM_METRE_DECIMALS, ' ');
        p = lum_put_column(p, samples[i].y, LUM_METRE_DECIMALS, ' ');
        p = lum_put_column(p, samples[i].z, LUM_METRE_DECIMALS, '\n');
    }
    return p;
}

static int add(lum_writer *writer, const lum_line_samples *line,
               lum_error *error)
{
    return lum_writer_put(writer, line, ROW_ROOM, put_rows, NULL, error);
}

const lum_format_ops lum_xyz_ops = {.name = "XYZ",
                                    .ending = ".xyz",
                                    .has_parts = true,
                                    .begin = begin,
                                    .add = add};
