#include "heart.h"

#include "shared.h"

#include "lum/wire.h"

void heart_init(heart *h, heart_send *send, void *context, uint32_t now_ms)
{
    *h = (heart){.send = send,
                 .context = context,
                 .stalls = 1,
                 .next_ms = now_ms + HEART_SILENCE_MS,
                 .until_poll = 1,
                 .hung = true};
}

/* In this order: a reader that sees the round also sees how long it is valid,
 * or how long a later one is. */
void heart_beat(heart *h, uint32_t lasts_ms)
{
    shared_store(&h->lasts_ms, lasts_ms);
    shared_store(&h->rounds, h->rounds + 1u);
}

bool heart_has_ticked(heart *h)
{
    const uint32_t ticks = shared_load(&h->ticks);
    const bool moved = ticks != h->ticks_seen;

    h->ticks_seen = ticks;
    return moved;
}

uint32_t heart_stalls(const heart *h)
{
    return shared_load(&h->stalls);
}

static void set_stalled(heart *h, bool stalled)
{
    if (((h->stalls & 1u) != 0) != stalled) {
        shared_store(&h->stalls, h->stalls + 1u);
    }
}

/* Compares counts, never times of two contexts. A stall lasts until a round
 * ends it, also beyond a wrap of the clock. */
static void watch(heart *h, uint32_t now_ms)
{
    const uint32_t rounds = shared_load(&h->rounds);

    if (rounds != h->rounds_seen) {
        h->rounds_seen = rounds;
        h->stall_ms = shared_load(&h->lasts_ms);
        h->alive_ms = now_ms;
        h->hung = false;
        set_stalled(h, false);
        return;
    }
    if (now_ms - h->alive_ms >= HEART_STALL_MS) {
        h->hung = true;
    }
    if (h->hung || now_ms - h->alive_ms >= h->stall_ms) {
        set_stalled(h, true);
    }
}

static bool try_to_send(heart *h, const uint8_t *packet, size_t len)
{
    const bool is_sent = h->send(h->context, packet, len);

    h->failed += is_sent ? 0u : 1u;
    return is_sent;
}

static void ask_clock(heart *h, uint32_t now_ms)
{
    const lum_timestamp request = {.sequence = now_ms};
    uint8_t packet[LUM_TIMESTAMP_BYTES];

    lum_timestamp_encode(packet, &request);
    (void)try_to_send(h, packet, sizeof packet);
}

/* The answer to a TLV packet without TLVs is the laser's status. */
static void poll_status(heart *h, uint32_t now_ms)
{
    uint8_t packet[LUM_TLV_PACKET_BYTES];
    lum_tlv_writer writer;

    if (--h->until_poll == 0 &&
        lum_tlv_begin(&writer, packet, sizeof packet, now_ms) == LUM_OK) {
        h->until_poll = HEART_POLL;
        (void)try_to_send(h, packet, writer.len);
    }
}

static void schedule(heart *h, uint32_t now_ms)
{
    h->next_ms += HEART_PERIOD_MS;
    if (now_ms - h->next_ms < UINT32_MAX / 2u) { /* that has passed too */
        h->next_ms = now_ms + HEART_PERIOD_MS;
    }
}

/* A packet that is due and cannot be sent stays due for any time. */
void heart_tick(heart *h, uint32_t now_ms)
{
    uint8_t packet[LUM_HEARTBEAT_BYTES];

    watch(h, now_ms);
    shared_store(&h->ticks, h->ticks + 1u);
    if (now_ms - h->next_ms > UINT32_MAX / 2u) { /* not yet due */
        return;
    }
    if (h->hung) {
        h->next_ms = now_ms;
        return;
    }
    lum_heartbeat_encode(packet);
    if (!try_to_send(h, packet, sizeof packet)) {
        h->next_ms = now_ms;
        return;
    }
    h->sent++;
    schedule(h, now_ms);
    ask_clock(h, now_ms);
    poll_status(h, now_ms);
}
