#include "line_words.h"

#include <stdbool.h>
#include <string.h>

static bool is_space(char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

void words_trim(char *text)
{
    size_t first = 0;
    size_t end = strlen(text);
    while (is_space(text[first])) {
        first++;
    }
    while (end > first && is_space(text[end - 1])) {
        end--;
    }
    memmove(text, text + first, end - first);
    text[end - first] = '\0';
}

/* One word from *in on, copied to *out without its quotes. False if a quote is
 * not closed. */
static bool cut_one(const char **in, char **out)
{
    char quote = '\0';
    const char *p = *in;
    for (; *p != '\0' && (quote != '\0' || !is_space(*p)); p++) {
        if (quote == '\0' && (*p == '"' || *p == '\'')) {
            quote = *p;
        } else if (*p == quote) {
            quote = '\0';
        } else {
            *(*out)++ = *p;
        }
    }
    *in = p;
    return quote == '\0';
}

int words_cut(char *text, char **words, int max)
{
    const char *in = text;
    char *out = text;
    int count = 0;
    for (;;) {
        in += strspn(in, " \t\r\n");
        if (*in == '\0') {
            return count;
        }
        if (count == max) {
            return -1;
        }
        words[count++] = out;
        if (!cut_one(&in, &out)) {
            return -1;
        }
        const bool is_last = *in == '\0';
        *out++ = '\0';
        if (is_last) {
            return count;
        }
        in++;
    }
}
