#include "nearest.h"

#include <string.h>

#define LENGTH_MAX 31

static size_t least(size_t a, size_t b, size_t c)
{
    const size_t ab = a < b ? a : b;
    return ab < c ? ab : c;
}

/* Letters to insert, remove or replace, one row of the table at a time. */
static size_t distance(const char *a, const char *b)
{
    size_t row[LENGTH_MAX + 1];
    const size_t n = strlen(b);
    for (size_t j = 0; j <= n; j++) {
        row[j] = j;
    }
    for (size_t i = 0; a[i] != '\0'; i++) {
        size_t diagonal = row[0];
        row[0] = i + 1;
        for (size_t j = 0; j < n; j++) {
            const size_t above = row[j + 1];
            row[j + 1] = least(above + 1, row[j] + 1,
                               diagonal + (a[i] == b[j] ? 0u : 1u));
            diagonal = above;
        }
    }
    return row[n];
}

const char *nearest(const char *text, const char *const *names, size_t count)
{
    const char *best = NULL;
    size_t least_distance = 3;
    for (size_t i = 0; i < count; i++) {
        const size_t len = strlen(names[i]);
        const size_t d =
            len <= LENGTH_MAX ? distance(text, names[i]) : least_distance;
        if (d < least_distance && 2 * d < len) {
            least_distance = d;
            best = names[i];
        }
    }
    return best;
}
