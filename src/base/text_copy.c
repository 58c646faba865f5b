#include "base/text_copy.h"

#include <stdlib.h>
#include <string.h>

char *lum_text_copy(const char *text)
{
    const size_t len = strlen(text) + 1u;
    char *copy = malloc(len);
    if (copy != NULL) {
        memcpy(copy, text, len);
    }
    return copy;
}
