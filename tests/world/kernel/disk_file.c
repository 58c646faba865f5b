#define _GNU_SOURCE /* POLLRDNORM */
#include "disk_internal.h"

#include "pipe_internal.h"
#include "task.h"
#include "trace.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

#define DEVICE      0x10u /* the number of the disk, for all hosts */
#define BLOCK_BYTES 512
#define NS_IN_A_S   INT64_C(1000000000)

/* A lock of a file by flock(). */
struct disk_lock {
    struct disk_lock *next;
    const world_file *file;
    bool is_shared;
};

/* An open file. */
struct open_file {
    disk_inode *inode; /* held */
    int64_t at;
    char *text; /* of one whose text is made */
    size_t len;
    bool was_written;
};

static int refuse(int code)
{
    errno = code;
    return -1;
}

static struct open_file *of(const world_file *file)
{
    return file->data;
}

static world_disk *disk_of(const world_file *file)
{
    return of(file)->inode->disk;
}

/* --- Locks --- */

static void unlock(const world_file *file, disk_inode *inode)
{
    for (struct disk_lock **at = &inode->locks; *at != NULL;
         at = &(*at)->next) {
        struct disk_lock *lock = *at;
        if (lock->file == file) {
            *at = lock->next;
            free(lock);
            world_wake_all(&inode->unlocked);
            return;
        }
    }
}

static bool is_free(const disk_inode *inode, const world_file *file,
                    bool is_shared)
{
    for (const struct disk_lock *i = inode->locks; i != NULL; i = i->next) {
        if (i->file != file && !(i->is_shared && is_shared)) {
            return false;
        }
    }
    return true;
}

static int lock(world_file *file, disk_inode *inode, bool is_shared, bool waits)
{
    while (!is_free(inode, file, is_shared)) {
        if (!waits) {
            return EWOULDBLOCK;
        }
        if (world_wait(&inode->unlocked, INT64_MAX) == WORLD_INTERRUPTED) {
            return EINTR;
        }
    }
    unlock(file, inode);
    struct disk_lock *made = malloc(sizeof *made);
    if (made == NULL) {
        abort();
    }
    *made = (struct disk_lock){inode->locks, file, is_shared};
    inode->locks = made;
    return 0;
}

int disk_lock(world_file *file, disk_inode *inode, int operation)
{
    const bool waits = (operation & LOCK_NB) == 0;
    switch (operation & ~LOCK_NB) {
    case LOCK_SH:
        return lock(file, inode, true, waits);
    case LOCK_EX:
        return lock(file, inode, false, waits);
    case LOCK_UN:
        unlock(file, inode);
        return 0;
    default:
        return EINVAL;
    }
}

/* --- Regular files --- */

static ssize_t read_at(world_file *file, void *out, size_t size, int64_t at)
{
    const int code = disk_pass(disk_of(file), WORLD_DISK_READ);
    if (S_ISDIR(of(file)->inode->mode)) {
        return refuse(EISDIR);
    }
    return code != 0 ? refuse(code)
                     : (ssize_t)disk_read_at(of(file)->inode, out, size, at);
}

static ssize_t read_file(world_file *file, void *out, size_t size)
{
    const ssize_t n = read_at(file, out, size, of(file)->at);
    of(file)->at += n > 0 ? n : 0;
    return n;
}

static ssize_t write_at(world_file *file, const void *bytes, size_t size,
                        int64_t at)
{
    const int code = disk_pass(disk_of(file), WORLD_DISK_WRITE);
    if (code != 0) {
        return refuse(code);
    }
    const size_t n = disk_write_at(of(file)->inode, bytes, size, at);
    of(file)->was_written = true;
    return n == 0 && size > 0 ? refuse(ENOSPC) : (ssize_t)n;
}

static ssize_t write_file(world_file *file, const void *bytes, size_t size)
{
    struct open_file *f = of(file);
    const bool appends = (file->flags & O_APPEND) != 0;
    const ssize_t n =
        write_at(file, bytes, size, appends ? f->inode->size : f->at);
    if (n > 0) {
        f->at = appends ? f->inode->size : f->at + n;
    }
    return n;
}

