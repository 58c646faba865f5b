#include "cloud.h"

#include "lum/version.h"

#include <inttypes.h>

/* CloudCompare strips "scalar_" and makes a scalar field of what is left. */
static void header(lum_cloud_text *out, const lum_writer *writer,
                   uint64_t count, int padding)
{
    const lum_writer_options *options = &writer->options;
    lum_cloud_print(out,
                    "ply\nformat %s 1.0\ncomment lumsdk " LUM_VERSION "\n"
                    "comment ",
                    options->ascii ? "ascii" : "binary_little_endian");
    lum_cloud_print_units(out, writer);
    if (lum_column_list_has(&writer->columns, LUM_FILE_TIME)) {
        lum_cloud_print(out,
                        "comment time in s from the beginning of the frame\n");
    }
    lum_cloud_print_comment(out, options, "comment ");
    lum_cloud_print(out, "comment %.*s\nelement vertex %" PRIu64 "\n", padding,
                    "...................", count);
    for (unsigned i = 0; i < lum_writer_column_count(writer); i++) {
        const lum_file_column_spec column = lum_writer_column(writer, i);
        lum_cloud_print(out, "property %s %s%s\n", column.ply_type,
                        column.is_plain ? "" : "scalar_", column.cloud_name);
    }
    lum_cloud_print(out, "end_header\n");
}

const lum_format_ops lum_ply_ops = {.name = "PLY",
                                    .ending = ".ply",
                                    .count_in_header = true,
                                    .columns = &lum_cloud_columns,
                                    .has_parts = true,
                                    .header = header,
                                    .mentions = 1u,
                                    .begin = lum_cloud_begin,
                                    .add = lum_cloud_add,
                                    .finish = lum_cloud_finish};
