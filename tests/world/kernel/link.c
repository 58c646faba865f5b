#define _GNU_SOURCE
#include "net.h"

#include "net_internal.h"
#include "time.h"
#include "trace.h"

#include <stdio.h>

#define DELAY_NS   (10 * WORLD_US)
#define HOLD_NS    WORLD_MS
#define QUEUE_MAX  1000u /* txqueuelen of Linux */
#define FRAME_MORE 42u   /* around UDP's bytes: Ethernet's, IP's and UDP's */

/* Each fault has its own chances: one that is switched on does not change what
 * the others do. */
enum chance {
    CHANCE_LOSE,
    CHANCE_REPEAT,
    CHANCE_REORDER,
    CHANCE_LATE,
    CHANCE_CORRUPT,
    CHANCE_JITTER,
    CHANCE_ARP
};

void world_link_begin(world_link *link, const char *owner,
                      const char *direction)
{
    char name[64];
    (void)snprintf(name, sizeof name, "link:%s:%s", owner, direction);
    for (unsigned i = 0;
         i < sizeof link->private.random / sizeof link->private.random[0];
         i++) {
        link->private.random[i] = world_stream(name, i);
    }
    link->delay_ns = DELAY_NS;
}

static bool befalls(world_link *link, enum chance which, double probability)
{
    return probability > 0 &&
           world_random_chance(&link->private.random[which], probability);
}

static bool is_open(const world_interface *interface, const world_link *link)
{
    return interface->is_up && interface->has_carrier && !link->is_cut;
}

/* --- faults --- */

/* Fragments are lost one by one, and with one of them all. */
static bool is_lost(world_link *link, const world_datagram *datagram)
{
    size_t fragments = 1u + (datagram->len + 8u) / 1480u;
    if (link->lose_next > 0) {
        link->lose_next--;
        return true;
    }
    if (link->loses != NULL && link->loses(link->context, datagram)) {
        return true;
    }
    while (fragments > 0 && !befalls(link, CHANCE_LOSE, link->lose)) {
        fragments--;
    }
    return fragments > 0;
}

