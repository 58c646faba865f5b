/* Names of files as words of the command line of Windows. */
#include "shell_word.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static const char plain[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwx"
                            "yz0123456789_@+:./\\-";

/* No name there has a double quote. */
const char *shell_word(const char *name, char *out, size_t room)
{
    const char *folder = name[0] == '-' ? ".\\" : "";
    const bool is_plain = name[0] != '\0' && name[strspn(name, plain)] == '\0';
    const char *quote = is_plain ? "" : "\"";
    for (const char *p = name; *p != '\0'; p++) {
        if ((unsigned char)*p < 0x20 || *p == 0x7f || *p == '"') {
            return NULL;
        }
    }
    const int len = snprintf(out, room, "%s%s%s%s", quote, folder, name, quote);
    return len >= 0 && (size_t)len < room ? out : NULL;
}
