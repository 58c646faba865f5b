/* What disk.c, disk_name.c, disk_fault.c, disk_file.c, disk_proc.c and
 * disk_calls.c share. */
#ifndef WORLD_DISK_INTERNAL_H
#define WORLD_DISK_INTERNAL_H

#include "disk.h"
#include "random.h"
#include "task.h"

#include <limits.h>
#include <sys/types.h>

#define DISK_PAGE 4096u

struct pipe_body;
typedef struct disk_inode disk_inode;

/* Of a file's bytes: as processes see them, and as they are on the disk. One
 * memory where both are the same; NULL: zeros. */
typedef struct disk_page {
    uint8_t *now;
    uint8_t *durable;
    bool is_lost; /* a sync of it failed: no other one writes it */
} disk_page;

typedef struct disk_name {
    char *text;
    disk_inode *inode;
} disk_name;

typedef struct disk_names {
    disk_name *list;
    unsigned count, room;
} disk_names;

/* What a virtual inode stands for. */
enum disk_magic {
    DISK_PLAIN,
    DISK_NULL,      /* /dev/null */
    DISK_FULL,      /* /dev/full */
    DISK_TEXT,      /* text() */
    DISK_PROC,      /* /proc: its names, and a folder for each process */
    DISK_SELF,      /* /proc/self */
    DISK_PROCESS,   /* /proc/PID */
    DISK_COMM,      /* /proc/PID/comm */
    DISK_FDS,       /* /proc/PID/fd */
    DISK_DESCRIPTOR /* /proc/PID/fd/N */
};

struct disk_inode {
    disk_inode *next; /* of the disk */
    world_disk *disk;
    uint64_t number;
    unsigned refs;    /* names, places, files, changes that are not synced */
    unsigned links;   /* names that processes see */
    unsigned opens;   /* files */
    bool has_no_room; /* neither a name nor a file: its bytes take no room */
    mode_t mode;
    uid_t uid;
    int64_t changed_ns; /* of the calendar */
    /* A regular file. */
    disk_page *pages;
    size_t page_room;
    int64_t size, durable_size;
    struct disk_lock *locks;
    world_queue unlocked;
    /* A folder. */
    disk_inode *parent; /* itself: the root */
    disk_names names, durable_names;
    /* A link. */
    char *target;
    /* A fifo. */
    struct pipe_body *pipe;
    /* A virtual one. */
    enum disk_magic magic;
    char *(*text)(world_host *host);
    long pid;
    int fd;
};

/* A change of names that is not on the disk yet: up to two names at once. */
typedef struct disk_change {
    struct disk_change *next;
    struct disk_change_part {
        disk_inode *folder; /* NULL: unused */
        char *name;
        disk_inode *inode; /* NULL: the name goes */
    } part[2];
} disk_change;

struct disk_fault {
    unsigned stall_calls, slow_calls, fail_calls, nth_calls;
    int64_t stall_until_ns, slow_low_ns, slow_high_ns;
    double fail_chance;
    int fail_code, nth_code;
    uint64_t nth;
    bool is_limited, is_read_only;
    uint64_t room; /* bytes that still fit */
    world_queue healed;
    world_random random;
};

struct world_disk {
    world_disk *next;
    world_host *host;
    disk_inode *root, *proc;
    disk_inode *inodes;
    uint64_t numbers;
    disk_change *changes, **last_change;
    struct disk_fault fault;
    world_random random; /* names of mkstemp() */
};

/* A name in a folder, and what it stands for; both are held. */
typedef struct disk_place {
    disk_inode *folder;
    char name[NAME_MAX + 1]; /* "": the folder is what the path names */
    disk_inode *inode;       /* NULL: nothing */
    unsigned dots;           /* its last name is "." or ".." */
    bool has_slash;          /* the path ends with one */
} disk_place;

/* --- disk.c: inodes --- */

