/* What a live run knows of its sensor and says about it: laser, hazards,
 * silence, the way to it. It asks for the status once a second. */
#ifndef LUMDUMP_WATCH_H
#define LUMDUMP_WATCH_H

#include "../common/laser_keeper.h"
#include "say.h"

#include "lum/net/sensor.h"

#include <stdbool.h>
#include <stdint.h>

/* So long without data at the end is told in the summary: in frames of any rate
 * lines come more often. */
#define WATCH_PAUSE_NS INT64_C(1000000000)

struct watch {
    struct say *say;
    lum_sensor *sensor;
    const lum_layout *layout;
    char address[16];
    struct laser_keeper laser;
    bool told_off_due; /* that "off" is not answered was warned of */
    uint16_t told;     /* hazards that were warned of */
    bool is_unheard;   /* status requests stay without answer */
    unsigned texts;    /* debug texts that were shown */
    bool has_data;     /* data has come */
    int64_t data_ns;   /* the last time it did; monotonic */
    bool is_silent;    /* it stopped */
    int64_t silent_ns; /* none came for so long before the end */
    bool told_move;    /* its new address was reported */
};

/* Begin; where laser is set, it will be switched on. */
void watch_begin(struct watch *watch, struct say *say, lum_sensor *sensor,
                 const lum_layout *layout, bool laser, int64_t now_ns);

/* An event of the session other than datagrams. */
void watch_take(struct watch *watch, const lum_sensor_event *event,
                int64_t now_ns);

/* Data has come. */
void watch_note_data(struct watch *watch, int64_t now_ns);

/* The run has ended. */
void watch_end(struct watch *watch, int64_t now_ns);

/* Pass the time; to be called several times a second. */
void watch_tick(struct watch *watch, int64_t now_ns);

/* Why lines have no ranges, as far as the last status shows. False: it shows
 * nothing, and out does not change. */
bool watch_darkness(const struct watch *watch, char *out, size_t room);

/* The laser, for the status line. */
const char *watch_laser_text(const struct watch *watch);

#endif
