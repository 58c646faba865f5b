#include "base/sized.h"

#include <errno.h>
#include <stdint.h>
#include <string.h>

/* The caller's struct may be shorter than any that is declared here, so its
 * members are not named. */
static size_t size_of(const void *sized)
{
    size_t size = 0;
    memcpy(&size, sized, sizeof size);
    return size;
}

/* All but struct_size; a size that covers no more than that is not set. */
static bool copy(void *to, const void *from, size_t size)
{
    if (size <= sizeof size) {
        return false;
    }
    memcpy((uint8_t *)to + sizeof size, (const uint8_t *)from + sizeof size,
           size - sizeof size);
    return true;
}

int lum_sized_take(void *out, size_t size, const void *from, const char *what,
                   const char *type, lum_error *error)
{
    const size_t given = size_of(from);
    memset(out, 0, size);
    memcpy(out, &size, sizeof size);
    if (!copy(out, from, given < size ? given : size)) {
        (void)lum_error_set(error,
                            "struct_size of %s is not set; set it to "
                            "sizeof(%s)",
                            what, type);
        errno = EINVAL;
        return -1;
    }
    return 0;
}

bool lum_sized_fill(void *out, const void *from, size_t size)
{
    const size_t asked = size_of(out);
    return copy(out, from, asked < size ? asked : size);
}
