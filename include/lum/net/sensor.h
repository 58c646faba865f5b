/** @file
 * A session with one sensor: requests and their answers, heartbeats, data
 * (docs/protocol.md, sections 1 to 6).
 *
 * There is no thread and no callback. Everything happens inside
 * lum_sensor_receive(), which the application calls again and again: it sends
 * the heartbeats that are due, sends unanswered requests again, receives, and
 * returns one event. When the application stops calling it, heartbeats stop,
 * and 3 s later the sensor switches its laser off. This is intended: only a
 * program that still listens can keep a laser on.
 *
 * A session that *owns* the sensor sends heartbeats and gets its data, because
 * the sensor sends data to the host that sent the last heartbeat. One program
 * of a host can own a sensor at a time; the others can still send requests.
 *
 * Only one thread at a time may use a session. One process can have any number
 * of sessions, and one thread can serve several by lum_sensor_wait_any(). */
#ifndef LUM_NET_SENSOR_H
#define LUM_NET_SENSOR_H

#include "lum/net/socket.h"
#include "lum/profile.h"
#include "lum/wire.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Time between heartbeats, and its limits. */
#define LUM_SENSOR_HEARTBEAT_MS     LUM_HEARTBEAT_MS
#define LUM_SENSOR_HEARTBEAT_MIN_MS 10u                  /**< closest */
#define LUM_SENSOR_HEARTBEAT_MAX_MS LUM_HEARTBEAT_MAX_MS /**< furthest */

#define LUM_SENSOR_TIMEOUT_MS 400u /**< wait for an answer before a resend */
#define LUM_SENSOR_RETRIES    4u   /**< resends before giving up */

/** After this time without data, a person should be informed. */
#define LUM_SENSOR_SILENCE_MS 3000u

/** If the application makes no call for this long while a request is under way,
 * and so sends no heartbeats either, the request is not sent again, and ends
 * with NO_ANSWER unless its answer has come. */
#define LUM_SENSOR_STALE_MS      2000u
#define LUM_SENSOR_REQUEST_BYTES 1472u /**< longest request */

/** Options of a session. */
typedef struct lum_sensor_options {
    size_t struct_size;         /**< sizeof(lum_sensor_options), which
                                     lum_sensor_options_default() sets */
    lum_endpoint sensor;        /**< who it is */
    const char *interface_name; /**< the interface to reach it; NULL: by the
                                     routes */
    lum_layout layout;          /**< for numbers of TLVs and order of
                                     addresses */
    bool owns;                  /**< send heartbeats, get data */
    uint32_t heartbeat_ms;      /**< time between heartbeats, 10..1000 */
    uint32_t timeout_ms;        /**< of one attempt of a request, at least 1 */
    uint32_t retries;           /**< further attempts */
    size_t receive_buffer;      /**< as lum_socket_options */
    bool has_sequence;          /**< false: requests begin at a random number */
    uint32_t sequence;          /**< of the first request */
    lum_cancel *cancel;         /**< ends waits, and while it is raised no
                                     heartbeat is sent; may be NULL; kept */
    bool takes_joined;          /**< as lum_socket_options */
} lum_sensor_options;

/** What lum_sensor_receive() found. */
typedef enum lum_sensor_event_kind {
    LUM_SENSOR_IDLE,      /**< the deadline passed */
    LUM_SENSOR_CANCELLED, /**< the cancel was raised */
    LUM_SENSOR_DATAGRAMS, /**< owner: datagrams of any kind from the sensor,
                               answers too, to be recorded or decoded */
    LUM_SENSOR_ANSWER,    /**< the TLV answer to the request under way */
    LUM_SENSOR_TIME,      /**< the answer to a time request */
    LUM_SENSOR_NO_ANSWER, /**< the request was given up after its last try */
    LUM_SENSOR_ALERT,     /**< a TLV packet that was not requested */
    LUM_SENSOR_LINK,      /**< sending began to fail, or works again */
    LUM_SENSOR_FAILED     /**< the socket broke; see the error */
} lum_sensor_event_kind;

/** An event. Pointers in it live until the session's next receive. It never
 * grows: new data gets functions of the session. */
