/* The parts of a session, and the work of lum_sensor_receive(). */
#ifndef LUM_NET_SESSION_H
#define LUM_NET_SESSION_H

#include "lum/net/sensor.h"
#include "net/exchange.h"
#include "net/owner.h"

#define NS_PER_MS INT64_C(1000000)

/* What the socket's last receive gave, filtered. */
struct session_batch {
    lum_received *list;
    size_t count;
    size_t next; /* first that the exchange has not seen */
    int64_t received_ns;
    int64_t heard_ns;     /* the socket was empty then */
    bool socket_is_empty; /* as far as it showed */
};

/* Who sends the magic from elsewhere. */
struct session_stranger {
    lum_endpoint from;
    uint32_t count; /* since something came from the sensor */
};

/* Whether what is sent leaves this host. */
struct session_link {
    bool is_up;
    bool told; /* what the last LINK event said */
    lum_error error;
};

struct lum_sensor {
    lum_endpoint endpoint;
    lum_layout layout;
    bool owns;
    uint32_t retries;
    lum_cancel *cancel;
    lum_owner *owner;
    lum_socket *socket;
    lum_exchange exchange;
    lum_sensor_counters counters;
    struct session_batch batch;
    struct session_stranger stranger;
    struct session_link link;
    bool has_failed;
    lum_error failure;
};

/* Sends to the sensor. Counts in *counter or as a failure, and keeps the
 * content of a LINK event. error may be NULL. */
lum_net_result lum_session_send(lum_sensor *s, const void *bytes, size_t len,
                                uint64_t *counter, lum_error *error);

/* lum_sensor_receive() with any cancel, or none. */
void lum_session_receive(lum_sensor *s, const lum_cancel *cancel,
                         int64_t deadline_ns, lum_sensor_event *out);

#endif
