/** @file
 * Bytes on their way to the disk, so that a later fsync() has less to wait for.
 * Internal. */
#ifndef LUM_BASE_WRITEBACK_H
#define LUM_BASE_WRITEBACK_H

/** Have the system begin to write what a file was given; does not wait for it.
 * Where the system has no such call, nothing happens. */
void lum_writeback_begin(int fd);

#endif
