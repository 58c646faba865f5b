/** @file
 * Tables of keys by their paths, such as "eyes.blue.mount.x_m", and the check
 * of values. Internal to host and config.
 *
 * Keys of one mapping are neighbours; if a mapping can also be a single value
 * ("group.tag" beside "group.tag.at"), that comes first. */
#ifndef LUM_HOST_KEY_TABLE_H
#define LUM_HOST_KEY_TABLE_H

#include "key_rule.h"
#include "lum/host/keys.h"

/** A key that has a value. */
typedef struct lum_key_entry {
    const char *path;         /**< at most LUM_KEY_BYTES - 1 bytes */
    unsigned index;           /**< of its value */
    const lum_key_rule *rule; /**< for the value */
} lum_key_entry;

/** Keys and their rules. */
typedef struct lum_key_table {
    const lum_key_entry *entries; /**< count of them */
    size_t count;                 /**< at most LUM_KEY_ENTRIES_MAX */
} lum_key_table;

/** Most entries of a table. */
#define LUM_KEY_ENTRIES_MAX 72

/** The rest of a path after a mapping's path, or NULL: it is not in the
 * mapping. */
const char *lum_key_within(const char *other, const char *path);

/** The first entry at or below a key of a mapping.
 * @param path the mapping's; empty: the table itself.
 * @param name len bytes: the key within it.
 * @return table->count: there is none. */
size_t lum_key_table_find(const lum_key_table *table, const char *path,
                          const char *name, size_t len);

/** The entry of exactly this path, or NULL: it is only a mapping. */
const lum_key_entry *lum_key_table_entry(const lum_key_table *table,
                                         const char *path);

/** Whether there are keys below a path. */
bool lum_key_table_is_mapping(const lum_key_table *table, const char *path);

/** Add the keys of a mapping, such as "at, bytes". */
void lum_key_table_add_names(const lum_key_table *table, const char *path,
                             lum_key_text *text);

/** Make the message that a path's value is refused: what is wrong, and what is
 * allowed. */
void lum_key_table_refuse_value(const lum_key_table *table, const char *path,
                                const char *what, lum_key_text *text);

/** Make the message that a mapping has no such key: which one may be meant, and
 * which exist. */
void lum_key_table_refuse_key(const lum_key_table *table, const char *path,
                              const char *name, size_t len, lum_key_text *text);

/** Read an entry's value.
 * @param out  its values, by index; written only on success.
 * @param text gets what is wrong and what is allowed.
 * @return whether it is allowed. */
bool lum_key_table_read(const lum_key_table *table, const lum_key_entry *entry,
                        lum_key_given given, int64_t *out, lum_key_text *text);

#endif
