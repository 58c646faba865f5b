/* Packets other than data: any bytes, every length up to 32. A packet ends
 * where its memory ends, so that a byte read beyond it is an alarm. */
#include "lum/wire.h"
#include "lum/laser.h"
#include "unknown.h"

#define MOST 32u

static uint8_t memory[MOST];

static void read_set_ip(const lum_layout *layout, const uint8_t *p, size_t len)
{
    uint32_t address = 0;
    if (lum_set_ip_decode(layout, p, len, &address) == LUM_OK) {
        (void)lum_address_is_host(address);
    }
}

static void read_timestamp(const uint8_t *p, size_t len)
{
    lum_timestamp t;
    if (lum_timestamp_decode(p, len, &t) == LUM_OK) {
        const uint32_t sum = t.sequence + t.clock_us;
        (void)sum;
    }
}

/* A reader's promise: what it will read ends with the packet. */
static void open_tlvs(const uint8_t *p, size_t len)
{
    uint32_t sequence;
    lum_tlv_reader reader;
    if (lum_tlv_open(p, len, &sequence, &reader) == LUM_OK) {
        //@ assert \initialized(&sequence);
        //@ assert reader.next + reader.left == &memory[0] + MOST;
    }
}

static void read_status(const lum_tlv *tlv)
{
    uint16_t status;
    if (lum_tlv_u16(tlv, &status) == LUM_OK) {
        (void)lum_laser_is_down(status);
        (void)lum_laser_has_hazard(status);
    }
}

/* One step from any state that the promise allows: it keeps the promise, the
 * value lies within, and less is left. So does, by induction, any number of
 * steps. The length's low byte is taken value by
 * value where a value of that length could fit. */
static void next_tlv(uint8_t *p, size_t left)
{
    lum_tlv_reader reader = {p, left};
    lum_tlv tlv;
    uint32_t low = any_u32(0, 255);
    if (low <= MOST) {
        //@ split low;
        low += 0;
    }
    if (left > 2) {
        p[2] = (uint8_t)low;
    }
    if (lum_tlv_next(&reader, &tlv) == LUM_OK) {
        //@ assert reader.left + LUM_TLV_HEAD_BYTES <= left;
        //@ assert reader.next + reader.left == &memory[0] + MOST;
        //@ assert tlv.value + tlv.length == reader.next;
        //@ assert \valid_read(tlv.value + (0 .. tlv.length - 1));
        read_status(&tlv);
    } else {
        //@ assert reader.left == 0;
    }
}

void main(void)
{
    lum_layout layout;
    lum_layout_default(&layout);
    layout.profile.set_ip_order = (uint8_t)any_u32(0, LUM_SET_IP_LITTLE);
    any_bytes(memory, MOST);
    const uint32_t len = any_u32(0, MOST);
    //@ split len;
    uint8_t *p = memory + (MOST - len);
    read_set_ip(&layout, p, len);
    read_timestamp(p, len);
    open_tlvs(p, len);
    next_tlv(p, len);
    (void)lum_laser_bit_name(any_u32(0, UINT32_MAX));
}