static void corrupt(world_link *link, world_datagram *datagram)
{
    world_random *random = &link->private.random[CHANCE_CORRUPT];
    const int64_t flips = world_random_between(random, 1, 4);
    for (int64_t i = 0; i < flips && datagram->len > 0; i++) {
        const uint64_t bit = world_random_below(random, 8u * datagram->len);
        datagram->bytes[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
    }
    if (datagram->len > 0 && world_random_chance(random, link->pass)) {
        datagram->is_altered = true;
        world_met("fault:altered");
    } else {
        datagram->is_bad = true;
        world_met("fault:corrupt");
    }
}

static int64_t hold(world_link *link, enum chance which, double probability,
                    int64_t most)
{
    if (!befalls(link, which, probability)) {
        return 0;
    }
    return world_random_between(&link->private.random[which], 1,
                                most > 0 ? most : HOLD_NS);
}

/* When it is at the other end; only what is held back is overtaken. */
static int64_t arrival(world_link *link, world_datagram *datagram,
                       int64_t from_ns)
{
    const int64_t reordered =
        hold(link, CHANCE_REORDER, link->reorder, link->reorder_ns);
    const int64_t late = hold(link, CHANCE_LATE, link->late, link->late_ns);
    int64_t at = from_ns + link->delay_ns;
    if (link->jitter_ns > 0) {
        at += world_random_between(&link->private.random[CHANCE_JITTER], 0,
                                   link->jitter_ns);
    }
    if (reordered > 0 || late > 0) {
        world_met(reordered > 0 ? "fault:reorder" : "fault:late");
        datagram->private.is_held = true;
    }
    if (datagram->private.is_held) {
        return at + reordered + late;
    }
    if (at < link->private.last_ns) {
        at = link->private.last_ns;
    }
    link->private.last_ns = at;
    return at;
}

/* Through one direction of a cable. False: it has come to its end there. */
static bool pass(world_link *link, world_datagram *datagram, int64_t *at)
{
    if (is_lost(link, datagram)) {
        world_met("fault:lose");
        world_datagram_end(datagram, WORLD_LOST_LINK);
        return false;
    }
    if (befalls(link, CHANCE_CORRUPT, link->corrupt)) {
        corrupt(link, datagram);
    }
    *at = arrival(link, datagram, *at);
    return true;
}

static int64_t wire_ns(const world_link *link, size_t len)
{
    return (int64_t)((len + FRAME_MORE) * 8u * 1000000000u / link->bits_per_s);
}

/* --- the way in --- */

static void arrive(void *argument)
{
    world_datagram *datagram = argument;
    if (!is_open(datagram->in_at, &datagram->in_at->in)) {
        world_met("fault:cut");
        world_datagram_end(datagram, WORLD_LOST_CUT);
        return;
    }
    world_net_arrive(datagram);
}

/* The switch holds what the cable to the host has no time for. False: it has
 * no room. */
static bool take_turn(world_link *link, size_t len, int64_t *at)
{
    const int64_t takes = wire_ns(link, len);
    if (link->private.free_ns < *at) {
        link->private.free_ns = *at;
    }
    if (link->private.free_ns - *at > (int64_t)QUEUE_MAX * takes) {
        return false;
    }
    link->private.free_ns += takes;
    *at = link->private.free_ns;
    return true;
}

static void go_in(world_datagram *datagram, world_interface *to, int64_t at)
{
    datagram->in_at = to;
    if (!is_open(to, &to->in) || datagram->out_at->island != to->island) {
        world_met("fault:cut");
        world_datagram_end(datagram, WORLD_LOST_CUT);
        return;
    }
    if (to->in.bits_per_s > 0 && !take_turn(&to->in, datagram->len, &at)) {
        world_met("fault:queue");
        world_datagram_end(datagram, WORLD_LOST_QUEUE);
        return;
    }
    const bool repeats = befalls(&to->in, CHANCE_REPEAT, to->in.repeat);
    if (repeats) {
        world_datagram *copy = world_datagram_copy(datagram);
        int64_t copy_at = at;
        world_met("fault:repeat");
        if (pass(&to->in, copy, &copy_at)) {
            (void)world_at(copy_at, arrive, copy);
        }
    }
    if (pass(&to->in, datagram, &at)) {
        (void)world_at(at, arrive, datagram);
    }
}

static bool hears(const world_interface *to, const world_interface *from)
{
    return to != from && to->is_up && to->has_carrier;
}

/* All others get one; the last one the original. */
static void flood(world_datagram *datagram, int64_t at)
{
    const world_interface *from = datagram->out_at;
    world_interface *last = NULL;
    for (world_interface *i = from->segment->interfaces; i != NULL;
         i = i->next_of_segment) {
        if (hears(i, from)) {
            if (last != NULL) {
                go_in(world_datagram_copy(datagram), last, at);
            }
            last = i;
        }
    }
    if (last != NULL) {
        go_in(datagram, last, at);
    } else {
        world_datagram_end(datagram, WORLD_LOST_NO_SOCKET);
    }
}

/* --- the way out --- */

static void spread(world_datagram *datagram, int64_t at)
{
    if (datagram->private.is_broadcast) {
        flood(datagram, at);
    } else {
        go_in(datagram, datagram->in_at, at);
    }
}

/* The first bit of it is on the wire. */
static void depart(void *argument)
{
    world_datagram *datagram = argument;
    world_interface *from = datagram->out_at;
    int64_t at = world_now();
    world_datagram_leave(datagram);
    if (!is_open(from, &from->out)) {
        world_met("fault:cut");
        world_datagram_end(datagram, WORLD_LOST_CUT);
        return;
    }
    if (befalls(&from->out, CHANCE_REPEAT, from->out.repeat)) {
        world_datagram *copy = world_datagram_copy(datagram);
        int64_t copy_at = at;
        world_met("fault:repeat");
        if (pass(&from->out, copy, &copy_at)) {
            spread(copy, copy_at);
        }
    }
    if (pass(&from->out, datagram, &at)) {
        spread(datagram, at);
    }
}

static void depart_in_turn(void *argument)
{
    world_datagram *datagram = argument;
    datagram->out_at->out.private.waiting--;
    depart(datagram);
}

void world_link_output(world_datagram *datagram, world_interface *to)
{
    world_link *link = &datagram->out_at->out;
    datagram->in_at = to;
    if (link->bits_per_s == 0) {
        depart(datagram);
        return;
    }
    if (link->private.waiting >= QUEUE_MAX) {
        world_met("fault:queue");
        world_datagram_end(datagram, WORLD_LOST_QUEUE);
        return;
    }
    const int64_t takes = wire_ns(link, datagram->len);
    const int64_t now = world_now();
    link->private.free_ns =
        (link->private.free_ns > now ? link->private.free_ns : now) + takes;
    link->private.waiting++;
    if (!datagram->private.is_queued) {
        world_datagram_queue(datagram);
    }
    (void)world_at(link->private.free_ns, depart_in_turn, datagram);
}

static bool small_passes(world_link *link, int64_t *ns)
{
    *ns += link->delay_ns;
    return !befalls(link, CHANCE_ARP, link->lose);
}

bool world_link_passes(world_interface *from, world_interface *to, int64_t *ns)
{
    *ns = 0;
    return is_open(from, &from->out) && is_open(to, &to->in) &&
           from->island == to->island && small_passes(&from->out, ns) &&
           small_passes(&to->in, ns);
}

bool world_link_answers(world_interface *from, world_interface *to, int64_t *ns)
{
    int64_t back_ns = 0;
    const bool is_heard = world_link_passes(from, to, ns) &&
                          world_link_passes(to, from, &back_ns);
    *ns += back_ns;
    return is_heard;
}
