/* The rules for a laser that a session should switch on. The command is sent
 * until a status shows the laser up. Once the laser is down, or no status shows
 * it up, it is switched off, so that it does not come up by itself when a
 * hazard ends: only a person switches it on again. In between, the status is
 * read once a second.
 *
 * What of it a person is told is the caller's. Times are monotonic. Not for
 * several threads. */
#ifndef LUM_LASER_KEEPER_H
#define LUM_LASER_KEEPER_H

#include "lum/net/sensor.h"

#include <stdbool.h>
#include <stdint.h>

enum laser_fate {
    LASER_UNTOUCHED, /* nobody asked for it */
    LASER_ASKED,     /* it is being switched on */
    LASER_UP,        /* a status showed it up */
    LASER_DOWN       /* given up: off, or being switched off */
};

/* What is asked of the sensor. */
enum laser_request {
    LASER_ASK_LOOK, /* its status */
    LASER_ASK_ON,
    LASER_ASK_OFF
};

/* What happened to the laser. */
enum laser_news {
    LASER_NO_NEWS,
    LASER_WENT_OFF,
    LASER_STAYS_DOWN, /* a hazard refuses it, or no answer showed it up */
    LASER_UNSEEN,     /* the answer to "on" had no status */
    LASER_UNANSWERED, /* an "on" had none, 5 s after the beginning or later */
    LASER_HELD_UP,    /* the session was delayed while it switched on */
    LASER_CAME_UP     /* after it was given up: another program did that */
};

struct laser_keeper {
    enum laser_fate fate;
    enum laser_request request; /* the one under way, or the last */
    bool off_due;    /* the command "on" may be in effect: off has to be sent */
    bool off_unseen; /* off was answered, but no status has shown it */
    uint16_t fell;   /* the status with which it was given up; 0: unknown */
    unsigned attempts;  /* at the laser */
    int64_t held_up_ns; /* how long the session stood still */
    bool has_status;
    uint16_t status; /* the last one */
    int64_t began_ns;
    int64_t tick_ns; /* when time last went on */
    int64_t next_ns; /* of the next request */
};

/* Begin. LASER_ASKED is switched on, LASER_DOWN switched off. */
void laser_keeper_begin(struct laser_keeper *keeper, enum laser_fate fate,
                        int64_t now_ns);

/* An answer to the request under way, an alert, or no answer; other events
 * change nothing. With an answer, or none, the request is LASER_ASK_LOOK again.
 */
enum laser_news laser_keeper_take(struct laser_keeper *keeper,
                                  const lum_sensor_event *event,
                                  int64_t now_ns);

/* Pass the time; to be called several times a second. */
enum laser_news laser_keeper_tick(struct laser_keeper *keeper, int64_t now_ns);

/* Send what is due, if the session is idle; if it cannot be sent, the next call
 * tries again. Off does not wait: the present request is given up, because it
 * would be repeated. */
void laser_keeper_ask(struct laser_keeper *keeper, lum_sensor *sensor,
                      int64_t now_ns);

/* What is due, without regard to when. */
enum laser_request laser_keeper_next(const struct laser_keeper *keeper);

/* It was sent. */
void laser_keeper_sent(struct laser_keeper *keeper, enum laser_request request,
                       int64_t now_ns);

/* Hazards that heartbeats do not end. */
unsigned laser_keeper_hazards(uint16_t status);

#endif
