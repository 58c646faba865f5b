/* The table of the file formats: which one a name asks for, and what each can
 * do. */
#include "formats.h"

#include "part.h"
#include "writer_internal.h"

#include "points/columns.h"

#include <errno.h>
#include <string.h>
#include <strings.h>

static int refuse_picture(lum_writer *writer, lum_error *error)
{
    errno = ENOTSUP;
    return lum_error_set(error,
                         "%s: this program cannot draw pictures; choose "
                         "another format",
                         lum_sink_name(writer->sink));
}

/* Where the caller has given no function that draws. */
static const lum_format_ops no_picture = {
    .name = "PNG", .ending = ".png", .begin = refuse_picture};

static const lum_format_ops *const formats[LUM_FORMATS] = {
    [LUM_FORMAT_CSV] = &lum_csv_ops,   [LUM_FORMAT_PLY] = &lum_ply_ops,
    [LUM_FORMAT_PCD] = &lum_pcd_ops,   [LUM_FORMAT_LAS] = &lum_las_ops,
    [LUM_FORMAT_XYZ] = &lum_xyz_ops,   [LUM_FORMAT_PNG] = &no_picture,
    [LUM_FORMAT_MCAP] = &lum_mcap_ops,
};

const lum_format_ops *lum_format_find(const lum_writer_options *options)
{
    if ((unsigned)options->format >= LUM_FORMATS) {
        return NULL;
    }
    return options->format == LUM_FORMAT_PNG && options->picture != NULL
               ? options->picture
               : formats[options->format];
}

int lum_format_from_name(const char *name, lum_format *out)
{
    const char *slash = strrchr(name, '/');
    const char *ending = strrchr(slash != NULL ? slash : name, '.');
    if (ending == NULL) {
        return -1;
    }
    for (int i = 0; i < LUM_FORMATS; i++) {
        if (strcasecmp(ending, formats[i]->ending) == 0) {
            *out = (lum_format)i;
            return 0;
        }
    }
    return -1;
}

bool lum_format_needs_count(lum_format format)
{
    return (unsigned)format < LUM_FORMATS && formats[format]->count_in_header;
}

bool lum_format_has_columns(lum_format format)
{
    return (unsigned)format < LUM_FORMATS && formats[format]->columns != NULL;
}

bool lum_format_has_frames(lum_format format)
{
    return (unsigned)format < LUM_FORMATS &&
           formats[format]->begin_frame != NULL;
}

bool lum_format_has_parts(lum_format format)
{
    return (unsigned)format < LUM_FORMATS && formats[format]->has_parts;
}

/* Whether names with commas between them have one of a column. */
static bool has_name(const char *names, lum_file_column column)
{
    const char *name = lum_file_column_specs[column].name;
    const size_t len = strlen(name);
    const char *p = names;
    size_t n = strcspn(p, ",");
    while ((n != len || strncmp(p, name, n) != 0) && p[n] != '\0') {
        p += n + 1u;
        n = strcspn(p, ",");
    }
    return n == len && strncmp(p, name, n) == 0;
}

unsigned lum_format_leaves(lum_format format, const char *columns)
{
    if (format == LUM_FORMAT_XYZ) {
        return LUM_LEAVE_ALL;
    }
    if (columns == NULL || !lum_format_has_columns(format)) {
        return 0;
    }
    const bool has_degrees = has_name(columns, LUM_FILE_AZIMUTH) ||
                             has_name(columns, LUM_FILE_ELEVATION);
    const bool has_returns = has_name(columns, LUM_FILE_PULSE_WIDTH) ||
                             has_name(columns, LUM_FILE_RETURN_NUMBER) ||
                             has_name(columns, LUM_FILE_NUMBER_OF_RETURNS);
    return (has_degrees ? 0 : LUM_LEAVE_DEGREES) |
           (has_returns ? 0 : LUM_LEAVE_RETURNS);
}

bool lum_format_has_presets(lum_format format)
{
    return lum_format_has_columns(format) || format == LUM_FORMAT_MCAP;
}

bool lum_format_has_voxels(lum_format format)
{
    return lum_format_has_columns(format) || format == LUM_FORMAT_LAS;
}
