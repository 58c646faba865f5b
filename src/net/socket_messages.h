/* The meaning of a socket's errors, and what to do. Codes are those of errno.h,
 * to which Winsock's are translated. */
#ifndef LUM_NET_SOCKET_MESSAGES_H
#define LUM_NET_SOCKET_MESSAGES_H

#include "lum/net/socket.h"

/* A local endpoint could not be bound. */
lum_net_result lum_socket_say_unbound(lum_endpoint local, int code,
                                      lum_error *error);

/* A datagram did not leave. */
lum_net_result lum_socket_say_unsent(const lum_outgoing *datagram, int code,
                                     lum_error *error);

/* More datagrams than LUM_SOCKET_BATCH. */
lum_net_result lum_socket_say_too_many(size_t count, lum_error *error);

/* A socket broke. */
lum_net_result lum_socket_say_broken(lum_endpoint local, int code,
                                     lum_error *error);

/* An interface is not there. */
lum_net_result lum_socket_say_no_interface(const char *name, const char *list,
                                           lum_error *error);

#endif
