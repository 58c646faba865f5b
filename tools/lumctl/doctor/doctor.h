/* Finds what keeps a sensor from being used, by a list of checks. Each check
 * looks at one thing: it is fine, wrong, worth a note, or could not be
 * checked. */
#ifndef LUMCTL_DOCTOR_H
#define LUMCTL_DOCTOR_H

#include "../../common/interfaces.h"
#include "../ctl.h"
#include "../ctl_session.h"
#include "../host_route.h"

#include "lum/assembler.h"
#include "lum/frame/framer.h"
#include "lum/host/clock_sync.h"
#include "lum/packet.h"

#include "base/text.h"

#include <stdbool.h>
#include <stdint.h>

enum doctor_result {
    DOCTOR_FINE,
    DOCTOR_WRONG,
    DOCTOR_NOTE,
    DOCTOR_UNSEEN,
    DOCTOR_RESULTS
};

#define DOCTOR_TEXT_BYTES 1024u
#define DOCTOR_FIX_BYTES  512u

struct doctor_finding {
    enum doctor_result result;
    char text[DOCTOR_TEXT_BYTES];
    char fix[DOCTOR_FIX_BYTES]; /* a command; empty: none */
};

/* What a check needs. Each of these needs all before it, too. */
enum doctor_need {
    DOCTOR_NEEDS_NOTHING,
    DOCTOR_NEEDS_INTERFACE, /* one in the sensor's subnet */
    DOCTOR_NEEDS_ROUTE,
    DOCTOR_NEEDS_NEIGHBOUR, /* some device has the address */
    DOCTOR_NEEDS_ANSWER,    /* a sensor answers */
    DOCTOR_NEEDS_SESSION,   /* heartbeats may be sent */
    DOCTOR_NEEDS_DATA,
    DOCTOR_NEEDS
};

/* A timestamp, and when it was asked for and came. */
struct doctor_exchange {
    int64_t sent_ns;
    int64_t received_ns;
    uint32_t clock_us;
};

/* The session that the doctor has with the sensor, as its owner or only for
 * requests. doctor_run.c begins its clock; else doctor_session.c alone
 * changes it. */
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

/* What came while the doctor was the session. */
struct doctor_stream {
    uint64_t kinds[LUM_PACKET_KINDS];
    uint32_t odd_type; /* of the last data packet that did not decode */
    size_t odd_len;
    uint64_t lines; /* judged; without those that were under way */
    uint64_t lines_missing_angles;
    uint64_t lost_words;
    unsigned pass_over[LUM_EYES]; /* lines that are not judged, still to come */
    bool has_clock;
    uint32_t clock_us; /* the latest data packet's, as sent */
    int64_t clock_ns;  /* when the kernel received it */
    lum_assembly_counters assembly;
    bool lacks_memory; /* for lines: they were not looked at */
    lum_sensor_counters session;
    bool counts_drops;
    uint64_t came_in; /* at least so many datagrams, by the interface, before
                         any rule of this host; 0: not known */
    int64_t duration_ns;
    lum_framer *framer; /* data to lines; NULL: no data was taken */
};

/* This host's interfaces (doctor_interface.c). */
struct doctor_host {
    struct host_interface *all; /* the heap's */
    size_t count;
    const struct host_interface
        *chosen;      /* in the sensor's subnet; NULL: none */
    uint32_t address; /* this host's, there */
    bool answers;     /* a device with the sensor's address was seen there */
    char own[64];     /* the sensor's address, where it is this host's:
                         "10.42.0.37/24 dev eth0"; empty: 127/8 */
};

struct doctor {
    struct ctl *ctl;
    lum_endpoint sensor;
    char address[16];
    const char *lacks[DOCTOR_NEEDS]; /* why not; NULL: it is there */
    bool is_silent;                  /* a request was sent, and nothing came */
    bool is_misled; /* requests or answers may reach another device */
    bool has_hazard;
    bool is_local;    /* the sensor's address is one of this host's */
    bool was_refused; /* the host there says that no program listens */
    struct doctor_host host;
    struct host_route route; /* to the sensor (doctor_route.c) */
    uint32_t next_hop;       /* of it */
    struct doctor_session session;
    struct doctor_stream stream;
};

/* What a check says; the text is a sentence without its full stop. */
LUM_PRINTF(3, 4)
void doctor_say(struct doctor_finding *out, enum doctor_result result,
                const char *text, ...);
