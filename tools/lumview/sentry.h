/* What is known of a sensor that is looked at: laser, hazards, silence, the way
 * to it; and what a person should be told of it. It asks for the status once a
 * second. A laser that it was to switch on and that goes down is switched off,
 * so that it does not come up by itself. */
#ifndef LUMVIEW_SENTRY_H
#define LUMVIEW_SENTRY_H

#include "lum/net/sensor.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* What became of the laser that was to be switched on. */
enum sentry_laser {
    SENTRY_UNTOUCHED, /* nobody asked for it */
    SENTRY_ASKED,     /* it is being switched on */
    SENTRY_UP,        /* a status showed it up */
    SENTRY_FALLING,   /* it is down, and is being switched off */
    SENTRY_DOWN       /* it is off, and stays alone */
};

struct sentry {
    lum_sensor *sensor;
    char address[16];
    enum sentry_laser laser;
    char request;      /* under way: 'u', 'd', or '?' for a status */
    unsigned attempts; /* at the laser */
    int64_t began_ns;  /* all times are monotonic */
    int64_t tick_ns;   /* when it was last called */
    int64_t next_ns;   /* of the next request */
    bool has_status;
    uint16_t status;  /* the last one */
    uint16_t fell;    /* with which the laser went down */
    bool is_unheard;  /* requests stay without answer */
    bool is_cut_off;  /* sending fails */
    char why[128];    /* it does */
    bool has_unknown; /* packets came that may be data of another layout */
    bool has_data;    /* data has come */
    int64_t data_ns;  /* the last time it did */
};

/* Begin; what was known before is forgotten, but for the laser's fate, which
 * the caller gives. */
void sentry_begin(struct sentry *sentry, lum_sensor *sensor,
                  enum sentry_laser laser, int64_t now_ns);

/* An event of the session other than datagrams. */
void sentry_take(struct sentry *sentry, const lum_sensor_event *event,
                 int64_t now_ns);

/* Time goes on; to be called several times a second. */
void sentry_tick(struct sentry *sentry, int64_t now_ns);

/* Whether data has stopped. */
bool sentry_is_silent(const struct sentry *sentry, int64_t now_ns);

/* What to tell; "": nothing. Returns out. */
const char *sentry_message(const struct sentry *sentry, int64_t now_ns,
                           char *out, size_t room);

#endif
