/* Topics of ROS 2: their names in DDS, what --namespace and --remap make of
 * them, and how their messages are kept and sent again (--qos). */
#ifndef LUMROS2_TOPICS_H
#define LUMROS2_TOPICS_H

#include "lum/base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Bytes of a name with its NUL, of a topic or of a type. */
#define NAMES_BYTES 320u

#define NAMES_REMAPS_MAX 32u

/* FROM:=TO, as it was given. */
struct names_remap {
    const char *text;
    size_t from_len;
    const char *to;
};

struct names {
    const char *prefix; /* a namespace; NULL: none */
    struct names_remap remaps[NAMES_REMAPS_MAX];
    size_t remap_count;
};

/* Whether a text is a name: words of letters, digits and _, none beginning with
 * a digit, with / between them and perhaps before the first. */
bool names_is(const char *text);

/* Take a namespace, or add "FROM:=TO", of a command line to a struct names.
 * False: why says the reason, if it is not its form. */
bool names_take_prefix(void *names, const char *text, lum_error *why);
bool names_add_remap(void *to, const char *text, lum_error *why);

/* The topic by which a topic of the file is published, such as /left/points.
 * Names that ROS 2 has once for all nodes, such as /tf_static, stay without the
 * namespace. False: the topic's name is none of ROS 2, or too long. */
bool names_topic(const struct names *names, const char *topic,
                 char out[NAMES_BYTES]);

/* rt/left/points of /left/points. */
void names_dds_topic(const char *topic, char out[NAMES_BYTES]);

/* sensor_msgs::msg::dds_::PointCloud2_ of sensor_msgs/msg/PointCloud2. False:
 * it is no type of a message of ROS 2. */
bool names_dds_type(const char *type, char out[NAMES_BYTES]);

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

/* Add a KIND or TOPIC=KIND to a struct qos. False: why says the reason, if it
 * is not its form. */
bool qos_add(void *to, const char *text, lum_error *why);

/* Of a topic as it is published. Without rules, /tf_static is latched and
 * others are reliable, which readers of either kind take. */
enum qos_kind qos_of(const struct qos *qos, const char *topic);

/* For messages. */
const char *qos_name(enum qos_kind kind);

#endif
