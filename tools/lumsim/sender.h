/* The way of data out of the sensor: through the faults of the options, in
 * batches, to the client. */
#ifndef LUMSIM_SENDER_H
#define LUMSIM_SENDER_H

#include "lum/net/socket.h"
#include "options.h"
#include "sim/fault.h"
#include "sim/random.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct sender_slot;

struct sender {
    bool is_direct; /* no faults, no jitter: nothing is copied */
    lum_fault fault;
    lum_random random;
    int64_t jitter_ns;
    uint64_t order; /* of the next slot that is filled */

    struct sender_slot *slots; /* NULL if direct */
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

/* Whether nothing happens to packets on their way. */
bool sender_is_direct(const struct delivery_options *options);

/* 0, or -1 without memory. */
int sender_open(struct sender *out, const struct delivery_options *options,
                uint64_t seed);
void sender_close(struct sender *sender);

/* Take datagrams to nobody yet, at most LUM_SOCKET_BATCH, and none while it is
 * stuck. If direct, their bytes must live until they have left or
 * sender_drop(). */
void sender_put(struct sender *sender, const lum_outgoing *datagrams, size_t n,
                int64_t now_ns);

/* Send what is due. False when datagrams had to be given up. */
bool sender_send(struct sender *sender, lum_socket *socket, lum_endpoint to,
                 int64_t now_ns);

/* When sender_send() has something to do; INT64_MAX: never. */
int64_t sender_next_ns(const struct sender *sender, int64_t now_ns);

/* Forget all that has not left. */
void sender_drop(struct sender *sender);

/* Forget packets that have not left and are not copies: their bytes will be
 * reused. */
void sender_drop_borrowed(struct sender *sender);

/* Whether something is stuck: nothing more is taken then. */
bool sender_is_stuck(const struct sender *sender);

#endif
