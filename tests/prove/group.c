/* Data packets: any layout that lum_layout_init() accepts, as profile.c shows
 * it to be, and any bytes. All fields have one width at a time, 0 where there
 * are none, and each of them every place up to the first sample, any order of
 * bytes and any of its bits: a field is read by itself. The packet ends where
 * its memory ends. */
#include "lum/packet.h"
#include "lum/wire.h"
#include "unknown.h"

#define BEYOND 5u /* most bytes behind the header: a sample and a byte */
#define MOST   (LUM_GROUP_HEAD_MAX + BEYOND)

static uint8_t memory[MOST];
static lum_layout layout;

static void use(const lum_group *g, uint32_t samples_at, uint32_t len)
{
    const uint32_t room = (len - samples_at) / LUM_SAMPLE_BYTES;
    const uint32_t i = any_u32(0, room - 1);
    //@ assert 1 <= g->num_samples <= room;
    //@ assert g->samples + (len - samples_at) == &memory[0] + MOST;
    //@ assert g->eye < LUM_EYES;
    //@ assert g->tag == LUM_TAG_ANGLES || g->tag == LUM_TAG_RANGES;
    (void)lum_group_angle(&layout, g, i);
    (void)lum_group_word(g, i);
}

static void decode(uint32_t samples_at, uint32_t len)
{
    lum_group group;
    const uint8_t *p = memory + (MOST - len);
    if (lum_packet_decode(&layout, p, len, &group) == LUM_PACKET_DATA) {
        use(&group, samples_at, len);
    }
    if (lum_group_decode(&layout, p, len, &group) == LUM_OK) {
        use(&group, samples_at, len);
    }
}

static void decode_fields_of(uint32_t samples_at, uint32_t bytes, uint32_t len)
{
    any_bytes(&layout, sizeof layout);
    layout.profile.samples_at = (uint8_t)samples_at;
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        lum_field *field = &layout.profile.group[f];
        field->bytes = (uint8_t)bytes;
        field->at = (uint8_t)any_u32(8, samples_at - bytes);
        field->order = (uint8_t)any_u32(0, LUM_ORDER_BIG);
        field->low = (uint8_t)any_u32(0, bytes > 0 ? 8u * bytes - 1u : 0);
        field->bits = (uint8_t)any_u32(0, 8u * bytes);
    }
    decode(samples_at, len);
}

static void decode_long(void)
{
    const uint32_t samples_at = any_u32(8, LUM_GROUP_HEAD_MAX);
    const uint32_t beyond = any_u32(0, BEYOND);
    const uint32_t bytes = any_u32(0, 8);
    //@ split samples_at;
    //@ split beyond;
    //@ split bytes;
    if ((bytes & (bytes - 1u)) == 0 && bytes + 8 <= samples_at) {
        decode_fields_of(samples_at, bytes, samples_at + beyond);
    }
}

/* Shorter than the layout's header. */
static void decode_short(void)
{
    const uint32_t len = any_u32(0, LUM_GROUP_HEAD_MAX - 1);
    //@ split len;
    const uint32_t samples_at = any_u32(len + 1, LUM_GROUP_HEAD_MAX);
    any_bytes(&layout, sizeof layout);
    layout.profile.samples_at = (uint8_t)samples_at;
    decode(samples_at, len);
    //@ merge len;
}

void main(void)
{
    any_bytes(memory, MOST);
    decode_short();
    decode_long();
}
