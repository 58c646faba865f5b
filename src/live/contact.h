/* Whether a sensor is heard: its data, its answers, the way to it. Times are
 * monotonic; nothing is sent. Each function returns the news, or 0. */
#ifndef LUM_LIVE_CONTACT_H
#define LUM_LIVE_CONTACT_H

#include "lum/group.h"
#include "lum/live/news.h"
#include "lum/net/sensor.h"
#include "lum/profile.h"

#include <stdbool.h>
#include <stdint.h>

/* A reading of the sensor's clock, and when it arrived. */
typedef struct lum_reading {
    bool is_there;
    uint64_t ticks;
    int64_t at_ns;
    int64_t utc_ns;
} lum_reading;

typedef struct lum_contact_answers {
    bool has_come;
    int64_t heard_ns; /* the last one; 0: never */
    bool is_unheard;  /* the last request had none */
    bool told_unheard;
    bool told_no_status;
    uint64_t dropped; /* that fitted no request, when one last did */
} lum_contact_answers;

typedef struct lum_contact {
    int64_t began_ns; /* anew after a pause of the program, which was so long */
    int64_t pause_ns;
    int64_t passed_ns;
    bool has_data;
    bool has_unknown;      /* packets of another layout, before any data */
    int64_t first_data_ns; /* when data came first */
    int64_t data_ns;       /* and last; the beginning: none has come */
    int64_t away_ns;       /* when data came again after a pause; 0: no pause */
    lum_news_kind quiet;   /* that data has stopped was told; 0: it has not */
    bool told_waiting;     /* that none has come was told */

    lum_contact_answers answers;

    lum_reading clock; /* the last that was where it should be */
    lum_reading odd;   /* the last that was not, if no other followed */

    bool link_is_down;
    bool is_moved;
    lum_endpoint to;
} lum_contact;

void lum_contact_begin(lum_contact *contact, int64_t now_ns);

/* Time has passed: what the program did not listen to is no silence. */
void lum_contact_pass(lum_contact *contact, int64_t now_ns);

/* Data has come. */
lum_news_kind lum_contact_note_data(lum_contact *contact, int64_t now_ns);

/* What its clock says. One odd reading may be a damaged packet, a second one
 * that fits to it is a clock that began anew. utc_ns: when the packet came. */
lum_news_kind lum_contact_note_clock(lum_contact *contact,
                                     const lum_profile *profile,
                                     const lum_group *group, int64_t now_ns,
                                     int64_t utc_ns);

/* An event other than datagrams. */
lum_news_kind lum_contact_take(lum_contact *contact,
                               const lum_sensor_event *event, int64_t now_ns);

/* Pass the time. An owner waits for data. dropped:
 * lum_sensor_counters.answers_dropped. */
lum_news_kind lum_contact_tick(lum_contact *contact, bool is_owner,
                               uint64_t dropped, int64_t now_ns);

/* Whether its data comes from elsewhere: then to says where from. */
lum_news_kind lum_contact_move(lum_contact *contact, bool is_moved);

/* Whether data had stopped a moment ago, or has, or the clock began anew. */
bool lum_contact_was_away(const lum_contact *contact, int64_t now_ns);

/* What holds now of all that; 0: nothing. */
lum_news_kind lum_contact_standing(const lum_contact *contact, int64_t now_ns);

#endif
