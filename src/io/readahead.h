/** @file
 * A file read by a thread, ahead of who wants it. Internal to the io layer.
 *
 * The kernel's copy out of the page cache is a third of the time of a summary;
 * so it runs beside the decoding. Only for regular files: reading them cannot
 * wait for somebody, so a signal finds the caller awake. */
#ifndef LUM_IO_READAHEAD_H
#define LUM_IO_READAHEAD_H

#include <stdio.h>

/** Open a stream that is read ahead; fclose() ends the thread and closes fd.
 * @param fd a regular file, taken over on success.
 * @return the stream; NULL where the system has no such streams or no memory:
 *         then fd is untouched, and is to be read as any file. */
FILE *lum_readahead_open(int fd);

#endif
