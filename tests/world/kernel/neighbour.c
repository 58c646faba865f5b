#define _GNU_SOURCE
#include "arp.h"
#include "time.h"
#include "trace.h"

#include <errno.h>
#include <stdlib.h>

/* As Linux has them at first. */
#define LISTS       64u
#define ENTRIES_MAX 1024u
#define TRIES       3u
#define TRY_NS      WORLD_S
#define REACHABLE   (30 * WORLD_S)
#define STALE_NS    (8 * WORLD_S) /* still used, while it is asked again */
#define LOCKED_NS   WORLD_S       /* for a second answer */
#define QUEUE_BYTES 212992u       /* for one that is asked */

typedef enum neighbour_state {
    NEIGHBOUR_ASKED,
    NEIGHBOUR_KNOWN,
    NEIGHBOUR_FAILED
} neighbour_state;

typedef struct neighbour {
    struct neighbour *next;
    world_interface *at;
    uint32_t address;
    neighbour_state state;
    world_interface *target; /* whose hardware address it is */
    int64_t confirmed_ns;
    unsigned tries;
    world_event *event;
    world_datagram *first, *last; /* that wait for the answer */
    uint32_t bytes;
} neighbour;

struct world_neighbours {
    neighbour *lists[LISTS];
    unsigned count;
};

static struct world_neighbours *table_of(world_interface *interface)
{
    if (interface->neighbours == NULL) {
        interface->neighbours = calloc(1, sizeof *interface->neighbours);
        if (interface->neighbours == NULL) {
            abort();
        }
    }
    return interface->neighbours;
}

static neighbour *look_up(const struct world_neighbours *table,
                          uint32_t address)
{
    neighbour *n = table->lists[address % LISTS];
    while (n != NULL && n->address != address) {
        n = n->next;
    }
    return n;
}

/* --- making room --- */

static void end_queue(neighbour *n, world_fate fate)
{
    while (n->first != NULL) {
        world_datagram *datagram = n->first;
        n->first = datagram->private.next;
        world_datagram_end(datagram, fate);
    }
    n->last = NULL;
    n->bytes = 0;
}

static void stop(neighbour *n)
{
    if (n->event != NULL) {
        world_cancel_event(n->event);
        n->event = NULL;
    }
}

/* Those that failed are the first to go. */
static void collect(struct world_neighbours *table)
{
    for (unsigned i = 0; i < LISTS; i++) {
        neighbour **at = &table->lists[i];
        while (*at != NULL) {
            neighbour *n = *at;
            if (n->state == NEIGHBOUR_FAILED) {
                *at = n->next;
                free(n);
                table->count--;
            } else {
                at = &n->next;
            }
        }
    }
}

/* NULL: the table is full. */
static neighbour *enter(world_interface *at, uint32_t address)
{
    struct world_neighbours *table = table_of(at);
    neighbour *n = look_up(table, address);
    if (n != NULL) {
        return n;
    }
    if (table->count >= ENTRIES_MAX) {
        collect(table);
    }
    if (table->count >= ENTRIES_MAX) {
        world_met("fault:neighbours-full");
        return NULL;
    }
    n = calloc(1, sizeof *n);
    if (n == NULL) {
        abort();
    }
    n->at = at;
    n->address = address;
    n->state = NEIGHBOUR_FAILED;
    n->next = table->lists[address % LISTS];
    table->lists[address % LISTS] = n;
    table->count++;
    return n;
}

/* --- asking --- */

static void know(neighbour *n, world_interface *target)
{
    n->state = NEIGHBOUR_KNOWN;
    n->target = target;
    n->confirmed_ns = world_now();
    stop(n);
}

/* Whoever is asked learns who asks. */
void world_neighbour_learn(world_interface *at, uint32_t address,
                           world_interface *target)
{
    neighbour *n = address != 0 ? enter(at, address) : NULL;
    if (n != NULL && n->state != NEIGHBOUR_ASKED) {
        know(n, target);
    }
}

static bool answers(const neighbour *n, const world_interface *other)
{
    return other != n->at && world_net_owner(other->host, n->address) != NULL &&
           n->address >> 24 != 127u;
}

static void send_queue(neighbour *n)
{
    world_datagram *datagram = n->first;
    n->first = NULL;
    n->last = NULL;
    n->bytes = 0;
    while (datagram != NULL) {
        world_datagram *next = datagram->private.next;
        world_link_output(datagram, n->target);
        datagram = next;
    }
}

/* The first answer counts; of two with one address, the other one's later. */
void world_neighbour_answered(world_interface *at, uint32_t address,
                              world_interface *target)
{
    neighbour *n = look_up(table_of(at), address);
    if (n == NULL) {
        return;
    }
    if (n->state == NEIGHBOUR_KNOWN && n->target != target) {
        world_met("net:address-twice");
        if (world_now() - n->confirmed_ns < LOCKED_NS) {
            return;
        }
    }
    know(n, target);
    send_queue(n);
}

