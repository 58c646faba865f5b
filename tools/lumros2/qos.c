#include "qos.h"

#include "names.h"

#include <string.h>

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

bool qos_add(struct qos *qos, const char *text, lum_error *why)
{
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
