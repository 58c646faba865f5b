#define _GNU_SOURCE /* O_TMPFILE, DT_REG */
#include "disk_calls.h"

#include "disk.h"
#include "disk_internal.h"
#include "file_calls.h"
#include "process.h"
#include "task.h"
#include "time.h"
#include "trace.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define CALL_NS WORLD_US
#define UMASK   022u
#define TRIES   100

static int refuse(int code)
{
    errno = code;
    return -1;
}

static world_disk *own_disk(void)
{
    return world_disk_of(world_process_self()->host);
}

/* Devices and /proc are on no disk. */
static bool is_on_disk(const char *path)
{
    return strncmp(path, "/dev/", 5) != 0 && strncmp(path, "/proc", 5) != 0;
}

/* Begins a call on a path. 0 or an errno. */
static int pass(const char *path, unsigned call)
{
    return is_on_disk(path) ? disk_pass(own_disk(), call) : 0;
}

static int find(const char *path, enum disk_end end, disk_place *out)
{
    return disk_find(own_disk(), world_process_self()->directory, path, end,
                     out);
}

/* As find(), but what it names has to be there. */
static int find_there(const char *path, enum disk_end end, disk_place *out)
{
    const int code = find(path, end, out);
    if (code == 0 && out->inode == NULL) {
        disk_place_drop(out);
        return ENOENT;
    }
    return code;
}

static int may_change(const disk_inode *folder)
{
    return folder->disk->fault.is_read_only ? EROFS
                                            : disk_may(folder, W_OK | X_OK);
}

/* --- Opening --- */

/* A file that is there. 0 or an errno. */
static int may_open(const disk_inode *inode, int flags)
{
    const int mode = flags & O_ACCMODE;
    const bool writes = mode != O_RDONLY || (flags & O_TRUNC) != 0;
    if ((flags & O_CREAT) != 0 && (flags & O_EXCL) != 0) {
        return EEXIST;
    }
    if (S_ISLNK(inode->mode)) {
        return ELOOP;
    }
    if (S_ISDIR(inode->mode)) {
        return writes || (flags & O_CREAT) != 0 ? EISDIR
                                                : disk_may(inode, R_OK);
    }
    if ((flags & O_DIRECTORY) != 0) {
        return ENOTDIR;
    }
    if (writes && S_ISREG(inode->mode) && inode->disk->fault.is_read_only) {
        return EROFS;
    }
    return disk_may(inode, (mode != O_WRONLY ? R_OK : 0) | (writes ? W_OK : 0));
}

static int create(disk_place *place, mode_t mode)
{
    world_disk *disk = place->folder->disk;
    const int code = may_change(place->folder);
    if (code != 0) {
        return code;
    }
    if (disk->fault.is_limited && disk->fault.room == 0) {
        world_met("fault:disk-full");
        return ENOSPC;
    }
    place->inode = disk_inode_new(
        disk, S_IFREG | (mode & ~(mode_t)UMASK & 07777u), WORLD_UID);
    disk_add_name(place->folder, place->name, place->inode);
    return 0;
}

/* The thing that a link in /proc/PID/fd stands for. */
static world_file *open_descriptor(const disk_inode *link, int flags)
{
    world_file *file = disk_proc_file(link);
    if (file == NULL || file->kind->reopen == NULL) {
        errno = file == NULL ? ENOENT : ENXIO;
        return NULL;
    }
    return file->kind->reopen(file, flags);
}

static world_file *open_inode(disk_place *place, int flags, mode_t mode)
{
    const int kept = flags & (O_ACCMODE | O_NONBLOCK | O_APPEND);
    int code = 0;
    if ((flags & O_CREAT) != 0 && place->has_slash) {
        code = EISDIR;
    } else if (place->inode == NULL) {
        code = (flags & O_CREAT) != 0 ? create(place, mode) : ENOENT;
    } else if (place->inode->magic == DISK_DESCRIPTOR &&
               (flags & O_NOFOLLOW) == 0) {
        return open_descriptor(place->inode, kept);
    } else {
        code = may_open(place->inode, flags);
    }
    if (code != 0) {
        errno = code;
        return NULL;
    }
    if ((flags & O_TRUNC) != 0 && S_ISREG(place->inode->mode)) {
        (void)disk_set_size(place->inode, 0);
    }
    return disk_file_new(place->inode, kept);
}

/* A name that may be made stands for itself where it ends in a slash, which is
 * refused then. */
