#include "cloud.h"

#include "lum/version.h"

#include <inttypes.h>

#define MENTIONS 1u

/* CloudCompare strips "scalar_" and makes a scalar field of what is left. */
static void header(lum_cloud_text *out, const lum_writer_options *options,
                   uint64_t count, int padding)
{
    lum_cloud_print(out,
                    "ply\nformat %s 1.0\ncomment lumsdk " LUM_VERSION "\n"
                    "comment metres, degrees; intensity is the pulse width in "
                    "ns; timestamp in us %s\n",
                    options->ascii ? "ascii" : "binary_little_endian",
                    lum_cloud_time_base(options));
    lum_cloud_print_comment(out, options, "comment ");
    lum_cloud_print(out, "comment %.*s\nelement vertex %" PRIu64 "\n", padding,
                    "...................", count);
    for (unsigned i = 0; i < LUM_CLOUD_COLUMNS; i++) {
        lum_cloud_print(
            out, "property %s %s%s\n", lum_cloud_columns[i].ply_type,
            i < LUM_CLOUD_PLAIN ? "" : "scalar_", lum_cloud_columns[i].name);
    }
    lum_cloud_print(out, "end_header\n");
}

static int begin(lum_writer *writer, lum_error *error)
{
    return lum_cloud_begin(writer, header, MENTIONS, error);
}

static int finish(lum_writer *writer, lum_error *error)
{
    return lum_cloud_finish(writer, header, MENTIONS, error);
}

const lum_format_ops lum_ply_ops = {.name = "PLY",
                                    .ending = ".ply",
                                    .count_in_header = true,
                                    .begin = begin,
                                    .add = lum_cloud_add,
                                    .finish = finish};
