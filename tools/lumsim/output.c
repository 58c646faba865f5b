#define _POSIX_C_SOURCE 200809L
#include "output.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

bool output_is_in_place(const char *path)
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

int output_open(const char *path, struct output *out, lum_error *error)
{
    *out = (struct output){.path = path};
    if (is_directory_missing(path)) {
        return lum_error_set(error,
                             "%s: cannot create it: the directory does not "
                             "exist; create it or write elsewhere",
                             path);
    }
    if (!output_is_in_place(path)) {
        out->part = name_part(path);
        if (out->part == NULL) {
            return lum_error_set(error, "%s: not enough memory", path);
        }
    }
    if (lum_capture_writer_open(out->part != NULL ? out->part : path,
                                &out->writer, error) != 0) {
        free(out->part);
        return -1;
    }
    return 0;
}

int output_add(struct output *output, const lum_datagram *datagram,
               lum_error *error)
{
    return lum_capture_writer_add(output->writer, datagram, error);
}

static int give_name(struct output *output, lum_error *error)
{
    if (output->part == NULL || rename(output->part, output->path) == 0) {
        return 0;
    }
    return lum_error_set(error, "%s: cannot be renamed to %s: %s", output->part,
                         output->path, strerror(errno));
}

static void remove_part(struct output *output)
{
    const int reason = errno;
    if (output->part != NULL) {
        (void)unlink(output->part);
    }
    errno = reason;
}

int output_close(struct output *output, lum_error *error)
{
    int result = lum_capture_writer_close(output->writer, error);
    if (result == 0) {
        result = give_name(output, error);
    }
    if (result != 0) {
        remove_part(output);
    }
    free(output->part);
    return result;
}

void output_abort(struct output *output)
{
    /* What could not be written is removed anyway. */
    const int ignored = lum_capture_writer_close(output->writer, NULL);
    (void)ignored;
    remove_part(output);
    free(output->part);
}

void output_abandon(struct output *output)
{
    remove_part(output);
}