static void give_up(neighbour *n)
{
    n->state = NEIGHBOUR_FAILED;
    world_met("net:no-answer-to-arp");
    for (const world_datagram *d = n->first; d != NULL; d = d->private.next) {
        if (d->sender->socket != NULL) {
            world_udp_unreachable(d->sender->socket);
        }
    }
    end_queue(n, WORLD_LOST_NO_ANSWER);
}

static void ask(void *argument)
{
    neighbour *n = argument;
    n->event = NULL;
    if (n->tries == TRIES) {
        give_up(n);
        return;
    }
    n->tries++;
    n->event = world_at(world_now() + TRY_NS, ask, n);
    world_arp_ask(n->at, world_interface_source(n->at, n->address), n->address);
}

static void begin(neighbour *n)
{
    n->state = NEIGHBOUR_ASKED;
    n->tries = 0;
    ask(n);
}

/* --- sending --- */

static void wait_for_answer(neighbour *n, world_datagram *datagram)
{
    world_datagram_queue(datagram);
    datagram->private.next = NULL;
    if (n->last != NULL) {
        n->last->private.next = datagram;
    } else {
        n->first = datagram;
    }
    n->last = datagram;
    n->bytes += datagram->private.truesize;
    while (n->bytes > QUEUE_BYTES) {
        world_datagram *oldest = n->first;
        n->first = oldest->private.next;
        n->bytes -= oldest->private.truesize;
        world_datagram_end(oldest, WORLD_LOST_NO_ANSWER);
    }
}

/* What was known half a minute ago is asked again, and still used meanwhile. */
static void confirm(neighbour *n)
{
    const int64_t age = world_now() - n->confirmed_ns;
    int64_t ns = 0;
    if (age <= REACHABLE) {
        return;
    }
    if (answers(n, n->target) && world_link_answers(n->at, n->target, &ns)) {
        know(n, n->target);
        world_neighbour_learn(n->target,
                              world_interface_source(n->at, n->address), n->at);
    } else if (age > REACHABLE + STALE_NS) {
        begin(n);
    }
}

static int send_to(world_datagram *datagram, uint32_t address)
{
    neighbour *n = enter(datagram->out_at, address);
    if (n == NULL) {
        return ENOBUFS;
    }
    if (n->state == NEIGHBOUR_KNOWN) {
        confirm(n);
    } else if (n->state == NEIGHBOUR_FAILED) {
        begin(n);
    }
    world_datagram_send(datagram);
    if (n->state == NEIGHBOUR_KNOWN) {
        world_link_output(datagram, n->target);
    } else {
        wait_for_answer(n, datagram);
    }
    return 0;
}

int world_net_output(world_datagram *datagram, uint32_t next_hop)
{
    const bool is_broadcast = datagram->private.is_broadcast;
    if (datagram->out_at->has_carrier && !is_broadcast) {
        return send_to(datagram, next_hop);
    }
    world_datagram_send(datagram);
    if (is_broadcast) {
        world_udp_hear_own(datagram);
    }
    if (datagram->out_at->has_carrier) {
        world_link_output(datagram, NULL);
    } else {
        world_met("fault:cut");
        world_datagram_end(datagram, WORLD_LOST_CUT);
    }
    return 0;
}

/* --- the table --- */

void world_neighbours_flush(world_interface *interface)
{
    struct world_neighbours *table = interface->neighbours;
    for (unsigned i = 0; table != NULL && i < LISTS; i++) {
        for (neighbour *n = table->lists[i]; n != NULL; n = n->next) {
            stop(n);
            n->state = NEIGHBOUR_FAILED;
            end_queue(n, WORLD_LOST_CUT);
        }
    }
    if (table != NULL) {
        collect(table);
    }
}

void world_neighbours_free(world_interface *interface)
{
    struct world_neighbours *table = interface->neighbours;
    for (unsigned i = 0; table != NULL && i < LISTS; i++) {
        while (table->lists[i] != NULL) {
            neighbour *next = table->lists[i]->next;
            free(table->lists[i]);
            table->lists[i] = next;
        }
    }
    free(table);
    interface->neighbours = NULL;
}

void world_neighbours_list(const world_interface *interface,
                           void (*tell)(void *context, uint32_t address,
                                        const uint8_t *mac),
                           void *context)
{
    const struct world_neighbours *table = interface->neighbours;
    for (unsigned i = 0; table != NULL && i < LISTS; i++) {
        for (const neighbour *n = table->lists[i]; n != NULL; n = n->next) {
            tell(context, n->address,
                 n->state == NEIGHBOUR_KNOWN ? n->target->mac : NULL);
        }
    }
}
