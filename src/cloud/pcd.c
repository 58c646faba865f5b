#include "cloud.h"

#include "lum/version.h"

#include <inttypes.h>

#define MENTIONS 2u

/* One line of the header, an item for each column. */
static void list(lum_cloud_text *out, const char *key, char what)
{
    lum_cloud_print(out, "%s", key);
    for (unsigned i = 0; i < LUM_CLOUD_COLUMNS; i++) {
        const lum_cloud_column *column = &lum_cloud_columns[i];
        if (what == 'N') {
            lum_cloud_print(out, " %s", column->name);
        } else if (what == 'T') {
            lum_cloud_print(out, " %c", column->pcd_type);
        } else {
            lum_cloud_print(out, " %u", what == 'S' ? column->bytes : 1u);
        }
    }
    lum_cloud_print(out, "\n");
}

static void header(lum_cloud_text *out, const lum_writer_options *options,
                   uint64_t count, int padding)
{
    lum_cloud_print(out,
                    "# .PCD v0.7 - Point Cloud Data file format\n"
                    "# lumsdk " LUM_VERSION
                    "; metres, degrees; intensity is the pulse width in ns; "
                    "timestamp in us %s\n",
                    lum_cloud_time_base(options));
    lum_cloud_print_comment(out, options, "# ");
    lum_cloud_print(out, "# %.*s\nVERSION 0.7\n", padding,
                    "......................................");
    list(out, "FIELDS", 'N');
    list(out, "SIZE", 'S');
    list(out, "TYPE", 'T');
    list(out, "COUNT", 'C');
    lum_cloud_print(out,
                    "WIDTH %" PRIu64 "\nHEIGHT 1\n"
                    "VIEWPOINT 0 0 0 1 0 0 0\n"
                    "POINTS %" PRIu64 "\nDATA %s\n",
                    count, count, options->ascii ? "ascii" : "binary");
}

static int begin(lum_writer *writer, lum_error *error)
{
    return lum_cloud_begin(writer, header, MENTIONS, error);
}

static int finish(lum_writer *writer, lum_error *error)
{
    return lum_cloud_finish(writer, header, MENTIONS, error);
}

const lum_format_ops lum_pcd_ops = {.name = "PCD",
                                    .ending = ".pcd",
                                    .count_in_header = true,
                                    .begin = begin,
                                    .add = lum_cloud_add,
                                    .finish = finish};
