#include "yaml.h"

#include "base/text.h"
#include "lum/config/config.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <yaml.h>

#define PATH_BYTES    96    /* of the longest path of the tables' keys */
#define PREFIX_BYTES  32    /* of a list's key and a number */
#define NAME_BYTES    208   /* of a file's name in a message */
#define PAIR_BYTES    64    /* of two numbers; more are cut, and none of it */
#define TEXT_BYTES    1024u /* of a value that is handed on as text */
#define MESSAGE_BYTES LUM_KEY_MESSAGE_BYTES

typedef struct reader {
    yaml_parser_t parser;
    yaml_event_t event; /* the one at hand */
    const lum_yaml_source *source;
    const lum_key_table *table;
    lum_key_value *values;
    lum_error *error;
    const lum_yaml_list *list; /* NULL: none, or it is being read */
    lum_yaml_take_text take_text;
    void *context;             /* of that */
    unsigned line;             /* of the key at hand */
    char prefix[PREFIX_BYTES]; /* of paths in messages: "steps.3" */
    char path[PATH_BYTES];
} reader;

/* --- Messages --- */

/* A name with what could break or forge a line replaced, its front cut where
 * it is long. */
static void clean_name(const char *name, char out[NAME_BYTES])
{
    const size_t len = strlen(name);
    const size_t room = NAME_BYTES - 4;
    out[0] = '\0';
    lum_text_add(out, NAME_BYTES, "%s%s", len > room ? "..." : "",
                 len > room ? name + (len - room) : name);
    for (char *p = out; *p != '\0'; p++) {
        if ((unsigned char)*p < 0x20 || *p == 0x7f) {
            *p = '?';
        }
    }
}

int lum_yaml_fail(lum_error *error, const char *name, unsigned line,
                  const char *key, const char *format, ...)
{
    char where[NAME_BYTES];
    char number[16] = "";
    char message[LUM_ERROR_BYTES];
    va_list arguments;
    clean_name(name, where);
    if (line > 0) {
        (void)snprintf(number, sizeof number, ":%u", line);
    }
    va_start(arguments, format);
    (void)vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    return key == NULL || key[0] == '\0'
               ? lum_error_set(error, "%s%s: %s", where, number, message)
               : lum_error_set(error, "%s%s: %s: %s", where, number, key,
                               message);
}

#define FAIL(r, ...)                                                           \
    lum_yaml_fail((r)->error, (r)->source->name, (r)->line,                    \
                  full_path((r), (char[FULL_BYTES]){""}), __VA_ARGS__)

#define FULL_BYTES (PREFIX_BYTES + PATH_BYTES)

static const char *full_path(const reader *r, char out[FULL_BYTES])
{
    const bool has_both = r->prefix[0] != '\0' && r->path[0] != '\0';
    lum_text_add(out, FULL_BYTES, "%s%s%s", r->prefix, has_both ? "." : "",
                 r->path);
    return out;
}

static int refuse_value(reader *r, const char *what)
{
    char message[MESSAGE_BYTES];
    lum_key_text text = lum_key_text_begin(message, sizeof message);
    lum_key_table_refuse_value(r->table, r->path, what, &text);
    return FAIL(r, "%s", message);
}

static int refuse_key(reader *r, const char *name, size_t len)
{
    char message[MESSAGE_BYTES];
    lum_key_text text = lum_key_text_begin(message, sizeof message);
    lum_key_table_refuse_key(r->table, r->path, name, len, &text);
    return FAIL(r, "%s", message);
}

static size_t min_of(size_t a, size_t b)
{
    return a < b ? a : b;
}

static unsigned line_of(size_t mark)
{
    return (unsigned)mark + 1u;
}

/* Lines are counted here because libyaml gives the place of invalid text only
 * as a byte. */
static unsigned line_of_byte(const lum_yaml_source *source, size_t offset)
{
    unsigned line = 1;
    for (size_t i = 0; i < min_of(offset, source->len); i++) {
        line += source->text[i] == '\n';
    }
    return line;
}

static bool is_indented_by_tab(const lum_yaml_source *source, unsigned line)
{
    size_t i = 0;
    while (i < source->len && line > 1) {
        line -= source->text[i++] == '\n';
    }
    while (i < source->len && source->text[i] == ' ') {
        i++;
    }
    return i < source->len && source->text[i] == '\t';
}

