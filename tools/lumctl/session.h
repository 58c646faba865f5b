/* The session's events, as all commands take them. */
#ifndef LUMCTL_SESSION_H
#define LUMCTL_SESSION_H

#include "ctl.h"

/* As session_open_at(), without a complaint. */
lum_net_result session_try(const struct ctl *ctl, lum_endpoint host, bool owns,
                           lum_sensor **out, lum_error *error);

/* Begins a session with a host that may be another than the options' own.
 * Complains. */
enum exit_status session_open_at(const struct ctl *ctl, lum_endpoint host,
                                 bool owns, lum_sensor **out);

/* Goes on with this session instead of the one before. */
void session_replace(struct ctl *ctl, lum_sensor *sensor, bool owns);

/* Texts of the sensor that came unasked, and the state of the link, on standard
 * error. A session that owns the sensor leaves out what would have to wait for
 * a reader. */
void session_tell(struct ctl *ctl, const lum_sensor_event *event);

/* Waits for an event. Messages without a request are printed on standard error;
 * data is left to the caller. */
lum_sensor_event_kind session_wait(struct ctl *ctl, int64_t deadline_ns,
                                   lum_sensor_event *out);

/* Waits until the request under way ends: EXIT_DONE with its answer in *out.
 * Complains otherwise. */
enum exit_status session_finish(struct ctl *ctl, lum_sensor_event *out);

/* Lets time pass, and takes what arrives during that time. */
void session_rest(struct ctl *ctl, int64_t ns);

/* Lets the session, if there is one, send what is due, without waiting. Packets
 * that it receives are not reported. */
void session_keep_alive(struct ctl *ctl);

/* What an answer holds. */
void session_read_answer(struct ctl *ctl, const lum_sensor_event *event,
                         struct ctl_answer *out);

/* A status that came; printed on standard error if it differs from the last. */
void session_note_status(struct ctl *ctl, uint16_t status);

/* The sensor's name for people: its address, with the port where that is not
 * the usual one. */
#define SESSION_NAME_BYTES 24
const char *session_name(lum_endpoint host, char out[SESSION_NAME_BYTES]);

/* Who the commands talk to now. */
lum_endpoint session_host(const struct ctl *ctl);

/* Whether a session of this host has to send heartbeats: this one, or another
 * program's. False, without a search, if the status shows no need. */
bool session_is_owned(const struct ctl *ctl, uint16_t status);

/* Nobody answered: says so and what to do. tries: of the request that had no
 * answer; 0: time ended before that was known. */
enum exit_status session_complain_silence(const struct ctl *ctl,
                                          unsigned tries);

/* What to say when the data comes from another address. Returns out. */
#define SESSION_MOVE_BYTES 256
const char *session_describe_move(const struct ctl *ctl, lum_endpoint to,
                                  char out[SESSION_MOVE_BYTES]);

/* Whether a datagram is a data packet of the sensor. */
bool session_is_data(const struct ctl *ctl, const lum_received *datagram);

#endif
