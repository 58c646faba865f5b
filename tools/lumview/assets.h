/* The page, as bundle.cmake put it together. */
#ifndef LUMVIEW_ASSETS_H
#define LUMVIEW_ASSETS_H

#include <stdbool.h>
#include <stddef.h>

struct asset {
    const char *path; /* of the URL */
    const char *type; /* MIME */
    const char *bytes;
    size_t len;
    bool is_kept; /* compressed by gzip; never another under this path */
};

extern const struct asset assets[];
extern const size_t assets_count;

#endif
