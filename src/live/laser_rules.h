/* The rules for a laser that a session has to do with. A command for it is sent
 * until a status shows the laser up. Once the laser is down, or no status shows
 * it up, it is switched off, so that it does not come up by itself when a
 * hazard ends: only a person switches it on again. In between, the status is
 * read once a second. Nothing is sent here; times are monotonic. */
#ifndef LUM_LIVE_LASER_RULES_H
#define LUM_LIVE_LASER_RULES_H

#include "lum/live/laser_session.h"
#include "lum/live/news.h"
#include "lum/net/sensor.h"

#include <stdbool.h>
#include <stdint.h>

/* What is asked of the sensor. */
typedef enum lum_laser_request {
    LUM_LASER_ASK_LOOK, /* its status */
    LUM_LASER_ASK_ON,
    LUM_LASER_ASK_OFF,
    LUM_LASER_ASK_OTHER /* what its user asks: the laser is not meant */
} lum_laser_request;

typedef struct lum_laser_rules {
    lum_laser_state state;
    lum_laser_request request; /* the one under way, or the last */
    bool off_due;    /* the command "on" may be in effect: off has to be sent */
    bool off_unseen; /* off was answered, but no status has shown it */
    bool is_owned;   /* heartbeats go to it: without, a refusal for want of them
                        is final */
    unsigned attempts_max;
    int64_t give_up_ns; /* how long "on" may stay without an answer */
    uint16_t fell;      /* the status with which it was left; 0: unknown */
    unsigned hit;       /* hazards of alerts that came before its answer */
    unsigned attempts;  /* at "on" */
    unsigned sent;      /* datagrams of them that had no answer */
    int64_t stood_ns;   /* how long the program stood still */
    bool has_status;
    uint16_t status; /* the last one; 0: none has come */
    int64_t began_ns;
    int64_t tick_ns; /* when time last went on */
    int64_t next_ns; /* of the next request */
} lum_laser_rules;

/* What the user wants from now on: UNTOUCHED, ASKED, or LEFT, which keeps it
 * down once it falls, and switches it off where is_off says so. What is known
 * of the sensor stays. */
void lum_laser_rules_want(lum_laser_rules *rules, lum_laser_state state,
                          bool is_off, int64_t now_ns);

/* An answer to the request under way, an alert, or no answer; other events
 * change nothing. With an answer, or none, the request is ASK_LOOK again.
 * Returns the news, or 0. */
lum_news_kind lum_laser_rules_take(lum_laser_rules *rules,
                                   const lum_sensor_event *event,
                                   int64_t now_ns);

/* Pass the time; to be called several times a second. As _take(). */
lum_news_kind lum_laser_rules_tick(lum_laser_rules *rules, int64_t now_ns);

/* What is due, without regard to when. */
lum_laser_request lum_laser_rules_next(const lum_laser_rules *rules);

/* It was sent. */
void lum_laser_rules_sent(lum_laser_rules *rules, lum_laser_request request,
                          int64_t now_ns);

/* Hazards that heartbeats do not end. */
unsigned lum_laser_rules_hazards(uint16_t status);

#endif
