#define _GNU_SOURCE
#include "disk_internal.h"

#include "trace.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define FILE_MODE   0644u
#define FOLDER_MODE 0755u

/* The folder of a path, which has to be there. False: the run has failed. */
static bool find(world_disk *disk, const char *path, enum disk_end end,
                 disk_place *out)
{
    const int code = disk_find(disk, "/", path, end, out);
    if (code != 0) {
        world_fail("the disk of %s: %s: %s", disk->host->name, path,
                   strerror(code));
    }
    return code == 0;
}

/* A new inode under a name, in place of what had it; on the disk at once. */
static disk_inode *plant(world_disk *disk, const char *path, mode_t mode)
{
    disk_place place;
    if (!find(disk, path, DISK_NAMES, &place)) {
        return NULL;
    }
    disk_inode *inode = disk_inode_new(disk, mode, WORLD_UID);
    disk_add_name(place.folder, place.name, inode);
    disk_sync_names(disk, place.folder);
    disk_place_drop(&place);
    disk_inode_drop(inode);
    return inode;
}

void world_disk_make_folder(world_disk *disk, const char *path)
{
    char part[PATH_MAX];
    for (const char *end = path; *end != '\0';) {
        end += strspn(end, "/");
        end += strcspn(end, "/");
        (void)snprintf(part, sizeof part, "%.*s", (int)(end - path), path);
        if (!world_disk_has(disk, part)) {
            (void)plant(disk, part, S_IFDIR | FOLDER_MODE);
        }
    }
}

/* The inode of what a path names, without a reference; NULL: none. */
static disk_inode *look_up(world_disk *disk, const char *path)
{
    disk_place place;
    if (disk_find(disk, "/", path, DISK_FOLLOWS, &place) != 0) {
        return NULL;
    }
    disk_inode *inode = place.inode;
    disk_place_drop(&place);
    return inode;
}

void world_disk_put(world_disk *disk, const char *path, const void *bytes,
                    size_t size)
{
    disk_inode *inode = look_up(disk, path);
    if (inode == NULL) {
        inode = plant(disk, path, S_IFREG | FILE_MODE);
    }
    if (inode != NULL) {
        const bool was_limited = disk->fault.is_limited;
        disk->fault.is_limited = false;
        (void)disk_set_size(inode, 0);
        (void)disk_write_at(inode, bytes, size, 0);
        disk_sync_bytes(inode);
        disk->fault.is_limited = was_limited;
    }
}

void world_disk_make_fifo(world_disk *disk, const char *path)
{
    (void)plant(disk, path, S_IFIFO | FILE_MODE);
}

void world_disk_make_link(world_disk *disk, const char *path,
                          const char *target)
{
    disk_inode *link = plant(disk, path, S_IFLNK | 0777u);
    if (link != NULL) {
        link->target = strdup(target);
    }
}

void world_disk_remove(world_disk *disk, const char *path)
{
    disk_place place;
    if (!find(disk, path, DISK_NAMES, &place)) {
        return;
    }
    if (place.inode == NULL || place.name[0] == '\0') {
        world_fail("the disk of %s: %s: there is nothing to remove",
                   disk->host->name, path);
    } else {
        disk_remove_name(place.folder, place.name);
        disk_sync_names(disk, place.folder);
    }
    disk_place_drop(&place);
}

void world_disk_set_mode(world_disk *disk, const char *path, mode_t bits,
                         bool is_of_root)
{
    disk_inode *inode = look_up(disk, path);
    if (inode == NULL) {
        world_fail("the disk of %s: %s: there is no such file",
                   disk->host->name, path);
        return;
    }
    inode->mode = (inode->mode & S_IFMT) | bits;
    inode->uid = is_of_root ? 0 : WORLD_UID;
}

/* --- Looks --- */

bool world_disk_has(world_disk *disk, const char *path)
{
    return look_up(disk, path) != NULL;
}

int64_t world_disk_size(world_disk *disk, const char *path)
{
    const disk_inode *inode = look_up(disk, path);
    return inode != NULL ? inode->size : -1;
}

static char *copy_of(const disk_inode *inode, size_t *size)
{
    char *bytes = NULL;
    if (inode == NULL || !S_ISREG(inode->mode)) {
        return NULL;
    }
    bytes = malloc((size_t)inode->size + 1u);
    if (bytes == NULL) {
        abort();
    }
    const size_t n = disk_read_at(inode, bytes, (size_t)inode->size, 0);
    bytes[n] = '\0';
    if (size != NULL) {
        *size = n;
    }
    return bytes;
}

char *world_disk_read(world_disk *disk, const char *path, size_t *size)
{
    return copy_of(look_up(disk, path), size);
}

char *world_disk_read_inode(world_disk *disk, uint64_t number, size_t *size)
{
    const disk_inode *inode = disk->inodes;
    while (inode != NULL && inode->number != number) {
        inode = inode->next;
    }
    return copy_of(inode, size);
}

const char *world_disk_name(world_disk *disk, const char *folder, unsigned n)
{
    const disk_inode *inode = look_up(disk, folder);
    return inode != NULL && n < inode->names.count ? inode->names.list[n].text
                                                   : NULL;
}

/* --- Other things --- */

world_file *world_disk_open(world_disk *disk, const char *path, int flags)
{
    disk_place place;
    const int code = disk_find(disk, "/", path, DISK_FOLLOWS, &place);
    if (code != 0) {
        errno = code;
        return NULL;
    }
    disk_inode *inode = place.inode;
    if (inode == NULL && (flags & O_CREAT) != 0) {
        inode = plant(disk, path, S_IFREG | FILE_MODE);
    }
    world_file *file = NULL;
    errno = ENOENT;
    if (inode != NULL) {
        if ((flags & O_TRUNC) != 0 && S_ISREG(inode->mode)) {
            (void)disk_set_size(inode, 0);
        }
        file = disk_file_new(inode, flags & ~(O_CREAT | O_TRUNC | O_EXCL));
    }
    disk_place_drop(&place);
    return file;
}

void world_disk_put_text(world_disk *disk, const char *path,
                         char *(*text)(world_host *host))
{
    char folder[PATH_MAX];
    const char *slash = strrchr(path, '/');
    (void)snprintf(folder, sizeof folder, "%.*s", (int)(slash - path), path);
    world_disk_make_folder(disk, folder);
    disk_inode *inode = plant(disk, path, S_IFREG | 0444u);
    if (inode != NULL) {
        inode->magic = DISK_TEXT;
        inode->text = text;
        inode->uid = 0;
    }
}
