#include "keys_internal.h"

/* Bytes of the mappings that two paths have in common, with the dot. No path is
 * there twice, so two paths differ before their ends. */
static size_t common(const char *a, const char *b)
{
    size_t found = 0;
    for (size_t i = 0; a[i] == b[i]; i++) {
        if (a[i] == '.') {
            found = i + 1;
        }
    }
    return found;
}

static void add_indent(const char *path, size_t at, lum_key_text *text)
{
    for (size_t i = 0; i < at; i++) {
        lum_key_text_add(text, path[i] == '.' ? "  " : "");
    }
}

/* Adds the mappings that begin with this path, and its last key. */
static void add_path(const char *path, const char *before, lum_key_text *text)
{
    size_t at = common(path, before);
    for (size_t i = at; path[i] != '\0'; i++) {
        if (path[i] == '.') {
            add_indent(path, at, text);
            lum_key_text_add_bytes(text, path + at, i - at);
            lum_key_text_add(text, ":\n");
            at = i + 1;
        }
    }
    add_indent(path, at, text);
    lum_key_text_add(text, path + at);
    lum_key_text_add(text, ": ");
}

/* A key that can also be a mapping is written as a mapping, unless its value is
 * a word, for example none, which no key below it can express. Rare values are
 * left out where they are usual. */
size_t lum_keys_write(const lum_keys *keys, char *out, size_t size)
{
    const lum_key_table *table = lum_keys_table(keys);
    lum_key_text text = lum_key_text_begin(out, size);
    const char *before = "";
    const lum_key_entry *word = NULL;
    for (size_t i = 0; i < table->count; i++) {
        const lum_key_entry *e = &table->entries[i];
        const int64_t number = keys->values[e->index].number;
        if (word != NULL && lum_key_within(e->path, word->path) != NULL) {
            continue;
        }
        word = lum_key_rule_is_word(e->rule, number) ? e : NULL;
        if (word == NULL && lum_key_table_is_mapping(table, e->path)) {
            continue;
        }
        if (e->rule->rare && number == e->rule->usual) {
            continue;
        }
        add_path(e->path, before, &text);
        lum_key_rule_add_value(e->rule, number, &text);
        lum_key_text_add(&text, "\n");
        before = e->path;
    }
    return text.len;
}
