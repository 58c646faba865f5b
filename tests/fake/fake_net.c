#include "fake_net.h"

#include "exact.h"
#include "lum/base/time.h"
#include "lum/net/cancel.h"
#include "lum/wire.h"
#include "net/owner.h"

#include <stdlib.h>
#include <string.h>

struct fake_net fake;

struct lum_socket {
    lum_received batch[LUM_SOCKET_BATCH];
    uint8_t *bytes[LUM_SOCKET_BATCH]; /* each as long as its datagram */
    size_t kept;                      /* of them */
};

struct arrival {
    int64_t ns;
    lum_endpoint from;
    size_t len;
    uint8_t bytes[FAKE_BYTES];
};

static const uint8_t flood[20];
static struct lum_socket the_socket;
static struct arrival arrivals[FAKE_ARRIVAL];
static size_t order[FAKE_ARRIVAL]; /* those that wait, then those free */
static size_t arrival_count;

void fake_reset(void)
{
    memset(&fake, 0, offsetof(struct fake_net, sent));
    fake.now_ns = INT64_C(1000000000);
    arrival_count = 0;
    for (size_t i = 0; i < FAKE_ARRIVAL; i++) {
        order[i] = i;
    }
}

static const struct arrival *first_arrival(void)
{
    return &arrivals[order[0]];
}

/* Sorted by time; what has the same time stays in order. */
void fake_arrive(int64_t ns, lum_endpoint from, const void *bytes, size_t len)
{
    size_t at = arrival_count;
    if (arrival_count == FAKE_ARRIVAL || len > FAKE_BYTES) {
        return;
    }
    while (at > 0 && arrivals[order[at - 1]].ns > ns) {
        at--;
    }
    const size_t slot = order[arrival_count];
    memmove(order + at + 1, order + at, (arrival_count - at) * sizeof *order);
    order[at] = slot;
    arrivals[slot].ns = ns;
    arrivals[slot].from = from;
    arrivals[slot].len = len;
    if (len > 0) {
        memcpy(arrivals[slot].bytes, bytes, len);
    }
    arrival_count++;
}

size_t fake_count_sent(uint8_t type)
{
    size_t count = 0;
    for (size_t i = 0; i < fake.sent_count && i < FAKE_SENT; i++) {
        count += fake.sent[i].bytes[8] == type;
    }
    return count;
}

lum_net_result lum_socket_open(const lum_socket_options *options,
                               lum_socket **out, lum_error *error)
{
    (void)options;
    (void)error;
    *out = &the_socket;
    return LUM_NET_OK;
}

static void free_batch(lum_socket *socket)
{
    while (socket->kept > 0) {
        exact_free(socket->bytes[--socket->kept]);
    }
}

void lum_socket_close(lum_socket *socket)
{
    if (socket != NULL) {
        free_batch(socket);
    }
}

void lum_socket_local(const lum_socket *socket, lum_endpoint *out)
{
    (void)socket;
    *out = (lum_endpoint){0x7f000001, 40000};
}

uint64_t lum_socket_drops(lum_socket *socket)
{
    (void)socket;
    return fake.drops;
}

uint64_t lum_socket_joined(const lum_socket *socket)
{
    (void)socket;
    return 0;
}

static bool has_arrived(void)
{
    return fake.floods > 0 ||
           (arrival_count > 0 && first_arrival()->ns <= fake.now_ns);
}

lum_net_result lum_socket_wait(lum_socket *const *sockets, size_t count,
                               int extra_fd, const lum_cancel *cancel,
                               int64_t deadline_ns)
{
    (void)sockets;
    (void)count;
    (void)extra_fd;
    if (fake.wait_breaks) {
        return LUM_NET_FAILED;
    }
    if (lum_cancel_is_raised(cancel)) {
        return LUM_NET_CANCELLED;
    }
    if (!has_arrived() && arrival_count > 0 &&
        first_arrival()->ns <= deadline_ns) {
        fake.now_ns = first_arrival()->ns;
    }
    if (has_arrived()) {
        return LUM_NET_OK;
    }
    if (deadline_ns > fake.now_ns) {
        fake.now_ns = deadline_ns;
    }
    return LUM_NET_TIMEOUT;
}

static void take_first(lum_socket *socket)
{
    const size_t slot = order[0];
    const struct arrival *a = &arrivals[slot];
    uint8_t *copy = exact_copy(a->bytes, a->len);
    socket->batch[socket->kept] =
        (lum_received){copy, a->len, a->from, a->ns, false};
    socket->bytes[socket->kept++] = copy;
    arrival_count--;
    memmove(order, order + 1, arrival_count * sizeof *order);
    order[arrival_count] = slot;
}

/* With what the flooder sends. */
static size_t fill(lum_socket *socket, size_t n)
{
    const lum_received one = {flood, sizeof flood, fake.flooder, fake.now_ns,
                              false};
    while (n < LUM_SOCKET_BATCH) {
        socket->batch[n++] = one;
    }
    return n;
}

lum_net_result lum_socket_receive(lum_socket *socket, lum_received **out,
                                  size_t *count, lum_error *error)
{
    if (fake.receive_breaks) {
        (void)lum_error_set(error, "broken by the test");
        return LUM_NET_FAILED;
    }
    free_batch(socket);
    fake.now_ns += fake.receive_ns;
    while (socket->kept < LUM_SOCKET_BATCH && arrival_count > 0 &&
           first_arrival()->ns <= fake.now_ns) {
        take_first(socket);
    }
    size_t n = socket->kept;
    if (fake.floods > 0) {
        fake.floods--;
        n = fill(socket, n);
    }
    *out = socket->batch;
    *count = n;
    return LUM_NET_OK;
}

lum_net_result lum_socket_send(lum_socket *socket, const lum_outgoing *datagram,
                               lum_error *error)
{
    static struct fake_sent spare;
    (void)socket;
    if (fake.send != LUM_NET_OK) {
        (void)lum_error_set(error, "the network is down");
        return fake.send;
    }
    struct fake_sent *sent =
        fake.sent_count < FAKE_SENT ? &fake.sent[fake.sent_count] : &spare;
    sent->ns = fake.now_ns;
    sent->to = datagram->to;
    sent->len = datagram->len;
    memcpy(sent->bytes, datagram->bytes, datagram->len);
    fake.sent_count++;
    if (fake.on_send != NULL) {
        fake.on_send(sent);
    }
    return LUM_NET_OK;
}

bool lum_cancel_is_raised(const lum_cancel *cancel)
{
    return cancel != NULL && fake.is_raised;
}

lum_net_result lum_owner_take(lum_endpoint sensor, const char *interface,
                              lum_owner **out, lum_error *error)
{
    (void)sensor;
    (void)interface;
    (void)error;
    *out = NULL;
    return LUM_NET_OK;
}

bool lum_owner_look(lum_endpoint sensor, const char *interface, lum_error *who)
{
    (void)sensor;
    (void)interface;
    (void)who;
    return false;
}

void lum_owner_release(lum_owner *owner)
{
    (void)owner;
}

int64_t lum_time_monotonic_ns(void)
{
    return fake.now_ns;
}

int64_t lum_time_utc_ns(void)
{
    return fake.now_ns;
}

void lum_time_sleep_until(int64_t monotonic_ns)
{
    fake.now_ns = monotonic_ns;
}
