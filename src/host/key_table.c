#include "key_table.h"

#include <string.h>

#define WORD_MAX 32 /* longest key that is compared with the known ones */

static size_t min_of(size_t a, size_t b)
{
    return a < b ? a : b;
}

static bool is_same(const char *a, size_t a_len, const char *b, size_t b_len)
{
    return a_len == b_len && memcmp(a, b, a_len) == 0;
}

const char *lum_key_within(const char *entry, const char *path)
{
    const char *p = path;
    while (*p != '\0' && *p == *entry) {
        p++;
        entry++;
    }
    if (*p != '\0') {
        return NULL;
    }
    if (p == path) {
        return entry;
    }
    return *entry == '.' ? entry + 1 : NULL;
}

/* Bytes of a path's first key. */
static size_t first_key(const char *path)
{
    const char *end = path;
    while (*end != '\0' && *end != '.') {
        end++;
    }
    return (size_t)(end - path);
}

size_t lum_key_table_find(const lum_key_table *table, const char *path,
                          const char *name, size_t len)
{
    size_t i = 0;
    while (i < table->count) {
        const char *rest = lum_key_within(table->entries[i].path, path);
        if (rest != NULL && is_same(rest, first_key(rest), name, len)) {
            break;
        }
        i++;
    }
    return i;
}

const lum_key_entry *lum_key_table_entry(const lum_key_table *table,
                                         const char *path)
{
    const size_t len = lum_key_text_length(path);
    for (size_t i = 0; i < table->count; i++) {
        const char *other = table->entries[i].path;
        if (is_same(other, lum_key_text_length(other), path, len)) {
            return &table->entries[i];
        }
    }
    return NULL;
}

bool lum_key_table_is_mapping(const lum_key_table *table, const char *path)
{
    size_t i = 0;
    while (i < table->count &&
           lum_key_within(table->entries[i].path, path) == NULL) {
        i++;
    }
    return i < table->count;
}

/* The next key of a mapping that may be given, from *at on, and its length;
 * NULL: there is none. */
static const char *next_name(const lum_key_table *table, const char *path,
                             size_t *at, size_t *len)
{
    for (size_t i = *at; i < table->count; i++) {
        const char *name = lum_key_within(table->entries[i].path, path);
        if (name == NULL || table->entries[i].rule->refusal != NULL) {
            continue;
        }
        *len = first_key(name);
        if (lum_key_table_find(table, path, name, *len) == i) {
            *at = i + 1;
            return name;
        }
    }
    return NULL;
}

void lum_key_table_add_names(const lum_key_table *table, const char *path,
                             lum_key_text *text)
{
    const char *between = "";
    size_t at = 0;
    size_t len = 0;
    const char *name = next_name(table, path, &at, &len);
    while (name != NULL) {
        lum_key_text_add(text, between);
        lum_key_text_add_bytes(text, name, len);
        between = ", ";
        name = next_name(table, path, &at, &len);
    }
}

void lum_key_table_refuse_value(const lum_key_table *table, const char *path,
                                const char *what, lum_key_text *text)
{
    const lum_key_entry *entry = lum_key_table_entry(table, path);
    lum_key_text_add(text, what);
    lum_key_text_add(text, "; allowed: ");
    if (entry != NULL) {
        lum_key_rule_add_allowed(entry->rule, text);
    }
    if (lum_key_table_is_mapping(table, path)) {
        lum_key_text_add(text, entry != NULL ? ", or " : "");
        lum_key_text_add(text, "a mapping of ");
        lum_key_table_add_names(table, path, text);
    }
}

/* Number of letters to insert, remove or change to get from one to the
 * other. */
static size_t distance(const char *a, size_t a_len, const char *b, size_t b_len)
{
    size_t row[WORD_MAX + 1];
    for (size_t j = 0; j <= WORD_MAX; j++) {
        row[j] = j;
    }
    for (size_t i = 1; i <= a_len; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b_len; j++) {
            const size_t change = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = min_of(change, 1 + min_of(row[j], row[j - 1]));
        }
    }
    return row[b_len];
}

/* The known key that was probably meant and its length, or NULL. */
static const char *nearest(const lum_key_table *table, const char *path,
                           const char *text, size_t len, size_t *best_len)
{
    const char *best = NULL;
    size_t least = 3;
    size_t at = 0;
    size_t name_len = 0;
    const char *name = next_name(table, path, &at, &name_len);
    while (name != NULL && len <= WORD_MAX) {
        const size_t d = distance(text, len, name, min_of(name_len, WORD_MAX));
        if (d < least && 3 * d <= min_of(len, name_len)) {
            least = d;
            best = name;
            *best_len = name_len;
        }
        name = next_name(table, path, &at, &name_len);
    }
    return best;
}

void lum_key_table_refuse_key(const lum_key_table *table, const char *path,
                              const char *name, size_t len, lum_key_text *text)
{
    size_t near_len = 0;
    const char *near = nearest(table, path, name, len, &near_len);
    lum_key_text_add(text, "unknown key '");
    lum_key_text_add_quoted(text, name, len);
    lum_key_text_add(text, near != NULL ? "'; did you mean '" : "'");
    if (near != NULL) {
        lum_key_text_add_bytes(text, near, near_len);
        lum_key_text_add(text, "'?");
    } else {
        lum_key_text_add(text, ";");
    }
    lum_key_text_add(text, " allowed here: ");
    lum_key_table_add_names(table, path, text);
}

bool lum_key_table_read(const lum_key_table *table, const lum_key_entry *entry,
                        lum_key_given given, int64_t *out, lum_key_text *text)
{
    const char *why = lum_key_rule_read(entry->rule, given, out);
    if (why == NULL) {
        return true;
    }
    lum_key_text_add(text, "'");
    lum_key_text_add_quoted(text, given.text, given.len);
    lum_key_text_add(text, "' ");
    lum_key_table_refuse_value(table, entry->path, why, text);
    return false;
}
