/* Requests and their answers, heartbeats and their schedule, as a machine of
 * bytes and times: no socket, no clock, no allocation. Times are monotonic ns,
 * 0 to 2^62, and never go back. */
#ifndef LUM_NET_EXCHANGE_H
#define LUM_NET_EXCHANGE_H

#include "lum/net/sensor.h"
#include "lum/wire.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Tries of a time request whose answers can still be matched. */
#define LUM_EXCHANGE_TRIES 16u

/* What a request needs now. */
typedef enum lum_exchange_step {
    LUM_EXCHANGE_NOTHING, /* until lum_exchange_next_ns() */
    LUM_EXCHANGE_REQUEST, /* send packet, for the first time */
    LUM_EXCHANGE_RESEND,  /* send packet again */
    LUM_EXCHANGE_GIVEN_UP /* no answer came; nothing to send */
} lum_exchange_step;

/* What a datagram from the sensor is. */
typedef enum lum_exchange_kind {
    LUM_EXCHANGE_OTHER,     /* data, or nothing that concerns requests */
    LUM_EXCHANGE_ANSWER,    /* to the TLV request under way */
    LUM_EXCHANGE_TIME,      /* to the time request under way */
    LUM_EXCHANGE_ALERT,     /* TLVs that nobody asked for */
    LUM_EXCHANGE_DROPPED,   /* an answer, late, repeated, or to nothing */
    LUM_EXCHANGE_MALFORMED, /* an answer or alert that contradicts itself */
    LUM_EXCHANGE_KINDS
} lum_exchange_kind;

/* What is under way. */
typedef enum lum_exchange_ask {
    LUM_ASK_NOTHING,
    LUM_ASK_TLV,
    LUM_ASK_TIME
} lum_exchange_ask;

#define LUM_EXCHANGE_STALE_NS (LUM_SENSOR_STALE_MS * INT64_C(1000000))

/* A step is due at least this often while a request is under way, so that a
 * longer time without one shows that the application was held up. */
#define LUM_EXCHANGE_LOOK_NS INT64_C(1000000000)

typedef struct lum_exchange_config {
    uint16_t status_tlv;  /* number of the status TLV */
    bool owns;            /* send heartbeats */
    uint32_t first;       /* sequence number of the first request */
    int64_t heartbeat_ns; /* between heartbeats, above 0 */
    int64_t timeout_ns;   /* of one try, above 0 */
    uint32_t retries;     /* further tries */
} lum_exchange_config;

/* A try of the request under way. */
typedef struct lum_exchange_try {
    uint32_t sequence;
    int64_t sent_ns;
} lum_exchange_try;

typedef struct lum_exchange {
    lum_exchange_config config;
    uint32_t next;   /* sequence number to be issued next */
    uint64_t issued; /* numbers from config.first on that were */
    bool has_beaten; /* the grid of heartbeats has begun */
    int64_t beat_ns; /* next heartbeat; on a grid */

    lum_exchange_ask ask;
    unsigned tries;     /* of the request under way */
    int64_t due_ns;     /* its next try, or the end */
    int64_t looked_ns;  /* when its step was last asked for */
    int64_t noticed_ns; /* when its end was first seen */
    bool has_noticed;   /* its end was seen, and answers may still wait */
    bool is_stale; /* the application was held up: it is not sent any more */
    uint32_t sequence;                        /* of its last try */
    lum_exchange_try log[LUM_EXCHANGE_TRIES]; /* a ring of its tries */
    uint8_t packet[LUM_SENSOR_REQUEST_BYTES]; /* the request, to be sent */
    size_t packet_len;
} lum_exchange;

/* What was found in a datagram, or given up. */
typedef struct lum_exchange_found {
    uint32_t sequence;
    lum_tlv_reader tlvs; /* ANSWER, ALERT; points into the datagram */
    bool has_status;     /* ANSWER, ALERT */
    uint16_t status;
    uint32_t clock_us; /* TIME */
    unsigned tries;    /* ANSWER, TIME, GIVEN_UP */
    int64_t sent_ns;   /* ANSWER, TIME: earliest try that fits */
} lum_exchange_found;

void lum_exchange_init(lum_exchange *out, const lum_exchange_config *config);

/* As lum_sensor_request() and lum_sensor_request_time(). It is due at now_ns.
 */
LUM_MUST_CHECK lum_result lum_exchange_request(lum_exchange *x, int64_t now_ns,
                                               const void *tlvs, size_t len);
LUM_MUST_CHECK lum_result lum_exchange_request_time(lum_exchange *x,
                                                    int64_t now_ns);

/* Forgets the request under way. */
void lum_exchange_give_up(lum_exchange *x);

/* When a step is due; INT64_MAX: never, INT64_MIN: at once. */
int64_t lum_exchange_next_ns(const lum_exchange *x);

/* The heartbeat, if it is due: true, and it counts as sent at now_ns. */
bool lum_exchange_beat(lum_exchange *x, int64_t now_ns);

/* The next step of the request under way; call until NOTHING. For REQUEST and
 * RESEND packet is to be sent, and counts as sent at now_ns.
 * heard_ns  all that had arrived by then was given to lum_exchange_take(): a
 *           request is not given up while its answer may wait in the socket,
 *           though never later than one timeout after that was first seen.
 * found    written for GIVEN_UP. */
lum_exchange_step lum_exchange_advance(lum_exchange *x, int64_t now_ns,
                                       int64_t heard_ns,
                                       lum_exchange_found *found);

/* Takes a datagram from the sensor; any bytes.
 * found  written for ANSWER, TIME and ALERT. */
lum_exchange_kind lum_exchange_take(lum_exchange *x, const void *bytes,
                                    size_t len, lum_exchange_found *found);

#endif
