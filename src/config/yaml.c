#include "yaml.h"

#include "lum/config/config.h"
#include "yaml_number.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <yaml.h>

#define PATH_BYTES    96  /* of the longest path of the tables' keys */
#define NAME_BYTES    208 /* of a file's name in a message */
#define QUOTED_BYTES  64  /* of a piece of a file in a message */
#define ALLOWED_BYTES 160
#define WORD_MAX      32 /* longest key that is held against the known ones */

typedef struct reader {
    yaml_parser_t parser;
    yaml_event_t event; /* the one at hand */
    const lum_yaml_source *source;
    lum_yaml_value *values;
    lum_error *error;
    unsigned line; /* of the key at hand */
    char path[PATH_BYTES];
} reader;

static void append(char *out, size_t size, const char *format, ...)
    LUM_PRINTF(3, 4);

/* Adds to a terminated string of size bytes; cuts what does not fit. */
static void append(char *out, size_t size, const char *format, ...)
{
    const size_t used = strlen(out);
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(out + used, size - used, format, arguments);
    va_end(arguments);
}

/* A name with what could break or forge a line replaced, its front cut where
 * it is long. */
static void clean_name(const char *name, char out[NAME_BYTES])
{
    const size_t len = strlen(name);
    const size_t room = NAME_BYTES - 4;
    out[0] = '\0';
    append(out, NAME_BYTES, "%s%s", len > room ? "..." : "",
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
    lum_yaml_fail((r)->error, (r)->source->name, (r)->line, (r)->path,         \
                  __VA_ARGS__)

/* A piece of the file as plain ASCII, cut where it is long. */
static void quote(char out[QUOTED_BYTES], const char *text, size_t len)
{
    out[0] = '\0';
    for (size_t i = 0; i < len; i++) {
        const unsigned char c = (unsigned char)text[i];
        if (strlen(out) + 9 > QUOTED_BYTES) {
            append(out, QUOTED_BYTES, "...");
            return;
        }
        if (c >= 0x20 && c < 0x7f) {
            append(out, QUOTED_BYTES, "%c", c);
        } else {
            append(out, QUOTED_BYTES, "\\x%02x", (unsigned)c);
        }
    }
}

/* Why a file may not have a known key, or NULL. */
static const char *refusal_of(const lum_yaml_key *key)
{
    return key->rule != NULL ? key->rule->refusal : NULL;
}

static void append_keys(char *out, size_t size, const lum_yaml_table *table)
{
    const char *between = "";
    for (size_t i = 0; i < table->count; i++) {
        if (refusal_of(&table->keys[i]) == NULL) {
            append(out, size, "%s%s", between, table->keys[i].name);
            between = ", ";
        }
    }
}

static void append_words(char *out, size_t size, const lum_yaml_word *words)
{
    for (size_t i = 0; words[i].text != NULL; i++) {
        append(out, size, "%s%s", i > 0 ? " or " : "", words[i].text);
    }
}

static bool takes_numbers(const lum_yaml_rule *rule)
{
    return rule->min <= rule->max;
}

static void append_numbers(char *out, size_t size, const lum_yaml_rule *rule)
{
    char min[LUM_YAML_NUMBER_BYTES];
    char max[LUM_YAML_NUMBER_BYTES];
    lum_yaml_number_format(min, rule->min, rule->decimals);
    lum_yaml_number_format(max, rule->max, rule->decimals);
    if (rule->allowed != NULL) {
        append(out, size, "%s", rule->allowed);
    } else if (rule->min == 1 && !rule->whole) {
        append(out, size, "above 0, at most %s%s", max, rule->unit);
    } else {
        append(out, size, "%s to %s%s", min, max, rule->unit);
    }
}

void lum_yaml_allowed(const lum_yaml_key *key, char *out, size_t size)
{
    const lum_yaml_rule *rule = key->rule;
    const char *between = "";
    out[0] = '\0';
    if (rule != NULL && rule->words != NULL) {
        append_words(out, size, rule->words);
        between = ", or ";
    }
    if (rule != NULL && takes_numbers(rule)) {
        append(out, size, "%s", between);
        append_numbers(out, size, rule);
        between = ", or ";
    }
    if (key->table != NULL) {
        append(out, size, "%sa mapping of ", between);
        append_keys(out, size, key->table);
    }
}

static int refuse_value(reader *r, const lum_yaml_key *key, const char *what)
{
    char allowed[ALLOWED_BYTES];
    lum_yaml_allowed(key, allowed, sizeof allowed);
    return FAIL(r, "%s; allowed: %s", what, allowed);
}

static size_t min_of(size_t a, size_t b)
{
    return a < b ? a : b;
}

/* Letters to insert, remove or change to make one of the other. */
static size_t distance(const char *a, size_t a_len, const char *b, size_t b_len)
{
    size_t row[WORD_MAX + 1];
    for (size_t j = 0; j <= b_len; j++) {
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

/* The known key that was probably meant, or NULL. */
static const char *nearest(const lum_yaml_table *table, const char *text,
                           size_t len)
{
    const char *best = NULL;
    size_t least = 3;
    for (size_t i = 0; i < table->count && len <= WORD_MAX; i++) {
        const char *name = table->keys[i].name;
        const size_t d =
            distance(text, len, name, min_of(strlen(name), WORD_MAX));
        if (d < least && 3 * d <= min_of(len, strlen(name)) &&
            refusal_of(&table->keys[i]) == NULL) {
            least = d;
            best = name;
        }
    }
    return best;
}

static int refuse_key(reader *r, const lum_yaml_table *table, const char *text,
                      size_t len)
{
    char key[QUOTED_BYTES];
    char hint[QUOTED_BYTES] = ";";
    char names[ALLOWED_BYTES] = "";
    const char *near = nearest(table, text, len);
    quote(key, text, len);
    append_keys(names, sizeof names, table);
    if (near != NULL) {
        (void)snprintf(hint, sizeof hint, "; did you mean '%s'?", near);
    }
    return FAIL(r, "unknown key '%s'%s allowed here: %s", key, hint, names);
}

static unsigned line_of(size_t mark)
{
    return (unsigned)mark + 1u;
}

/* Lines are counted here because libyaml places what is no text by byte. */
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

/* Refuses what makes one place of a file depend on another. */
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

static const lum_yaml_word *find_word(const lum_yaml_rule *rule,
                                      const char *text, size_t len)
{
    const lum_yaml_word *word = rule->words;
    while (word != NULL && word->text != NULL) {
        if (strlen(word->text) == len && memcmp(word->text, text, len) == 0) {
            return word;
        }
        word++;
    }
    return NULL;
}

/* Why a scalar is not accepted, or NULL with its number. */
static const char *read_number(const reader *r, const lum_yaml_rule *rule,
                               int64_t *out)
{
    static const char *const why[] = {
        [LUM_YAML_NUMBER_NONE] = "is not a decimal number",
        [LUM_YAML_NUMBER_NOT_WHOLE] = "is not a whole number in digits",
        [LUM_YAML_NUMBER_LEADING_ZERO] =
            "begins with 0, which some read as octal; leave the 0 out",
        [LUM_YAML_NUMBER_TOO_LARGE] = "is out of range",
    };
    if (!takes_numbers(rule)) {
        return "is not known";
    }
    if (!is_plain(r)) {
        return "is text; write a number, without quotes";
    }
    const lum_yaml_number kind = lum_yaml_number_parse(
        scalar_text(r), scalar_len(r), rule->decimals, rule->whole, out);
    if (kind != LUM_YAML_NUMBER_FINE) {
        return why[kind];
    }
    return *out < rule->min || *out > rule->max ? "is out of range" : NULL;
}

static int read_scalar(reader *r, const lum_yaml_key *key, lum_yaml_value *out)
{
    const lum_yaml_word *word =
        find_word(key->rule, scalar_text(r), scalar_len(r));
    int64_t number = word != NULL ? word->number : 0;
    const char *why = word != NULL ? NULL : read_number(r, key->rule, &number);
    if (why != NULL) {
        char text[QUOTED_BYTES];
        char what[2 * QUOTED_BYTES];
        quote(text, scalar_text(r), scalar_len(r));
        (void)snprintf(what, sizeof what, "'%s' %s", text, why);
        return refuse_value(r, key, what);
    }
    out->number = number;
    out->line = r->line;
    return 0;
}

static int refuse_kind(reader *r, const lum_yaml_key *key)
{
    if (is_empty(r)) {
        return refuse_value(r, key, "no value");
    }
    switch (r->event.type) {
    case YAML_SEQUENCE_START_EVENT:
        return refuse_value(r, key, "a sequence does not belong here");
    case YAML_MAPPING_START_EVENT:
        return refuse_value(r, key, "a mapping does not belong here");
    default:
        return refuse_value(r, key, "a single value does not belong here");
    }
}

/* Notes where a known key stands; NULL: refused. */
static const lum_yaml_key *admit_key(reader *r, const lum_yaml_key *key,
                                     unsigned *seen)
{
    if (refusal_of(key) != NULL) {
        (void)FAIL(r, "%s", refusal_of(key));
        return NULL;
    }
    if (*seen != 0) {
        (void)FAIL(r, "repeated; it stands on line %u already", *seen);
        return NULL;
    }
    *seen = r->line;
    return key;
}

/* Reads a key and notes where it stands; NULL: refused. */
static const lum_yaml_key *read_key(reader *r, const lum_yaml_table *table,
                                    unsigned seen[LUM_YAML_KEYS_MAX])
{
    r->line = line_of(r->event.start_mark.line);
    if (refuse_links(r) != 0) {
        return NULL;
    }
    if (r->event.type != YAML_SCALAR_EVENT) {
        (void)FAIL(r, "a key must be a single word");
        return NULL;
    }
    for (size_t i = 0; i < table->count; i++) {
        const lum_yaml_key *key = &table->keys[i];
        if (strlen(key->name) != scalar_len(r) ||
            memcmp(key->name, scalar_text(r), scalar_len(r)) != 0) {
            continue;
        }
        append(r->path, sizeof r->path, "%s%s", r->path[0] != '\0' ? "." : "",
               key->name);
        return admit_key(r, key, &seen[i]);
    }
    (void)refuse_key(r, table, scalar_text(r), scalar_len(r));
    return NULL;
}

static int read_mapping(reader *r, const lum_yaml_table *table, unsigned first);

static int read_value(reader *r, const lum_yaml_key *key, unsigned first)
{
    const unsigned index = first + key->index;
    if (refuse_links(r) != 0) {
        return -1;
    }
    if (r->event.type == YAML_MAPPING_START_EVENT && key->table != NULL) {
        return read_mapping(r, key->table, index);
    }
    if (r->event.type == YAML_SCALAR_EVENT && key->rule != NULL &&
        !is_empty(r)) {
        return read_scalar(r, key, &r->values[index]);
    }
    return refuse_kind(r, key);
}

/* Reads from behind a mapping's start to its end. Calls itself no deeper than
 * the tables are. */
static int read_mapping(reader *r, const lum_yaml_table *table, unsigned first)
{
    unsigned seen[LUM_YAML_KEYS_MAX] = {0};
    const size_t path_len = strlen(r->path);
    while (next(r) == 0) {
        if (r->event.type == YAML_MAPPING_END_EVENT) {
            return 0;
        }
        const lum_yaml_key *key = read_key(r, table, seen);
        if (key == NULL || next(r) != 0 || read_value(r, key, first) != 0) {
            return -1;
        }
        r->path[path_len] = '\0';
    }
    return -1;
}

static int refuse_root(reader *r, const lum_yaml_table *root)
{
    char names[ALLOWED_BYTES] = "";
    append_keys(names, sizeof names, root);
    if (r->event.type == YAML_STREAM_END_EVENT || is_empty(r)) {
        r->line = 1;
        return FAIL(r, "nothing but blanks or comments; begin with "
                       "'version: 1'");
    }
    return FAIL(r, "not a mapping of keys; allowed here: %s", names);
}

static int read_root(reader *r, const lum_yaml_table *root)
{
    if (next(r) != 0) {
        return -1;
    }
    r->line = line_of(r->event.start_mark.line);
    if (refuse_links(r) != 0) {
        return -1;
    }
    return r->event.type == YAML_MAPPING_START_EVENT ? read_mapping(r, root, 0)
                                                     : refuse_root(r, root);
}

/* To the event behind the next one. */
static int next_but_one(reader *r)
{
    return next(r) != 0 ? -1 : next(r);
}

static int read_stream(reader *r, const lum_yaml_table *root)
{
    if (next_but_one(r) != 0) {
        return -1;
    }
    if (r->event.type == YAML_STREAM_END_EVENT) {
        return refuse_root(r, root);
    }
    if (read_root(r, root) != 0 || next_but_one(r) != 0) {
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

int lum_yaml_read(const lum_yaml_source *source, const lum_yaml_table *root,
                  lum_yaml_value *values, lum_error *error)
{
    const lum_yaml_source rest = without_mark(source);
    const char *text = rest.len > 0 ? rest.text : "";
    reader r;
    if (source->len > LUM_CONFIG_BYTES_MAX) {
        return lum_yaml_fail(error, source->name, 0, NULL,
                             "longer than the %u bytes that are accepted",
                             LUM_CONFIG_BYTES_MAX);
    }
    memset(&r, 0, sizeof r);
    r.source = &rest;
    r.values = values;
    r.error = error;
    if (yaml_parser_initialize(&r.parser) == 0) {
        return FAIL(&r, "out of memory");
    }
    yaml_parser_set_encoding(&r.parser, YAML_UTF8_ENCODING);
    yaml_parser_set_input_string(&r.parser, (const unsigned char *)text,
                                 rest.len);
    const int result = read_stream(&r, root);
    yaml_event_delete(&r.event);
    yaml_parser_delete(&r.parser);
    return result;
}
