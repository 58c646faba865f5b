/* Datagrams to a sensor on the network go to the device, its answers back. */
#include "live_sensor.h"

#include "../common/arrival.h"

#include "lum/base/time.h"

#include <stdio.h>
#include <string.h>

#define BATCHES_MAX 16  /* of one look */
#define STREAM      101 /* of random numbers */

/* The device's time does not go back. */
static int64_t tell_time(struct live *live, int64_t t_ns)
{
    if (t_ns > live->device_ns) {
        live->device_ns = t_ns;
    }
    return live->device_ns;
}

/* --- Answers on their way --- */

void live_init_replies(struct live *live)
{
    const struct options *o = live->options;
    live->replies.delay_ns = (int64_t)(o->answers.delay_ms * 1e6);
    live->replies.loss = o->answers.loss;
    lum_random_init(&live->replies.random, o->render.seed, STREAM);
}

/* Whether it will be sent; otherwise it is lost, by chance or because there is
 * no room. */
static bool replies_add(struct replies *replies, int64_t now_ns,
                        lum_device_peer to, const void *bytes, size_t len)
{
    if (lum_random_chance(&replies->random, replies->loss) ||
        replies->count == REPLIES_MAX || len > LUM_DEVICE_REPLY_BYTES) {
        return false;
    }
    struct reply *r =
        &replies->waiting[(replies->first + replies->count) % REPLIES_MAX];
    r->due_ns = now_ns + replies->delay_ns;
    r->to = to;
    r->len = len;
    memcpy(r->bytes, bytes, len);
    replies->count++;
    return true;
}

static int64_t replies_next_ns(const struct replies *replies)
{
    return replies->count > 0 ? replies->waiting[replies->first].due_ns
                              : INT64_MAX;
}

int64_t live_replies_next_ns(const struct live *live)
{
    return replies_next_ns(&live->replies);
}

/* The next one that leaves by then, or NULL. Lives until the next is added. */
static const struct reply *replies_take(struct replies *replies, int64_t now_ns)
{
    if (replies_next_ns(replies) > now_ns) {
        return NULL;
    }
    const struct reply *r = &replies->waiting[replies->first];
    replies->first = (replies->first + 1) % REPLIES_MAX;
    replies->count--;
    return r;
}

static void send_reply(struct live *live, const struct reply *reply,
                       int64_t now_ns)
{
    const lum_outgoing datagram = {.bytes = reply->bytes,
                                   .len = reply->len,
                                   .to = {reply->to.address, reply->to.port}};
    lum_error error;
    bool is_lost = live->is_silent;
    if (!is_lost &&
        lum_socket_send(live->socket, &datagram, &error) != LUM_NET_OK) {
        live_log_text(live, now_ns, "unsent", "reason", error.text);
        is_lost = true;
    }
    live->counts.answers += is_lost ? 0 : 1;
    live->counts.answers_lost += is_lost ? 1 : 0;
    live_log_reply(live, now_ns, reply->to, reply->bytes, reply->len, is_lost);
}

void live_send_replies(struct live *live, int64_t now_ns)
{
    const struct reply *reply;
    while ((reply = replies_take(&live->replies, now_ns)) != NULL) {
        send_reply(live, reply, now_ns);
    }
}

static void answer(struct live *live, const lum_device_effects *effects,
                   lum_device_peer to, int64_t now_ns)
{
    if (!replies_add(&live->replies, now_ns, to, effects->reply,
                     effects->reply_len)) {
        live->counts.answers_lost++;
        live_log_reply(live, now_ns, to, effects->reply, effects->reply_len,
                       true);
    }
    live_send_replies(live, now_ns);
}

/* A sensor changes its address at once; a machine may not have the new
 * address. */
static void move(struct live *live, uint32_t address, int64_t now_ns)
{
    const lum_socket_options options = {
        .struct_size = sizeof options,
        .local = {.address = address, .port = live->self.port},
        .interface_name = live->options->live.interface};
    lum_socket *there = NULL;
    lum_error error;
    char name[24];
    if (address == live->self.address) {
        return;
    }
    if (lum_socket_open(&options, &there, &error) != LUM_NET_OK) {
        (void)fprintf(stderr, "lumsim: cannot move to %s: %s\n",
                      live_name(address, live->self.port, name), error.text);
        live_log_move(live, now_ns, address, error.text);
        return;
    }
    lum_socket_close(live->socket);
    live->socket = there;
    live->self.address = address;
    live_log_move(live, now_ns, address, NULL);
}

