#define _GNU_SOURCE
#include "disk_internal.h"

#include "process.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Each look at a process in /proc makes its inodes anew. */
static disk_inode *make(disk_inode *folder, mode_t mode, enum disk_magic magic,
                        long pid)
{
    disk_inode *inode = disk_inode_new(folder->disk, mode, WORLD_UID);
    inode->magic = magic;
    inode->pid = pid;
    inode->links = 1;
    inode->parent = folder->disk->proc; /* one that stays */
    return inode;
}

/* Of this host, and not ended. */
static const world_process *process_of(const disk_inode *inode, long pid)
{
    const world_process *process = world_process_find(pid);
    return process != NULL && !process->has_ended &&
                   process->host == inode->disk->host
               ? process
               : NULL;
}

static bool read_number(const char *name, long *out)
{
    char *end = NULL;
    *out = strtol(name, &end, 10);
    return name[0] >= '0' && name[0] <= '9' && *end == '\0';
}

static disk_inode *find_in_proc(disk_inode *folder, const char *name)
{
    long pid = 0;
    const world_process *self = world_process_self();
    if (strcmp(name, "self") == 0 && self != NULL) {
        return make(folder, S_IFLNK | 0777u, DISK_SELF, self->pid);
    }
    return read_number(name, &pid) && process_of(folder, pid) != NULL
               ? make(folder, S_IFDIR | 0555u, DISK_PROCESS, pid)
               : NULL;
}

static disk_inode *find_of_process(disk_inode *folder, const char *name)
{
    if (process_of(folder, folder->pid) == NULL) {
        return NULL;
    }
    if (strcmp(name, "comm") == 0) {
        return make(folder, S_IFREG | 0644u, DISK_COMM, folder->pid);
    }
    return strcmp(name, "fd") == 0
               ? make(folder, S_IFDIR | 0500u, DISK_FDS, folder->pid)
               : NULL;
}

static bool is_open(const disk_inode *folder, long fd)
{
    const world_process *process = process_of(folder, folder->pid);
    return process != NULL && fd >= 0 && fd < WORLD_FDS &&
           process->fds[fd].file != NULL;
}

static disk_inode *find_descriptor(disk_inode *folder, const char *name)
{
    long fd = 0;
    if (!read_number(name, &fd) || !is_open(folder, fd)) {
        return NULL;
    }
    disk_inode *link =
        make(folder, S_IFLNK | 0700u, DISK_DESCRIPTOR, folder->pid);
    link->fd = (int)fd;
    return link;
}

disk_inode *disk_proc_find(disk_inode *folder, const char *name)
{
    switch (folder->magic) {
    case DISK_PROC:
        return find_in_proc(folder, name);
    case DISK_PROCESS:
        return find_of_process(folder, name);
    case DISK_FDS:
        return find_descriptor(folder, name);
    case DISK_PLAIN:
    case DISK_NULL:
    case DISK_FULL:
    case DISK_TEXT:
    case DISK_SELF:
    case DISK_COMM:
    case DISK_DESCRIPTOR:
        break;
    }
    return NULL;
}

/* --- Names --- */

static bool name_process(const disk_inode *folder, unsigned n,
                         char out[NAME_MAX + 1])
{
    for (const world_process *p = world_process_first(); p != NULL;
         p = p->next) {
        if (process_of(folder, p->pid) != p) {
            continue;
        }
        if (n == 0) {
            (void)snprintf(out, NAME_MAX + 1, "%ld", p->pid);
            return true;
        }
        n--;
    }
    return false;
}

static bool name_descriptor(const disk_inode *folder, unsigned n,
                            char out[NAME_MAX + 1])
{
    for (int fd = 0; fd < WORLD_FDS; fd++) {
        if (!is_open(folder, fd)) {
            continue;
        }
        if (n == 0) {
            (void)snprintf(out, NAME_MAX + 1, "%d", fd);
            return true;
        }
        n--;
    }
    return false;
}

bool disk_proc_name(const disk_inode *folder, unsigned n,
                    char out[NAME_MAX + 1])
{
    static const char *const of_process[] = {"comm", "fd"};
    if (folder->magic == DISK_PROC) {
        return name_process(folder, n, out);
    }
    if (folder->magic == DISK_FDS) {
        return name_descriptor(folder, n, out);
    }
    if (folder->magic != DISK_PROCESS || n >= 2) {
        return false;
    }
    (void)snprintf(out, NAME_MAX + 1, "%s", of_process[n]);
    return true;
}

/* --- What they hold --- */

world_file *disk_proc_file(const disk_inode *link)
{
    return is_open(link, link->fd)
               ? world_process_find(link->pid)->fds[link->fd].file
               : NULL;
}

static const char *shown_kind(const world_file *file)
{
    return file->kind->sendmsg != NULL ? "socket" : file->kind->name;
}

void disk_proc_target(const disk_inode *link, char *out, size_t room)
{
    const world_file *file =
        link->magic == DISK_DESCRIPTOR ? disk_proc_file(link) : NULL;
    if (file == NULL) {
        (void)snprintf(out, room, "%ld", link->pid);
    } else if (file->kind->path != NULL) {
        file->kind->path(file, out, room);
    } else {
        (void)snprintf(out, room, "%s:[%llu]", shown_kind(file),
                       (unsigned long long)file->number);
    }
}

char *disk_proc_text(const disk_inode *inode)
{
    const world_process *process =
        inode->magic == DISK_COMM ? process_of(inode, inode->pid) : NULL;
    char name[32];
    (void)snprintf(name, sizeof name, "%s\n",
                   process != NULL ? process->name : "");
    char *text =
        inode->text != NULL ? inode->text(inode->disk->host) : strdup(name);
    if (text == NULL) {
        abort();
    }
    return text;
}
