/** @file
 * Structs that tell their size, so that they may grow: the first member is
 * struct_size, which the caller sets to the sizeof that it was compiled with
 * (docs/internals/design.md). Internal. */
#ifndef LUM_BASE_SIZED_H
#define LUM_BASE_SIZED_H

#include "lum/base/error.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>

/** Take what a caller filled in, as far as it knows of it; the rest is 0.
 * @param out  size bytes, overwritten; its struct_size becomes size.
 * @param from of the caller's size.
 * @param what it is, for the message: "the framer's options".
 * @param type of the struct, likewise.
 * @return 0, or -1 where struct_size is not set; then errno is EINVAL. */
LUM_MUST_CHECK int lum_sized_take(void *out, size_t size, const void *from,
                                  const char *what, const char *type,
                                  lum_error *error);

/** Fill in what a caller asked for, as far as it knows of it.
 * @param out  its struct_size is read and stays.
 * @param from size bytes, with a struct_size too.
 * @return false where struct_size of out is not set: then nothing is written.
 */
bool lum_sized_fill(void *out, const void *from, size_t size);

#endif
