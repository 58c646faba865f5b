/* Datagrams of lwIP's raw API to points: see lidar.h. */
#include "lidar.h"

#include <lwip/pbuf.h>
#include <lwip/udp.h>

#define BLOCK 16u /* points at a time, on the stack */

static void take_datagram(struct lidar *lidar, const void *bytes, size_t len)
{
    lum_fixed_point points[BLOCK];
    lum_group group;
    const lum_packet_kind kind =
        lum_packet_decode(lidar->layout, bytes, len, &group);
    lidar->kinds[kind]++;
    if (kind != LUM_PACKET_DATA) {
        return;
    }
    if (lum_receiver_push(&lidar->receiver, &group) != LUM_OK) {
        lidar->refused++;
        return;
    }
    const lum_line *line = lum_receiver_line(&lidar->receiver);
    for (uint32_t i = 0; i < line->word_count; i += BLOCK) {
        lidar->use(points,
                   lum_points_fixed_compute(lidar->projector, line, i, BLOCK,
                                            points, &lidar->losses));
    }
}

/* lwIP gives the pbuf away: it is freed here, and the core keeps nothing of it.
 * A chain of pbufs (small buffers of a pool, or fragments of IP) is copied. One
 * pbuf is read where the driver put it, at any alignment. Where others can send
 * to the port, compare from and port with the sensor's. */
static void take(void *arg, struct udp_pcb *pcb, struct pbuf *p,
                 const ip_addr_t *from, u16_t port)
{
    struct lidar *lidar = arg;
    (void)pcb;
    (void)from;
    (void)port;
    if (p->tot_len > sizeof lidar->bytes) {
        lidar->too_long++;
    } else {
        take_datagram(lidar,
                      pbuf_get_contiguous(p, lidar->bytes, sizeof lidar->bytes,
                                          p->tot_len, 0),
                      p->tot_len);
    }
    (void)pbuf_free(p);
}

err_t lidar_begin(struct lidar *lidar, uint16_t port)
{
    const uint32_t room = sizeof lidar->words / sizeof lidar->words[0];
    if (lum_receiver_init(&lidar->receiver, lidar->layout, LUM_RECEIVER_GAP_US,
                          lidar->words, room) != LUM_OK) {
        return ERR_VAL;
    }
    lidar->pcb = udp_new();
    if (lidar->pcb == NULL) {
        return ERR_MEM;
    }
    const err_t result = udp_bind(lidar->pcb, IP_ADDR_ANY, port);
    if (result != ERR_OK) {
        udp_remove(lidar->pcb);
        return result;
    }
    udp_recv(lidar->pcb, take, lidar);
    return ERR_OK;
}
