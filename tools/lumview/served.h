/* Files that the page fetches beside the points: arrays of NumPy with labels,
 * and with points that are true. */
#ifndef LUMVIEW_SERVED_H
#define LUMVIEW_SERVED_H

#include "assets.h"
#include "lum/base/error.h"

#include <stdbool.h>
#include <stddef.h>

#define SERVED_MAX 2u

struct served {
    struct asset files[SERVED_MAX];
    char *memory[SERVED_MAX]; /* of each */
    size_t count;
};

/* Read an array to be served under a path, which is kept; name: NULL, nothing
 * is read. 0, or -1 with the reason. */
int served_add(struct served *served, const char *path, const char *name,
               lum_error *error);

/* The same of bytes that are there, made by malloc() and taken over. */
void served_put(struct served *served, const char *path, char *bytes,
                size_t len);

/* Whether a file begins as an array does. */
bool served_is_array(const char *name);

/* NULL: there is none. */
const struct asset *served_find(const struct served *served, const char *path);

void served_free(struct served *served);

#endif
