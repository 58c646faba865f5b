#include "mcap_datagram.h"

#include "byte_order.h"

/* Each field follows the one before without padding. */
enum {
    SECONDS = 4,
    NANOSECONDS = 8,
    SOURCE = 12,
    SOURCE_PORT = 16,
    DESTINATION = 18,
    DESTINATION_PORT = 22,
    WHOLE = 24,
    COUNT = 28,
    DATA = 32,
    NANOSECONDS_PER_S = 1000000000
};

static uint32_t number(bool is_little, const uint8_t *p)
{
    return is_little ? load_le32(p) : load_be32(p);
}

static uint16_t port(bool is_little, const uint8_t *p)
{
    return is_little ? load_le16(p) : load_be16(p);
}

bool lum_mcap_datagram_read(const uint8_t *message, size_t len, lum_record *out,
                            uint32_t *whole)
{
    if (len < DATA || message[0] != 0 || message[1] > 1) {
        return false;
    }
    const bool is_little = message[1] == 1;
    const uint32_t nanoseconds = number(is_little, message + NANOSECONDS);
    const uint32_t sent = number(is_little, message + WHOLE);
    const uint32_t count = number(is_little, message + COUNT);
    if (count > len - DATA || count > sent ||
        nanoseconds >= NANOSECONDS_PER_S) {
        return false;
    }
    const int64_t seconds = (int32_t)number(is_little, message + SECONDS);
    *out = (lum_record){
        .time_ns = seconds * NANOSECONDS_PER_S + nanoseconds,
        .payload = message + DATA,
        .len = count,
        .source = load_be32(message + SOURCE),
        .destination = load_be32(message + DESTINATION),
        .source_port = port(is_little, message + SOURCE_PORT),
        .destination_port = port(is_little, message + DESTINATION_PORT),
        .kind = count < sent ? LUM_RECORD_CUT_SHORT : LUM_RECORD_DATAGRAM};
    *whole = sent;
    return true;
}
