#include "internal.h"

#include <regex.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What lives until the end of a telling. */
typedef union kept {
    union kept *next;
    long double aligned;
} kept;

static struct {
    kept *all;
    user_text *texts;
} memory;

static void *must(void *block)
{
    if (block == NULL) {
        abort();
    }
    return block;
}

void *user_keep(size_t bytes)
{
    kept *block = must(calloc(1, sizeof *block + bytes));
    block->next = memory.all;
    memory.all = block;
    return block + 1;
}

char *user_keep_text(const char *text, size_t size)
{
    char *copy = user_keep(size + 1);
    memcpy(copy, text, size);
    return copy;
}

user_text *user_text_new(void)
{
    user_text *text = user_keep(sizeof *text);
    text->room = 256;
    text->bytes = must(calloc(1, text->room));
    text->next = memory.texts;
    memory.texts = text;
    return text;
}

void user_text_add(user_text *text, const void *bytes, size_t size)
{
    while (text->room - text->size <= size) {
        text->room *= 2;
        text->bytes = must(realloc(text->bytes, text->room));
    }
    memcpy(text->bytes + text->size, bytes, size);
    text->size += size;
    text->bytes[text->size] = '\0';
}

void user_text_reset(void)
{
    for (user_text *t = memory.texts; t != NULL; t = t->next) {
        free(t->bytes);
    }
    memory.texts = NULL;
    while (memory.all != NULL) {
        kept *block = memory.all;
        memory.all = block->next;
        free(block);
    }
}

const char *user_format(const char *format, ...)
{
    va_list arguments;
    char text[4096];
    va_start(arguments, format);
    const int size = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (size < 0 || (size_t)size >= sizeof text) {
        user_fail(USER_HERE, "a text of %d bytes is too long", size);
    }
    return user_keep_text(text, (size_t)size);
}

bool user_has(const char *text, const char *part)
{
    return strstr(text, part) != NULL;
}

bool user_like(const char *text, const char *pattern)
{
    regex_t compiled;
    if (regcomp(&compiled, pattern, REG_EXTENDED | REG_NOSUB) != 0) {
        user_fail(USER_HERE, "no regular expression: %s", pattern);
    }
    const bool found = regexec(&compiled, text, 0, NULL, 0) == 0;
    regfree(&compiled);
    return found;
}

size_t user_count(const char *text, const char *part)
{
    size_t count = 0;
    for (const char *at = strstr(text, part); at != NULL;
         at = strstr(at + strlen(part), part)) {
        count++;
    }
    return count;
}

/* One word from *at on, without its quotes; NULL: none is left. */
static char *next_word(const char **at)
{
    const char *from = *at + strspn(*at, " ");
    if (*from == '\0') {
        return NULL;
    }
    char *word = user_keep(strlen(from) + 1);
    size_t size = 0;
    bool quoted = false;
    for (; *from != '\0' && (quoted || *from != ' '); from++) {
        if (*from == '\'') {
            quoted = !quoted;
        } else {
            word[size++] = *from;
        }
    }
    *at = from;
    return word;
}

const char **user_words(const char *line, size_t *count)
{
    const char **words = user_keep((strlen(line) / 2 + 2) * sizeof *words);
    *count = 0;
    for (const char *at = line; (words[*count] = next_word(&at)) != NULL;) {
        ++*count;
    }
    return words;
}
