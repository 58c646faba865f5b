/* DDS: a participant in a domain, with writers of messages in CDR. Its threads
 * never touch what is here. One thread's. */
#ifndef LUMROS2_BUS_H
#define LUMROS2_BUS_H

#include "lum/base/error.h"
#include "topics.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Most topics. */
#define BUS_TOPICS_MAX 512u

struct bus;

/* What a topic is published as. */
struct bus_topic {
    const char *name; /* such as /left/points */
    const char *type; /* such as sensor_msgs/msg/PointCloud2 */
    enum qos_kind kind;
    uint32_t depth;
};

/* What became of its messages. */
struct bus_count {
    const char *name;
    uint64_t messages;
    uint64_t bytes;
    uint64_t dropped;   /* replaced by newer ones, or not taken by DDS */
    unsigned readers;   /* now */
    bool has_new_count; /* since the last look */
};

/* Join a domain. If CYCLONEDDS_URI is set, it has the settings. */
int bus_open(unsigned domain, struct bus **out, lum_error *error);

/* Leave it. NULL is allowed. */
void bus_close(struct bus *bus);

/* Add a topic, or find it again by its name; *index is its place. A name that
 * has another type already is refused. */
int bus_add(struct bus *bus, const struct bus_topic *topic, size_t *index,
            lum_error *error);

/* Send a message. Waits for no reader. */
int bus_publish(struct bus *bus, size_t index, const uint8_t *cdr, size_t len,
                lum_error *error);

/* Whether all reliable readers have got everything, waiting for it so long at
 * most. */
bool bus_wait(struct bus *bus, int ms);

/* Readers of all topics. */
unsigned bus_readers(struct bus *bus);

size_t bus_topics(const struct bus *bus);

/* Of the topic at a place. */
struct bus_count bus_count(struct bus *bus, size_t index);

#endif
