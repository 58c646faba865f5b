#include "sender.h"

#include <stdlib.h>
#include <string.h>

#define STREAM      102 /* of random numbers */
#define SLOTS       16384u
#define RETRY_NS    INT64_C(200000)
#define PATIENCE_NS INT64_C(20000000)

struct sender_slot {
    int64_t due_ns;
    uint64_t order; /* among those of one time */
    size_t len;
    uint8_t bytes[LUM_PACKET_BYTES_MAX];
};

bool sender_is_direct(const struct delivery_options *options)
{
    bool is_direct = options->jitter_ms <= 0.0;
    for (unsigned k = 0; k < LUM_FAULT_KINDS; k++) {
        is_direct &= options->faults[k] <= 0.0;
    }
    return is_direct;
}

int sender_open(struct sender *out, const struct delivery_options *options,
                uint64_t seed)
{
    *out = (struct sender){.is_direct = sender_is_direct(options),
                           .jitter_ns = (int64_t)(options->jitter_ms * 1e6)};
    lum_fault_init(&out->fault, options->faults, seed);
    lum_random_init(&out->random, seed, STREAM);
    if (out->is_direct) {
        return 0;
    }
    out->slots = malloc(SLOTS * sizeof *out->slots);
    out->heap = malloc(SLOTS * sizeof *out->heap);
    if (out->slots == NULL || out->heap == NULL) {
        sender_close(out);
        return -1;
    }
    for (uint32_t i = 0; i < SLOTS; i++) {
        out->heap[i] = i;
    }
    return 0;
}

void sender_close(struct sender *sender)
{
    free(sender->slots);
    free(sender->heap);
    sender->slots = NULL;
    sender->heap = NULL;
}

static bool is_before(const struct sender *o, uint32_t a, uint32_t b)
{
    const struct sender_slot *x = &o->slots[a];
    const struct sender_slot *y = &o->slots[b];
    return x->due_ns < y->due_ns ||
           (x->due_ns == y->due_ns && x->order < y->order);
}

static void swap(uint32_t *a, uint32_t *b)
{
    const uint32_t kept = *a;
    *a = *b;
    *b = kept;
}

static void sift_up(struct sender *o, size_t i)
{
    while (i > 0 && is_before(o, o->heap[i], o->heap[(i - 1) / 2])) {
        swap(&o->heap[i], &o->heap[(i - 1) / 2]);
        i = (i - 1) / 2;
    }
}

static void sift_down(struct sender *o)
{
    size_t i = 0;
    for (;;) {
        size_t least = 2 * i + 1;
        if (least >= o->waiting) {
            return;
        }
        if (least + 1 < o->waiting &&
            is_before(o, o->heap[least + 1], o->heap[least])) {
            least++;
        }
        if (!is_before(o, o->heap[least], o->heap[i])) {
            return;
        }
        swap(&o->heap[i], &o->heap[least]);
        i = least;
    }
}

static int64_t due_ns(struct sender *o, int64_t now_ns)
{
    return o->jitter_ns > 0
               ? now_ns + (int64_t)((double)lum_random_unit(&o->random) *
                                    (double)o->jitter_ns)
               : now_ns;
}

/* The slots that pending points into come directly after those that wait. */
static void hold(struct sender *o, const lum_sim_packet *packet, int64_t now_ns)
{
    if (o->waiting + o->leaving == SLOTS) {
        o->no_room++;
        return;
    }
    swap(&o->heap[o->waiting], &o->heap[o->waiting + o->leaving]);
    struct sender_slot *slot = &o->slots[o->heap[o->waiting]];
    slot->due_ns = due_ns(o, now_ns);
    slot->order = o->order++;
    slot->len = packet->len;
    memcpy(slot->bytes, packet->bytes, packet->len);
    sift_up(o, o->waiting++);
}

