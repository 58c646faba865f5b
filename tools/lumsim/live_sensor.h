/* A sensor on the network, and what its parts share. */
#ifndef LUMSIM_LIVE_SENSOR_H
#define LUMSIM_LIVE_SENSOR_H

#include "../common/json.h"
#include "lum/net/cancel.h"
#include "lum/net/socket.h"
#include "lum/packet.h"
#include "named_files.h"
#include "options.h"
#include "renderer.h"
#include "scene_feed.h"
#include "sender.h"
#include "sim/device.h"
#include "sim/random.h"
#include "timeline.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#define REPLIES_MAX 256

struct reply {
    int64_t due_ns;
    lum_device_peer to;
    size_t len;
    uint8_t bytes[LUM_DEVICE_REPLY_BYTES];
};

/* Answers on their way: delayed or lost, by the options. */
struct replies {
    int64_t delay_ns;
    double loss; /* a probability */
    lum_random random;
    size_t first;
    size_t count;                      /* that wait */
    struct reply waiting[REPLIES_MAX]; /* all wait alike: in order of due_ns */
};

/* The data of a recording, sent with its timing. */
struct playback {
    struct recording *recording; /* NULL: nothing is replayed */
    struct recording_facts facts;
    double speed;
    bool loops;
    bool has_ended;  /* all of it was given */
    bool has_next;   /* next is a packet */
    bool has_failed; /* error says why */
    lum_error error;
    struct recorded next;
    int64_t begin_ns;   /* when its first packet is due */
    int64_t delayed_ns; /* by which all came later than recorded */
    uint8_t *bytes;     /* of the packets given last */
    uint64_t rounds;    /* times it was given whole */
};

/* Where data comes from, and how it leaves; of live_data.c. */
struct live_data {
    struct renderer *renderer;
    struct scene scene;
    struct playback playback; /* in the place of scene when replaying */
    struct sender sender;
    bool has_begun; /* the device streams, and the data was begun */
    bool has_link;  /* data leaves */
};

struct log_file;

/* The log of --log: one JSON object a line, each line flushed; of events.c. */
struct live_log {
    FILE *out;             /* NULL: there is none, or it cannot be written */
    struct log_file *file; /* NULL: standard output */
    struct json json;
    int reason;         /* errno of the write that failed; 0: none did */
    int64_t ignored_ns; /* when ignored datagrams were last logged */
    uint64_t ignored;   /* since then */
    int64_t skipped_ns; /* when skipped lines were last logged */
    uint64_t skipped;   /* lines, until then */
    uint64_t rounds;    /* of the replay, until now */
};

struct live_counts {
    uint64_t heard[LUM_PACKET_KINDS]; /* datagrams */
    uint64_t unheard;                 /* in silence */
    uint64_t unsent;                  /* data, in silence */
    uint64_t answers;                 /* sent, alerts among them */
    uint64_t answers_lost;
};

struct live {
    const struct options *options;
    lum_cancel *cancel;
    lum_socket *socket;
    struct timeline timeline;
    struct replies replies;
    struct live_data data;
    struct live_log log;
    struct live_counts counts;
    lum_device device;
    lum_endpoint self; /* where it listens */
    int64_t start_ns;  /* monotonic, as all times here */
    int64_t end_ns;    /* INT64_MAX: a signal ends it */
    int64_t device_ns; /* the latest time passed to the device */
    bool is_silent;    /* sends nothing, hears nothing */
    bool has_failed;   /* the run ends, and not well */
    lum_error error;
};

static inline int64_t earlier(int64_t a_ns, int64_t b_ns)
{
    return a_ns < b_ns ? a_ns : b_ns;
}

/* Be one until a signal or the duration ends it. Returns the exit status. */
int live_run(const struct options *o);

/* serve.c: take the datagrams that have come, and do what the device says. */
void live_receive(struct live *live);
void live_tick(struct live *live, int64_t now_ns);
void live_init_replies(struct live *live);
int64_t live_replies_next_ns(const struct live *live); /* INT64_MAX: none */
void live_send_replies(struct live *live,
                       int64_t now_ns); /* answers that are due */
void live_reboot(struct live *live, int64_t now_ns);
void live_set_hazard(struct live *live, uint16_t bits, bool ends,
                     int64_t now_ns);

/* live_data.c: the data. To open it: 0, or -1 with the reason in live->error.
 */
int live_open_data(struct live *live);
void live_close_data(struct live *live);
unsigned live_frames(const struct live *live); /* that a reel has */
void live_order(struct live *live); /* a reel that suits the settings */
void live_fetch(struct live *live, int64_t now_ns); /* it, once it is done */
void live_stream(struct live *live, int64_t now_ns);
void live_switch_data(struct live *live, int64_t now_ns); /* as the device */
void live_darken_data(struct live *live); /* what has not left */
int64_t live_stream_next_ns(const struct live *live, int64_t now_ns);

/* events.c: lines of the log. A file exists from its first line on, and only
 * one run can write it. To open it: 0, or -1 with the reason in live->error; to
 * close it: 0, or the errno of what could not be written. */
int live_open_log(struct live *live);
int live_close_log(struct live *live);
/* Begin a line with "t" and "event". Returns the object for its rest. */
struct json *live_begin_line(struct live *live, int64_t t_ns,
                             const char *event);
void live_end_line(struct live *live);
/* "a.b.c.d:port" into 24 bytes. */
const char *live_name(uint32_t address, uint16_t port, char out[24]);
void live_log_text(struct live *live, int64_t t_ns, const char *event,
                   const char *key, const char *text);
void live_log_start(struct live *live);
void live_log_received(struct live *live, int64_t t_ns, lum_packet_kind kind,
                       const lum_received *datagram, const char *note);
void live_log_reply(struct live *live, int64_t t_ns, lum_device_peer to,
                    const void *bytes, size_t len, bool is_lost);
void live_log_state(struct live *live, const lum_device_effects *effects,
                    int64_t now_ns);
void live_log_move(struct live *live, int64_t now_ns, uint32_t address,
                   const char *reason);
void live_log_frames(struct live *live, int64_t now_ns);
void live_log_round(struct live *live, int64_t now_ns);
void live_log_skipped(struct live *live, int64_t now_ns);
void live_log_stop(struct live *live, int64_t now_ns);
void live_flush_ignored(struct live *live, int64_t now_ns);

#endif
