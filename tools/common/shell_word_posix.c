/* Names of files as words of a POSIX shell. */
#include "shell_word.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwx"
                            "yz0123456789_@%+=:,./-";

static bool can_be_shown(const char *name)
{
    for (const char *p = name; *p != '\0'; p++) {
        if ((unsigned char)*p < 0x20 || *p == 0x7f) {
            return false;
        }
    }
    return true;
}

/* Nothing is special between single quotes but the quote itself. Returns the
 * bytes of the whole. */
static size_t put_quoted(const char *name, char *out, size_t room)
{
    size_t len = 1;
    for (const char *p = name; *p != '\0'; p++) {
        len += *p == '\'' ? 4u : 1u;
    }
    if (len + 2 > room) {
        return len + 1;
    }
    char *to = out;
    *to++ = '\'';
    for (const char *p = name; *p != '\0'; p++) {
        if (*p == '\'') {
            memcpy(to, "'\\''", 4);
            to += 4;
        } else {
            *to++ = *p;
        }
    }
    memcpy(to, "'", 2);
    return len + 1;
}

const char *shell_word(const char *name, char *out, size_t room)
{
    const char *folder = name[0] == '-' ? "./" : "";
    const size_t before = strlen(folder);
    const bool is_plain = name[0] != '\0' && name[strspn(name, plain)] == '\0';
    if (!can_be_shown(name) || room <= before) {
        return NULL;
    }
    (void)snprintf(out, room, "%s", folder);
    const size_t len =
        is_plain ? (size_t)snprintf(out + before, room - before, "%s", name)
                 : put_quoted(name, out + before, room - before);
    return before + len < room ? out : NULL;
}
