/* What descriptors stand for: files of a disk, pipes, terminals, sockets. Each
 * kind has its functions; the calls of a process (file_calls.c) find them here.
 */
#ifndef WORLD_FILE_H
#define WORLD_FILE_H

#include <poll.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/types.h>

struct world_queue;
struct world_process;
typedef struct world_file world_file;

/* Functions of a kind return as the system's calls do: -1 and errno. A function
 * that is NULL: the call is refused with the errno that Linux gives. They run
 * in a task of the process, which may wait (world_wait) unless the file is
 * non-blocking. */
typedef struct world_file_kind {
    const char *name; /* for the trace: "file", "pipe", "udp", ... */
    ssize_t (*read)(world_file *file, void *out, size_t size);
    ssize_t (*write)(world_file *file, const void *bytes, size_t size);
    ssize_t (*pread)(world_file *file, void *out, size_t size, int64_t at);
    ssize_t (*pwrite)(world_file *file, const void *bytes, size_t size,
                      int64_t at);
    int64_t (*seek)(world_file *file, int64_t offset, int whence);
    int (*sync)(world_file *file);
    int (*truncate)(world_file *file, int64_t size);
    int (*stat)(world_file *file, struct stat *out);
    /* Events of poll() that are true now: POLLIN, POLLOUT, POLLERR, POLLHUP. */
    short (*poll)(world_file *file);
    int (*ioctl)(world_file *file, unsigned long request, void *argument);
    /* Sockets. */
    int (*bind)(world_file *file, const struct sockaddr *address,
                socklen_t size);
    int (*connect)(world_file *file, const struct sockaddr *address,
                   socklen_t size);
    int (*listen)(world_file *file, int backlog);
    int (*getsockname)(world_file *file, struct sockaddr *out, socklen_t *size);
    int (*setsockopt)(world_file *file, int level, int name, const void *value,
                      socklen_t size);
    int (*getsockopt)(world_file *file, int level, int name, void *value,
                      socklen_t *size);
    ssize_t (*sendmsg)(world_file *file, const struct msghdr *message,
                       int flags);
    ssize_t (*recvmsg)(world_file *file, struct msghdr *message, int flags);
    /* Each close() of a descriptor, before its use is dropped: 0, or -1 and
     * errno. */
    int (*flush)(world_file *file);
    /* A new file of the same thing, as an open() of /dev/fd/N makes it; NULL
     * and errno. */
    world_file *(*reopen)(world_file *file, int flags);
    /* What a link in /proc/PID/fd says; without it "name:[number]". */
    void (*path)(const world_file *file, char *out, size_t room);
    /* The last use is gone: free what the kind holds, not the file itself. */
    void (*close)(world_file *file);
} world_file_kind;

struct world_file {
    const world_file_kind *kind;
    unsigned uses;
    int flags;                   /* O_ACCMODE, O_NONBLOCK, O_APPEND */
    uint64_t number;             /* of the world, for traces and /proc */
    struct world_queue *changed; /* woken when poll() may give more */
    void *data;                  /* the kind's */
};

/* A file with one use. */
world_file *world_file_new(const world_file_kind *kind, int flags, void *data);
world_file *world_file_use(world_file *file);
void world_file_drop(world_file *file);
static inline bool world_file_waits(const world_file *file);

/* The lowest free descriptor of a process takes over a use; -1 and EMFILE, and
 * the use is dropped. */
int world_fd_take(struct world_process *process, world_file *file, int flags);
/* NULL and EBADF. */
world_file *world_fd_file(struct world_process *process, int fd);
/* After its tasks were dropped. */
void world_fd_close_all(struct world_process *process);

/* The file of a descriptor of the process that runs; NULL and EBADF. Another
 * task may close the descriptor while a call waits: the file stays until it is
 * released, or the process has ended. */
world_file *world_fd_hold(int fd);
/* The same for a file that has no descriptor yet. */
void world_file_hold(world_file *file);
void world_fd_release(world_file *file);

/* Drops all that is left, from one world to the next. */
void world_file_reset(void);

#include <fcntl.h>
static inline bool world_file_waits(const world_file *file)
{
    return (file->flags & O_NONBLOCK) == 0;
}

#endif
