#define _GNU_SOURCE
#include "net.h"

#include "net_internal.h"
#include "time.h"
#include "trace.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WATCHERS 8

/* Datagrams are kept for others of their size. */
static const size_t sizes[] = {256, 2048, 65536};
#define SIZES (sizeof sizes / sizeof sizes[0])

typedef struct watcher {
    void (*tell)(void *context, const world_datagram *datagram);
    void *context;
} watcher;

static struct {
    world_datagram *made; /* all */
    world_datagram *idle[SIZES];
    uint64_t numbers;
    uint64_t sent, under_way;
    uint64_t ended[WORLD_FATES];
    watcher watchers[WATCHERS];
    unsigned watcher_count;
    world_socket_log *logs, *last_log;
} net;

const char *world_fate_name(world_fate fate)
{
    static const char *const names[WORLD_FATES] = {
        [WORLD_UNDER_WAY] = "under way",
        [WORLD_RECEIVED] = "received",
        [WORLD_LOST_LINK] = "lost on the link",
        [WORLD_LOST_CUT] = "lost at a cut",
        [WORLD_LOST_QUEUE] = "lost before the link",
        [WORLD_LOST_NO_ANSWER] = "lost without an answer to ARP",
        [WORLD_LOST_FOREIGN] = "lost at a host of another address",
        [WORLD_LOST_NO_SOCKET] = "lost at a closed port",
        [WORLD_LOST_CHECKSUM] = "lost by its checksum",
        [WORLD_LOST_BUFFER] = "lost at a full buffer",
        [WORLD_LOST_UNREAD] = "lost unread",
    };
    return (unsigned)fate < WORLD_FATES ? names[fate] : "?";
}

/* --- memory --- */

static unsigned class_of(size_t len)
{
    unsigned i = 0;
    while (i + 1u < SIZES && sizes[i] < len) {
        i++;
    }
    return i;
}

static world_datagram *make(unsigned size_class)
{
    world_datagram *datagram = malloc(sizeof *datagram + sizes[size_class]);
    if (datagram == NULL) {
        abort();
    }
    datagram->private.size_class = size_class;
    datagram->private.next_made = net.made;
    net.made = datagram;
    return datagram;
}

world_datagram *world_datagram_new(size_t len)
{
    const unsigned size_class = class_of(len);
    world_datagram *datagram = net.idle[size_class];
    if (datagram != NULL) {
        net.idle[size_class] = datagram->private.next;
    } else {
        datagram = make(size_class);
    }
    world_datagram *const next_made = datagram->private.next_made;
    memset(datagram, 0, sizeof *datagram);
    datagram->private.size_class = size_class;
    datagram->private.next_made = next_made;
    datagram->private.truesize = world_truesize(len);
    datagram->bytes = (uint8_t *)(datagram + 1);
    datagram->len = len;
    return datagram;
}

void world_datagram_free(world_datagram *datagram)
{
    datagram->private.next = net.idle[datagram->private.size_class];
    net.idle[datagram->private.size_class] = datagram;
}

/* As Linux 6 allocates: headers, the bytes and struct skb_shared_info, in a
 * slab of their size, and struct sk_buff. Beyond four pages the bytes have
 * pages of their own. */
uint32_t world_truesize(size_t len)
{
    const size_t need = (59u + len + 63u) / 64u * 64u + 320u;
    uint32_t slab = 1024;
    if (need <= 576u) {
        return 832;
    }
    if (need > 16384u) {
        return (uint32_t)len + 832u;
    }
    while (slab < need) {
        slab *= 2u;
    }
    return slab + 256u;
}

/* --- lives --- */

static void tell(const world_datagram *datagram)
{
    for (unsigned i = 0; i < net.watcher_count; i++) {
        net.watchers[i].tell(net.watchers[i].context, datagram);
    }
}

void world_net_watch(void (*told)(void *context,
                                  const world_datagram *datagram),
                     void *context)
{
    if (net.watcher_count == WATCHERS) {
        world_fail("more than %d watch the network", WATCHERS);
        return;
    }
    net.watchers[net.watcher_count++] = (watcher){told, context};
}

bool (*world_net_describe)(const world_datagram *datagram, char *out,
                           size_t room);

/* 10.42.0.1:20000 */
static void trace(const world_datagram *d, const char *what)
{
    char is[96];
    (void)snprintf(is, sizeof is, "%zu bytes", d->len);
    if (world_net_describe != NULL && !world_net_describe(d, is, sizeof is)) {
        return;
    }
    WORLD_TRACE("datagram %llu (%s) %u.%u.%u.%u:%u to %u.%u.%u.%u:%u: %s",
                (unsigned long long)d->number, is, d->from >> 24,
                d->from >> 16 & 255u, d->from >> 8 & 255u, d->from & 255u,
                d->from_port, d->to >> 24, d->to >> 16 & 255u,
                d->to >> 8 & 255u, d->to & 255u, d->to_port, what);
}

