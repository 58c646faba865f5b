/* The known state of the shown sensor: laser, hazards, silence, the way to it;
 * and the messages about it. */
#ifndef LUMVIEW_SENTRY_H
#define LUMVIEW_SENTRY_H

#include "../common/laser_keeper.h"
#include "lum/net/sensor.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct sentry {
    lum_sensor *sensor;
    char address[16];
    struct laser_keeper laser;
    enum laser_news news; /* why it was given up */
    bool is_unheard;      /* requests stay without answer */
    bool is_cut_off;      /* sending fails */
    char why[128];        /* it does */
    bool has_unknown;     /* packets came that may be data of another layout */
    bool has_data;        /* data has come */
    int64_t data_ns;      /* the last time it did; monotonic */
};

/* Begin; all earlier state is forgotten, except the laser's, which the caller
 * passes. */
void sentry_begin(struct sentry *sentry, lum_sensor *sensor,
                  enum laser_fate laser, int64_t now_ns);

/* An event of the session other than datagrams. */
void sentry_take(struct sentry *sentry, const lum_sensor_event *event,
                 int64_t now_ns);

/* Pass the time; to be called several times a second. */
void sentry_tick(struct sentry *sentry, int64_t now_ns);

/* Whether data has stopped. */
bool sentry_is_silent(const struct sentry *sentry, int64_t now_ns);

/* The message; "": none. Returns out. */
const char *sentry_message(const struct sentry *sentry, int64_t now_ns,
                           char *out, size_t room);

#endif
