#include "store.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static int fail(const char *path, lum_error *error)
{
    return lum_error_set(error, "%s: cannot be read: %s", path,
                         strerror(errno));
}

int store_read(const char *path, char *out, size_t size, lum_error *error)
{
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        return errno == ENOENT || errno == ENOTDIR ? 0 : fail(path, error);
    }
    errno = 0;
    const size_t len = fread(out, 1, size, file);
    const int result = ferror(file) != 0 ? fail(path, error) : 1;
    (void)fclose(file);
    if (result == 1 && (len == size || memchr(out, '\0', len) != NULL)) {
        return lum_error_set(error, "%s: is not a state file of lumctl", path);
    }
    out[len < size ? len : 0] = '\0';
    return result;
}
