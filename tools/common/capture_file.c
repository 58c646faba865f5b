#define _XOPEN_SOURCE 700 /* realpath */
#include "capture_file.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

bool capture_file_is_in_place(const char *path)
{
    struct stat st;
    return strcmp(path, "-") == 0 ||
           (stat(path, &st) == 0 && !S_ISREG(st.st_mode));
}

static char *name_part(const char *path)
{
    const size_t size = strlen(path) + sizeof ".part";
    char *part = malloc(size);
    if (part != NULL) {
        (void)snprintf(part, size, "%s.part", path);
    }
    return part;
}

static bool is_directory_missing(const char *path)
{
    const char *slash = strrchr(path, '/');
    struct stat st;
    if (slash == NULL || slash == path) {
        return false;
    }
    char *directory = strdup(path);
    if (directory == NULL) {
        return false;
    }
    directory[slash - path] = '\0';
    const bool missing = stat(directory, &st) != 0 && errno == ENOENT;
    free(directory);
    return missing;
}

/* What a link leads to is replaced, not the link. A link that leads nowhere
 * cannot be followed, and is not replaced either. */
static char *resolve(const char *path, lum_error *error)
{
    struct stat st;
    const bool is_there = lstat(path, &st) == 0;
    char *resolved = is_there ? realpath(path, NULL) : strdup(path);
    if (resolved == NULL) {
        (void)lum_error_set(error, "%s: cannot be written: %s", path,
                            strerror(errno));
    }
    return resolved;
}

static int check_directory(const char *path, lum_error *error)
{
    return !is_directory_missing(path)
               ? 0
               : lum_error_set(error,
                               "%s: cannot create it: the directory does not "
                               "exist; create it or write elsewhere",
                               path);
}

/* What is left out stays NULL, and free() allows that. */
static int open_writer(struct capture_file *file, const char *path,
                       lum_error *error)
{
    if (lum_capture_writer_open(path, &file->writer, error) == 0) {
        return 0;
    }
    free(file->path);
    free(file->part);
    *file = (struct capture_file){0};
    return -1;
}

int capture_file_open(const char *path, struct capture_file *out,
                      lum_error *error)
{
    *out = (struct capture_file){0};
    if (check_directory(path, error) != 0) {
        return -1;
    }
    if (!capture_file_is_in_place(path)) {
        out->path = resolve(path, error);
        if (out->path == NULL) {
            return -1;
        }
        out->part = name_part(out->path);
        if (out->part == NULL) {
            free(out->path);
            return lum_error_set(error, "%s: not enough memory", path);
        }
    }
    return open_writer(out, out->part != NULL ? out->part : path, error);
}

/* The writer makes a file anew, which would replace a link. */
int capture_file_record(const char *path, struct capture_file *out,
                        lum_error *error)
{
    *out = (struct capture_file){0};
    if (check_directory(path, error) != 0) {
        return -1;
    }
    if (!capture_file_is_in_place(path)) {
        out->path = resolve(path, error);
        if (out->path == NULL) {
            return -1;
        }
    }
    if (open_writer(out, out->path != NULL ? out->path : path, error) != 0) {
        return -1;
    }
    if (capture_file_flush(out, error) != 0) {
        capture_file_abort(out);
        return -1;
    }
    return 0;
}

int capture_file_add(struct capture_file *file, const lum_datagram *datagram,
                     lum_error *error)
{
    file->has_any = true;
    return lum_capture_writer_add(file->writer, datagram, error);
}

int capture_file_flush(struct capture_file *file, lum_error *error)
{
    return lum_capture_writer_flush(file->writer, error);
}

uint64_t capture_file_bytes(const struct capture_file *file)
{
    return lum_capture_writer_bytes(file->writer);
}

static int give_name(struct capture_file *file, lum_error *error)
{
    if (file->part == NULL || rename(file->part, file->path) == 0) {
        return 0;
    }
    return lum_error_set(error, "%s: cannot be renamed to %s: %s", file->part,
                         file->path, strerror(errno));
}

static void remove_part(struct capture_file *file)
{
    const int reason = errno;
    if (file->part != NULL) {
        (void)unlink(file->part);
    } else if (file->path != NULL && !file->has_any) {
        (void)unlink(file->path);
    }
    errno = reason;
}

int capture_file_close(struct capture_file *file, lum_error *error)
{
    int result = lum_capture_writer_close(file->writer, error);
    if (result == 0) {
        result = give_name(file, error);
    }
    if (result != 0) {
        remove_part(file);
    }
    free(file->path);
    free(file->part);
    return result;
}

void capture_file_abort(struct capture_file *file)
{
    /* What could not be written is removed anyway. */
    const int ignored = lum_capture_writer_close(file->writer, NULL);
    (void)ignored;
    remove_part(file);
    free(file->path);
    free(file->part);
}

void capture_file_abandon(struct capture_file *file)
{
    remove_part(file);
}
