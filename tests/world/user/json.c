#include "internal.h"

#include <stdlib.h>
#include <string.h>

/* JSON as the tools write it, which is taken to be well-formed. */

static const char *skip_blanks(const char *at)
{
    return at + strspn(at, " \t\r\n");
}

/* Behind a text that begins here. */
static const char *skip_text(const char *at)
{
    for (at++; *at != '"' && *at != '\0'; at++) {
        if (*at == '\\' && at[1] != '\0') {
            at++;
        }
    }
    return *at == '"' ? at + 1 : at;
}

/* Behind a value that begins here. */
static const char *skip_value(const char *at)
{
    unsigned depth = 0;
    if (*at != '{' && *at != '[') {
        return *at == '"' ? skip_text(at) : at + strcspn(at, ",]} \t\r\n");
    }
    do {
        if (*at == '"') {
            at = skip_text(at);
            continue;
        }
        depth += *at == '{' || *at == '[' ? 1 : 0;
        depth -= *at == '}' || *at == ']' ? 1 : 0;
        at++;
    } while (depth > 0 && *at != '\0');
    return at;
}

/* The value of a key of an object; NULL: none. */
static const char *of_object(const char *at, const char *key, size_t size)
{
    at = skip_blanks(at + 1);
    while (*at == '"') {
        const char *end = skip_text(at);
        const bool is_it =
            (size_t)(end - at) == size + 2 && memcmp(at + 1, key, size) == 0;
        at = skip_blanks(end);
        at = skip_blanks(at + (*at == ':' ? 1 : 0));
        if (is_it) {
            return at;
        }
        at = skip_blanks(skip_value(at));
        at = skip_blanks(at + (*at == ',' ? 1 : 0));
    }
    return NULL;
}

static const char *of_array(const char *at, size_t index)
{
    at = skip_blanks(at + 1);
    for (; *at != ']' && *at != '\0'; index--) {
        if (index == 0) {
            return at;
        }
        at = skip_blanks(skip_value(at));
        at = skip_blanks(at + (*at == ',' ? 1 : 0));
    }
    return NULL;
}

static const char *find(const char *json, const char *path)
{
    const char *at = skip_blanks(json);
    while (at != NULL && *path != '\0') {
        const size_t size = strcspn(path, ".");
        if (*at == '{') {
            at = of_object(at, path, size);
        } else {
            at = *at == '[' ? of_array(at, strtoul(path, NULL, 10)) : NULL;
        }
        path += size + (path[size] == '.' ? 1 : 0);
    }
    return at;
}

const char *user_value(const char *json, const char *path)
{
    const char *at = find(json, path);
    if (at == NULL || *at == '\0') {
        return NULL;
    }
    const size_t size = (size_t)(skip_value(at) - at);
    return *at == '"' && size >= 2 ? user_keep_text(at + 1, size - 2)
                                   : user_keep_text(at, size);
}

double user_number(const char *json, const char *path)
{
    char *end = NULL;
    const char *value = user_value(json, path);
    const double number = value != NULL ? strtod(value, &end) : 0;
    if (value == NULL || end == value) {
        user_fail(USER_HERE, "no number %s in %.300s", path, json);
    }
    return number;
}

size_t user_length(const char *json, const char *path)
{
    const char *at = find(json, path);
    size_t count = 0;
    while (at != NULL && *at == '[' && of_array(at, count) != NULL) {
        count++;
    }
    return count;
}
