#include "heart.h"

#include "shared.h"

#include "lum/wire.h"

void heart_init(heart *h, heart_send *send, void *context, uint32_t now_ms)
{
    *h = (heart){.send = send,
                 .context = context,
                 .alive_ms = now_ms,
                 .next_ms = now_ms,
                 .until_poll = 1};
}

void heart_beat(heart *h)
{
    shared_store(&h->rounds, h->rounds + 1u);
}

bool heart_is_stalled(const heart *h)
{
    return shared_load(&h->stalled) != 0;
}

/* Compares counts, never times of two contexts. A stall lasts until a round
 * ends it, also beyond a wrap of the clock. */
static bool is_alive(heart *h, uint32_t now_ms)
{
    const uint32_t rounds = shared_load(&h->rounds);

    if (rounds != h->rounds_seen) {
        h->rounds_seen = rounds;
        h->alive_ms = now_ms;
        shared_store(&h->stalled, 0);
    } else if (now_ms - h->alive_ms >= HEART_STALL_MS) {
        shared_store(&h->stalled, 1);
    }
    return h->stalled == 0;
}

/* A TLV packet without TLVs is answered by the laser's status. */
static void poll_status(heart *h)
{
    uint8_t packet[LUM_TLV_PACKET_BYTES];
    lum_tlv_writer writer;

    if (--h->until_poll == 0 &&
        lum_tlv_begin(&writer, packet, sizeof packet, h->sequence) == LUM_OK) {
        h->until_poll = HEART_POLL;
        h->sequence++;
        (void)h->send(h->context, packet, writer.len);
    }
}

static void schedule(heart *h, uint32_t now_ms)
{
    h->next_ms += HEART_PERIOD_MS;
    if (now_ms - h->next_ms < UINT32_MAX / 2u) { /* that has passed too */
        h->next_ms = now_ms + HEART_PERIOD_MS;
    }
}

void heart_tick(heart *h, uint32_t now_ms)
{
    uint8_t packet[LUM_HEARTBEAT_BYTES];
    const bool alive = is_alive(h, now_ms);

    if (now_ms - h->next_ms > UINT32_MAX / 2u) { /* not yet due */
        return;
    }
    if (!alive) {
        h->next_ms = now_ms;
        return;
    }
    lum_heartbeat_encode(packet);
    if (!h->send(h->context, packet, sizeof packet)) {
        h->failed++;
        return;
    }
    h->sent++;
    schedule(h, now_ms);
    poll_status(h);
}
