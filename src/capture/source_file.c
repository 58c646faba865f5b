#include "source_file.h"

#include "source_internal.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

struct file {
    int fd;
    bool has_place; /* of its own: a process that was forked has the descriptor,
                       and with it the system's place, too */
    uint64_t at;
};

static int64_t read_some(void *context, void *buffer, size_t room,
                         lum_error *error)
{
    struct file *file = context;
    if (!file->has_place) {
        return lum_source_file_read(file->fd, buffer, room, error);
    }
    const int64_t got =
        lum_source_file_read_at(file->fd, file->at, buffer, room, error);
    file->at += got > 0 ? (uint64_t)got : 0;
    return got;
}

static bool wait_for_some(void *context, int ms)
{
    const struct file *file = context;
    return lum_source_file_wait(file->fd, ms);
}

static int seek_file(void *context, uint64_t offset, lum_error *error)
{
    struct file *file = context;
    if (!file->has_place &&
        lum_source_file_seek(file->fd, offset, error) != 0) {
        return -1;
    }
    file->at = offset;
    return 0;
}

static void close_file(void *context)
{
    struct file *file = context;
    lum_source_file_close(file->fd);
    free(file);
}

static lum_source *from_descriptor(const char *name, int fd, bool is_own)
{
    struct file *file = calloc(1, sizeof *file);
    if (file == NULL) {
        return NULL;
    }
    file->fd = fd;
    const uint64_t total = lum_source_file_bytes(fd);
    file->has_place = is_own && total != 0;
    const lum_source_functions functions = {.struct_size = sizeof functions,
                                            .read = read_some,
                                            .close = close_file,
                                            .context = file,
                                            .total = total,
                                            .seek =
                                                total != 0 ? seek_file : NULL};
    lum_source *source = lum_source_from_functions(name, &functions, NULL);
    if (source == NULL) {
        free(file);
        return NULL;
    }
    source->wait = functions.total == 0 ? wait_for_some : NULL;
    return source;
}

int lum_source_open(const char *path, lum_source **out, lum_error *error)
{
    const bool is_own = strcmp(path, "-") != 0;
    const char *name = is_own ? path : "standard input";
    const int fd = lum_source_file_open(path);
    if (fd < 0) {
        return lum_error_set(error,
                             "%s: cannot be opened: %s; a pcap, pcapng, MCAP "
                             "or bag file is expected",
                             name, strerror(errno));
    }
    lum_source *source = from_descriptor(name, fd, is_own);
    if (source == NULL) {
        lum_source_file_close(fd);
        errno = ENOMEM;
        return lum_error_set(error, "%s: not enough memory to read it", name);
    }
    *out = source;
    return 0;
}
