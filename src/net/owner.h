/* Who owns a sensor: only one program of a host at a time may send heartbeats
 * and get the data, because the sensor sends data to the sender of the last
 * heartbeat. The system releases the right when the owner's process ends in any
 * way. */
#ifndef LUM_NET_OWNER_H
#define LUM_NET_OWNER_H

#include "lum/base/error.h"
#include "lum/net/socket.h"

#include <stdbool.h>
#include <stdint.h>

/* The right to a sensor. Its marks are ADDRESS:PORT and, where the interface is
 * known, ADDRESS:PORT%INTERFACE. A session that names no interface has the
 * first, even if the routes change, and the second for the interface that they
 * name now. A session that names an interface has the second, and also the
 * first if the routes name the same interface. So two sessions cannot own one
 * sensor, but they can own two sensors of one address on two interfaces. */
typedef struct lum_owner lum_owner;

/* Take a sensor. interface: where it is reached; NULL: as the routes say.
 * out gets what is to be given back with lum_owner_release(). LUM_NET_OK;
 * LUM_NET_BUSY: another session has it, error names its program and process;
 * LUM_NET_FAILED. */
LUM_MUST_CHECK lum_net_result lum_owner_take(lum_endpoint sensor,
                                             const char *interface,
                                             lum_owner **out, lum_error *error);

/* Whether a session has a sensor; nothing is taken, so that a session that
 * begins now is not refused. who may be NULL; else it names the program. */
bool lum_owner_look(lum_endpoint sensor, const char *interface, lum_error *who);

/* Give it back. NULL is allowed. */
void lum_owner_release(lum_owner *owner);

/* --- By each system: a name that only one process at a time holds --- */

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
