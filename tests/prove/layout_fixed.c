/* The built-in layout alone: a profile of any bytes, any packet of every length
 * up to three samples and a byte behind the header, a clock at any ticks. The
 * packet, and what its angles are copied to, end where their memory ends. */
#include "clock.h"
#include "layout.h"
#include "lum/packet.h"
#include "lum/wire.h"
#include "unknown.h"

#define SAMPLES_AT 24u
#define SAMPLES    3u
#define MOST       (SAMPLES_AT + SAMPLES * LUM_SAMPLE_BYTES + 1u)

static uint8_t memory[MOST];
static lum_layout layout;
static lum_angle angles[SAMPLES];

static void follow(const lum_group *g)
{
    lum_clock clock = {.lowest = any_u64(0, UINT64_MAX)};
    uint64_t ticks;
    lum_clock_init(&clock, &layout.profile);
    (void)lum_clock_follow(&clock, g, &ticks);
    clock_take(&clock, &ticks);
}

static void use(const lum_group *g, uint32_t len)
{
    const uint32_t room = (len - SAMPLES_AT) / LUM_SAMPLE_BYTES;
    const uint32_t i = any_u32(0, room - 1);
    //@ assert 1 <= g->num_samples <= room;
    //@ assert g->samples + (len - SAMPLES_AT) == &memory[0] + MOST;
    //@ assert g->eye < LUM_EYES;
    //@ assert g->tag == LUM_TAG_ANGLES || g->tag == LUM_TAG_RANGES;
    (void)lum_group_word(g, i);
    follow(g);
}

static void copy(uint32_t n)
{
    const lum_group g = {.samples = memory + (MOST - n * LUM_SAMPLE_BYTES),
                         .num_samples = n};
    lum_layout_copy_angles(angles + (SAMPLES - n), &g, 0);
}

static void decode(uint32_t len)
{
    lum_group group;
    const uint8_t *p = memory + (MOST - len);
    if (lum_packet_decode(&layout, p, len, &group) == LUM_PACKET_DATA) {
        use(&group, len);
    }
    if (lum_group_decode(&layout, p, len, &group) == LUM_OK) {
        use(&group, len);
    }
}

void main(void)
{
    any_bytes(memory, MOST);
    any_bytes(&layout, sizeof layout);
    (void)lum_layout_is_read(&layout);
    const uint32_t n = any_u32(1, SAMPLES);
    //@ split n;
    copy(n);
    //@ merge n;
    const uint32_t len = any_u32(0, MOST);
    //@ split len;
    decode(len);
    //@ merge len;
}
