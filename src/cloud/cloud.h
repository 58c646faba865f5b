/** @file
 * What PLY and PCD have in common: their columns, rows in binary and in ascii,
 * and a header that is written again, at the same length, once the count is
 * known. Internal to cloud. */
#ifndef LUM_CLOUD_CLOUD_H
#define LUM_CLOUD_CLOUD_H

#include "lum/base/error.h"
#include "writer_internal.h"

/** One column. */
typedef struct lum_cloud_column {
    const char *name;     /**< without prefix */
    const char *ply_type; /**< as PLY names it */
    char pcd_type;        /**< as PCD names it: F, I or U */
    unsigned bytes;       /**< in binary */
} lum_cloud_column;

#define LUM_CLOUD_COLUMNS 15u /**< how many there are */
#define LUM_CLOUD_PLAIN   4u  /**< x y z intensity: these come first */

/** In the order of a row. */
extern const lum_cloud_column lum_cloud_columns[LUM_CLOUD_COLUMNS];

/** The text of a header. */
typedef struct lum_cloud_text {
    char *at;    /**< its NUL included */
    size_t len;  /**< bytes without it */
    size_t room; /**< bytes with it */
} lum_cloud_text;

/** Append a header to a text.
 * @param padding characters that some comment has to be longer. */
typedef void lum_cloud_header(lum_cloud_text *out,
                              const lum_writer_options *options, uint64_t count,
                              int padding);

/** Append to a text as printf does. */
LUM_PRINTF(2, 3)
void lum_cloud_print(lum_cloud_text *out, const char *format, ...);

/** Append the lines of the options' comment, each behind a prefix of at most 8
 * bytes. */
void lum_cloud_print_comment(lum_cloud_text *out,
                             const lum_writer_options *options,
                             const char *prefix);

/** Words that say what timestamps count. */
const char *lum_cloud_time_base(const lum_writer_options *options);

/** Write the header, with the count if it is known.
 * @param mentions how many times it holds the count. */
LUM_MUST_CHECK int lum_cloud_begin(lum_writer *writer, lum_cloud_header *header,
                                   unsigned mentions, lum_error *error);

/** Write a line's rows. */
LUM_MUST_CHECK int lum_cloud_add(lum_writer *writer,
                                 const lum_line_samples *line,
                                 lum_error *error);

/** Write the header again, if the count was not known. As lum_cloud_begin(). */
LUM_MUST_CHECK int lum_cloud_finish(lum_writer *writer,
                                    lum_cloud_header *header, unsigned mentions,
                                    lum_error *error);

#endif
