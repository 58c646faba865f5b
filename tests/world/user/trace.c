#include "internal.h"

#include "kernel/trace.h"

#include <stdio.h>
#include <string.h>

/* What a datagram is, for people: names of the protocol (docs/protocol.md). */

#define HEADER_BYTES 12u
#define NUMBERED     16u

enum {
    SET_IP = 5,
    TIME_STAMP = 6,
    TLV = 7,
    HEARTBEAT_OR_DATA = 8
};
enum {
    ITEM_COMMAND = 1,
    ITEM_STATUS = 2,
    ITEM_SAYS = 3
};

static bool tells_all;

static unsigned get16(const uint8_t *at)
{
    return at[0] | (unsigned)at[1] << 8;
}

static unsigned get32(const uint8_t *at)
{
    return get16(at) | get16(at + 2) << 16;
}

/* Text of a datagram, with ? for what is none. */
static int say(char *out, size_t room, const char *what, const uint8_t *bytes,
               size_t size)
{
    char text[40];
    size_t n = 0;
    for (; n < size && n + 1 < sizeof text; n++) {
        const bool is_plain = bytes[n] >= ' ' && bytes[n] <= '~';
        text[n] = is_plain ? (char)bytes[n] : '?';
    }
    text[n] = '\0';
    return snprintf(out, room, ", %s '%s'%s", what, text,
                    n < size ? "..." : "");
}

static int say_item(char *out, size_t room, unsigned kind, const uint8_t *bytes,
                    size_t size)
{
    if (kind == ITEM_STATUS && size == 2) {
        return snprintf(out, room, ", status 0x%04x", get16(bytes));
    }
    return say(out, room,
               kind == ITEM_COMMAND ? "command"
               : kind == ITEM_SAYS  ? "says"
                                    : "item",
               bytes, size);
}

static void say_items(const world_datagram *d, char *out, size_t room)
{
    size_t used = strlen(out);
    size_t at = NUMBERED;
    while (at + 4 <= d->len && used < room) {
        const unsigned size = get16(d->bytes + at + 2);
        if (at + 4 + size > d->len) {
            break;
        }
        used += (size_t)say_item(out + used, room - used, get16(d->bytes + at),
                                 d->bytes + at + 4, size);
        at += 4 + (size_t)size;
    }
}

static void say_packet(const world_datagram *d, char *out, size_t room)
{
    const unsigned type = get32(d->bytes + 8);
    if (type == SET_IP && d->len >= NUMBERED) {
        (void)snprintf(out, room, "set IP %u.%u.%u.%u", d->bytes[12],
                       d->bytes[13], d->bytes[14], d->bytes[15]);
    } else if (type == TIME_STAMP && d->len >= NUMBERED) {
        (void)snprintf(out, room, "time stamp %u", get32(d->bytes + 12));
    } else if (type == TLV && d->len >= NUMBERED) {
        (void)snprintf(out, room, "TLV %u", get32(d->bytes + 12));
        say_items(d, out, room);
    } else {
        (void)snprintf(out, room, "type %u, %zu bytes", type, d->len);
    }
}

/* One with data is told only if it was lost at one of its ends. */
static bool describe(const world_datagram *d, char *out, size_t room)
{
    static const uint8_t magic[8] = {0xed, 0xfe, 0xf3, 0xa1,
                                     0xef, 0xbe, 0x34, 0x12};
    if (d->len < HEADER_BYTES || memcmp(d->bytes, magic, sizeof magic) != 0) {
        (void)snprintf(out, room, "foreign, %zu bytes", d->len);
    } else if (get32(d->bytes + 8) != HEARTBEAT_OR_DATA) {
        say_packet(d, out, room);
    } else if (d->len == HEADER_BYTES) {
        (void)snprintf(out, room, "heartbeat");
    } else {
        (void)snprintf(out, room, "data, %zu bytes", d->len);
        return tells_all ||
               (d->fate != WORLD_UNDER_WAY && d->fate != WORLD_RECEIVED &&
                d->fate != WORLD_LOST_LINK);
    }
    return true;
}

void user_trace_datagrams(bool all)
{
    tells_all = all;
    world_net_describe = describe;
}