static enum disk_end end_of(const char *path, int flags)
{
    const size_t len = strlen(path);
    const bool is_exclusive =
        (flags & (O_CREAT | O_EXCL)) == (O_CREAT | O_EXCL);
    if ((flags & O_CREAT) != 0 && len > 0 && path[len - 1u] == '/') {
        return DISK_NAMES;
    }
    return (flags & O_NOFOLLOW) != 0 || is_exclusive ? DISK_STAYS
                                                     : DISK_FOLLOWS;
}

static int open_path(const char *path, int flags, mode_t mode)
{
    disk_place place;
    int code = pass(path, WORLD_DISK_OPEN);
    if (code == 0) {
        code = find(path, end_of(path, flags), &place);
    }
    if (code != 0) {
        return refuse(code);
    }
    world_file *file = open_inode(&place, flags, mode);
    code = errno;
    disk_place_drop(&place);
    if (file == NULL) {
        return refuse(code);
    }
    return world_fd_take(world_process_self(), file,
                         (flags & O_CLOEXEC) != 0 ? FD_CLOEXEC : 0);
}

int world_call_open64(const char *path, int flags, ...)
{
    mode_t mode = 0;
    if ((flags & O_CREAT) != 0) {
        va_list arguments;
        va_start(arguments, flags);
        mode = va_arg(arguments, mode_t);
        va_end(arguments);
    }
    world_call(CALL_NS);
    const int fd = open_path(path, flags, mode);
    const int code = errno;
    WORLD_TRACE("open %s -> %s", path, fd < 0 ? strerror(code) : "done");
    errno = code;
    return fd;
}

/* Fills in the six X of a name. NULL: there are none. */
static char *pattern(char *path)
{
    const size_t len = strlen(path);
    return len >= 6 && strcmp(path + len - 6u, "XXXXXX") == 0 ? path + len - 6u
                                                              : NULL;
}

static void draw_name(char *at)
{
    static const char letters[] =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";
    for (int i = 0; i < 6; i++) {
        at[i] = letters[world_random_below(&own_disk()->random,
                                           sizeof letters - 1u)];
    }
}

int world_call_mkstemp64(char *path)
{
    char *at = pattern(path);
    world_call(CALL_NS);
    if (at == NULL) {
        return refuse(EINVAL);
    }
    int fd = -1;
    errno = EEXIST;
    for (int i = 0; i < TRIES && fd < 0 && errno == EEXIST; i++) {
        draw_name(at);
        fd = open_path(path, O_RDWR | O_CREAT | O_EXCL, S_IRUSR | S_IWUSR);
    }
    return fd;
}

int world_call_tmpfile_fd(void)
{
    world_call(CALL_NS);
    const int code = disk_pass(own_disk(), WORLD_DISK_OPEN);
    if (code != 0) {
        return refuse(code);
    }
    disk_inode *inode =
        disk_inode_new(own_disk(), S_IFREG | S_IRUSR | S_IWUSR, WORLD_UID);
    world_file *file = disk_file_new(inode, O_RDWR);
    disk_inode_drop(inode);
    return world_fd_take(world_process_self(), file, 0);
}

/* --- Looks --- */

static int look(const char *path, enum disk_end end, struct stat *out)
{
    disk_place place;
    int code = pass(path, WORLD_DISK_LOOK);
    code = code != 0 ? code : find_there(path, end, &place);
    if (code != 0) {
        return refuse(code);
    }
    const disk_inode *inode = place.inode;
    world_file *file = inode->magic == DISK_DESCRIPTOR && end == DISK_FOLLOWS
                           ? disk_proc_file(inode)
                           : NULL;
    int result = 0;
    disk_stat(inode, out);
    if (file != NULL && file->kind->stat != NULL) {
        *out = (struct stat){0};
        result = file->kind->stat(file, out);
    }
    disk_place_drop(&place);
    return result;
}

int world_call_stat64(const char *path, struct stat *out)
{
    world_call(CALL_NS);
    return look(path, DISK_FOLLOWS, out);
}

int world_call_lstat64(const char *path, struct stat *out)
{
    world_call(CALL_NS);
    return look(path, DISK_STAYS, out);
}

int world_call_access(const char *path, int rights)
{
    disk_place place;
    world_call(CALL_NS);
    int code = pass(path, WORLD_DISK_LOOK);
    code = code != 0 ? code : find_there(path, DISK_FOLLOWS, &place);
    if (code != 0) {
        return refuse(code);
    }
    code = (rights & W_OK) != 0 && place.inode->disk->fault.is_read_only &&
                   !S_ISFIFO(place.inode->mode)
               ? EROFS
               : disk_may(place.inode, rights);
    disk_place_drop(&place);
    return code == 0 ? 0 : refuse(code);
}

