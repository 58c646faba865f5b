/* Calls of processes on names: files, folders, links. */
#ifndef WORLD_DISK_CALLS_H
#define WORLD_DISK_CALLS_H

#include <dirent.h>
#include <sys/stat.h>
#include <sys/types.h>

int world_call_open64(const char *path, int flags, ...);
int world_call_mkstemp64(char *path);
char *world_call_mkdtemp(char *path);
/* A descriptor of a file without a name. */
int world_call_tmpfile_fd(void);
int world_call_stat64(const char *path, struct stat *out);
int world_call_lstat64(const char *path, struct stat *out);
int world_call_access(const char *path, int rights);
int world_call_mkdir(const char *path, mode_t mode);
int world_call_rmdir(const char *path);
int world_call_rename(const char *from, const char *to);
int world_call_linkat(int from_fd, const char *from, int to_fd, const char *to,
                      int flags);
int world_call_unlink(const char *path);
ssize_t world_call_readlink(const char *path, char *out, size_t room);
ssize_t world_call_readlinkat(int fd, const char *path, char *out, size_t room);
char *world_call_realpath(const char *path, char *out);
int world_call_fchmod(int fd, mode_t mode);
int world_call_fchown(int fd, uid_t owner, gid_t group);
int world_call_flock(int fd, int operation);
DIR *world_call_opendir(const char *path);
struct dirent *world_call_readdir64(DIR *folder);
int world_call_dirfd(DIR *folder);
int world_call_closedir(DIR *folder);

#endif
