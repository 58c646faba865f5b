/** @file
 * UDP over IPv4 for the sensor's packets: many datagrams a call, their arrival
 * times, and a count of what the kernel dropped (docs/protocol.md, section 1).
 *
 * POSIX or Winsock. If a system lacks recvmmsg(), sendmmsg(), kernel time
 * stamps or drop counts, the same calls work without them: one datagram at a
 * time, the time of the call, a drop count of 0 (see
 * lum_socket_counts_drops()). Only Linux joins datagrams.
 *
 * Only one thread at a time may use a socket. Addresses and ports are in host
 * order. */
#ifndef LUM_NET_SOCKET_H
#define LUM_NET_SOCKET_H

#include "lum/base/error.h"
#include "lum/net/cancel.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Most datagrams that one receive or one send handles. */
#define LUM_SOCKET_BATCH 64u

/** Most datagrams of one receive if the kernel may join them. */
#define LUM_SOCKET_JOINED_BATCH 8192u

/** Longest datagram that is received whole: that of a jumbo frame. */
#define LUM_SOCKET_BYTES 9216u

/** Receive buffer that holds a sensor's data for a quarter of a second. */
#define LUM_SOCKET_RECEIVE_BUFFER 33554432u

/** Most sockets of one wait. */
#define LUM_SOCKET_WAIT_MAX 32u

/** Results of calls that wait or that may be refused. */
typedef enum lum_net_result {
    LUM_NET_OK = 0,        /**< done */
    LUM_NET_TIMEOUT = 1,   /**< the deadline passed first */
    LUM_NET_CANCELLED = 2, /**< the cancel was raised */
    LUM_NET_BUSY = -1,     /**< another program has it; the error says who */
    LUM_NET_DENIED = -2,   /**< no permission */
    LUM_NET_FAILED = -3    /**< anything else; the error says what */
} lum_net_result;

/** An address and a port. It never grows. */
typedef struct lum_endpoint {
    uint32_t address; /**< IPv4, host order */
    uint16_t port;    /**< UDP */
} lum_endpoint;

/** Options of a socket. All bytes 0 except struct_size give a socket of any
 * address and port. */
typedef struct lum_socket_options {
    size_t struct_size;         /**< sizeof(lum_socket_options) */
    lum_endpoint local;         /**< 0.0.0.0: any address; port 0: any port */
    const char *interface_name; /**< send and receive only on it; NULL: by the
                                     routes */
    size_t receive_buffer; /**< bytes of payload to buffer in the kernel; 0: the
                                system's default */
    bool takes_joined;     /**< the kernel may join several datagrams of one
                                size, which takes less time at high rates; all
                                have the time of the first. Then a receive gives
                                up to LUM_SOCKET_JOINED_BATCH, and more may be
                                dropped than is counted: see
                                lum_socket_joined() */
    bool sends_joined;     /**< hand over several datagrams of one size as one
                                message, if Linux can split it: less time at
                                high rates. They leave the host singly, but a
                                packet capture on it (tcpdump) sees them as
                                one */
} lum_socket_options;

/** A UDP socket. */
typedef struct lum_socket lum_socket;

/** A datagram that was received. It never grows, because it is used in arrays.
 */
typedef struct lum_received {
    const uint8_t *bytes; /**< payload; lives until the socket's next receive */
    size_t len;           /**< its bytes here */
    lum_endpoint from;    /**< who sent it */
    int64_t utc_ns;       /**< when the kernel received it, ns since 1970 UTC */
    bool cut_short;       /**< it was longer than LUM_SOCKET_BYTES */
} lum_received;

/** A datagram to be sent. It never grows, because it is used in arrays. */
typedef struct lum_outgoing {
    const void *bytes; /**< payload; not kept */
    size_t len;        /**< its bytes */
    lum_endpoint to;   /**< who gets it */
} lum_outgoing;

