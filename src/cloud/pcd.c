#include "cloud.h"

#include "lum/version.h"

#include <inttypes.h>

/* One line of the header, an item for each column. */
static void list(lum_cloud_text *out, const lum_writer *writer, const char *key,
                 char what)
{
    lum_cloud_print(out, "%s", key);
    for (unsigned i = 0; i < lum_writer_column_count(writer); i++) {
        const lum_file_column_spec column = lum_writer_column(writer, i);
        if (what == 'N') {
            lum_cloud_print(out, " %s", column.cloud_name);
        } else if (what == 'T') {
            lum_cloud_print(out, " %c", column.pcd_type);
        } else {
            lum_cloud_print(out, " %u", what == 'S' ? column.bytes : 1u);
        }
    }
    lum_cloud_print(out, "\n");
}

/* How large it is; an organised cloud is as many rows of pixels. */
static void print_size(lum_cloud_text *out, const lum_writer *writer,
                       uint64_t count)
{
    const bool has_rows = writer->options.organized;
    const uint64_t width = has_rows ? LUM_LINE_PIXELS : count;
    const uint64_t height = has_rows ? writer->rows : 1u;
    lum_cloud_print(out,
                    "WIDTH %" PRIu64 "\nHEIGHT %" PRIu64 "\n"
                    "VIEWPOINT 0 0 0 1 0 0 0\n"
                    "POINTS %" PRIu64 "\nDATA %s\n",
                    width, height, has_rows ? width * height : count,
                    writer->options.ascii ? "ascii" : "binary");
}

static void header(lum_cloud_text *out, const lum_writer *writer,
                   uint64_t count, int padding)
{
    const lum_writer_options *options = &writer->options;
    lum_cloud_print(out, "# .PCD v0.7 - Point Cloud Data file format\n"
                         "# lumsdk " LUM_VERSION "; ");
    lum_cloud_print_units(out, writer);
    if (lum_column_list_has(&writer->columns, LUM_FILE_TIME)) {
        lum_cloud_print(out, "# time in s from the beginning of the frame\n");
    }
    lum_cloud_print_comment(out, options, "# ");
    if (options->organized) {
        lum_cloud_print(out, "# organised: a row is a line, eye after eye, a "
                             "column a pixel; NaN where there is no point\n");
    } else {
        lum_cloud_print(out, "# %.*s\n", padding,
                        "......................................");
    }
    lum_cloud_print(out, "VERSION 0.7\n");
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
                                    .header = header,
                                    .mentions = 2u,
                                    .begin = lum_cloud_begin,
                                    .add = lum_cloud_add,
                                    .finish = lum_cloud_finish};
