#include "heard.h"

#include "lum/packet.h"

struct heard heard_in(const lum_sensor_event *event, const lum_layout *layout)
{
    struct heard heard = {false, false};
    for (size_t i = 0; i < event->datagram_count && !heard.has_data; i++) {
        const lum_received *d = &event->datagrams[i];
        lum_group group;
        const lum_packet_kind kind =
            lum_packet_decode(layout, d->bytes, d->len, &group);
        heard.has_data = kind == LUM_PACKET_DATA;
        heard.has_unknown |= kind == LUM_PACKET_MALFORMED ||
                             kind == LUM_PACKET_UNKNOWN_TYPE ||
                             kind == LUM_PACKET_UNKNOWN_TAG;
    }
    return heard;
}
