/** @file
 * What makes writing quicker. A large file's bytes go to the disk early, so
 * that a later fsync() waits less, and their places there are chosen many at a
 * time; and how long they stay in memory. A pipe takes many bytes at a time.
 * Internal. */
#ifndef LUM_BASE_WRITEBACK_H
#define LUM_BASE_WRITEBACK_H

#include <stdbool.h>
#include <stdint.h>

/** Let the system start to write a file's bytes to the disk, without waiting.
 * On a system without such a call nothing happens. */
void lum_writeback_begin(int fd);

/** Let the system reuse the memory of a file's first bytes, as far as they are
 * on the disk. On a system without such a call nothing happens. */
void lum_writeback_forget(int fd, int64_t bytes);

/** Whether n bytes of places on the disk, reserved, make writing quicker and
 * nobody miss them: on ext4 each write() would look for places itself, and
 * there is room for many times as much. */
bool lum_writeback_can_reserve(int fd, int64_t n);

/** Reserve places for n bytes from an offset on; the file's size stays. What is
 * not used goes back by ftruncate() to its size.
 * @return whether there were places. */
bool lum_writeback_reserve(int fd, int64_t from, int64_t n);

/** Open a pipe again, so that a write takes what there is room for and does not
 * wait, and make more room in it. Others that hold the pipe do not notice:
 * their writes wait as before.
 * @return a second descriptor; -1: it is no pipe, or the system cannot. */
int lum_writeback_open_pipe(int fd);

#endif
