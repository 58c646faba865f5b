/* The system's part of an owner: a name that only one process at a time
 * holds. */
#ifndef LUM_NET_OWNER_SYSTEM_H
#define LUM_NET_OWNER_SYSTEM_H

#include "lum/net/socket.h"

#include <stdbool.h>
#include <stdint.h>

/* Longest name, its NUL included. */
#define LUM_OWNER_NAME_BYTES 100

/* Hold a name such as "10.42.0.37:5517%eth0". LUM_NET_OK: *held is for
 * lum_owner_system_drop(); LUM_NET_BUSY: *process has it, 0 if the system does
 * not say which; LUM_NET_FAILED with a message. */
lum_net_result lum_owner_system_hold(const char *name, intptr_t *held,
                                     long *process, lum_error *error);

/* Whether a process holds a name: *process, 0 if the system does not say which.
 * Who takes the name meanwhile gets it. */
bool lum_owner_system_look(const char *name, long *process);

void lum_owner_system_drop(intptr_t held);

#endif
