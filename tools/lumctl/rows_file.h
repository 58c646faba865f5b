/* A file to which several runs add lines. */
#ifndef LUMCTL_ROWS_FILE_H
#define LUMCTL_ROWS_FILE_H

#include <stddef.h>

/* Opens it to read it and to write at its end, and makes it where there is
 * none. Until close() other runs are kept out. -1 with the reason in errno:
 * EBUSY if another run adds lines just now. */
int rows_file_open(const char *path);

/* Writes all of a text to any file that is open. 0, or -1 with the reason in
 * errno. */
int rows_file_put(int fd, const char *text, size_t len);

/* Cuts it off. 0, or -1. */
int rows_file_cut(int fd, long long size);

#endif