#define doctor_fine(out, ...)   doctor_say(out, DOCTOR_FINE, __VA_ARGS__)
#define doctor_wrong(out, ...)  doctor_say(out, DOCTOR_WRONG, __VA_ARGS__)
#define doctor_note(out, ...)   doctor_say(out, DOCTOR_NOTE, __VA_ARGS__)
#define doctor_unseen(out, ...) doctor_say(out, DOCTOR_UNSEEN, __VA_ARGS__)
/* More of the sentence. */
#define doctor_add(out, ...)                                                   \
    lum_text_add((out)->text, sizeof(out)->text, __VA_ARGS__)
LUM_PRINTF(2, 3)
void doctor_fix(struct doctor_finding *out, const char *command, ...);

/* Where a program listens, as options: "127.0.0.1 --port 5518"; the port only
 * if it is not the usual one. */
struct doctor_place {
    char text[40];
};
struct doctor_place doctor_place(lum_endpoint at);

/* Where a simulator of this host is, if there is one that may be named; else
 * false, and nothing is written. otherwise: a command for users who have
 * another sensor, may be empty. */
bool doctor_fix_simulator(struct doctor_finding *out, const char *otherwise);

/* The command that lists the rules of this host's firewall that may drop
 * datagrams. */
void doctor_fix_rules(const struct doctor *d, struct doctor_finding *out);

/* Where else the sensor may be. */
void doctor_fix_elsewhere(const struct doctor *d, struct doctor_finding *out);

/* Marks a need as missing, and all needs after it. why is kept, not copied; an
 * earlier reason stays. */
void doctor_lack(struct doctor *d, enum doctor_need need, const char *why);

/* --- doctor_session.c --- */

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

/* Checks of this host: doctor_interface.c, doctor_route.c, doctor_arp.c,
 * doctor_ports.c, doctor_firewall.c, doctor_host.c; or doctor_other.c. */
void doctor_check_interface(struct doctor *d, struct doctor_finding *out);
void doctor_check_route(struct doctor *d, struct doctor_finding *out);
void doctor_check_arp(struct doctor *d, struct doctor_finding *out);
void doctor_check_port(struct doctor *d, struct doctor_finding *out);
void doctor_check_firewall(struct doctor *d, struct doctor_finding *out);
void doctor_check_mtu(struct doctor *d, struct doctor_finding *out);
/* The command that shows packets as they pass. filter: as for tcpdump; why: a
 * comment. */
void doctor_fix_watch(const struct doctor *d, struct doctor_finding *out,
                      const char *filter, const char *why);
/* Bytes of datagrams that a receive buffer holds. */
size_t doctor_buffer_payload(size_t granted);
/* The command that raises the kernel's limit for receive buffers. */
void doctor_fix_buffer(struct doctor_finding *out);

/* Checks on the wire: doctor_session.c, doctor_answer.c, doctor_data.c,
 * doctor_stream.c, doctor_sensor.c. */
void doctor_check_session(struct doctor *d, struct doctor_finding *out);
void doctor_check_buffer(struct doctor *d, struct doctor_finding *out);
void doctor_check_answer(struct doctor *d, struct doctor_finding *out);
void doctor_check_data(struct doctor *d, struct doctor_finding *out);
void doctor_check_layout(struct doctor *d, struct doctor_finding *out);
void doctor_check_loss(struct doctor *d, struct doctor_finding *out);
void doctor_check_strangers(struct doctor *d, struct doctor_finding *out);
void doctor_check_clock(struct doctor *d, struct doctor_finding *out);
void doctor_check_status(struct doctor *d, struct doctor_finding *out);

/* As doctor_fix_watch(), while a command of lumctl runs, with a question to
 * look for. */
void doctor_fix_watch_while(const struct doctor *d, struct doctor_finding *out,
                            const char *filter, const char *command,
                            const char *question);
/* False without memory. */
bool doctor_stream_open(struct doctor *d);
void doctor_stream_take(struct doctor *d, const lum_received *datagram,
                        int64_t arrived_ns);
/* Datagrams that are data, and do not fit the wire profile. */
uint64_t doctor_stream_odd(const struct doctor_stream *s);
/* Datagrams that this host dropped between interface and program, except those
 * for which the buffer was full; 0: none, or not known. */
uint64_t doctor_stream_filtered(const struct doctor *d);

/* Opens a capture of what the sensor sends to a UDP port of this host. Returns
 * a descriptor for capture_end(); -1: this is not allowed, or there is no such
 * interface. */
int capture_open(const char *interface, lum_endpoint sensor, uint16_t to_port);

/* Whether something came, without a wait. */
bool capture_saw(int fd);

/* Number of packets since it was opened; closes it. -1 is allowed. */
uint64_t capture_end(int fd);

#endif