/** Open a socket.
 * @param out   gets it on LUM_NET_OK; to be closed with lum_socket_close().
 * @param error gets the message otherwise.
 * @return LUM_NET_OK; LUM_NET_BUSY if the local port is taken; LUM_NET_DENIED;
 *         LUM_NET_FAILED (no such interface, address not of this host,
 *         struct_size is not set, ...). */
LUM_MUST_CHECK lum_net_result lum_socket_open(const lum_socket_options *options,
                                              lum_socket **out,
                                              lum_error *error);

/** Close. NULL is allowed. */
void lum_socket_close(lum_socket *socket);

/** Where the socket is bound. */
void lum_socket_local(const lum_socket *socket, lum_endpoint *out);

/** Bytes of receive buffer that the kernel granted, as it counts them (payload
 * and its own overhead). */
size_t lum_socket_receive_buffer(const lum_socket *socket);

/** Whether the requested receive buffer was granted. */
bool lum_socket_has_room(const lum_socket *socket);

/** Wait until one of several sockets has a datagram.
 * @param sockets count of them, at most LUM_SOCKET_WAIT_MAX.
 * @param extra_fd POSIX: a descriptor whose input ends the wait too, such as
 *                 standard input; -1 for none.
 * @param cancel  may be NULL.
 * @param deadline_ns on the monotonic clock (lum/base/time.h).
 * @return LUM_NET_OK; LUM_NET_TIMEOUT; LUM_NET_CANCELLED, also when a signal
 *         handler that raised the cancel interrupted; LUM_NET_FAILED. */
LUM_MUST_CHECK lum_net_result lum_socket_wait(lum_socket *const *sockets,
                                              size_t count, int extra_fd,
                                              const lum_cancel *cancel,
                                              int64_t deadline_ns);

/** Receive the datagrams that have come; does not wait.
 * @param out   gets an array that lives until the next receive, in order of
 *              arrival; the caller may reorder and overwrite it.
 * @param count gets how many, 0..LUM_SOCKET_BATCH, or
 *              0..LUM_SOCKET_JOINED_BATCH if takes_joined was set.
 * @return LUM_NET_OK, also with none; LUM_NET_FAILED. Errors that the network
 *         reports for datagrams sent earlier (unreachable, down) are ignored.
 */
LUM_MUST_CHECK lum_net_result lum_socket_receive(lum_socket *socket,
                                                 lum_received **out,
                                                 size_t *count,
                                                 lum_error *error);

/** Send a datagram; does not wait.
 * @return LUM_NET_OK; LUM_NET_DENIED, LUM_NET_FAILED with the reason in error
 *         (network down, no route, buffers full): it did not leave. */
LUM_MUST_CHECK lum_net_result lum_socket_send(lum_socket *socket,
                                              const lum_outgoing *datagram,
                                              lum_error *error);

/** Send several datagrams, in order; does not wait.
 * @param count at most LUM_SOCKET_BATCH.
 * @param sent  gets how many left, from the first on.
 * @return as lum_socket_send() for the first that did not leave. */
LUM_MUST_CHECK lum_net_result
lum_socket_send_batch(lum_socket *socket, const lum_outgoing *datagrams,
                      size_t count, size_t *sent, lum_error *error);

/** Datagrams that the kernel dropped since the socket was opened: because the
 * receive buffer was full, or because of a wrong checksum. Up to date at the
 * time of the call. A lower bound if lum_socket_joined() is not 0. */
uint64_t lum_socket_drops(lum_socket *socket);

/** Datagrams that came joined with others, also from other interfaces; 0 if
 * takes_joined was not set. The kernel counts joined datagrams that it drops as
 * one. */
uint64_t lum_socket_joined(const lum_socket *socket);

/** Whether the system counts such drops; if not, the count is always 0. */
bool lum_socket_counts_drops(const lum_socket *socket);

#ifdef __cplusplus
}
#endif

#endif
