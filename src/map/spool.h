/** @file
 * A temporary file without a name: what is written is appended, and read again
 * by its place. It is gone with the process, however that ends. Internal to
 * map. */
#ifndef LUM_MAP_SPOOL_H
#define LUM_MAP_SPOOL_H

#include "lum/result.h"

#include <stddef.h>
#include <stdint.h>

/** A spool. */
typedef struct lum_map_spool {
    int fd;        /**< -1: not made yet */
    uint64_t size; /**< bytes written */
} lum_map_spool;

/** Make it.
 * @param beside a name in the folder where it is to be.
 * @return 0, or an errno. */
LUM_MUST_CHECK int lum_map_spool_open(lum_map_spool *spool, const char *beside);

/** Append bytes.
 * @return 0, or an errno. */
LUM_MUST_CHECK int lum_map_spool_write(lum_map_spool *spool, const void *bytes,
                                       size_t n);

/** Read bytes that were written.
 * @return 0, or an errno. */
LUM_MUST_CHECK int lum_map_spool_read(const lum_map_spool *spool, uint64_t from,
                                      void *bytes, size_t n);

/** Close it, if it is open. errno stays. */
void lum_map_spool_close(lum_map_spool *spool);

#endif