disk_inode *disk_inode_new(world_disk *disk, mode_t mode, uid_t uid);
disk_inode *disk_inode_use(disk_inode *inode);
void disk_inode_drop(disk_inode *inode);
void disk_touch(disk_inode *inode);
/* After its names or files changed: whether its bytes take room. */
void disk_settle_room(disk_inode *inode);
/* 0 or an errno, of the rights of WORLD_UID. rights: R_OK, W_OK, X_OK. */
int disk_may(const disk_inode *inode, int rights);

size_t disk_read_at(const disk_inode *inode, void *out, size_t size,
                    int64_t at);
/* How much was written: less where the disk is full. */
size_t disk_write_at(disk_inode *inode, const void *bytes, size_t size,
                     int64_t at);
/* 0 or ENOSPC. */
int disk_set_size(disk_inode *inode, int64_t size);
void disk_sync_bytes(disk_inode *inode);
/* A sync that fails. */
void disk_lose_bytes(disk_inode *inode);
bool disk_is_synced(const disk_inode *inode);
/* As after a cut. */
void disk_revert_bytes(disk_inode *inode, double kept);

/* --- disk_name.c: folders and paths --- */

disk_name *disk_names_find(const disk_names *names, const char *name);
void disk_names_set(disk_names *names, const char *name, disk_inode *inode);
void disk_names_clear(disk_names *names);

/* What becomes of a link at a path's end. */
enum disk_end {
    DISK_FOLLOWS,
    DISK_STAYS, /* but it is followed where a slash comes behind it */
    DISK_NAMES  /* only a name is meant, whatever it stands for */
};

/* directory: what a path that is not absolute begins from. 0 or an errno;
 * ENOENT only where a folder on the way is missing, or the path is empty:
 * out->inode is NULL where just the last name is. To be dropped where 0. */
int disk_find(world_disk *disk, const char *directory, const char *path,
              enum disk_end end, disk_place *out);
void disk_place_drop(disk_place *place);
/* A name in a folder, with a reference; NULL: none. */
disk_inode *disk_child(disk_inode *folder, const char *name);
/* The absolute path of a name in a folder. */
void disk_path_of(const disk_inode *folder, const char *name,
                  char out[PATH_MAX]);

/* Names that change, as processes see it: told to those who watch, and on the
 * disk once it is synced. */
void disk_add_name(disk_inode *folder, const char *name, disk_inode *inode);
void disk_link_name(disk_inode *folder, const char *name, disk_inode *inode,
                    const char *old_path);
void disk_remove_name(disk_inode *folder, const char *name);
void disk_move_name(disk_inode *from, const char *name, disk_inode *to,
                    const char *new_name);
/* The changes that concern a folder, or all where NULL. */
void disk_sync_names(world_disk *disk, const disk_inode *folder);
void disk_revert_names(world_disk *disk, double kept);
void disk_forget_changes(world_disk *disk);
void disk_forget_watchers(void);

/* --- disk_fault.c --- */

/* At the beginning of each call on the disk: it may wait. 0 or an errno. call:
 * one of the WORLD_DISK_ bits. */
int disk_pass(world_disk *disk, unsigned call);
void disk_fault_begin(world_disk *disk);

/* --- disk_file.c --- */

/* A file of an inode, of which it takes a reference. NULL and errno. */
world_file *disk_file_new(disk_inode *inode, int flags);
/* The inode of a file; NULL: it is of no disk. */
disk_inode *disk_file_inode(const world_file *file);
void disk_stat(const disk_inode *inode, struct stat *out);
/* 0 or an errno. */
int disk_lock(world_file *file, disk_inode *inode, int operation);

/* --- disk_proc.c --- */

/* A name in a virtual folder, with a reference; NULL: none. */
disk_inode *disk_proc_find(disk_inode *folder, const char *name);
/* The n-th of its names. False: there is none. */
bool disk_proc_name(const disk_inode *folder, unsigned n,
                    char out[NAME_MAX + 1]);
/* What a virtual link says. */
void disk_proc_target(const disk_inode *link, char *out, size_t room);
/* The file of a DISK_DESCRIPTOR; NULL: it was closed. */
world_file *disk_proc_file(const disk_inode *link);
/* A DISK_TEXT's or DISK_COMM's, for free(). */
char *disk_proc_text(const disk_inode *inode);

#endif
