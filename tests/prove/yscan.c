/* A Y-scan table from a TLV: any bytes, every length up to 9, room for 0 to 4
 * elevations; the value and the room end where their memory ends. */
#include "lum/host/yscan.h"
#include "unknown.h"

#define MOST 9u
#define ROOM 4u

static uint8_t memory[MOST];
static int16_t out[ROOM];

static void decode(uint32_t len, uint32_t room)
{
    const lum_tlv tlv = {4, (uint16_t)len, memory + (MOST - len)};
    size_t n;
    if (lum_yscan_decode(&tlv, out + (ROOM - room), room, &n) == LUM_OK) {
        //@ assert n <= room;
    }
}

void main(void)
{
    any_bytes(memory, MOST);
    const uint32_t len = any_u32(0, MOST);
    const uint32_t room = any_u32(0, ROOM);
    //@ split len;
    //@ split room;
    decode(len, room);
}
