/* What a live run knows of its sensor and says about it: laser, hazards,
 * silence, the way to it. It asks for the status once a second. */
#ifndef LUMDUMP_WATCH_H
#define LUMDUMP_WATCH_H

#include "say.h"

#include "lum/net/sensor.h"

#include <stdbool.h>
#include <stdint.h>

/* What became of the laser that was to be switched on. */
enum watch_laser {
    WATCH_UNTOUCHED, /* nobody asked for it */
    WATCH_ASKED,     /* it is being switched on */
    WATCH_UP,        /* a status showed it up */
    WATCH_DOWN,      /* it was down, or went down, and is left so */
    WATCH_GIVEN_UP   /* whether it is up was not to be learnt */
};

/* What is asked of the sensor. */
enum watch_request {
    WATCH_LOOK, /* its status */
    WATCH_ON,
    WATCH_OFF
};

struct watch {
    struct say *say;
    lum_sensor *sensor;
    const lum_layout *layout;
    char address[16];
    enum watch_laser laser;
    enum watch_request request; /* the one under way */
    bool off_due;      /* the command "on" stands: the laser would come up by
                          itself when a hazard ends */
    bool told_off_due; /* that this cannot be mended was warned of */
    unsigned attempts; /* at the laser */
    int64_t began_ns;  /* all times are monotonic */
    int64_t tick_ns;   /* when it was last called */
    int64_t next_ns;   /* of the next request */
    bool has_status;
    uint16_t status; /* the last one */
    uint16_t told;   /* hazards that were warned of */
    bool is_unheard; /* status requests stay without answer */
    unsigned texts;  /* debug texts that were shown */
    bool has_data;   /* data has come */
    int64_t data_ns; /* the last time it did */
    bool is_silent;  /* it stopped */
};

/* Begin; where laser is set, it will be switched on. Once it was seen down, or
 * could not be seen up, it is switched off, so that only a person switches it
 * on again. */
void watch_begin(struct watch *watch, struct say *say, lum_sensor *sensor,
                 const lum_layout *layout, bool laser, int64_t now_ns);

/* An event of the session other than datagrams. */
void watch_take(struct watch *watch, const lum_sensor_event *event,
                int64_t now_ns);

/* Data has come. */
void watch_note_data(struct watch *watch, int64_t now_ns);

/* Time goes on; to be called several times a second. */
void watch_tick(struct watch *watch, int64_t now_ns);

/* Why lines have no ranges, as far as the last status tells. False: it tells
 * nothing, and out stays as it is. */
bool watch_darkness(const struct watch *watch, char *out, size_t room);

/* The laser, for the status line. */
const char *watch_laser_text(const struct watch *watch);

#endif
