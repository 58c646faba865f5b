#include "numbered.h"

#include "base/system.h"

#include <stdio.h>
#include <string.h>

static size_t stem_of(const char *base)
{
    const char *dot = strrchr(base, '.');
    return dot != NULL && dot != base ? (size_t)(dot - base) : strlen(base);
}

struct numbered numbered_of(const char *base)
{
    const char *percent = strchr(base, '%');
    if (percent != NULL) {
        return (struct numbered){base, (size_t)(percent - base), "",
                                 strchr(percent, 'd') + 1};
    }
    const size_t len = stem_of(base);
    return (struct numbered){base, len, "-", base + len};
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

int numbered_name(const char *name, unsigned number, char *out, size_t room,
                  lum_error *error)
{
    const char *base = lum_system_base(name);
    const size_t stem = (size_t)(base - name) + stem_of(base);
    const int n = snprintf(out, room, "%.*s-%04u%s", (int)stem, name, number,
                           name + stem);
    if (n < 0 || (size_t)n >= room) {
        return lum_error_set(error, "%s: the name is too long", name);
    }
    return 0;
}
