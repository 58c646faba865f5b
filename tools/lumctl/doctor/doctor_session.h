/* The session that the doctor has with the sensor, as its owner or only for
 * requests. doctor_run.c begins its clock; else doctor_session.c alone
 * changes it. */
#ifndef LUMCTL_DOCTOR_SESSION_H
#define LUMCTL_DOCTOR_SESSION_H

#include "lum/base/error.h"
#include "lum/host/clock_sync.h"
#include "lum/net/sensor.h"

#include <stdbool.h>
#include <stdint.h>

struct doctor;

/* A timestamp, and when it was asked for and came. */
struct doctor_exchange {
    int64_t sent_ns;
    int64_t received_ns;
    uint32_t clock_us;
};

struct doctor_session {
    lum_sensor *handle; /* NULL: none is open */
    lum_clock_sync clock;
    bool has_time;
    int64_t begin_ns;             /* of the exchanges, where has_time */
    struct doctor_exchange early; /* the shortest near their beginning */
    struct doctor_exchange late;  /* and near their end */
    bool has_status;
    uint16_t status;
};

/* Opens a session in the place of the one before. owns: it sends heartbeats. */
lum_net_result doctor_open(struct doctor *d, bool owns, lum_error *error);
void doctor_close(struct doctor *d);

/* Asks for the time repeatedly, as long as answers come. */
void doctor_ask_times(struct doctor *d);

/* False: no answer, or no session. An answer may bear no status. */
bool doctor_ask_status(struct doctor *d);

/* Receives, without a request, until a time. False: that is not possible. */
bool doctor_rest_until(struct doctor *d, int64_t end);

/* Keeps the time or the status of an event. */
void doctor_note_event(struct doctor_session *s, const lum_sensor_event *event);

/* Whether no event comes after it: a signal, or no network. */
bool doctor_is_broken(lum_sensor_event_kind kind);

int64_t doctor_round_trip_ns(const struct doctor_exchange *e);

#endif
