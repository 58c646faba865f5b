#include "base/pack.h"

#include "base/grow.h"

#include <stdlib.h>
#include <string.h>

#define NUMBER_MAX 10u /* bytes of 64 bits */

lum_pack lum_pack_of(const void *bytes, size_t len)
{
    static const uint8_t nothing = 0;
    const uint8_t *at = len != 0 ? bytes : &nothing;
    return (lum_pack){.at = at, .end = at + len};
}

void lum_pack_reset(lum_pack *pack)
{
    free(pack->written);
    *pack = (lum_pack){.written = NULL};
}

static bool make_room(lum_pack *pack, size_t bytes)
{
    uint8_t *written =
        lum_grown(pack->written, pack->len, bytes, 1, &pack->room);
    if (written == NULL) {
        pack->has_failed = true;
        return false;
    }
    pack->written = written;
    return true;
}

static void put(lum_pack *pack, uint64_t value)
{
    if (pack->has_failed || !make_room(pack, NUMBER_MAX)) {
        return;
    }
    while (value > 0x7fu) {
        pack->written[pack->len++] = (uint8_t)(0x80u | (value & 0x7fu));
        value >>= 7;
    }
    pack->written[pack->len++] = (uint8_t)value;
}

static uint64_t get(lum_pack *pack)
{
    uint64_t value = 0;
    for (unsigned shift = 0; !pack->has_failed && pack->at != pack->end;
         shift += 7u) {
        const uint8_t byte = *pack->at++;
        const uint64_t bits = byte & 0x7fu;
        if (shift > 63u || bits << shift >> shift != bits) {
            break;
        }
        value |= bits << shift;
        if (byte < 0x80u) {
            return value;
        }
    }
    pack->has_failed = true;
    return 0;
}

static uint64_t exchange(lum_pack *pack, uint64_t value, uint64_t most)
{
    if (!lum_pack_is_reading(pack)) {
        put(pack, value);
        return value;
    }
    const uint64_t got = get(pack);
    return lum_pack_check(pack, got <= most) ? got : 0;
}

void lum_pack_u64(lum_pack *pack, uint64_t *value)
{
    *value = exchange(pack, *value, UINT64_MAX);
}

void lum_pack_u32(lum_pack *pack, uint32_t *value)
{
    *value = (uint32_t)exchange(pack, *value, UINT32_MAX);
}

void lum_pack_u16(lum_pack *pack, uint16_t *value)
{
    *value = (uint16_t)exchange(pack, *value, UINT16_MAX);
}

void lum_pack_u8(lum_pack *pack, uint8_t *value)
{
    *value = (uint8_t)exchange(pack, *value, UINT8_MAX);
}

void lum_pack_bool(lum_pack *pack, bool *value)
{
    *value = exchange(pack, *value ? 1u : 0u, 1u) != 0;
}

/* Small ones of either sign take few bits: 0, -1, 1, -2 ... */
static uint64_t fold(uint64_t value)
{
    return value << 1 ^ (0u - (value >> 63));
}

static uint64_t unfold(uint64_t folded)
{
    return folded >> 1 ^ (0u - (folded & 1u));
}

void lum_pack_i64(lum_pack *pack, int64_t *value)
{
    const uint64_t folded = exchange(pack, fold((uint64_t)*value), UINT64_MAX);
    *value = (int64_t)unfold(folded);
}

void lum_pack_near(lum_pack *pack, int64_t *value, int64_t other)
{
    int64_t away = (int64_t)((uint64_t)*value - (uint64_t)other);
    lum_pack_i64(pack, &away);
    *value = (int64_t)((uint64_t)other + (uint64_t)away);
}

void lum_pack_bytes(lum_pack *pack, void *bytes, size_t len)
{
    if (pack->has_failed || len == 0) {
        return;
    }
    if (lum_pack_is_reading(pack)) {
        if (lum_pack_check(pack, (size_t)(pack->end - pack->at) >= len)) {
            memcpy(bytes, pack->at, len);
            pack->at += len;
        }
    } else if (make_room(pack, len)) {
        memcpy(pack->written + pack->len, bytes, len);
        pack->len += len;
    }
}

void lum_pack_text(lum_pack *pack, char *text, size_t room)
{
    const char *end = memchr(text, '\0', room);
    uint8_t len = end != NULL ? (uint8_t)(end - text) : 0;
    lum_pack_u8(pack, &len);
    if (lum_pack_check(pack, len < room)) {
        lum_pack_bytes(pack, text, len);
        text[pack->has_failed ? 0 : len] = '\0';
    }
}

bool lum_pack_check(lum_pack *pack, bool is_possible)
{
    if (lum_pack_is_reading(pack) && !is_possible) {
        pack->has_failed = true;
    }
    return !pack->has_failed;
}
