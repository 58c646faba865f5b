/* The page: its own files and the modules it uses, as the build found them. */
#ifndef LUMVIEW_ASSETS_H
#define LUMVIEW_ASSETS_H

#include <stddef.h>

struct asset {
    const char *path; /* of the URL */
    const char *type; /* MIME */
    const char *bytes;
    size_t len;
};

extern const struct asset assets[];
extern const size_t assets_count;

/* SHA-256 of the import map, in base64: the one inline script. */
extern const char assets_import_map_hash[];

#endif
