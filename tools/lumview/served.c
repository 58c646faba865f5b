#define _POSIX_C_SOURCE 200809L
#include "served.h"

#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* More than a browser can take. */
#define BYTES_MAX (INT64_C(1) << 30)

/* How an array of NumPy begins. */
static const char magic[] = {'\x93', 'N', 'U', 'M', 'P', 'Y'};

static int refuse(lum_error *error, const char *name, const char *why)
{
    return lum_error_set(error, "%s: %s", name, why);
}

/* All of a file; NULL with the reason. */
static char *read_all(FILE *in, const char *name, size_t *len, lum_error *error)
{
    struct stat about;
    if (fstat(fileno(in), &about) != 0) {
        (void)refuse(error, name, strerror(errno));
        return NULL;
    }
    if (!S_ISREG(about.st_mode) || about.st_size < (off_t)sizeof magic ||
        about.st_size > BYTES_MAX) {
        (void)refuse(error, name,
                     "is no array of NumPy of at most 1 GB, as numpy.save() "
                     "writes it");
        return NULL;
    }
    *len = (size_t)about.st_size;
    char *bytes = malloc(*len);
    if (bytes == NULL || fread(bytes, 1, *len, in) != *len) {
        (void)refuse(error, name,
                     bytes == NULL ? "no memory for it" : "cannot be read");
        free(bytes);
        return NULL;
    }
    return bytes;
}

int served_add(struct served *served, const char *path, const char *name,
               lum_error *error)
{
    size_t len = 0;
    FILE *in = name != NULL ? fopen(name, "rb") : NULL;
    if (name == NULL) {
        return 0;
    }
    if (in == NULL) {
        return refuse(error, name, strerror(errno));
    }
    char *bytes = read_all(in, name, &len, error);
    (void)fclose(in);
    if (bytes == NULL) {
        return -1;
    }
    if (memcmp(bytes, magic, sizeof magic) != 0) {
        free(bytes);
        return refuse(error, name,
                      "is no array of NumPy, as numpy.save() writes it");
    }
    served_put(served, path, bytes, len);
    return 0;
}

void served_put(struct served *served, const char *path, char *bytes,
                size_t len)
{
    served->memory[served->count] = bytes;
    served->files[served->count++] = (struct asset){
        .path = path,
        .type = "application/octet-stream",
        .bytes = bytes,
        .len = len,
    };
}

bool served_is_array(const char *name)
{
    char begin[sizeof magic];
    FILE *in = fopen(name, "rb");
    const bool is_array = in != NULL &&
                          fread(begin, 1, sizeof begin, in) == sizeof begin &&
                          memcmp(begin, magic, sizeof magic) == 0;
    if (in != NULL) {
        (void)fclose(in);
    }
    return is_array;
}

const struct asset *served_find(const struct served *served, const char *path)
{
    for (size_t i = 0; served != NULL && i < served->count; i++) {
        if (strcmp(served->files[i].path, path) == 0) {
            return &served->files[i];
        }
    }
    return NULL;
}

void served_free(struct served *served)
{
    while (served->count > 0) {
        free(served->memory[--served->count]);
    }
}