static ssize_t read_link(const disk_inode *link, char *out, size_t room)
{
    char target[PATH_MAX];
    if (!S_ISLNK(link->mode)) {
        return refuse(EINVAL);
    }
    if (link->target != NULL) {
        (void)snprintf(target, sizeof target, "%s", link->target);
    } else {
        disk_proc_target(link, target, sizeof target);
    }
    const size_t len = strlen(target);
    const size_t n = len < room ? len : room;
    memcpy(out, target, n);
    return (ssize_t)n;
}

ssize_t world_call_readlink(const char *path, char *out, size_t room)
{
    disk_place place;
    world_call(CALL_NS);
    const int code = find_there(path, DISK_STAYS, &place);
    if (code != 0) {
        return refuse(code);
    }
    const ssize_t n = read_link(place.inode, out, room);
    disk_place_drop(&place);
    return n;
}

/* Below a folder only its own names. */
ssize_t world_call_readlinkat(int fd, const char *path, char *out, size_t room)
{
    if (fd == AT_FDCWD || path[0] == '/') {
        return world_call_readlink(path, out, room);
    }
    world_call(CALL_NS);
    const world_file *file = world_fd_file(world_process_self(), fd);
    disk_inode *folder = file != NULL ? disk_file_inode(file) : NULL;
    if (folder == NULL || !S_ISDIR(folder->mode)) {
        return refuse(file == NULL ? EBADF : ENOTDIR);
    }
    disk_inode *inode = disk_child(folder, path);
    if (inode == NULL) {
        return refuse(ENOENT);
    }
    const ssize_t n = read_link(inode, out, room);
    const int code = errno;
    disk_inode_drop(inode);
    errno = code;
    return n;
}

char *world_call_realpath(const char *path, char *out)
{
    disk_place place;
    char whole[PATH_MAX];
    world_call(CALL_NS);
    int code = pass(path, WORLD_DISK_LOOK);
    code = code != 0 ? code : find_there(path, DISK_FOLLOWS, &place);
    if (code != 0) {
        errno = code;
        return NULL;
    }
    disk_path_of(place.folder, place.name, whole);
    disk_place_drop(&place);
    char *to = out != NULL ? out : world_malloc(PATH_MAX);
    if (to != NULL) {
        (void)snprintf(to, PATH_MAX, "%s", whole);
    }
    return to;
}

/* --- Names --- */

static int make_folder(const char *path, mode_t mode)
{
    disk_place place;
    int code = pass(path, WORLD_DISK_OPEN);
    code = code != 0 ? code : find(path, DISK_NAMES, &place);
    if (code != 0) {
        return code;
    }
    code = place.inode != NULL ? EEXIST : may_change(place.folder);
    if (code == 0) {
        disk_inode *folder = disk_inode_new(
            own_disk(), S_IFDIR | (mode & ~(mode_t)UMASK & 07777u), WORLD_UID);
        disk_add_name(place.folder, place.name, folder);
        disk_inode_drop(folder);
    }
    disk_place_drop(&place);
    return code;
}

int world_call_mkdir(const char *path, mode_t mode)
{
    world_call(CALL_NS);
    const int code = make_folder(path, mode);
    return code == 0 ? 0 : refuse(code);
}

char *world_call_mkdtemp(char *path)
{
    char *at = pattern(path);
    int code = at == NULL ? EINVAL : EEXIST;
    world_call(CALL_NS);
    for (int i = 0; i < TRIES && code == EEXIST; i++) {
        draw_name(at);
        code = make_folder(path, S_IRWXU);
    }
    errno = code;
    return code == 0 ? path : NULL;
}

/* In /tmp only one's own can be removed. */
static int may_remove(const disk_place *place)
{
    const int code = may_change(place->folder);
    const bool is_foreign = (place->folder->mode & S_ISVTX) != 0 &&
                            place->folder->uid != WORLD_UID &&
                            place->inode->uid != WORLD_UID;
    return code == 0 && is_foreign ? EPERM : code;
}

static int may_remove_as(const disk_place *place, bool is_folder)
{
    const bool has_folder = S_ISDIR(place->inode->mode);
    if (has_folder != is_folder || (place->has_slash && !has_folder)) {
        return has_folder ? EISDIR : ENOTDIR;
    }
    if (place->name[0] == '\0') {
        return place->dots == 0 ? EBUSY : place->dots == 1 ? EINVAL : ENOTEMPTY;
    }
    return place->inode->names.count > 0 ? ENOTEMPTY : may_remove(place);
}

