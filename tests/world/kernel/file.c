#define _GNU_SOURCE
#include "file.h"

#include "process.h"
#include "task.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

/* A file of the world, in the order of their making. */
struct entry {
    world_file file;
    world_queue changed;
    struct entry *before, *after;
};

/* A call that uses a file while it waits. */
struct hold {
    struct hold *next;
    world_process *process;
    const world_task *task;
    world_file *file;
};

static struct {
    struct entry *first, *last;
    uint64_t numbers;
    struct hold *holds, *spare;
} files;

/* --- Files --- */

world_file *world_file_new(const world_file_kind *kind, int flags, void *data)
{
    struct entry *entry = calloc(1, sizeof *entry);
    if (entry == NULL) {
        abort();
    }
    entry->file = (world_file){.kind = kind,
                               .uses = 1,
                               .flags = flags,
                               .number = ++files.numbers,
                               .changed = &entry->changed,
                               .data = data};
    entry->before = files.last;
    if (files.last != NULL) {
        files.last->after = entry;
    } else {
        files.first = entry;
    }
    files.last = entry;
    return &entry->file;
}

world_file *world_file_use(world_file *file)
{
    file->uses++;
    return file;
}

static void destroy(world_file *file)
{
    struct entry *entry = (struct entry *)(void *)file;
    if (file->kind->close != NULL) {
        file->kind->close(file);
    }
    world_wake_all(&entry->changed);
    if (entry->before != NULL) {
        entry->before->after = entry->after;
    } else {
        files.first = entry->after;
    }
    if (entry->after != NULL) {
        entry->after->before = entry->before;
    } else {
        files.last = entry->before;
    }
    free(entry);
}

void world_file_drop(world_file *file)
{
    file->uses--;
    if (file->uses == 0) {
        destroy(file);
    }
}

void world_file_reset(void)
{
    while (files.holds != NULL) {
        struct hold *hold = files.holds;
        files.holds = hold->next;
        free(hold);
    }
    while (files.spare != NULL) {
        struct hold *hold = files.spare;
        files.spare = hold->next;
        free(hold);
    }
    while (files.last != NULL) {
        destroy(&files.last->file);
    }
    files.numbers = 0;
}

/* --- Descriptors --- */

int world_fd_take(world_process *process, world_file *file, int flags)
{
    for (int fd = 0; fd < WORLD_FDS; fd++) {
        if (process->fds[fd].file == NULL) {
            process->fds[fd].file = file;
            process->fds[fd].flags = flags;
            return fd;
        }
    }
    world_file_drop(file);
    errno = EMFILE;
    return -1;
}

world_file *world_fd_file(world_process *process, int fd)
{
    if (fd < 0 || fd >= WORLD_FDS || process->fds[fd].file == NULL) {
        errno = EBADF;
        return NULL;
    }
    return process->fds[fd].file;
}

void world_fd_close_all(world_process *process)
{
    for (int fd = 0; fd < WORLD_FDS; fd++) {
        world_file *file = process->fds[fd].file;
        process->fds[fd].file = NULL;
        if (file != NULL) {
            world_file_drop(file);
        }
    }
    struct hold **at = &files.holds;
    while (*at != NULL) {
        struct hold *hold = *at;
        if (hold->process != process) {
            at = &hold->next;
            continue;
        }
        *at = hold->next;
        world_file_drop(hold->file);
        free(hold);
    }
}

/* --- Files that calls use --- */

void world_file_hold(world_file *file)
{
    struct hold *hold = files.spare;
    if (hold != NULL) {
        files.spare = hold->next;
    } else {
        hold = malloc(sizeof *hold);
    }
    if (hold == NULL) {
        abort();
    }
    *hold = (struct hold){files.holds, world_process_self(), world_task_self(),
                          world_file_use(file)};
    files.holds = hold;
}

world_file *world_fd_hold(int fd)
{
    world_file *file = world_fd_file(world_process_self(), fd);
    if (file != NULL) {
        world_file_hold(file);
    }
    return file;
}

void world_fd_release(world_file *file)
{
    const world_task *task = world_task_self();
    struct hold **at = &files.holds;
    while ((*at)->file != file || (*at)->task != task) {
        at = &(*at)->next;
    }
    struct hold *hold = *at;
    *at = hold->next;
    hold->next = files.spare;
    files.spare = hold;
    const int kept = errno;
    world_file_drop(file);
    errno = kept;
}
