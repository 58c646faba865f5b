/* The disk of a host: folders, files, links, fifos, /dev and /proc. What a
 * process wrote is in the memory of the system until it is synced: the bytes of
 * a file by a sync of the file, a name by a sync of its folder. A power cut
 * takes away the rest. */
#ifndef WORLD_DISK_H
#define WORLD_DISK_H

#include "file.h"
#include "host.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

typedef struct world_disk world_disk;

/* Whom the tools belong to. Others' files are made by world_disk_set_mode(). */
#define WORLD_UID 1000u

/* The disk of a host, made when it is first asked for, with /home, /tmp, /dev
 * and /proc. */
world_disk *world_disk_of(world_host *host);

/* --- what the user does, outside of processes ---
 *
 * Paths are absolute. All of it is on the disk at once, and meets no fault.
 * Where something is wrong with a path, the run fails (world_fail). */

void world_disk_make_folder(world_disk *disk, const char *path);
void world_disk_put(world_disk *disk, const char *path, const void *bytes,
                    size_t size);
void world_disk_make_fifo(world_disk *disk, const char *path);
void world_disk_make_link(world_disk *disk, const char *path,
                          const char *target);
void world_disk_remove(world_disk *disk, const char *path);
/* The bits of a file, and whether it belongs to root instead of WORLD_UID. */
void world_disk_set_mode(world_disk *disk, const char *path, mode_t bits,
                         bool is_of_root);

/* Of what the path names; links are followed. */
bool world_disk_has(world_disk *disk, const char *path);
/* -1: there is none. */
int64_t world_disk_size(world_disk *disk, const char *path);
/* A copy of a file's bytes with a 0 behind them, for free(); NULL: no file of
 * this name. */
char *world_disk_read(world_disk *disk, const char *path, size_t *size);
/* Of the inode of a name's event, as it is now, whatever its name is. */
char *world_disk_read_inode(world_disk *disk, uint64_t inode, size_t *size);

/* The n-th name in a folder, in the order of their making; NULL after the last,
 * or where there is no folder. */
const char *world_disk_name(world_disk *disk, const char *folder, unsigned n);

/* For `< FILE` and `> FILE` of a shell: flags as open(), with O_CREAT and so
 * on. NULL and errno. */
world_file *world_disk_open(world_disk *disk, const char *path, int flags);

/* A file whose text is made when it is opened: a copy for free(). For /proc;
 * folders above it are made. */
void world_disk_put_text(world_disk *disk, const char *path,
                         char *(*text)(world_host *host));

/* --- names that change --- */

typedef enum world_name_change {
    WORLD_NAME_MADE,    /* by open() */
    WORLD_NAME_GIVEN,   /* by rename(): another file may have had it; by
                           linkat() */
    WORLD_NAME_REMOVED, /* by unlink() */
    WORLD_NAME_LOST     /* by a power cut */
} world_name_change;

typedef struct world_name_event {
    world_name_change change;
    world_disk *disk;
    long pid;         /* 0: the user */
    const char *path; /* absolute */
    const char *from; /* of WORLD_NAME_GIVEN: what it was called before */
    uint64_t inode;
    int64_t size;
    bool is_synced; /* all its bytes are on the disk */
} world_name_event;

/* told() is called at each change of a regular file's name on any disk, in the
 * task that makes it: it must not wait. Up to 8 per world; they end with it. */
void world_disk_watch(void (*told)(const world_name_event *event,
                                   void *argument),
                      void *argument);

/* --- faults --- */

/* Calls that a fault is for. */
enum {
    WORLD_DISK_READ = 1,
    WORLD_DISK_WRITE = 2,
    WORLD_DISK_SYNC = 4,
    WORLD_DISK_CLOSE = 8,
    WORLD_DISK_OPEN = 16, /* and mkdir */
    WORLD_DISK_RENAME = 32,
    WORLD_DISK_REMOVE = 64,
    WORLD_DISK_LOOK = 128, /* stat, access, opendir */
    WORLD_DISK_ALL = 255
};

/* Such calls wait until a moment (true time), WORLD_NEVER: until it is healed.
 * As on Linux no signal ends the wait but SIGKILL. */
void world_disk_stall(world_disk *disk, unsigned calls, int64_t until_ns);
/* Each such call takes from low to high longer. */
void world_disk_slow(world_disk *disk, unsigned calls, int64_t low_ns,
                     int64_t high_ns);
/* Only so many bytes more fit: then short writes, then ENOSPC. What is removed
 * makes room. */
void world_disk_fill(world_disk *disk, uint64_t room);
/* Such calls fail with a probability. code: EIO, EDQUOT, ... After a sync that
 * failed, the bytes it was for are not on the disk, and no later sync says so.
 */
void world_disk_fail(world_disk *disk, unsigned calls, double chance, int code);
/* Only the n-th such call from now, counted from 1. */
void world_disk_fail_nth(world_disk *disk, unsigned calls, uint64_t n,
                         int code);
/* EROFS for all that writes. */
void world_disk_set_read_only(world_disk *disk, bool is_read_only);
/* All of these end. */
void world_disk_heal(world_disk *disk);

/* What was not synced is lost, but for a part of it that the disk had got by
 * itself: of the pages with this probability each, but what was appended to a
 * file only up to the first that is lost; of the names the first ones. The
 * processes of the host have to be ended before (world_host_power_cut). */
void world_disk_cut(world_disk *disk, double kept);

/* The host's processes end, its disk keeps what is on it. It can be used again
 * at once: new processes are started by the user. */
void world_host_power_cut(world_host *host, double kept);

/* Frees all disks, after all files (world_file_reset). */
void world_disk_reset(void);

#endif
