/** @file
 * Starts writing bytes to the disk early, so that a later fsync() waits less.
 * Internal. */
#ifndef LUM_BASE_WRITEBACK_H
#define LUM_BASE_WRITEBACK_H

/** Let the system start to write a file's bytes to the disk, without waiting.
 * On a system without such a call nothing happens. */
void lum_writeback_begin(int fd);

#endif
