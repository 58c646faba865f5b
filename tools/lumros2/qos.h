/* How messages of a topic are kept and sent again. */
#ifndef LUMROS2_QOS_H
#define LUMROS2_QOS_H

#include "lum/base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define QOS_RULES_MAX 32u

enum qos_kind {
    QOS_RELIABLE, /* what is lost on the way is sent again */
    QOS_SENSOR,   /* it is not: best effort */
    QOS_LATCHED   /* reliable, and the last ones for readers that come later */
};

/* TOPIC=KIND. */
struct qos_rule {
    const char *topic;
    size_t len;
    enum qos_kind kind;
};

struct qos {
    struct qos_rule rules[QOS_RULES_MAX];
    size_t count;
    bool has_kind; /* of all topics without a rule */
    enum qos_kind kind;
    int64_t depth; /* messages that are kept */
};

#define QOS_ALLOWED                                                            \
    "sensor, reliable or latched, or TOPIC=sensor, TOPIC=reliable, "           \
    "TOPIC=latched"

/* Takes a KIND or TOPIC=KIND. False: why says the reason, if it is not its
 * form. */
bool qos_add(struct qos *qos, const char *text, lum_error *why);

/* Of a topic as it is published. Without rules, /tf_static is latched and
 * others are reliable, which readers of either kind take. */
enum qos_kind qos_of(const struct qos *qos, const char *topic);

/* For messages. */
const char *qos_name(enum qos_kind kind);

#endif
