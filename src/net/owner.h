/* Who owns a sensor: heartbeats and data are one program's of a host at a time,
 * since the sensor sends data to whoever sent the last heartbeat. What the
 * system keeps of an owner ends with its process, however that ends. */
#ifndef LUM_NET_OWNER_H
#define LUM_NET_OWNER_H

#include "lum/base/error.h"
#include "lum/net/socket.h"

/* The right to a sensor. Its marks are ADDRESS:PORT and, where the interface is
 * known, ADDRESS:PORT%INTERFACE. A session that names no interface has the
 * first, whatever becomes of the routes, and the second of the interface that
 * they name now. One that names an interface has the second, and the first too
 * where the routes name the same. So the two ways to one sensor exclude each
 * other, and two sensors of one address on two interfaces do not. */
typedef struct lum_owner lum_owner;

/* Take a sensor. interface: where it is reached; NULL: as the routes say.
 * out gets what is to be given back with lum_owner_release(). LUM_NET_OK;
 * LUM_NET_BUSY: another session has it, error names its program and process;
 * LUM_NET_FAILED. */
LUM_MUST_CHECK lum_net_result lum_owner_take(lum_endpoint sensor,
                                             const char *interface,
                                             lum_owner **out, lum_error *error);

/* Give it back. NULL is allowed. */
void lum_owner_release(lum_owner *owner);

#endif
