#include "topics.h"

#include <stdio.h>
#include <string.h>

#define DIGITS  "0123456789"
#define LETTERS "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_"

/* --- Names --- */

/* A word at *at, which then is behind it. */
static bool take_word(const char **at)
{
    const size_t len = strspn(*at, LETTERS DIGITS);
    const bool is_word = len > 0 && strspn(*at, DIGITS) == 0;
    *at += len;
    return is_word;
}

bool names_is(const char *text)
{
    const char *at = text[0] == '/' ? text + 1 : text;
    bool is_name = take_word(&at);
    while (is_name && *at == '/') {
        at++;
        is_name = take_word(&at);
    }
    return is_name && *at == '\0' && strlen(text) < NAMES_BYTES / 2u;
}

bool names_take_prefix(void *names, const char *text, lum_error *why)
{
    (void)why;
    ((struct names *)names)->prefix = text;
    return names_is(text);
}

bool names_add_remap(void *to, const char *text, lum_error *why)
{
    struct names *names = to;
    char from[NAMES_BYTES];
    const char *sign = strstr(text, ":=");
    if (names->remap_count == NAMES_REMAPS_MAX) {
        (void)lum_error_set(why, "more than %u of them", NAMES_REMAPS_MAX);
        return false;
    }
    if (sign == NULL || (size_t)(sign - text) >= sizeof from) {
        return false;
    }
    (void)memcpy(from, text, (size_t)(sign - text));
    from[sign - text] = '\0';
    if (!names_is(from) || !names_is(sign + 2)) {
        return false;
    }
    names->remaps[names->remap_count++] =
        (struct names_remap){text, (size_t)(sign - text), sign + 2};
    return true;
}

/* Without a slash at its beginning. */
static const char *bare(const char *name)
{
    return name[0] == '/' ? name + 1 : name;
}

static bool is_from(const struct names_remap *remap, const char *topic)
{
    const char *from = bare(remap->text);
    const size_t len = remap->from_len - (size_t)(from - remap->text);
    const char *name = bare(topic);
    return strlen(name) == len && memcmp(name, from, len) == 0;
}

static bool is_global(const char *topic)
{
    static const char *const globals[] = {"tf",    "tf_static", "diagnostics",
                                          "clock", "rosout",    "rosout_agg"};
    for (size_t i = 0; i < sizeof globals / sizeof globals[0]; i++) {
        if (strcmp(bare(topic), globals[i]) == 0) {
            return true;
        }
    }
    return false;
}

bool names_topic(const struct names *names, const char *topic,
                 char out[NAMES_BYTES])
{
    const char *name = topic;
    bool is_whole = is_global(topic);
    if (!names_is(topic)) {
        return false;
    }
    for (size_t i = 0; i < names->remap_count; i++) {
        if (is_from(&names->remaps[i], topic)) {
            name = names->remaps[i].to;
            is_whole = name[0] == '/' || is_global(name);
        }
    }
    const bool has_prefix = names->prefix != NULL && !is_whole;
    const int n = snprintf(out, NAMES_BYTES, "%s%s/%s", has_prefix ? "/" : "",
                           has_prefix ? bare(names->prefix) : "", bare(name));
    return n > 0 && (size_t)n < NAMES_BYTES;
}

void names_dds_topic(const char *topic, char out[NAMES_BYTES])
{
    (void)snprintf(out, NAMES_BYTES, "rt%.*s", (int)NAMES_BYTES - 3, topic);
}

bool names_dds_type(const char *type, char out[NAMES_BYTES])
{
    const char *at = type;
    const char *package = type;
    if (!take_word(&at)) {
        return false;
    }
    const size_t len = (size_t)(at - package);
    if (strncmp(at, "/msg/", 5) != 0) {
        return false;
    }
    at += 5;
    const char *name = at;
    if (!take_word(&at) || *at != '\0') {
        return false;
    }
    const int n = snprintf(out, NAMES_BYTES, "%.*s::msg::dds_::%s_", (int)len,
                           package, name);
    return n > 0 && (size_t)n < NAMES_BYTES;
}

/* --- Quality of service --- */

static bool take_kind(const char *text, enum qos_kind *out)
{
    static const enum qos_kind kinds[] = {QOS_RELIABLE, QOS_SENSOR,
                                          QOS_LATCHED};
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (strcmp(text, qos_name(kinds[i])) == 0) {
            *out = kinds[i];
            return true;
        }
    }
    return false;
}

bool qos_add(void *to, const char *text, lum_error *why)
{
    struct qos *qos = to;
    const char *sign = strchr(text, '=');
    struct qos_rule rule = {.topic = text};
    if (sign == NULL) {
        qos->has_kind = take_kind(text, &qos->kind);
        return qos->has_kind;
    }
    if (qos->count == QOS_RULES_MAX) {
        (void)lum_error_set(why, "more than %u of them", QOS_RULES_MAX);
        return false;
    }
    rule.len = (size_t)(sign - text);
    if (rule.len == 0 || !take_kind(sign + 1, &rule.kind)) {
        return false;
    }
    qos->rules[qos->count++] = rule;
    return true;
}

static bool is_of(const struct qos_rule *rule, const char *topic)
{
    const char *name = rule->topic[0] == '/' ? topic : topic + 1;
    return strlen(name) == rule->len &&
           memcmp(name, rule->topic, rule->len) == 0;
}

enum qos_kind qos_of(const struct qos *qos, const char *topic)
{
    for (size_t i = qos->count; i > 0; i--) {
        if (is_of(&qos->rules[i - 1u], topic)) {
            return qos->rules[i - 1u].kind;
        }
    }
    if (strcmp(topic, "/tf_static") == 0) {
        return QOS_LATCHED;
    }
    return qos->has_kind ? qos->kind : QOS_RELIABLE;
}

const char *qos_name(enum qos_kind kind)
{
    switch (kind) {
    case QOS_SENSOR:
        return "sensor";
    case QOS_LATCHED:
        return "latched";
    case QOS_RELIABLE:
    default:
        return "reliable";
    }
}