static int remove_name(const char *path, bool is_folder)
{
    disk_place place;
    int code = pass(path, WORLD_DISK_REMOVE);
    code = code != 0 ? code : find_there(path, DISK_NAMES, &place);
    if (code != 0) {
        return code;
    }
    code = may_remove_as(&place, is_folder);
    if (code == 0) {
        disk_remove_name(place.folder, place.name);
    }
    disk_place_drop(&place);
    return code;
}

/* The file that is to have one more name, not held; NULL: none may. */
static disk_inode *linked_file(const disk_place *from)
{
    const world_file *file = from->inode->magic == DISK_DESCRIPTOR
                                 ? disk_proc_file(from->inode)
                                 : NULL;
    disk_inode *inode = file != NULL ? disk_file_inode(file) : from->inode;
    return inode != NULL && S_ISREG(inode->mode) && inode->links > 0 ? inode
                                                                     : NULL;
}

static int link_found(const disk_place *from, const disk_place *to)
{
    char path[PATH_MAX];
    disk_inode *inode = linked_file(from);
    if (inode == NULL || to->inode != NULL) {
        return inode == NULL ? ENOENT : EEXIST;
    }
    const int code = may_change(to->folder);
    if (code == 0) {
        disk_path_of(from->folder, from->name, path);
        disk_link_name(to->folder, to->name, inode, path);
    }
    return code;
}

/* Give what was found at one place a name at another. The source is dropped. */
static int name_at(disk_place *source, const char *to,
                   int (*act)(const disk_place *from, const disk_place *to))
{
    disk_place target;
    int code = find(to, DISK_NAMES, &target);
    if (code == 0) {
        code = act(source, &target);
        disk_place_drop(&target);
    }
    disk_place_drop(source);
    return code;
}

static int make_link(const char *from, const char *to)
{
    disk_place source;
    int code = pass(to, WORLD_DISK_RENAME);
    code = code != 0 ? code : find_there(from, DISK_STAYS, &source);
    return code != 0 ? code : name_at(&source, to, link_found);
}

/* Only of paths that are absolute or begin where the process is; what is linked
 * is no symbolic link but a descriptor of /proc. */
int world_call_linkat(int from_fd, const char *from, int to_fd, const char *to,
                      int flags)
{
    (void)from_fd;
    (void)to_fd;
    (void)flags;
    world_call(CALL_NS);
    const int code = make_link(from, to);
    return code == 0 ? 0 : refuse(code);
}

int world_call_unlink(const char *path)
{
    world_call(CALL_NS);
    const int code = remove_name(path, false);
    return code == 0 ? 0 : refuse(code);
}

int world_call_rmdir(const char *path)
{
    world_call(CALL_NS);
    const int code = remove_name(path, true);
    return code == 0 ? 0 : refuse(code);
}

/* Whether a folder is another one, or above it. */
static bool is_above(const disk_inode *folder, const disk_inode *other)
{
    while (other != folder && other->parent != other) {
        other = other->parent;
    }
    return other == folder;
}

/* What stands in the way of a rename. 0 or an errno. */
static int may_replace(const disk_place *from, const disk_place *to)
{
    const bool is_folder = S_ISDIR(from->inode->mode);
    if (is_folder && is_above(from->inode, to->folder)) {
        return EINVAL;
    }
    if (to->inode != NULL && is_above(to->inode, from->folder)) {
        return ENOTEMPTY;
    }
    if (from->inode == to->inode) {
        return 0;
    }
    if (to->inode != NULL && S_ISDIR(to->inode->mode) != is_folder) {
        return is_folder ? ENOTDIR : EISDIR;
    }
    if (to->inode != NULL && is_folder && to->inode->names.count > 0) {
        return ENOTEMPTY;
    }
    const int code = may_remove(from);
    return code != 0           ? code
           : to->inode != NULL ? may_remove(to)
                               : may_change(to->folder);
}

/* Both folders are looked for before what is in them. */
static int move_found(const disk_place *from, const disk_place *to)
{
    if (from->name[0] == '\0' || to->name[0] == '\0') {
        return EBUSY;
    }
    if (from->inode == NULL) {
        return ENOENT;
    }
    if (!S_ISDIR(from->inode->mode) && (from->has_slash || to->has_slash)) {
        return ENOTDIR;
    }
    const int code = may_replace(from, to);
    if (code == 0 && from->inode != to->inode) {
        disk_move_name(from->folder, from->name, to->folder, to->name);
    }
    return code;
}