static void bend(struct sender *o, const lum_outgoing *datagram, int64_t now_ns)
{
    lum_sim_packet packet;
    const lum_sim_packet *leaving;
    if (datagram->len > sizeof packet.bytes) {
        o->no_room++;
        return;
    }
    packet.time_ns = now_ns;
    packet.len = datagram->len;
    memcpy(packet.bytes, datagram->bytes, datagram->len);
    lum_fault_push(&o->fault, &packet);
    while ((leaving = lum_fault_pull(&o->fault)) != NULL) {
        hold(o, leaving, now_ns);
    }
}

void sender_put(struct sender *sender, const lum_outgoing *datagrams, size_t n,
                int64_t now_ns)
{
    if (sender->is_direct) {
        memcpy(sender->pending, datagrams, n * sizeof datagrams[0]);
        sender->pending_next = 0;
        sender->pending_count = n;
        return;
    }
    for (size_t i = 0; i < n; i++) {
        bend(sender, &datagrams[i], now_ns);
    }
}

/* The first that waits is due: on to pending. */
static void load_one(struct sender *o)
{
    struct sender_slot *slot = &o->slots[o->heap[0]];
    o->pending[o->pending_count++] =
        (lum_outgoing){.bytes = slot->bytes, .len = slot->len};
    o->waiting--;
    o->leaving++;
    swap(&o->heap[0], &o->heap[o->waiting]);
    sift_down(o);
}

static void load(struct sender *o, int64_t now_ns)
{
    if (o->is_direct || sender_is_stuck(o)) {
        return;
    }
    o->pending_next = 0;
    o->pending_count = 0;
    o->leaving = 0;
    while (o->waiting > 0 && o->pending_count < LUM_SOCKET_BATCH &&
           o->slots[o->heap[0]].due_ns <= now_ns) {
        load_one(o);
    }
}

static void count_sent(struct sender *o, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        o->bytes += o->pending[o->pending_next + i].len;
    }
    o->sent += n;
    o->pending_next += n;
}

/* A packet that cannot be sent for this long is given up: its line is over. */
static bool wait_or_give_up(struct sender *o, int64_t now_ns)
{
    o->retries++;
    if (o->stuck_ns == 0) {
        o->stuck_ns = now_ns;
    }
    if (now_ns - o->stuck_ns < PATIENCE_NS) {
        return true;
    }
    o->given_up += o->pending_count - o->pending_next;
    o->pending_next = o->pending_count;
    return false;
}

static bool send_pending(struct sender *o, lum_socket *socket, lum_endpoint to,
                         int64_t now_ns)
{
    size_t sent = 0;
    for (size_t i = o->pending_next; i < o->pending_count; i++) {
        o->pending[i].to = to;
    }
    const lum_net_result result = lum_socket_send_batch(
        socket, o->pending + o->pending_next,
        o->pending_count - o->pending_next, &sent, &o->error);
    if (sent > 0) {
        o->stuck_ns = 0;
    }
    count_sent(o, sent);
    return result == LUM_NET_OK || o->pending_next == o->pending_count ||
           wait_or_give_up(o, now_ns);
}

bool sender_send(struct sender *sender, lum_socket *socket, lum_endpoint to,
                 int64_t now_ns)
{
    bool flows = true;
    for (;;) {
        load(sender, now_ns);
        const size_t left = sender->pending_count - sender->pending_next;
        if (left == 0) {
            return flows;
        }
        flows = send_pending(sender, socket, to, now_ns) && flows;
        if (sender_is_stuck(sender)) {
            return flows;
        }
    }
}

int64_t sender_next_ns(const struct sender *sender, int64_t now_ns)
{
    if (sender_is_stuck(sender)) {
        return now_ns + RETRY_NS;
    }
    return sender->waiting > 0 ? sender->slots[sender->heap[0]].due_ns
                               : INT64_MAX;
}

void sender_drop(struct sender *sender)
{
    sender->pending_next = sender->pending_count;
    sender->leaving = 0;
    sender->waiting = 0;
}

void sender_drop_borrowed(struct sender *sender)
{
    if (sender->is_direct) {
        sender_drop(sender);
    }
}

bool sender_is_stuck(const struct sender *sender)
{
    return sender->pending_next < sender->pending_count;
}
