/* feed FLAT BYTES: the datagrams of a flat file (tests/flat/flatten.c) through
 * lwIP to examples/lwip, as a driver hands them in: packets of IP, in a pbuf of
 * their own, or, if BYTES is not 0, in a chain of pbufs with so many bytes
 * each. The points are those that the core makes of the same datagrams, what
 * does not fit is dropped and counted, and each pbuf is freed. */
#include "lidar.h"

#include "lum/calibration.h"
#include "lum/wire.h"

#include <lwip/inet_chksum.h>
#include <lwip/netif.h>
#include <lwip/pbuf.h>
#include <lwip/tcpip.h>

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HEADS 28u /* of IP and UDP */
#define BLOCK 16u

struct sum {
    uint64_t points;
    uint64_t digest; /* FNV-1a */
};

/* A driver's buffer. */
struct buffer {
    struct pbuf_custom pbuf; /* first, as lwIP finds the buffer by it */
    uint8_t bytes[];
};

static lum_layout layout;
static lum_fixed_projector projector;
static struct lidar lidar;
static struct netif netif;
static sys_sem_t done;
static size_t buffers_in_use; /* under lwIP's lock for memory */
static struct sum by_lwip;

/* What the core makes of them without lwIP. */
static struct sum direct;
static lum_receiver receiver;
static uint32_t words[LUM_RECEIVER_WORDS(LIDAR_BYTES)];
static uint32_t kinds[LUM_PACKET_KINDS];

static void add(struct sum *to, const lum_fixed_point *points, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const uint32_t values[] = {(uint32_t)points[i].x, (uint32_t)points[i].y,
                                   (uint32_t)points[i].z, points[i].word};
        for (size_t k = 0; k < sizeof values / sizeof values[0]; k++) {
            to->digest = (to->digest ^ values[k]) * UINT64_C(0x100000001b3);
        }
        to->points++;
    }
}

static void use(const lum_fixed_point *points, size_t count)
{
    add(&by_lwip, points, count);
}

static void take_directly(const uint8_t *bytes, size_t len)
{
    lum_point_losses losses = {0, 0};
    lum_fixed_point points[BLOCK];
    lum_group group;
    const lum_packet_kind kind = lum_packet_decode(&layout, bytes, len, &group);
    kinds[kind]++;
    if (kind != LUM_PACKET_DATA ||
        lum_receiver_push(&receiver, &group) != LUM_OK) {
        return;
    }
    const lum_line *line = lum_receiver_line(&receiver);
    for (uint32_t i = 0; i < line->word_count; i += BLOCK) {
        add(&direct, points,
            lum_points_fixed_compute(&projector, line, i, BLOCK, points,
                                     &losses));
    }
}

/* --- A driver --- */

static void give_back(struct pbuf *p)
{
    SYS_ARCH_DECL_PROTECT(level);
    SYS_ARCH_PROTECT(level);
    buffers_in_use--;
    SYS_ARCH_UNPROTECT(level);
    free(p);
}

static struct pbuf *buffer_of(const uint8_t *bytes, size_t len)
{
    struct buffer *b = malloc(sizeof *b + len);
    SYS_ARCH_DECL_PROTECT(level);
    if (b == NULL) {
        abort();
    }
    memcpy(b->bytes, bytes, len);
    b->pbuf.custom_free_function = give_back;
    SYS_ARCH_PROTECT(level);
    buffers_in_use++;
    SYS_ARCH_UNPROTECT(level);
    return pbuf_alloced_custom(PBUF_RAW, (u16_t)len, PBUF_REF, &b->pbuf,
                               b->bytes, (u16_t)len);
}

static void put_be16(uint8_t *out, size_t value)
{
    out[0] = (uint8_t)(value >> 8);
    out[1] = (uint8_t)value;
}

/* From 10.42.0.37 to 10.42.0.1; no checksum of UDP. */
static void put_heads(uint8_t *out, size_t len)
{
    static const uint8_t ip[20] = {0x45, 0, 0,  0,  0, 0,  0,  0,  64, 17,
                                   0,    0, 10, 42, 0, 37, 10, 42, 0,  1};
    u16_t sum = 0;
    memset(out, 0, HEADS);
    memcpy(out, ip, sizeof ip);
    put_be16(out + 2, HEADS + len);
    sum = inet_chksum(out, sizeof ip);
    memcpy(out + 10, &sum, sizeof sum);
    put_be16(out + 20, LUM_PORT);
    put_be16(out + 22, LUM_PORT);
    put_be16(out + 24, 8 + len);
}