static void apply(struct live *live, const lum_device_effects *effects,
                  lum_device_peer from, int64_t now_ns)
{
    live_log_state(live, effects, now_ns);
    if ((effects->laser_changed || effects->settings_changed) &&
        lum_device_gain(&live->device, now_ns) <= 0.0f) {
        live_darken_data(live);
    }
    live_switch_data(live, now_ns);
    if (effects->geometry_changed) {
        live_order(live);
    }
    if (effects->has_reply) {
        answer(live, effects, from, now_ns);
    }
    if (effects->has_address) {
        move(live, effects->address, now_ns);
    }
}

static void take(struct live *live, const lum_received *datagram, int64_t t_ns)
{
    const lum_device_peer from = {datagram->from.address, datagram->from.port};
    lum_device_effects effects;
    lum_group group;
    const lum_packet_kind kind = lum_packet_decode(
        &live->device.layout, datagram->bytes, datagram->len, &group);
    live->counts.heard[kind]++;
    lum_device_receive(&live->device, t_ns, from, datagram->bytes,
                       datagram->len, &effects);
    live_log_received(live, t_ns, kind, datagram, effects.note);
    apply(live, &effects, from, lum_time_monotonic_ns());
}

/* Time passes for the device before it hears. */
void live_tick(struct live *live, int64_t now_ns)
{
    lum_device_effects effects;
    const lum_device_peer client = live->device.client;
    if (lum_device_next_ns(&live->device) > now_ns) {
        return;
    }
    lum_device_tick(&live->device, tell_time(live, now_ns), &effects);
    apply(live, &effects, client, now_ns);
}

static bool receive_batch(struct live *live)
{
    lum_received *datagrams;
    size_t count = 0;
    const lum_socket *socket = live->socket;
    if (lum_socket_receive(live->socket, &datagrams, &count, &live->error) !=
        LUM_NET_OK) {
        live->has_failed = true;
        return false;
    }
    const int64_t now_ns = lum_time_monotonic_ns();
    const int64_t now_utc_ns = lum_time_utc_ns();
    for (size_t i = 0; i < count && live->socket == socket; i++) {
        if (live->is_silent) {
            live->counts.unheard++;
            continue;
        }
        const int64_t t_ns =
            arrival_ns(datagrams[i].utc_ns, now_ns, now_utc_ns);
        live_tick(live, t_ns);
        take(live, &datagrams[i], tell_time(live, t_ns));
    }
    return count == LUM_SOCKET_BATCH;
}

void live_receive(struct live *live)
{
    for (unsigned i = 0; i < BATCHES_MAX && receive_batch(live); i++) {
    }
}

void live_set_hazard(struct live *live, uint16_t bits, bool ends,
                     int64_t now_ns)
{
    const lum_device_peer client = live->device.client;
    lum_device_effects effects;
    lum_device_set_hazards(&live->device, ends ? 0 : bits, ends ? bits : 0,
                           tell_time(live, now_ns), &effects);
    apply(live, &effects, client, now_ns);
}

/* All as after power-up, and at the address it was started with. */
void live_reboot(struct live *live, int64_t now_ns)
{
    const struct options *o = live->options;
    const lum_layout layout = live->device.layout;
    const lum_device_effects effects = {
        .status_changed = true,
        .geometry_changed = o->mode == MODE_SCENE,
        .laser_changed = lum_device_laser_is_up(&live->device),
        .streaming_changed = live->device.is_streaming,
        .has_address = true,
        .address = o->sensor};
    const lum_device_peer nobody = {0, 0};
    lum_device_init(&live->device, &layout, (uint16_t)o->render.lines,
                    o->live.boot_status, 0, tell_time(live, now_ns));
    live->replies.count = 0;
    apply(live, &effects, nobody, now_ns);
}
