/* A timestamp request that also hears what the network says of it. */
#ifndef LUMCTL_DOCTOR_KNOCK_H
#define LUMCTL_DOCTOR_KNOCK_H

#include "lum/net/socket.h"

#include <stdbool.h>
#include <stdint.h>

enum knock_answer {
    KNOCK_SILENCE,
    KNOCK_ANSWERED,    /* by whatever has the port */
    KNOCK_REFUSED,     /* the host is there, nobody has the port */
    KNOCK_UNREACHABLE, /* nobody has the address, or no way there */
    KNOCK_DENIED,      /* this host forbids it: a firewall rule */
    KNOCK_FAILED       /* no socket */
};

struct knock {
    int fd; /* -1: none */
};

/* Sends the request. KNOCK_SILENCE: it left. */
enum knock_answer knock_begin(struct knock *knock, lum_endpoint to,
                              const char *interface);

/* Looks whether something came; waits so long for it. */
enum knock_answer knock_hear(struct knock *knock, int wait_ms);

void knock_end(struct knock *knock);

#endif