/* In lwIP's mailbox there may be no place: a real driver drops the frame. */
static void receive(const uint8_t *payload, size_t len, size_t cut)
{
    uint8_t packet[HEADS + 2 * LIDAR_BYTES];
    const size_t first = cut == 0 || cut > len ? len : cut;
    struct pbuf *p = NULL;
    put_heads(packet, len);
    memcpy(packet + HEADS, payload, len);
    p = buffer_of(packet, HEADS + first);
    for (size_t at = first; at < len; at += cut) {
        pbuf_cat(
            p, buffer_of(packet + HEADS + at, len - at < cut ? len - at : cut));
    }
    while (netif.input(p, &netif) != ERR_OK) {
        sys_msleep(1);
    }
}

static err_t begin_netif(struct netif *n)
{
    n->mtu = 1500;
    return ERR_OK;
}

/* --- The run --- */

static void signal_done(void *unused)
{
    (void)unused;
    sys_sem_signal(&done);
}

/* What was handed in before is done with. */
static void drain(void)
{
    if (tcpip_callback(signal_done, NULL) != ERR_OK) {
        abort();
    }
    (void)sys_arch_sem_wait(&done, 0);
}

static bool begin_core(void)
{
    lum_calibration calibration;
    lum_layout_default(&layout);
    lum_calibration_default(&calibration);
    lidar.layout = &layout;
    lidar.projector = &projector;
    lidar.use = use;
    return lum_fixed_projector_init(&projector, &calibration, &layout) ==
               LUM_OK &&
           lum_receiver_init(&receiver, &layout, LUM_RECEIVER_GAP_US, words,
                             sizeof words / sizeof words[0]) == LUM_OK;
}

static bool begin_lwip(void)
{
    static struct lidar second;
    ip4_addr_t address;
    ip4_addr_t mask;
    bool ok = sys_sem_new(&done, 0) == ERR_OK;
    IP4_ADDR(&address, 10, 42, 0, 1);
    IP4_ADDR(&mask, 255, 255, 255, 0);
    tcpip_init(signal_done, NULL);
    (void)sys_arch_sem_wait(&done, 0);
    second.layout = &layout;
    LOCK_TCPIP_CORE();
    ok = ok && netif_add(&netif, &address, &mask, NULL, NULL, begin_netif,
                         tcpip_input) != NULL;
    netif_set_up(&netif);
    netif_set_link_up(&netif);
    ok = ok && lidar_begin(&lidar, LUM_PORT) == ERR_OK &&
         lidar_begin(&second, LUM_PORT) == ERR_USE;
    UNLOCK_TCPIP_CORE();
    return ok;
}

static uint64_t get_le(const uint8_t *bytes, unsigned count)
{
    uint64_t value = 0;
    for (unsigned i = count; i-- > 0;) {
        value = value << 8 | bytes[i];
    }
    return value;
}

static bool feed(FILE *in, size_t cut)
{
    static uint8_t datagram[LIDAR_BYTES];
    uint8_t head[12]; /* length, time */
    while (fread(head, 1, sizeof head, in) == sizeof head) {
        const size_t len = (size_t)get_le(head, 4);
        if (len > sizeof datagram || fread(datagram, 1, len, in) != len) {
            return false;
        }
        take_directly(datagram, len);
        receive(datagram, len, cut);
    }
    drain();
    return true;
}

static bool is_same(void)
{
    bool same = by_lwip.points == direct.points &&
                by_lwip.digest == direct.digest && direct.points > 0 &&
                lidar.refused == 0 && lidar.too_long == 0;
    for (size_t i = 0; i < LUM_PACKET_KINDS; i++) {
        same = same && lidar.kinds[i] == kinds[i];
    }
    return same;
}

/* Neither is read as data, and both are counted. */
static bool drops_what_it_must(size_t cut)
{
    static const uint8_t zeros[LIDAR_BYTES + 1];
    receive(zeros, sizeof zeros, cut);
    receive(zeros, sizeof zeros - 1, cut);
    drain();
    return lidar.too_long == 1 &&
           lidar.kinds[LUM_PACKET_FOREIGN] == kinds[LUM_PACKET_FOREIGN] + 1 &&
           by_lwip.points == direct.points;
}

int main(int argc, char **argv)
{
    FILE *in = NULL;
    size_t cut = 0;
    bool ok = false;
    if (argc != 3 || (in = fopen(argv[1], "rb")) == NULL) {
        (void)fprintf(stderr, "usage: feed FLAT BYTES\n");
        return 2;
    }
    cut = (size_t)strtoul(argv[2], NULL, 10);
    ok = begin_core() && begin_lwip() && feed(in, cut) && is_same() &&
         drops_what_it_must(cut) && buffers_in_use == 0;
    (void)printf("%" PRIu64 " points by lwIP, %" PRIu64
                 " by the core of %" PRIu32 " data packets; %" PRIu32
                 " refused, %" PRIu32 " too long; %zu buffers still in use\n",
                 by_lwip.points, direct.points, kinds[LUM_PACKET_DATA],
                 lidar.refused, lidar.too_long, buffers_in_use);
    (void)fclose(in);
    return ok ? 0 : 1;
}
