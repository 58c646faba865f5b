#include "numbered.h"

#include "base/system.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static size_t stem_of(const char *path)
{
    const char *base = lum_system_base(path);
    const char *dot = strrchr(base, '.');
    return dot != NULL && dot != base ? (size_t)(dot - path) : strlen(path);
}

struct numbered numbered_of(const char *path)
{
    const char *percent = strchr(path, '%');
    if (percent != NULL) {
        return (struct numbered){path, (size_t)(percent - path), "",
                                 strchr(percent, 'd') + 1};
    }
    const size_t len = stem_of(path);
    return (struct numbered){path, len, "-", path + len};
}

bool numbered_has(const struct numbered *n, const char *base)
{
    const size_t divider_len = strlen(n->divider);
    if (strncmp(base, n->head, n->head_len) != 0 ||
        strncmp(base + n->head_len, n->divider, divider_len) != 0) {
        return false;
    }
    base += n->head_len + divider_len;
    const size_t count = strspn(base, "0123456789");
    return count > 0 && strcmp(base + count, n->tail) == 0;
}

/* A width past two digits would only pad. */
int numbered_name(const char *name, int64_t number, char *out, size_t room,
                  lum_error *error)
{
    const struct numbered n = numbered_of(name);
    const char *digits = *n.divider == '\0' ? name + n.head_len + 1 : "04";
    const long width = strtol(digits, NULL, 10);
    if (width > 64) {
        return lum_error_set(
            error, "%s: a frame number of %ld digits; use %%04d", name, width);
    }
    const int len =
        snprintf(out, room, *digits == '0' ? "%.*s%s%0*lld%s" : "%.*s%s%*lld%s",
                 (int)n.head_len, name, n.divider, (int)width,
                 (long long)number, n.tail);
    return len >= 0 && (size_t)len < room
               ? 0
               : lum_error_set(error, "%s: the name is too long", name);
}