static int refuse_syntax(reader *r)
{
    const yaml_parser_t *p = &r->parser;
    const char *problem = p->problem != NULL ? p->problem : "unreadable";
    r->path[0] = '\0';
    r->prefix[0] = '\0';
    r->line = line_of(p->problem_mark.line);
    switch (p->error) {
    case YAML_MEMORY_ERROR:
        return FAIL(r, "out of memory");
    case YAML_READER_ERROR:
        r->line = line_of_byte(r->source, p->problem_offset);
        return FAIL(r, "not plain UTF-8 text: %s", problem);
    default:
        break;
    }
    if (is_indented_by_tab(r->source, r->line)) {
        return FAIL(r, "a tab indents this line; use spaces");
    }
    return p->context == NULL
               ? FAIL(r, "not valid YAML: %s", problem)
               : FAIL(r, "not valid YAML: %s %s (line %u)", problem, p->context,
                      line_of(p->context_mark.line));
}

/* --- Events and scalars of libyaml --- */

static int next(reader *r)
{
    yaml_event_delete(&r->event);
    return yaml_parser_parse(&r->parser, &r->event) != 0 ? 0 : refuse_syntax(r);
}

static const char *scalar_text(const reader *r)
{
    return (const char *)r->event.data.scalar.value;
}

static size_t scalar_len(const reader *r)
{
    return r->event.data.scalar.length;
}

static bool is_plain(const reader *r)
{
    return r->event.data.scalar.style == YAML_PLAIN_SCALAR_STYLE;
}

/* Whether the event at hand is a value that the file leaves out. */
static bool is_empty(const reader *r)
{
    return r->event.type == YAML_SCALAR_EVENT && is_plain(r) &&
           scalar_len(r) == 0;
}

static bool has_anchor(const yaml_event_t *e)
{
    switch (e->type) {
    case YAML_SCALAR_EVENT:
        return e->data.scalar.anchor != NULL;
    case YAML_MAPPING_START_EVENT:
        return e->data.mapping_start.anchor != NULL;
    default:
        return e->type == YAML_SEQUENCE_START_EVENT &&
               e->data.sequence_start.anchor != NULL;
    }
}

static bool has_tag(const yaml_event_t *e)
{
    switch (e->type) {
    case YAML_SCALAR_EVENT:
        return e->data.scalar.tag != NULL;
    case YAML_MAPPING_START_EVENT:
        return e->data.mapping_start.tag != NULL;
    default:
        return e->type == YAML_SEQUENCE_START_EVENT &&
               e->data.sequence_start.tag != NULL;
    }
}

/* Refuses anchors, aliases and tags, by which one place of a file depends on
 * another. */
static int refuse_links(reader *r)
{
    if (r->event.type == YAML_ALIAS_EVENT) {
        return FAIL(r, "aliases (*) are not accepted; write the value out");
    }
    if (has_anchor(&r->event)) {
        return FAIL(r, "anchors (&) are not accepted; leave it out");
    }
    if (has_tag(&r->event)) {
        return FAIL(r, "tags (!) are not accepted; leave it out");
    }
    return 0;
}

/* Hands a value on as text; none that a rule allows has a NUL. */
static int hand_on(reader *r, lum_key_given given)
{
    char text[TEXT_BYTES];
    lum_key_refusal why;
    if (r->take_text == NULL) {
        return 0;
    }
    if (given.len >= sizeof text) {
        return FAIL(r, "longer than %u bytes", TEXT_BYTES - 1u);
    }
    (void)snprintf(text, sizeof text, "%.*s", (int)given.len, given.text);
    return r->take_text(r->context, r->prefix[0] != '\0', r->path, text,
                        &why) == LUM_OK
               ? 0
               : FAIL(r, "%s", why.text);
}

static int take(reader *r, const lum_key_entry *entry, lum_key_given given)
{
    lum_key_value *value = &r->values[entry->index];
    char message[MESSAGE_BYTES];
    lum_key_text text = lum_key_text_begin(message, sizeof message);
    if (!lum_key_table_read(r->table, entry, given, &value->number, &text)) {
        return FAIL(r, "%s", message);
    }
    value->place = r->line;
    return hand_on(r, given);
}

