/** @file
 * When bytes of a file go to the disk, and how long they stay in memory.
 * Internal. */
#ifndef LUM_BASE_WRITEBACK_H
#define LUM_BASE_WRITEBACK_H

#include <stdint.h>

/** Let the system start to write a file's bytes to the disk, without waiting.
 * On a system without such a call nothing happens. */
void lum_writeback_begin(int fd);

/** Let the system reuse the memory of a file's first bytes, as far as they are
 * on the disk. On a system without such a call nothing happens. */
void lum_writeback_forget(int fd, uint64_t bytes);

#endif
