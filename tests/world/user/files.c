#include "internal.h"

#include <stdlib.h>
#include <string.h>

#define NAMES 256

const char *user_path(const char *path)
{
    return path[0] == '/' ? path : user_format(USER_HOME "/%s", path);
}

int64_t user_size(world_host *host, const char *path)
{
    return world_disk_size(world_disk_of(host), user_path(path));
}

const char *user_file(world_host *host, const char *path)
{
    size_t size = 0;
    char *bytes = world_disk_read(world_disk_of(host), user_path(path), &size);
    if (bytes == NULL) {
        user_fail(USER_HERE, "there is no file %s, but: %s", path,
                  user_names(host));
    }
    const char *copy = user_keep_text(bytes, size);
    free(bytes);
    return copy;
}

void user_write_file(world_host *host, const char *path, const char *text)
{
    user_trace("writes %s", path);
    world_disk_put(world_disk_of(host), user_path(path), text, strlen(text));
}

static bool ends_so(const char *name, const char *begin, const char *end)
{
    const size_t size = strlen(name);
    return strncmp(name, begin, strlen(begin)) == 0 && size >= strlen(end) &&
           strcmp(name + size - strlen(end), end) == 0;
}

size_t user_files(world_host *host, const char *begin, const char *end)
{
    world_disk *disk = world_disk_of(host);
    const char *name = NULL;
    size_t count = 0;
    for (unsigned i = 0; (name = world_disk_name(disk, USER_HOME, i)) != NULL;
         i++) {
        count += ends_so(name, begin, end) ? 1 : 0;
    }
    return count;
}

static int by_name(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

const char *user_names(world_host *host)
{
    world_disk *disk = world_disk_of(host);
    const char *names[NAMES];
    const char *name = NULL;
    unsigned count = 0;
    user_text *all = user_text_new();
    while (count < NAMES &&
           (name = world_disk_name(disk, USER_HOME, count)) != NULL) {
        names[count++] = name;
    }
    qsort(names, count, sizeof *names, by_name);
    for (unsigned i = 0; i < count; i++) {
        user_text_add(all, names[i], strlen(names[i]));
        user_text_add(all, " ", 1);
    }
    return all->bytes;
}

int64_t user_size_of(world_host *host, const char *begin)
{
    world_disk *disk = world_disk_of(host);
    const char *name = NULL;
    int64_t largest = 0;
    for (unsigned i = 0; (name = world_disk_name(disk, USER_HOME, i)) != NULL;
         i++) {
        const int64_t size =
            ends_so(name, begin, "") ? user_size(host, name) : 0;
        largest = size > largest ? size : largest;
    }
    return largest;
}

world_reader *user_fifo(world_host *host, const char *path)
{
    world_disk *disk = world_disk_of(host);
    user_trace("makes a fifo %s, and opens it", path);
    world_disk_make_fifo(disk, user_path(path));
    world_reader *reader = world_reader_of_fifo(disk, user_path(path));
    world_reader_pace(reader, 0);
    return reader;
}

const char *user_taken(const world_reader *reader)
{
    size_t size = 0;
    return world_reader_text(reader, &size);
}

const char *user_shown(const world_terminal *terminal)
{
    size_t size = 0;
    return world_terminal_text(terminal, &size);
}

void user_foreground(world_terminal *terminal, const user_tool *tool)
{
    world_terminal_set_foreground(terminal, tool->process->group);
}