typedef struct lum_sensor_event {
    lum_sensor_event_kind kind;    /**< what follows depends on it */
    const lum_received *datagrams; /**< DATAGRAMS: in order of arrival */
    size_t datagram_count;         /**< DATAGRAMS: at least 1 */
    lum_tlv_reader tlvs;           /**< ANSWER, ALERT: for lum_tlv_next() */
    bool has_status;         /**< ANSWER, ALERT: a status was among them */
    uint16_t status;         /**< the last one, see lum/laser.h */
    uint32_t sequence;       /**< ANSWER, ALERT, TIME, NO_ANSWER */
    uint32_t clock_us;       /**< TIME: sensor clock, 32 bits */
    unsigned tries;          /**< ANSWER, TIME, NO_ANSWER: times it was sent */
    int64_t sent_ns;         /**< ANSWER, TIME: monotonic, the earliest try that
                                  the answer can belong to */
    int64_t received_ns;     /**< monotonic */
    int64_t received_utc_ns; /**< ns since 1970 UTC */
    bool is_up;              /**< LINK: sending works again */
    lum_error error;         /**< LINK down, FAILED */
} lum_sensor_event;

/** What was counted since the session began. */
typedef struct lum_sensor_counters {
    size_t struct_size;       /**< sizeof(lum_sensor_counters), set by the
                                   caller */
    uint64_t datagrams;       /**< from the sensor */
    uint64_t bytes;           /**< of payload in them */
    uint64_t foreign_source;  /**< from others, dropped */
    uint64_t other_port;      /**< of these: from the sensor's address, but
                                   another port */
    uint64_t cut_short;       /**< longer than LUM_SOCKET_BYTES */
    uint64_t kernel_drops;    /**< lum_socket_drops() */
    uint64_t heartbeats;      /**< sent */
    uint64_t requests;        /**< sent for the first time */
    uint64_t resends;         /**< sent again */
    uint64_t answers;         /**< that fitted the request under way */
    uint64_t answers_dropped; /**< late or repeated */
    uint64_t alerts;          /**< TLV packets that were not requested */
    uint64_t malformed;       /**< answers that contradict themselves */
    uint64_t send_failures;   /**< datagrams that did not leave */
    uint64_t joined;          /**< lum_socket_joined(): if not 0, kernel_drops
                                   is a lower bound */
} lum_sensor_counters;

/** A session. */
typedef struct lum_sensor lum_sensor;

/** Usual options: LUM_BOOT_ADDRESS and LUM_PORT, the default layout, not the
 * owner, LUM_SENSOR_HEARTBEAT_MS, _TIMEOUT_MS and _RETRIES. Cannot fail. */
static inline void lum_sensor_options_default(lum_sensor_options *out)
{
    memset(out, 0, sizeof *out);
    out->struct_size = sizeof *out;
    out->sensor.address = LUM_BOOT_ADDRESS;
    out->sensor.port = LUM_PORT;
    lum_layout_default(&out->layout);
    out->heartbeat_ms = LUM_SENSOR_HEARTBEAT_MS;
    out->timeout_ms = LUM_SENSOR_TIMEOUT_MS;
    out->retries = LUM_SENSOR_RETRIES;
    out->receive_buffer = LUM_SOCKET_RECEIVE_BUFFER;
}

/** Begin a session. Nothing is sent yet.
 * @param options copied, interface too; cancel is kept.
 * @param out     gets it on LUM_NET_OK; to be ended with lum_sensor_close().
 * @param error   gets the message otherwise.
 * @return LUM_NET_OK; LUM_NET_BUSY when another program of this host owns the
 *         sensor, error has its name and process number; LUM_NET_DENIED;
 *         LUM_NET_FAILED, also for options that are not allowed. */
LUM_MUST_CHECK lum_net_result lum_sensor_open(const lum_sensor_options *options,
                                              lum_sensor **out,
                                              lum_error *error);

/** Whether a session of this host, of this program or of another, owns a
 * sensor, even if it does not send heartbeats as it should. The answer holds
 * only for this moment: an owner can come or go at any time. A session that
 * begins during the call is not refused because of it.
 * @param sensor         who it is.
 * @param interface_name as lum_sensor_options; NULL: by the routes.
 * @param who            gets a sentence that names the owner's program and
 *                       process when the sensor is owned; may be NULL.
 * @return false also if the system cannot say. */
bool lum_sensor_is_owned(lum_endpoint sensor, const char *interface_name,
                         lum_error *who);

