/* A timestamp request that also hears errors of the network. */
#ifndef LUMCTL_DOCTOR_KNOCK_H
#define LUMCTL_DOCTOR_KNOCK_H

#include "lum/net/socket.h"

#include <stdbool.h>
#include <stdint.h>

enum knock_answer {
    KNOCK_SILENCE,
    KNOCK_ANSWERED,    /* by a sensor */
    KNOCK_REFUSED,     /* the host is there, no program has the port */
    KNOCK_UNREACHABLE, /* no device has the address, or no route there */
    KNOCK_DENIED,      /* this host forbids it: a firewall rule */
    KNOCK_FAILED       /* no socket, or choosing the interface is not allowed */
};

struct knock {
    int fd;        /* -1: none */
    uint16_t port; /* ours */
};

/* Opens the socket; interface: NULL for the kernel's own route. KNOCK_SILENCE:
 * it is open. Call knock_end() in any case. */
enum knock_answer knock_open(struct knock *knock, lum_endpoint to,
                             const char *interface);

/* Sends the request, once for each call. KNOCK_SILENCE: it was sent. */
enum knock_answer knock_send(const struct knock *knock);

/* knock_open() and knock_send(). */
enum knock_answer knock_begin(struct knock *knock, lum_endpoint to,
                              const char *interface);

/* Looks whether something came; waits for this time at most. */
enum knock_answer knock_hear(struct knock *knock, int wait_ms);

void knock_end(struct knock *knock);

/* Whether a sensor answers; asks more than once, for less than a second. */
bool knock_reaches(lum_endpoint to, const char *interface);

/* The port of an address from which a sensor answers a request to another port;
 * 0: no such answer came. */
uint16_t knock_other_port(lum_endpoint to, const char *interface);

#endif
