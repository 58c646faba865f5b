/** @file
 * The columns that CSV, PLY and PCD files may have: one table, lists of them,
 * and rows of any list. Rows of the default lists of the formats are written by
 * faster code elsewhere. Internal to cloud. */
#ifndef LUM_CLOUD_FILE_COLUMNS_H
#define LUM_CLOUD_FILE_COLUMNS_H

#include "extras.h"

#include "lum/base/error.h"
#include "lum/cloud/writer.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** What a file can contain of a point. */
typedef enum lum_file_column {
    LUM_FILE_X,
    LUM_FILE_Y,
    LUM_FILE_Z,
    LUM_FILE_RANGE,
    LUM_FILE_AZIMUTH,
    LUM_FILE_ELEVATION,
    LUM_FILE_PULSE_WIDTH,
    LUM_FILE_TIMESTAMP,
    LUM_FILE_FRAME,
    LUM_FILE_EYE,
    LUM_FILE_LINE,
    LUM_FILE_PIXEL,
    LUM_FILE_RETURN_NUMBER,
    LUM_FILE_NUMBER_OF_RETURNS,
    LUM_FILE_EDGE,
    LUM_FILE_TIME,
    LUM_FILE_COLUMNS /**< how many there are */
} lum_file_column;

/** Name and type of a column. */
typedef struct lum_file_column_spec {
    const char *name;       /**< in CSV and in options */
    const char *cloud_name; /**< in PCD, and in PLY after its prefix */
    const char *ply_type;   /**< its name in PLY */
    char pcd_type;          /**< its name in PCD: F, I or U */
    uint8_t bytes;          /**< in binary */
    bool is_plain;          /**< no prefix in PLY */
} lum_file_column_spec;

/** By ::lum_file_column. */
extern const lum_file_column_spec lum_file_column_specs[LUM_FILE_COLUMNS];

/** Most columns of a file. */
#define LUM_FILE_COLUMNS_MAX (LUM_FILE_COLUMNS + LUM_WRITER_EXTRA_MAX)

/** Some columns in their order, none twice. */
typedef struct lum_column_list {
    uint8_t count;                    /**< how many */
    uint8_t at[LUM_FILE_COLUMNS_MAX]; /**< each a ::lum_file_column, or
                                           LUM_FILE_COLUMNS plus the place of
                                           an extra one */
} lum_column_list;

/** The default lists of CSV, and of PLY and PCD. */
extern const lum_column_list lum_csv_columns, lum_cloud_columns;

/** Read names with commas between them, also of extra columns.
 * @return 0, or -1 with what is wrong in error. */
LUM_MUST_CHECK int lum_column_list_read(const char *names,
                                        const lum_extras *extras,
                                        lum_column_list *out, lum_error *error);

/** Append all extra columns. */
void lum_column_list_append(lum_column_list *list, const lum_extras *extras);

/** Whether it has a column. */
bool lum_column_list_has(const lum_column_list *list, lum_file_column column);

/** Room that a row of any list takes at most, as text or in binary. */
#define LUM_FILE_ROW_ROOM                                                      \
    (1024u + LUM_WRITER_EXTRA_MAX * (LUM_NUMBER_ROOM + 1u))

/** Rows of a line. */
typedef struct lum_file_rows {
    const lum_column_list *columns; /**< which */
    char separator;                 /**< between them, in text */
    const lum_sample *samples;      /**< of the line, its first */
    const float *times;             /**< likewise; NULL: not requested */
    const lum_extras *extras;       /**< of the file */
    const void *const *extra;       /**< their values */
    size_t row_bytes;               /**< of a row in binary */
    char text[4][24];               /**< of the columns of the line itself */
    uint8_t text_bytes[4];          /**< of those */
    unsigned char bytes[4][8];      /**< the same in binary */
} lum_file_rows;

/** Begin a line. */
void lum_file_rows_begin(lum_file_rows *rows, const lum_column_list *columns,
                         const lum_extras *extras, const lum_line_samples *line,
                         char separator);

/** Write rows of n samples as text; a lum_put_rows of writer_internal.h.
 * @param context a lum_file_rows; samples are of its line. */
char *lum_file_rows_put_text(char *p, void *context, const lum_sample *samples,
                             size_t n);

/** The same in binary, little-endian and without padding. */
char *lum_file_rows_put_binary(char *p, void *context,
                               const lum_sample *samples, size_t n);

#endif