/* The plain values of a sequence as one text, "[0, 14]". */
static int read_pair(reader *r, const lum_key_entry *entry)
{
    char pair[PAIR_BYTES];
    lum_key_text text = lum_key_text_begin(pair, sizeof pair);
    lum_key_text_add(&text, "[");
    for (;;) {
        if (next(r) != 0 || refuse_links(r) != 0) {
            return -1;
        }
        if (r->event.type == YAML_SEQUENCE_END_EVENT) {
            break;
        }
        if (r->event.type != YAML_SCALAR_EVENT || !is_plain(r)) {
            return refuse_value(r, "only numbers belong in [ ]");
        }
        lum_key_text_add(&text, text.len > 1 ? ", " : "");
        lum_key_text_add_bytes(&text, scalar_text(r), scalar_len(r));
    }
    lum_key_text_add(&text, "]");
    return take(r, entry, (lum_key_given){pair, strlen(pair), false});
}

static int refuse_kind(reader *r)
{
    if (is_empty(r)) {
        return refuse_value(r, "no value");
    }
    switch (r->event.type) {
    case YAML_SEQUENCE_START_EVENT:
        return refuse_value(r, "a sequence does not belong here");
    case YAML_MAPPING_START_EVENT:
        return refuse_value(r, "a mapping does not belong here");
    default:
        return refuse_value(r, "a single value does not belong here");
    }
}

/* --- Keys and values --- */

/* Notes where a known key stands. */
static int admit_key(reader *r, unsigned *seen)
{
    const lum_key_entry *entry = lum_key_table_entry(r->table, r->path);
    if (entry != NULL && entry->rule->refusal != NULL) {
        return FAIL(r, "%s", entry->rule->refusal);
    }
    if (*seen != 0) {
        return FAIL(r, "repeated; it is already on line %u", *seen);
    }
    *seen = r->line;
    return 0;
}

/* Reads a key, adds it to the path and notes its line, at the first entry of
 * the table that is at it or below it. */
static int read_key(reader *r, unsigned seen[LUM_KEY_ENTRIES_MAX])
{
    r->line = line_of(r->event.start_mark.line);
    if (refuse_links(r) != 0) {
        return -1;
    }
    if (r->event.type != YAML_SCALAR_EVENT) {
        return FAIL(r, "a key must be a single word");
    }
    const char *name = scalar_text(r);
    const size_t len = scalar_len(r);
    const size_t i = lum_key_table_find(r->table, r->path, name, len);
    if (i == r->table->count) {
        return refuse_key(r, name, len);
    }
    lum_text_add(r->path, sizeof r->path, "%s%.*s",
                 r->path[0] != '\0' ? "." : "", (int)len, name);
    return admit_key(r, &seen[i]);
}

static int read_mapping(reader *r);
static int read_list(reader *r);

static int read_value(reader *r)
{
    const lum_key_entry *entry = lum_key_table_entry(r->table, r->path);
    if (refuse_links(r) != 0) {
        return -1;
    }
    if (r->event.type == YAML_MAPPING_START_EVENT &&
        lum_key_table_is_mapping(r->table, r->path)) {
        return read_mapping(r);
    }
    if (r->event.type == YAML_SEQUENCE_START_EVENT && r->list != NULL &&
        strcmp(r->path, r->list->key) == 0) {
        return read_list(r);
    }
    if (r->event.type == YAML_SCALAR_EVENT && entry != NULL && !is_empty(r)) {
        return take(
            r, entry,
            (lum_key_given){scalar_text(r), scalar_len(r), !is_plain(r)});
    }
    if (r->event.type == YAML_SEQUENCE_START_EVENT && entry != NULL &&
        entry->rule->pair) {
        return read_pair(r, entry);
    }
    return refuse_kind(r);
}

/* Reads from after a mapping's start to its end. The recursion is no deeper
 * than the table's paths. */
static int read_mapping(reader *r)
{
    unsigned seen[LUM_KEY_ENTRIES_MAX] = {0};
    const size_t path_len = strlen(r->path);
    while (next(r) == 0) {
        if (r->event.type == YAML_MAPPING_END_EVENT) {
            return 0;
        }
        if (read_key(r, seen) != 0 || next(r) != 0 || read_value(r) != 0) {
            return -1;
        }
        r->path[path_len] = '\0';
    }
    return -1;
}

static int read_item(reader *r, const lum_yaml_list *list, unsigned number)
{
    const unsigned line = line_of(r->event.start_mark.line);
    r->line = line;
    (void)snprintf(r->prefix, sizeof r->prefix, "%.16s.%u", list->key, number);
    if (number > list->max) {
        return FAIL(r, "more than the %zu that are accepted", list->max);
    }
    if (refuse_links(r) != 0) {
        return -1;
    }
    if (r->event.type != YAML_MAPPING_START_EVENT) {
        return FAIL(r, "not a mapping of keys");
    }
    memset(list->values, 0, list->value_count * sizeof list->values[0]);
    return read_mapping(r) == 0 ? list->take(list->context, number, line) : -1;
}