static int move(const char *from, const char *to)
{
    disk_place source;
    int code = pass(from, WORLD_DISK_RENAME);
    code = code != 0 ? code : find(from, DISK_NAMES, &source);
    return code != 0 ? code : name_at(&source, to, move_found);
}

int world_call_rename(const char *from, const char *to)
{
    world_call(CALL_NS);
    const int code = move(from, to);
    return code == 0 ? 0 : refuse(code);
}

/* --- Owners, modes, locks --- */

/* The inode of a descriptor, not held; NULL and errno. */
static disk_inode *inode_of(int fd)
{
    const world_file *file = world_fd_file(world_process_self(), fd);
    disk_inode *inode = file != NULL ? disk_file_inode(file) : NULL;
    if (file != NULL && inode == NULL) {
        errno = EPERM;
    }
    return inode;
}

int world_call_fchmod(int fd, mode_t mode)
{
    world_call(CALL_NS);
    disk_inode *inode = inode_of(fd);
    if (inode == NULL || inode->uid != WORLD_UID) {
        return inode == NULL ? -1 : refuse(EPERM);
    }
    inode->mode = (inode->mode & S_IFMT) | (mode & 07777u);
    return 0;
}

/* Nobody can give a file away. */
int world_call_fchown(int fd, uid_t owner, gid_t group)
{
    world_call(CALL_NS);
    const disk_inode *inode = inode_of(fd);
    if (inode == NULL) {
        return -1;
    }
    const bool keeps_owner = owner == (uid_t)-1 || owner == inode->uid;
    const bool keeps_group = group == (gid_t)-1 || group == inode->uid;
    return inode->uid == WORLD_UID && keeps_owner && keeps_group
               ? 0
               : refuse(EPERM);
}

int world_call_flock(int fd, int operation)
{
    world_call(CALL_NS);
    world_file *file = world_fd_hold(fd);
    if (file == NULL) {
        return -1;
    }
    disk_inode *inode = disk_file_inode(file);
    const bool is_locked_here = inode != NULL && !S_ISFIFO(inode->mode);
    const int code = is_locked_here ? disk_lock(file, inode, operation) : 0;
    world_fd_release(file);
    return code == 0 ? 0 : refuse(code);
}

/* --- Folders --- */

/* What a DIR is here. */
struct open_folder {
    int fd;
    unsigned next;
    struct dirent entry;
};

static struct open_folder *of(DIR *folder)
{
    return (struct open_folder *)(void *)folder;
}

DIR *world_call_opendir(const char *path)
{
    world_call(CALL_NS);
    const int fd =
        open_path(path, O_RDONLY | O_DIRECTORY | O_NONBLOCK | O_CLOEXEC, 0);
    struct open_folder *folder =
        fd >= 0 ? world_calloc(1, sizeof *folder) : NULL;
    if (folder == NULL) {
        return NULL;
    }
    folder->fd = fd;
    return (DIR *)(void *)folder;
}

/* The n-th name of a folder: "." and "..", its own, and virtual ones. */
static bool nth_name(const disk_inode *folder, unsigned n,
                     char out[NAME_MAX + 1])
{
    if (n < 2) {
        (void)snprintf(out, NAME_MAX + 1, "%s", n == 0 ? "." : "..");
        return true;
    }
    n -= 2u;
    if (n < folder->names.count) {
        (void)snprintf(out, NAME_MAX + 1, "%s", folder->names.list[n].text);
        return true;
    }
    return disk_proc_name(folder, n - folder->names.count, out);
}

struct dirent *world_call_readdir64(DIR *stream)
{
    struct open_folder *folder = of(stream);
    world_call(CALL_NS);
    disk_inode *inode = inode_of(folder->fd);
    struct dirent *entry = &folder->entry;
    if (inode == NULL || !nth_name(inode, folder->next, entry->d_name)) {
        return NULL;
    }
    folder->next++;
    disk_inode *found = disk_child(inode, entry->d_name);
    entry->d_type = DT_UNKNOWN;
    if (found != NULL) {
        entry->d_ino = found->number;
        entry->d_type = (unsigned char)IFTODT(found->mode);
        disk_inode_drop(found);
    }
    return entry;
}

int world_call_dirfd(DIR *stream)
{
    return of(stream)->fd;
}

int world_call_closedir(DIR *stream)
{
    const int fd = of(stream)->fd;
    world_free(of(stream));
    return world_call_close(fd);
}
