/* A file that several runs open, one at a time: to add lines to it, or as a
 * lock. */
#ifndef LUMCTL_ROWS_FILE_H
#define LUMCTL_ROWS_FILE_H

#include <stdbool.h>
#include <stddef.h>

/* Opens it to read it and to write at its end, and makes it where there is
 * none, for its user alone or for all. Until close() other runs are kept out,
 * where the file system has locks. -1 with the reason in errno: EBUSY if
 * another run has it open just now. */
int rows_file_open(const char *path, bool is_private);

/* Writes all of a text to any file that is open. 0, or -1 with the reason in
 * errno. */
int rows_file_put(int fd, const char *text, size_t len);

/* Cuts it off. 0, or -1. */
int rows_file_cut(int fd, long long size);

/* Gives a file the name of another, which it replaces. 0, or -1 with the reason
 * in errno. */
int rows_file_replace(const char *from, const char *to);

#endif