/** End a session. The laser is not touched: lum_laser_session_end() of
 * lum/live/laser_session.h first. NULL is allowed. */
void lum_sensor_close(lum_sensor *sensor);

/** Do all that is due and wait for one event.
 * @param deadline_ns monotonic (lum/base/time.h); a time that has passed takes
 *                    what is there without a wait.
 * @param out         overwritten.
 * Constant memory. After LUM_SENSOR_FAILED only lum_sensor_close() is
 * allowed. */
void lum_sensor_receive(lum_sensor *sensor, int64_t deadline_ns,
                        lum_sensor_event *out);

/** Wait until lum_sensor_receive() of one of several sessions has something to
 * do: a datagram, a heartbeat, a resend. Then call it for all of them, with a
 * deadline of 0.
 * @param count    at most LUM_SOCKET_WAIT_MAX.
 * @param extra_fd as lum_socket_wait(); -1 for none.
 * @param cancel   may be NULL.
 * @return as lum_socket_wait(); LUM_NET_OK when one has something to do. */
LUM_MUST_CHECK lum_net_result lum_sensor_wait_any(lum_sensor *const *sensors,
                                                  size_t count, int extra_fd,
                                                  const lum_cancel *cancel,
                                                  int64_t deadline_ns);

/** Begin a TLV request. Its TLVs are sent with the session's next sequence
 * number, and again after every timeout, until lum_sensor_receive() returns
 * ANSWER or NO_ANSWER. Every command of the protocol sets an absolute state, so
 * a repeat is harmless.
 * @param tlvs len bytes of encoded TLVs, copied; 0: a status poll.
 * @return LUM_OK; LUM_E_SPACE if it would exceed LUM_SENSOR_REQUEST_BYTES;
 *         LUM_E_VALUE while another request is under way. */
LUM_MUST_CHECK lum_result lum_sensor_request(lum_sensor *sensor,
                                             const void *tlvs, size_t len);

/** Begin a request with one command TLV that holds a text, such as "50p u". As
 * lum_sensor_request(). */
LUM_MUST_CHECK lum_result lum_sensor_command(lum_sensor *sensor,
                                             const char *text);

/** Begin a time request; ends with TIME or NO_ANSWER. A resend has a sequence
 * number of its own, so that the answer tells which try it belongs to. As
 * lum_sensor_request(). */
LUM_MUST_CHECK lum_result lum_sensor_request_time(lum_sensor *sensor);

/** Whether a request is under way. */
bool lum_sensor_is_waiting(const lum_sensor *sensor);

/** Forget the request under way; its answer will count as late. */
void lum_sensor_give_up(lum_sensor *sensor);

/** Send a set IP packet (section 2); there is no answer. The caller must make
 * sure that this host can reach the new address: `lumctl set-ip` refuses this
 * host's own addresses, broadcast ones, and those without a route.
 * @return LUM_NET_OK: it left; LUM_NET_FAILED, also for an address that cannot
 *         be a sensor's. */
LUM_MUST_CHECK lum_net_result lum_sensor_set_ip(lum_sensor *sensor,
                                                uint32_t address,
                                                lum_error *error);

/** Counters up to now.
 * @param out the caller sets struct_size; the members within that size are
 *            overwritten.
 * @return LUM_OK; LUM_E_VALUE if struct_size is not set: then nothing is
 *         written. */
lum_result lum_sensor_count(lum_sensor *sensor, lum_sensor_counters *out);

/** Datagrams with the magic that must come from one other address, with none
 * from the sensor in between, for lum_sensor_moved_to(). */
#define LUM_SENSOR_MOVED_COUNT 8u

/** Whether the sensor seems to have another address now: a sensor whose address
 * was changed continues to send to the same host until 3 s after the last
 * heartbeat. The session stays with the old address and sends its heartbeats
 * there.
 * @param out where datagrams come from instead; written when true.
 * @return true until something comes from the session's own address again. */
bool lum_sensor_moved_to(const lum_sensor *sensor, lum_endpoint *out);

/** The session's socket, for its buffer and its local endpoint. */
lum_socket *lum_sensor_socket(lum_sensor *sensor);

/** Address and port of the sensor. */
lum_endpoint lum_sensor_endpoint(const lum_sensor *sensor);

#ifdef __cplusplus
}
#endif

#endif
