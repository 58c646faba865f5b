/* The session's events, as all commands take them. */
#ifndef LUMCTL_CTL_SESSION_H
#define LUMCTL_CTL_SESSION_H

#include "ctl.h"

/* A session with a host that may be another than the options' own, without a
 * complaint. */
lum_net_result session_try(const struct ctl *ctl, lum_endpoint host, bool owns,
                           lum_sensor **out, lum_error *error);

/* Goes on with a session with this host instead of the one before, and with a
 * laser session of its own. Complains. */
enum exit_status session_change(struct ctl *ctl, lum_endpoint host, bool owns);

/* The beginning of a command for a host: lum_news_ctl(). */
#define SESSION_CTL_BYTES 320
struct session_ctl {
    char text[SESSION_CTL_BYTES];
};
struct session_ctl session_ctl(const struct ctl *ctl, lum_endpoint host);

/* Ends the session, and with it its heartbeats. */
void session_end(struct ctl *ctl);

/* What is new about the sensor, on standard error, but for what commands say of
 * their own requests; is_alone: only the laser session asks. A session that
 * owns the sensor leaves out what would have to wait for a reader. */
void session_tell(struct ctl *ctl, const lum_sensor_event *event,
                  bool is_alone);

/* Whether a session of this host sends heartbeats: this one, or another
 * program's. */
bool session_has_owner(const struct ctl *ctl);

/* Begins a request, in place of the one under way. */
lum_result session_request(struct ctl *ctl, const void *tlvs, size_t len);
lum_result session_request_time(struct ctl *ctl);

/* The same with a checked text of commands. */
lum_result session_command(struct ctl *ctl, const char *text);

/* Receives an event, and hands it to the laser session. Laser off does not wait
 * where it is due. */
void session_receive(struct ctl *ctl, int64_t deadline_ns,
                     lum_sensor_event *out);

/* Waits for an event. Messages without a request are printed on standard error;
 * data is left to the caller. */
lum_sensor_event_kind session_wait(struct ctl *ctl, int64_t deadline_ns,
                                   lum_sensor_event *out);

/* Waits until the request under way ends: EXIT_DONE with its answer in *out.
 * Complains otherwise, also where laser off came first. */
enum exit_status session_finish(struct ctl *ctl, lum_sensor_event *out);

/* Lets time pass, and takes what arrives during that time. */
void session_rest(struct ctl *ctl, int64_t ns);

/* Sends laser off where it is due, in place of the request under way. Whether
 * it is. */
bool session_serve_off(struct ctl *ctl);

/* Lets the session, if there is one, send what is due, without waiting. Packets
 * that it receives are not reported. */
void session_keep_alive(struct ctl *ctl);

/* The same; false where a signal ended the command. owner: struct ctl. For
 * struct arp_patience. */
bool session_goes_on(void *owner);

/* What an answer holds. */
void session_read_answer(struct ctl *ctl, const lum_sensor_event *event,
                         struct ctl_answer *out);

/* The sensor's name for people: its address, with the port where that is not
 * the usual one. */
#define SESSION_NAME_BYTES 24
struct session_name {
    char text[SESSION_NAME_BYTES];
};
struct session_name session_name(lum_endpoint host);

/* Who the commands talk to now. */
lum_endpoint session_host(const struct ctl *ctl);

/* Whether a session of this host has to send heartbeats: this one, or another
 * program's. False, without a search, if the status shows no need. */
bool session_is_owned(const struct ctl *ctl, uint16_t status);

/* Nobody answered: says so and what to do. tries: of the request that had no
 * answer; 0: time ended before that was known. */
enum exit_status session_complain_silence(const struct ctl *ctl,
                                          unsigned tries);

#endif
