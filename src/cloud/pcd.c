#include "cloud.h"

#include "lum/version.h"

#include <inttypes.h>

#define MENTIONS 2u

/* One line of the header, an item for each column. */
static size_t list(char *out, size_t used, const char *key, char what)
{
    size_t n = lum_cloud_print(out, used, "%s", key);
    for (unsigned i = 0; i < LUM_CLOUD_COLUMNS; i++) {
        const lum_cloud_column *column = &lum_cloud_columns[i];
        if (what == 'N') {
            n = lum_cloud_print(out, n, " %s", column->name);
        } else if (what == 'T') {
            n = lum_cloud_print(out, n, " %c", column->pcd_type);
        } else {
            n = lum_cloud_print(out, n, " %u",
                                what == 'S' ? column->bytes : 1u);
        }
    }
    return lum_cloud_print(out, n, "\n");
}

static size_t header(char out[LUM_CLOUD_HEADER_BYTES],
                     const lum_writer_options *options, uint64_t count,
                     int padding)
{
    size_t n = lum_cloud_print(out, 0,
                               "# .PCD v0.7 - Point Cloud Data file format\n"
                               "# lumsdk " LUM_VERSION
                               "; metres, degrees; intensity is the pulse "
                               "width in ns; timestamp in us %s\n"
                               "# %.*s\nVERSION 0.7\n",
                               lum_cloud_time_base(options), padding,
                               "......................................");
    n = list(out, n, "FIELDS", 'N');
    n = list(out, n, "SIZE", 'S');
    n = list(out, n, "TYPE", 'T');
    n = list(out, n, "COUNT", 'C');
    return lum_cloud_print(out, n,
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
