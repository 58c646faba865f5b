/* The thread that keeps the session with a sensor. It never waits for an
 * output: the laser is on only while it receives, and a slow disk is no reason
 * to lose it. */
#ifndef LUMDUMP_RECEIVING_H
#define LUMDUMP_RECEIVING_H

#include "lanes.h"
#include "options.h"
#include "say.h"

#include "lum/live/laser_session.h"

#include <stdbool.h>
#include <stdint.h>

/* Why a session ends. */
enum session_end {
    SESSION_GOES_ON,
    SESSION_DURATION, /* it is over, or all of --frames has come */
    SESSION_SIGNAL,   /* one came */
    SESSION_OUTPUT,   /* the last one has ended */
    SESSION_NO_DATA,  /* from the start */
    SESSION_BROKEN    /* the socket; see the error */
};

/* Totals at a moment. */
struct status_totals {
    int64_t time_ns; /* monotonic */
    uint64_t datagrams;
    uint64_t bytes;
    uint64_t points;
    uint64_t lost_words; /* on the wire, as reassembly saw it */
    uint64_t lost_lines;
    uint64_t kernel_drops;
    uint64_t ring_drops;
    uint64_t refused;     /* by reassembly */
    unsigned buffer_used; /* percent */
};

struct session {
    const struct options *options;
    const lum_layout *layout;
    lum_sensor *sensor;
    struct lanes *lanes;

    struct say say;
    lum_laser_session *laser;
    int64_t dark_ns; /* with data, and without the laser that was asked for */
    enum session_end end;
    lum_error error;
    int64_t began_ns; /* all times are monotonic */
    int64_t ended_ns;
    int64_t end_ns; /* of the duration; far away: none */
    int64_t tick_ns;
    int64_t status_ns;
    uint64_t received; /* datagrams, and bytes in them */
    uint64_t bytes;
    struct say_count told_kernel; /* of those that it dropped */
    struct status_totals before;
};

/* Receive until there is a reason to end. The first members are set, up to the
 * laser session; the rest is zero. */
void session_run(struct session *session);

/* Takes what had come before the run ended and still waits in the kernel, so
 * that all of it is either received or counted as dropped. cancel: the
 * sensor's, which is reset. */
void session_drain(struct session *session, lum_cancel *cancel);

/* What is known of the sensor. */
lum_laser_session_view session_look(const struct session *session);

/* Why lines have no ranges; out does not change where nothing shows that. */
void session_darkness(const struct session *session, char *out, size_t room);

#endif
