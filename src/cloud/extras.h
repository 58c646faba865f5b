/** @file
 * Columns of the caller's own, behind those of a format: their names and types,
 * checked. Internal to cloud. */
#ifndef LUM_CLOUD_EXTRAS_H
#define LUM_CLOUD_EXTRAS_H

#include "numbers.h"

#include "lum/base/error.h"
#include "lum/cloud/writer.h"

/** Some columns; all 0 is none. */
typedef struct lum_extras {
    uint8_t count;                      /**< how many */
    uint8_t type[LUM_WRITER_EXTRA_MAX]; /**< each a ::lum_number_type */
    char name[LUM_WRITER_EXTRA_MAX]
             [LUM_WRITER_EXTRA_NAME_MAX + 1u]; /**< of each */
} lum_extras;

/** Check and copy columns.
 * @param format of the file; LUM_FORMATS: of any.
 * @return 0, or -1 with what is wrong in error. */
LUM_MUST_CHECK int lum_extras_take(lum_extras *out, lum_format format,
                                   const lum_writer_extra *extra, size_t count,
                                   lum_error *error);

/** Bytes of all of a point. */
size_t lum_extras_bytes(const lum_extras *extras);

/** Whether n points, one at least, have the same values. */
bool lum_extras_are_same(const lum_extras *extras, const void *const *values,
                         size_t n);

/** Room that all values of a point take as text. */
#define LUM_EXTRAS_ROOM (LUM_WRITER_EXTRA_MAX * (LUM_NUMBER_ROOM + 1u))

/** Write the first values of all as text, each behind a separator.
 * @param p has LUM_EXTRAS_ROOM bytes.
 * @return the end of them. */
char *lum_extras_print(char *p, const lum_extras *extras,
                       const void *const *values, char separator);

/** Write the i-th values of all, little-endian and without gaps.
 * @return the end of them. */
unsigned char *lum_extras_put(unsigned char *p, const lum_extras *extras,
                              const void *const *values, size_t i);

#endif