/* Reads from after a sequence's start to its end, each mapping by the list's
 * table. */
static int read_list(reader *r)
{
    const lum_yaml_list *list = r->list;
    const lum_key_table *table = r->table;
    const lum_key_entry *entry = lum_key_table_entry(table, list->key);
    lum_key_value *values = r->values;
    unsigned number = 0;
    values[entry->index].place = r->line;
    r->table = list->table;
    r->values = list->values;
    r->list = NULL;
    r->path[0] = '\0';
    int result = next(r);
    while (result == 0 && r->event.type != YAML_SEQUENCE_END_EVENT) {
        result = read_item(r, list, ++number);
        result = result == 0 ? next(r) : result;
    }
    if (result != 0) {
        return -1;
    }
    r->table = table;
    r->values = values;
    r->list = list;
    r->prefix[0] = '\0';
    (void)snprintf(r->path, sizeof r->path, "%s", list->key);
    values[entry->index].number = number;
    return 0;
}

/* --- The document --- */

static int refuse_root(reader *r)
{
    char names[MESSAGE_BYTES];
    lum_key_text text = lum_key_text_begin(names, sizeof names);
    lum_key_table_add_names(r->table, "", &text);
    if (r->event.type == YAML_STREAM_END_EVENT || is_empty(r)) {
        r->line = 1;
        return FAIL(r, "nothing but blanks or comments; begin with "
                       "'version: 1'");
    }
    return FAIL(r, "not a mapping of keys; allowed here: %s", names);
}

static int read_root(reader *r)
{
    if (next(r) != 0) {
        return -1;
    }
    r->line = line_of(r->event.start_mark.line);
    if (refuse_links(r) != 0) {
        return -1;
    }
    return r->event.type == YAML_MAPPING_START_EVENT ? read_mapping(r)
                                                     : refuse_root(r);
}

/* To the event behind the next one. */
static int next_but_one(reader *r)
{
    return next(r) != 0 ? -1 : next(r);
}

static int read_stream(reader *r)
{
    if (next_but_one(r) != 0) {
        return -1;
    }
    if (r->event.type == YAML_STREAM_END_EVENT) {
        return refuse_root(r);
    }
    if (read_root(r) != 0 || next_but_one(r) != 0) {
        return -1;
    }
    if (r->event.type != YAML_STREAM_END_EVENT) {
        r->line = line_of(r->event.start_mark.line);
        return FAIL(r, "a second document begins; a file holds one");
    }
    return 0;
}

/* libyaml counts the mark of UTF-8 as a column, which would indent the first
 * line. */
static lum_yaml_source without_mark(const lum_yaml_source *source)
{
    static const char mark[] = "\xef\xbb\xbf";
    const size_t len = sizeof mark - 1;
    lum_yaml_source rest = *source;
    if (rest.len >= len && memcmp(rest.text, mark, len) == 0) {
        rest.text += len;
        rest.len -= len;
    }
    return rest;
}

int lum_yaml_read(const lum_yaml_source *source, const lum_key_table *table,
                  lum_key_value *values, lum_error *error)
{
    return lum_yaml_read_list(source, table, values, NULL, error);
}

int lum_yaml_read_list(const lum_yaml_source *source,
                       const lum_key_table *table, lum_key_value *values,
                       const lum_yaml_list *list, lum_error *error)
{
    const lum_yaml_source rest = without_mark(source);
    const char *text = rest.len > 0 ? rest.text : "";
    const unsigned most =
        list != NULL ? LUM_YAML_LIST_BYTES_MAX : LUM_CONFIG_BYTES_MAX;
    reader r;
    if (source->len > most) {
        return lum_yaml_fail(error, source->name, 0, NULL,
                             "longer than the %u bytes that are accepted",
                             most);
    }
    memset(&r, 0, sizeof r);
    r.source = &rest;
    r.table = table;
    r.values = values;
    r.list = list;
    if (list != NULL) {
        r.take_text = list->take_text;
        r.context = list->context;
    }
    r.error = error;
    if (yaml_parser_initialize(&r.parser) == 0) {
        return FAIL(&r, "out of memory");
    }
    yaml_parser_set_encoding(&r.parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&r.parser, (const unsigned char *)text,
                                 rest.len);
    const int result = read_stream(&r);
    yaml_event_delete(&r.event);
    yaml_parser_delete(&r.parser);
    return result;
}
