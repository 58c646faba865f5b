/* Calls of processes on descriptors. */
#ifndef WORLD_FILE_CALLS_H
#define WORLD_FILE_CALLS_H

#include <poll.h>
#include <signal.h>
#include <stdint.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/types.h>
#include <sys/vfs.h>
#include <time.h>

ssize_t world_call_read(int fd, void *out, size_t size);
ssize_t world_call_write(int fd, const void *bytes, size_t size);
ssize_t world_call_pread64(int fd, void *out, size_t size, int64_t at);
ssize_t world_call_pwrite64(int fd, const void *bytes, size_t size, int64_t at);
int64_t world_call_lseek64(int fd, int64_t offset, int whence);
int world_call_close(int fd);
int world_call_dup(int fd);
int world_call_dup2(int from, int to);
int world_call_fcntl64(int fd, int command, ...);
int world_call_ioctl(int fd, unsigned long request, ...);
int world_call_pipe(int ends[2]);
int world_call_pipe2(int ends[2], int flags);
int world_call_fstat64(int fd, struct stat *out);
int world_call_fsync(int fd);
int world_call_fdatasync(int fd);
int world_call_sync_file_range(int fd, int64_t offset, int64_t size,
                               unsigned flags);
int world_call_posix_fadvise64(int fd, int64_t offset, int64_t size,
                               int advice);
int world_call_fstatfs64(int fd, struct statfs *status);
int world_call_statvfs64(const char *path, struct statvfs *out);
int world_call_fallocate64(int fd, int mode, int64_t offset, int64_t size);
int world_call_ftruncate64(int fd, int64_t size);
int world_call_isatty(int fd);
pid_t world_call_tcgetpgrp(int fd);
int world_call_tcsetpgrp(int fd, pid_t group);
int world_call_poll(struct pollfd *set, nfds_t count, int wait_ms);
int world_call_ppoll(struct pollfd *set, nfds_t count,
                     const struct timespec *wait, const sigset_t *mask);

#endif
