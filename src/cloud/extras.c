#include "extras.h"

#include "file_columns.h"
#include "formats.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

/* --- Names --- */

#define LETTERS "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_"
#define DIGITS  "0123456789"

/* Names that files of a format have beside those of lum_file_column_specs: LAS
 * by those that its readers give to the fields of a point. */
static const char *const of_las[] = {"X",
                                     "Y",
                                     "Z",
                                     "synthetic",
                                     "key_point",
                                     "withheld",
                                     "overlap",
                                     "scanner_channel",
                                     "scan_direction_flag",
                                     "edge_of_flight_line",
                                     "classification",
                                     "user_data",
                                     "scan_angle",
                                     "point_source_id",
                                     "gps_time",
                                     "full_return_number",
                                     "full_number_of_returns",
                                     "return_num",
                                     "num_returns",
                                     "scan_dir_flag",
                                     "edge_flight_line",
                                     "pt_src_id",
                                     "flag_byte",
                                     NULL};
static const char *const of_messages[] = {"ring", "return", NULL};

static bool is_one_of(const char *name, const char *const *names)
{
    while (*names != NULL && strcmp(*names, name) != 0) {
        names++;
    }
    return *names != NULL;
}

static bool is_taken(lum_format format, const char *name)
{
    for (unsigned i = 0; i < LUM_FILE_COLUMNS; i++) {
        if (strcmp(lum_file_column_specs[i].name, name) == 0 ||
            strcmp(lum_file_column_specs[i].cloud_name, name) == 0) {
            return true;
        }
    }
    return (format == LUM_FORMAT_LAS && is_one_of(name, of_las)) ||
           (format == LUM_FORMAT_MCAP && is_one_of(name, of_messages));
}

static int check_name(const lum_extras *before, lum_format format,
                      const char *name, lum_error *error)
{
    const size_t n = strlen(name);
    if (n == 0 || n > LUM_WRITER_EXTRA_NAME_MAX ||
        strspn(name, LETTERS DIGITS) != n || strspn(name, LETTERS) == 0) {
        return lum_error_set(
            error,
            "'%.40s' cannot be the name of a column; use 1 to %u ASCII "
            "letters, digits and _, not a digit first",
            name, LUM_WRITER_EXTRA_NAME_MAX);
    }
    if (is_taken(format, name)) {
        return lum_error_set(error,
                             "the column %s is one of the format's own; give "
                             "yours another name",
                             name);
    }
    for (unsigned i = 0; i < before->count; i++) {
        if (strcmp(before->name[i], name) == 0) {
            return lum_error_set(error, "two columns have the name %s", name);
        }
    }
    return 0;
}

/* --- Types --- */

static bool has_type(lum_format format, const lum_number_spec *type)
{
    return format == LUM_FORMAT_PLY || format == LUM_FORMAT_PCD
               ? type->pcd != '\0'
           : format == LUM_FORMAT_MCAP ? type->ros != 0
                                       : true;
}

static int check_type(lum_format format, const lum_writer_extra *extra,
                      lum_error *error)
{
    if ((unsigned)extra->type >= LUM_NUMBER_TYPES) {
        return lum_error_set(
            error, "the column %s is of type %d; 0 to %d are known",
            extra->name, (int)extra->type, LUM_NUMBER_TYPES - 1);
    }
    if (!has_type(format, &lum_number_types[extra->type])) {
        return lum_error_set(
            error,
            "the column %s has 64-bit integers, which this format lacks; use "
            "32-bit integers or float64, or write csv or las",
            extra->name);
    }
    return 0;
}

/* --- All of them --- */

static bool has_extras(lum_format format)
{
    return format == LUM_FORMATS || lum_format_has_columns(format) ||
           format == LUM_FORMAT_LAS || format == LUM_FORMAT_MCAP ||
           format == LUM_FORMAT_PNG;
}

static int take(lum_extras *out, lum_format format,
                const lum_writer_extra *extra, size_t count, lum_error *error)
{
    if (count > 0 && !has_extras(format)) {
        return lum_error_set(error, "this format takes no extra columns; csv, "
                                    "ply, pcd, las and mcap do");
    }
    if (count > LUM_WRITER_EXTRA_MAX) {
        return lum_error_set(error, "%zu extra columns; at most %u", count,
                             LUM_WRITER_EXTRA_MAX);
    }
    for (size_t i = 0; i < count; i++) {
        if (check_name(out, format, extra[i].name, error) != 0 ||
            check_type(format, &extra[i], error) != 0) {
            return -1;
        }
        (void)snprintf(out->name[i], sizeof out->name[i], "%s", extra[i].name);
        out->type[i] = (uint8_t)extra[i].type;
        out->count++;
    }
    return 0;
}

int lum_extras_take(lum_extras *out, lum_format format,
                    const lum_writer_extra *extra, size_t count,
                    lum_error *error)
{
    *out = (lum_extras){0};
    if (take(out, format, extra, count, error) != 0) {
        errno = EINVAL;
        return -1;
    }
    return 0;
}

int lum_writer_check_extra(lum_format format, const char *columns,
                           const lum_writer_extra *extra, size_t count,
                           lum_error *error)
{
    lum_extras extras;
    lum_column_list list;
    if (lum_extras_take(&extras, format, extra, count, error) != 0) {
        return -1;
    }
    return columns == NULL
               ? 0
               : lum_column_list_read(columns, &extras, &list, error);
}

int lum_writer_check_columns(const char *names, lum_error *error)
{
    return lum_writer_check_extra(LUM_FORMATS, names, NULL, 0, error);
}

/* --- Values --- */

size_t lum_extras_bytes(const lum_extras *extras)
{
    size_t n = 0;
    for (unsigned i = 0; i < extras->count; i++) {
        n += lum_number_types[extras->type[i]].bytes;
    }
    return n;
}

bool lum_extras_are_same(const lum_extras *extras, const void *const *values,
                         size_t n)
{
    bool are_same = true;
    for (unsigned k = 0; k < extras->count && are_same; k++) {
        const unsigned char *first = values[k];
        const size_t bytes = lum_number_types[extras->type[k]].bytes;
        are_same = memcmp(first, first + bytes, bytes * (n - 1u)) == 0;
    }
    return are_same;
}

char *lum_extras_print(char *p, const lum_extras *extras,
                       const void *const *values, char separator)
{
    for (unsigned k = 0; k < extras->count; k++) {
        *p++ = separator;
        p = lum_number_print(p, (lum_number_type)extras->type[k], values[k], 0);
    }
    return p;
}

unsigned char *lum_extras_put(unsigned char *p, const lum_extras *extras,
                              const void *const *values, size_t i)
{
    for (unsigned k = 0; k < extras->count; k++) {
        p = lum_number_put(p, (lum_number_type)extras->type[k], values[k], i);
    }
    return p;
}
