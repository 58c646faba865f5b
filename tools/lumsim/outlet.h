/* The way of data out of the sensor: through the faults of the options, in
 * batches, to the client. */
#ifndef LUMSIM_OUTLET_H
#define LUMSIM_OUTLET_H

#include "feed.h"
#include "lum/net/socket.h"
#include "sim/fault.h"
#include "sim/random.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct outlet_slot;

struct outlet {
    bool is_direct; /* no faults, no jitter: nothing is copied */
    lum_fault fault;
    lum_random random;
    int64_t jitter_ns;
    uint64_t order; /* of the next slot that is filled */

    struct outlet_slot *slots; /* NULL if direct */
    uint32_t *heap; /* slots that wait, by time; free ones after them */
    size_t waiting;

    lum_outgoing pending[LUM_SOCKET_BATCH]; /* on the point of leaving */
    size_t pending_count;
    size_t pending_next;
    size_t leaving; /* slots that pending points into, after the waiting ones */
    int64_t stuck_ns; /* since when nothing has left; 0: it flows */
    lum_error error;  /* why it was given up last */

    uint64_t sent;
    uint64_t bytes;
    uint64_t retries;  /* sends that did not take all */
    uint64_t given_up; /* datagrams that the system would not send */
    uint64_t no_room;  /* datagrams that jitter could not hold */
};

/* 0, or -1 without memory. */
int outlet_open(struct outlet *out, const double faults[LUM_FAULT_KINDS],
                double jitter_ms, uint64_t seed);
void outlet_close(struct outlet *outlet);

/* How many parcels it takes now, at most LUM_SOCKET_BATCH. */
size_t outlet_room(const struct outlet *outlet);

/* Take parcels, at most outlet_room(). If direct, their bytes must live until
 * they have left or outlet_drop(). */
void outlet_put(struct outlet *outlet, const struct parcel *parcels, size_t n,
                int64_t now_ns);

/* Send what is due. False when datagrams had to be given up. */
bool outlet_send(struct outlet *outlet, lum_socket *socket, lum_endpoint to,
                 int64_t now_ns);

/* When outlet_send() has something to do; INT64_MAX: never. */
int64_t outlet_next_ns(const struct outlet *outlet, int64_t now_ns);

/* Forget all that has not left. */
void outlet_drop(struct outlet *outlet);

/* Forget packets that have not left and are not copies: their bytes will be
 * reused. */
void outlet_drop_borrowed(struct outlet *outlet);

/* Whether something is stuck: nothing more is taken then. */
bool outlet_is_stuck(const struct outlet *outlet);

#endif