void world_datagram_send(world_datagram *datagram)
{
    datagram->number = ++net.numbers;
    if (datagram->first == 0) {
        datagram->first = datagram->number;
    }
    datagram->fate = WORLD_UNDER_WAY;
    datagram->sent_ns = world_now();
    world_digest_bytes(datagram->bytes, datagram->len);
    net.sent++;
    net.under_way++;
    datagram->sender->sent_total++;
    datagram->sender->sent[WORLD_UNDER_WAY]++;
    if (world_traces) {
        trace(datagram,
              datagram->first == datagram->number ? "sent" : "copied");
    }
    tell(datagram);
}

world_datagram *world_datagram_copy(const world_datagram *of)
{
    world_datagram *copy = world_datagram_new(of->len);
    memcpy(copy->bytes, of->bytes, of->len);
    copy->first = of->first;
    copy->is_altered = of->is_altered;
    copy->is_bad = of->is_bad;
    copy->from = of->from;
    copy->to = of->to;
    copy->from_port = of->from_port;
    copy->to_port = of->to_port;
    copy->sender = of->sender;
    copy->out_at = of->out_at;
    copy->in_at = of->in_at;
    copy->private.is_broadcast = of->private.is_broadcast;
    world_datagram_send(copy);
    return copy;
}

void world_datagram_end(world_datagram *datagram, world_fate fate)
{
    if (datagram->fate != WORLD_UNDER_WAY || fate == WORLD_UNDER_WAY) {
        world_fail("datagram %llu has come to two ends",
                   (unsigned long long)datagram->number);
        return;
    }
    world_datagram_leave(datagram);
    datagram->fate = fate;
    datagram->ended_ns = world_now();
    net.ended[fate]++;
    net.under_way--;
    datagram->sender->sent[WORLD_UNDER_WAY]--;
    datagram->sender->sent[fate]++;
    if (datagram->receiver != NULL) {
        datagram->receiver->got[fate]++;
    }
    world_digest_add(datagram->number << 8 | fate);
    if (world_traces) {
        trace(datagram, world_fate_name(fate));
    }
    tell(datagram);
    world_datagram_free(datagram);
}

void world_datagram_queue(world_datagram *datagram)
{
    datagram->private.is_queued = true;
    datagram->sender->queued += datagram->private.truesize;
}

void world_datagram_leave(world_datagram *datagram)
{
    if (datagram->private.is_queued) {
        datagram->private.is_queued = false;
        datagram->sender->queued -= datagram->private.truesize;
        if (datagram->sender->socket != NULL) {
            world_udp_drained(datagram->sender->socket);
        }
    }
}

/* --- counts --- */

uint64_t world_net_count(world_fate fate)
{
    return fate == WORLD_UNDER_WAY ? net.under_way : net.ended[fate];
}

uint64_t world_net_sent(void)
{
    return net.sent;
}

const world_socket_log *world_net_sockets(void)
{
    return net.logs;
}

world_socket_log *world_socket_log_new(const world_host *host)
{
    const world_process *process = world_process_self();
    world_socket_log *log = calloc(1, sizeof *log);
    if (log == NULL) {
        abort();
    }
    log->host = host;
    log->pid = process != NULL ? process->pid : 0;
    if (net.last_log != NULL) {
        net.last_log->next = log;
    } else {
        net.logs = log;
    }
    net.last_log = log;
    return log;
}

static void check_log(const world_socket_log *log, uint64_t all[WORLD_FATES])
{
    uint64_t sum = 0;
    for (unsigned i = 0; i < WORLD_FATES; i++) {
        sum += log->sent[i];
        all[i] += log->sent[i];
    }
    if (sum != log->sent_total) {
        world_fail("socket %llu of %s sent %llu datagrams, of which %llu are "
                   "accounted for",
                   (unsigned long long)log->number, log->host->name,
                   (unsigned long long)log->sent_total,
                   (unsigned long long)sum);
    }
}

void world_net_check(void)
{
    uint64_t all[WORLD_FATES] = {0};
    for (const world_socket_log *log = net.logs; log != NULL; log = log->next) {
        check_log(log, all);
    }
    for (unsigned i = 0; i < WORLD_FATES; i++) {
        if (all[i] != world_net_count((world_fate)i)) {
            world_fail("%llu datagrams %s, of which sockets know %llu",
                       (unsigned long long)world_net_count((world_fate)i),
                       world_fate_name((world_fate)i),
                       (unsigned long long)all[i]);
        }
    }
}

void world_datagrams_reset(void)
{
    while (net.made != NULL) {
        world_datagram *next = net.made->private.next_made;
        free(net.made);
        net.made = next;
    }
    while (net.logs != NULL) {
        world_socket_log *next = net.logs->next;
        free(net.logs);
        net.logs = next;
    }
    memset(&net, 0, sizeof net);
}