/* As Linux: bytes are appended wherever they were meant to go. */
static ssize_t pwrite_file(world_file *file, const void *bytes, size_t size,
                           int64_t at)
{
    const bool appends = (file->flags & O_APPEND) != 0;
    return write_at(file, bytes, size, appends ? of(file)->inode->size : at);
}

static int64_t seek_within(world_file *file, int64_t size, int64_t offset,
                           int whence)
{
    struct open_file *f = of(file);
    const int64_t from = whence == SEEK_SET   ? 0
                         : whence == SEEK_CUR ? f->at
                         : whence == SEEK_END ? size
                                              : -1;
    if (from < 0 || offset < -from) {
        return refuse(EINVAL);
    }
    f->at = from + offset;
    return f->at;
}

static int64_t seek_file(world_file *file, int64_t offset, int whence)
{
    return seek_within(file, of(file)->inode->size, offset, whence);
}

static int sync_file(world_file *file)
{
    disk_inode *inode = of(file)->inode;
    const int code = disk_pass(inode->disk, WORLD_DISK_SYNC);
    if (code != 0) {
        disk_lose_bytes(inode);
        return refuse(code);
    }
    disk_sync_bytes(inode);
    if (S_ISDIR(inode->mode)) {
        disk_sync_names(inode->disk, inode);
    }
    WORLD_TRACE("inode %llu is synced", (unsigned long long)inode->number);
    return 0;
}

static int truncate_file(world_file *file, int64_t size)
{
    const int code = disk_pass(disk_of(file), WORLD_DISK_WRITE);
    const int result = code != 0 ? code : disk_set_size(of(file)->inode, size);
    of(file)->was_written = true;
    return result == 0 ? 0 : refuse(result);
}

static int stat_file(world_file *file, struct stat *out)
{
    disk_stat(of(file)->inode, out);
    return 0;
}

static short poll_file(world_file *file)
{
    (void)file;
    return POLLIN | POLLOUT | POLLRDNORM | POLLWRNORM;
}

/* Network disks tell so that what was written did not come to them. */
static int flush_file(world_file *file)
{
    const int code =
        of(file)->was_written ? disk_pass(disk_of(file), WORLD_DISK_CLOSE) : 0;
    return code == 0 ? 0 : refuse(code);
}

static world_file *reopen_file(world_file *file, int flags)
{
    return disk_file_new(of(file)->inode, flags);
}

static void path_of_file(const world_file *file, char *out, size_t room)
{
    const disk_inode *inode = of(file)->inode;
    (void)snprintf(out, room, "/inode/%llu", (unsigned long long)inode->number);
}

static void close_file(world_file *file)
{
    struct open_file *f = of(file);
    unlock(file, f->inode);
    f->inode->opens--;
    disk_settle_room(f->inode);
    disk_inode_drop(f->inode);
    free(f->text);
    free(f);
}

static const world_file_kind regular = {
    .name = "file",
    .read = read_file,
    .write = write_file,
    .pread = read_at,
    .pwrite = pwrite_file,
    .seek = seek_file,
    .sync = sync_file,
    .truncate = truncate_file,
    .stat = stat_file,
    .poll = poll_file,
    .flush = flush_file,
    .reopen = reopen_file,
    .path = path_of_file,
    .close = close_file,
};

/* --- Files without a disk: /dev/null, and texts that are made --- */

static ssize_t read_text(world_file *file, void *out, size_t size)
{
    struct open_file *f = of(file);
    const size_t left = f->at < (int64_t)f->len ? f->len - (size_t)f->at : 0;
    const size_t n = left < size ? left : size;
    if (n > 0) {
        memcpy(out, f->text + f->at, n);
        f->at += (int64_t)n;
    }
    return (ssize_t)n;
}

static ssize_t pread_text(world_file *file, void *out, size_t size, int64_t at)
{
    struct open_file *f = of(file);
    const int64_t kept = f->at;
    f->at = at;
    const ssize_t n = read_text(file, out, size);
    f->at = kept;
    return n;
}

