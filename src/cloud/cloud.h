/** @file
 * What PLY and PCD have in common: rows in binary and in ascii,
 * and a header that is written again, at the same length, once the count is
 * known. Internal to cloud. */
#ifndef LUM_CLOUD_CLOUD_H
#define LUM_CLOUD_CLOUD_H

#include "lum/base/error.h"
#include "writer_internal.h"

/** Append to a text as printf does. */
LUM_PRINTF(2, 3)
void lum_cloud_print(lum_cloud_text *out, const char *format, ...);

/** Append the lines of the options' comment, each behind a prefix of at most 8
 * bytes. */
void lum_cloud_print_comment(lum_cloud_text *out,
                             const lum_writer_options *options,
                             const char *prefix);

/** Append what the columns are in, and a line's end. */
void lum_cloud_print_units(lum_cloud_text *out, const lum_writer *writer);

/** Write the format's header, with the count if it is known. */
LUM_MUST_CHECK int lum_cloud_begin(lum_writer *writer, lum_error *error);

/** Write a line's rows. */
LUM_MUST_CHECK int lum_cloud_add(lum_writer *writer,
                                 const lum_line_samples *line,
                                 lum_error *error);

/** Write the header again, if the count was not known. */
LUM_MUST_CHECK int lum_cloud_finish(lum_writer *writer, lum_error *error);

#endif
