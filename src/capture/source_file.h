/* Files of the system, as a source reads them. */
#ifndef LUM_CAPTURE_SOURCE_FILE_H
#define LUM_CAPTURE_SOURCE_FILE_H

#include "lum/base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A descriptor, or -1 with the reason in errno. "-" is standard input, read
 * through a separate descriptor, so that closing it has no effect on others. On
 * Linux it does not wait for the writer of a pipe: reading does. */
int lum_source_file_open(const char *path);

/* Some bytes; 0 at the end; -1 with the reason in error. A signal ends the
 * waiting: the caller decides what it means. */
int64_t lum_source_file_read(int fd, void *buffer, size_t room,
                             lum_error *error);

/* The same, of a regular file, from a place that no other process moves. */
int64_t lum_source_file_read_at(int fd, uint64_t offset, void *buffer,
                                size_t room, lum_error *error);

/* Whether there is something to read, or a failure to be told; false: not in
 * this time. A signal ends the waiting. */
bool lum_source_file_wait(int fd, int ms);

/* Of a regular file; 0: not known. */
uint64_t lum_source_file_bytes(int fd);

/* 0, or -1 with the reason in error. */
int lum_source_file_seek(int fd, uint64_t offset, lum_error *error);

void lum_source_file_close(int fd);

#endif
