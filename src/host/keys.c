#include "keys_internal.h"

#include <string.h>

const lum_key_table *lum_keys_table(const lum_keys *keys)
{
    return keys->kind == LUM_KEYS_PROFILE ? &lum_profile_keys
                                          : &lum_calibration_keys;
}

static size_t part_length(const char *part)
{
    size_t len = 0;
    while (part[len] != '\0' && part[len] != '.') {
        len++;
    }
    return len;
}

/* Follows a key as far as its mappings are known. Returns the part that is
 * unknown or lies below a value; NULL: all is known. */
static const char *follow(const lum_key_table *table, const char *key,
                          char path[LUM_KEY_BYTES])
{
    lum_key_text known = lum_key_text_begin(path, LUM_KEY_BYTES);
    for (const char *part = key;; part++) {
        const size_t len = part_length(part);
        if (lum_key_table_find(table, path, part, len) == table->count) {
            return part;
        }
        lum_key_text_add(&known, known.len > 0 ? "." : "");
        lum_key_text_add_bytes(&known, part, len);
        part += len;
        if (*part == '\0') {
            return NULL;
        }
    }
}

lum_result lum_key_refuse_key(const lum_key_table *table, const char *key,
                              uint32_t place, lum_key_refusal *why)
{
    char path[LUM_KEY_BYTES];
    const char *part = follow(table, key, path);
    lum_key_text text = lum_key_refuse(why, path, place);
    if (part == NULL) {
        lum_key_table_refuse_value(
            table, path, "a single value does not belong here", &text);
    } else if (lum_key_table_is_mapping(table, path)) {
        lum_key_table_refuse_key(table, path, part, part_length(part), &text);
    } else {
        lum_key_table_refuse_value(table, path,
                                   "a mapping does not belong here", &text);
    }
    return LUM_E_TYPE;
}

lum_result lum_keys_set(lum_keys *keys, const char *key, const char *value,
                        uint32_t place, lum_key_refusal *why)
{
    const lum_key_table *table = lum_keys_table(keys);
    const lum_key_entry *entry = lum_key_table_entry(table, key);
    const lum_key_given given = {value, lum_key_text_length(value), false};
    int64_t number = 0;
    if (entry == NULL) {
        return lum_key_refuse_key(table, key, place, why);
    }
    lum_key_refusal refused;
    lum_key_text text = lum_key_refuse(&refused, key, place);
    if (place == 0) {
        lum_key_text_add(&text, "a value that is set comes from a place above "
                                "0");
    } else if (lum_key_table_read(table, entry, given, &number, &text)) {
        keys->values[entry->index] = (lum_key_value){number, place};
        return LUM_OK;
    }
    if (why != NULL) {
        *why = refused;
    }
    return LUM_E_VALUE;
}

lum_result lum_keys_get(const lum_keys *keys, const char *key,
                        char out[LUM_KEY_VALUE_BYTES])
{
    const lum_key_entry *entry = lum_key_table_entry(lum_keys_table(keys), key);
    if (entry == NULL) {
        return LUM_E_TYPE;
    }
    lum_key_text text = lum_key_text_begin(out, LUM_KEY_VALUE_BYTES);
    lum_key_rule_add_value(entry->rule, keys->values[entry->index].number,
                           &text);
    return LUM_OK;
}

static lum_key_kind kind_of(const lum_key_rule *rule)
{
    if (!lum_key_rule_takes_numbers(rule)) {
        return LUM_KEY_WORD;
    }
    if (rule->pair) {
        return LUM_KEY_WORD_OR_PAIR;
    }
    if (rule->words != NULL) {
        return rule->whole ? LUM_KEY_WORD_OR_WHOLE : LUM_KEY_WORD_OR_DECIMAL;
    }
    return rule->whole ? LUM_KEY_WHOLE : LUM_KEY_DECIMAL;
}

static void describe_words(const lum_key_rule *rule, lum_key *out)
{
    const size_t most = sizeof out->words / sizeof out->words[0] - 1;
    for (size_t i = 0; rule->words != NULL && i < most; i++) {
        out->words[i] = rule->words[i].text;
        if (out->words[i] == NULL) {
            break;
        }
    }
}

/* Of a pair, one of twice that number. */
static void add_limit(const lum_key_rule *rule, int64_t number,
                      lum_key_text *text)
{
    if (rule->pair) {
        lum_key_rule_add_value(rule, LUM_KEY_PAIR(number, number), text);
    } else {
        lum_key_text_add_number(text, number, rule->decimals);
    }
}

static void describe_numbers(const lum_key_rule *rule, lum_key *out)
{
    lum_key_text min = lum_key_text_begin(out->min, sizeof out->min);
    lum_key_text max = lum_key_text_begin(out->max, sizeof out->max);
    if (lum_key_rule_takes_numbers(rule)) {
        add_limit(rule, rule->min, &min);
        add_limit(rule, rule->max, &max);
    }
}

lum_result lum_keys_describe(const lum_keys *keys, size_t i, lum_key *out)
{
    const lum_key_table *table = lum_keys_table(keys);
    if (i >= table->count) {
        return LUM_E_VALUE;
    }
    const lum_key_entry *entry = &table->entries[i];
    lum_keys usual;
    if (keys->kind == LUM_KEYS_PROFILE) {
        lum_keys_of_profile(&usual, NULL);
    } else {
        lum_keys_of_calibration(&usual, NULL);
    }
    memset(out, 0, sizeof *out);
    out->name = entry->path;
    out->kind = kind_of(entry->rule);
    out->unit = entry->rule->unit != NULL ? entry->rule->unit : "";
    describe_words(entry->rule, out);
    describe_numbers(entry->rule, out);
    lum_key_text text = lum_key_text_begin(out->allowed, sizeof out->allowed);
    lum_key_rule_add_allowed(entry->rule, &text);
    return lum_keys_get(&usual, entry->path, out->usual);
}

/* --- As YAML --- */

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