static ssize_t write_null(world_file *file, const void *bytes, size_t size)
{
    (void)file;
    (void)bytes;
    return (ssize_t)size;
}

static ssize_t pwrite_null(world_file *file, const void *bytes, size_t size,
                           int64_t at)
{
    (void)at;
    return write_null(file, bytes, size);
}

static ssize_t write_full(world_file *file, const void *bytes, size_t size)
{
    (void)file;
    (void)bytes;
    return size == 0 ? 0 : refuse(ENOSPC);
}

static ssize_t pwrite_full(world_file *file, const void *bytes, size_t size,
                           int64_t at)
{
    (void)at;
    return write_full(file, bytes, size);
}

static int64_t seek_text(world_file *file, int64_t offset, int whence)
{
    return seek_within(file, (int64_t)of(file)->len, offset, whence);
}

/* Any position of a device is its first. */
static int64_t seek_null(world_file *file, int64_t offset, int whence)
{
    (void)file;
    (void)offset;
    (void)whence;
    return 0;
}

static const world_file_kind null_device = {
    .name = "null",
    .read = read_text, /* its text is empty */
    .write = write_null,
    .pread = pread_text,
    .pwrite = pwrite_null,
    .seek = seek_null,
    .stat = stat_file,
    .poll = poll_file,
    .reopen = reopen_file,
    .path = path_of_file,
    .close = close_file,
};

static const world_file_kind full_device = {
    .name = "full",
    .read = read_text,
    .write = write_full,
    .pread = pread_text,
    .pwrite = pwrite_full,
    .seek = seek_null,
    .stat = stat_file,
    .poll = poll_file,
    .reopen = reopen_file,
    .path = path_of_file,
    .close = close_file,
};

static const world_file_kind made_text = {
    .name = "text",
    .read = read_text,
    .pread = pread_text,
    .seek = seek_text,
    .stat = stat_file,
    .poll = poll_file,
    .reopen = reopen_file,
    .path = path_of_file,
    .close = close_file,
};

/* --- Opening --- */

static const world_file_kind *kind_of(const disk_inode *inode)
{
    return inode->magic == DISK_NULL   ? &null_device
           : inode->magic == DISK_FULL ? &full_device
           : inode->magic == DISK_TEXT || inode->magic == DISK_COMM ? &made_text
                                                                    : &regular;
}

world_file *disk_file_new(disk_inode *inode, int flags)
{
    if (S_ISFIFO(inode->mode)) {
        return pipe_open_fifo(inode, flags);
    }
    struct open_file *f = calloc(1, sizeof *f);
    if (f == NULL) {
        abort();
    }
    f->inode = disk_inode_use(inode);
    inode->opens++;
    disk_settle_room(inode);
    if (kind_of(inode) == &made_text) {
        f->text = disk_proc_text(inode);
        f->len = strlen(f->text);
    }
    return world_file_new(kind_of(inode), flags, f);
}

disk_inode *disk_file_inode(const world_file *file)
{
    const bool is_ours = file->kind == &regular || file->kind == &made_text ||
                         file->kind == &null_device ||
                         file->kind == &full_device;
    return is_ours ? of(file)->inode : pipe_inode(file);
}

static struct timespec time_of(int64_t ns)
{
    return (struct timespec){.tv_sec = ns / NS_IN_A_S,
                             .tv_nsec = ns % NS_IN_A_S};
}

void disk_stat(const disk_inode *inode, struct stat *out)
{
    *out = (struct stat){0};
    out->st_dev = DEVICE;
    out->st_ino = inode->number;
    out->st_mode = inode->mode;
    out->st_nlink = inode->links;
    out->st_uid = inode->uid;
    out->st_gid = inode->uid;
    out->st_size = inode->size;
    out->st_blksize = DISK_PAGE;
    out->st_blocks = (inode->size + BLOCK_BYTES - 1) / BLOCK_BYTES;
    out->st_mtim = time_of(inode->changed_ns);
    out->st_ctim = out->st_mtim;
    out->st_atim = out->st_mtim;
}
