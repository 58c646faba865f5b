#include "bag_packets.h"

#include "byte_order.h"
#include "datagram_packet.h"

#include "lum/calibration.h"
#include "lum/wire.h"

#include <stdlib.h>
#include <string.h>

#define SENSORS_MAX 4u
#define NS_PER_S    1000000000u

/* The number of a port that the sensor could have sent to: which one it was is
 * not recorded. */
#define CLIENT_PORT 50000u

/* A message; its parts point into it. */
struct half {
    uint8_t *bytes; /* NULL: there is none */
    uint32_t sensor;
    uint64_t begin;
    uint64_t end;
    size_t count;
    const uint8_t *places;
    const uint8_t *stamps;
    const uint8_t *lengths;
    const uint8_t *data;
    size_t next; /* packet to be taken, and where it begins in data */
    size_t next_at;
};

struct pair {
    struct half eyes[LUM_EYES];
    bool is_ready; /* its packets are taken, whatever is missing */
};

struct lum_bag_packets {
    struct pair pairs[SENSORS_MAX];
    size_t oldest;        /* the pair that gives way to a fifth sensor's */
    struct half incoming; /* until those before it have been taken */
    unsigned eye;         /* of it */
    bool has_ended;       /* no other half comes any more */
};

/* --- A message --- */

struct bytes {
    const uint8_t *at;
    size_t left;
    bool is_short;
};

static const uint8_t *take(struct bytes *b, size_t n)
{
    const uint8_t *at = b->at;
    if (b->is_short || n > b->left) {
        b->is_short = true;
        return NULL;
    }
    b->at += n;
    b->left -= n;
    return at;
}

static uint32_t take_u32(struct bytes *b)
{
    const uint8_t *at = take(b, 4);
    return at != NULL ? load_le32(at) : 0;
}

static uint64_t take_u64(struct bytes *b)
{
    const uint8_t *at = take(b, 8);
    return at != NULL ? load_le64(at) : 0;
}

/* An array with its length before it, which has to be `count`. */
static const uint8_t *take_array(struct bytes *b, size_t count, size_t size)
{
    const uint32_t n = take_u32(b);
    if (n != count || n > b->left / size) {
        b->is_short = true;
        return NULL;
    }
    return take(b, n * size);
}

/* Numbers rise and belong to the batch; lengths are those of the data. */
static bool is_consistent(const struct half *h, size_t data_len)
{
    size_t bytes = 0;
    uint64_t least = 0;
    for (size_t i = 0; i < h->count; i++) {
        const uint64_t place = load_le16(h->places + 2u * i);
        const size_t len = load_le16(h->lengths + 2u * i);
        if (place < least || place >= h->end - h->begin ||
            len > LUM_DATAGRAM_BYTES_MAX ||
            load_le32(h->stamps + 8u * i + 4u) >= NS_PER_S) {
            return false;
        }
        least = place;
        bytes += len;
    }
    return bytes == data_len;
}

static bool parse(struct half *h, size_t len, unsigned *eye)
{
    struct bytes b = {h->bytes, len, false};
    (void)take(&b, 12); /* the header's number and time */
    (void)take(&b, take_u32(&b));
    const uint8_t *which = take(&b, 1);
    h->sensor = take_u32(&b);
    h->begin = take_u64(&b);
    h->end = take_u64(&b);
    (void)take(&b, 1); /* last */
    if (b.is_short || *which >= LUM_EYES || h->begin > h->end || b.left < 4u) {
        return false;
    }
    *eye = *which;
    h->count = load_le32(b.at);
    h->places = take_array(&b, h->count, 2);
    h->stamps = take_array(&b, h->count, 8);
    h->lengths = take_array(&b, h->count, 2);
    const size_t data_len = b.is_short || b.left < 4u ? 0 : load_le32(b.at);
    h->data = take_array(&b, data_len, 1);
    return !b.is_short && b.left == 0 && is_consistent(h, data_len);
}

/* --- Batches --- */

static void drop(struct half *h)
{
    free(h->bytes);
    *h = (struct half){0};
}

lum_bag_packets *lum_bag_packets_new(void)
{
    return calloc(1, sizeof(lum_bag_packets));
}

void lum_bag_packets_free(lum_bag_packets *packets)
{
    if (packets == NULL) {
        return;
    }
    for (size_t i = 0; i < SENSORS_MAX; i++) {
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            drop(&packets->pairs[i].eyes[eye]);
        }
    }
    drop(&packets->incoming);
    free(packets);
}

static bool is_of(const struct pair *p, uint32_t sensor)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        if (p->eyes[eye].bytes != NULL && p->eyes[eye].sensor == sensor) {
            return true;
        }
    }
    return false;
}

static bool is_empty(const struct pair *p)
{
    return p->eyes[0].bytes == NULL && p->eyes[1].bytes == NULL;
}

/* That of a sensor, or one for it; where none is free, the oldest has to go
 * first. */
static struct pair *find_pair(lum_bag_packets *packets, uint32_t sensor)
{
    struct pair *unused = NULL;
    for (size_t i = 0; i < SENSORS_MAX; i++) {
        struct pair *p = &packets->pairs[i];
        if (is_of(p, sensor)) {
            return p;
        }
        unused = unused == NULL && is_empty(p) ? p : unused;
    }
    if (unused != NULL) {
        return unused;
    }
    struct pair *oldest = &packets->pairs[packets->oldest];
    packets->oldest = (packets->oldest + 1u) % SENSORS_MAX;
    oldest->is_ready = true;
    return NULL;
}

/* To its other half, if that is there; what is of another batch goes first. */
static void place_incoming(lum_bag_packets *packets)
{
    struct half *in = &packets->incoming;
    struct pair *p = find_pair(packets, in->sensor);
    if (p == NULL) {
        return;
    }
    const struct half *other = &p->eyes[1u - packets->eye];
    const bool is_other_batch =
        p->eyes[packets->eye].bytes != NULL ||
        (other->bytes != NULL &&
         (other->begin != in->begin || other->end != in->end));
    if (is_other_batch) {
        p->is_ready = true;
        return;
    }
    p->is_ready = packets->has_ended || other->bytes != NULL;
    p->eyes[packets->eye] = *in;
    *in = (struct half){0};
}

int lum_bag_packets_add(lum_bag_packets *packets, const uint8_t *message,
                        size_t len)
{
    struct half h = {0};
    unsigned eye = 0;
    if (len == 0 || len > LUM_BAG_MESSAGE_MAX) {
        return 0;
    }
    h.bytes = malloc(len);
    if (h.bytes == NULL) {
        return -1;
    }
    memcpy(h.bytes, message, len);
    if (!parse(&h, len, &eye)) {
        drop(&h);
        return 0;
    }
    drop(&packets->incoming);
    packets->incoming = h;
    packets->eye = eye;
    return 1;
}

void lum_bag_packets_end(lum_bag_packets *packets)
{
    packets->has_ended = true;
    for (size_t i = 0; i < SENSORS_MAX; i++) {
        packets->pairs[i].is_ready = true;
    }
}

/* --- Packets --- */

static bool has_packet(const struct half *h)
{
    return h->bytes != NULL && h->next < h->count;
}

static uint64_t number_of(const struct half *h)
{
    return h->begin + load_le16(h->places + 2u * h->next);
}

static void take_packet(struct half *h, lum_record *out)
{
    const uint8_t *stamp = h->stamps + 8u * h->next;
    const size_t len = load_le16(h->lengths + 2u * h->next);
    *out = (lum_record){.time_ns = (int64_t)load_le32(stamp) * NS_PER_S +
                                   load_le32(stamp + 4),
                        .payload = h->data + h->next_at,
                        .len = len,
                        .source = h->sensor,
                        .source_port = LUM_PORT,
                        .destination_port = CLIENT_PORT,
                        .kind = LUM_RECORD_DATAGRAM};
    h->next++;
    h->next_at += len;
}

/* Its lowest number. */
static bool take_of_pair(struct pair *p, lum_record *out)
{
    struct half *blue = &p->eyes[LUM_EYE_BLUE];
    struct half *green = &p->eyes[LUM_EYE_GREEN];
    const bool has_blue = has_packet(blue);
    const bool has_green = has_packet(green);
    if (!has_blue && !has_green) {
        return false;
    }
    const bool is_blue =
        has_blue && (!has_green || number_of(blue) <= number_of(green));
    take_packet(is_blue ? blue : green, out);
    return true;
}

static bool take_ready(lum_bag_packets *packets, lum_record *out)
{
    for (size_t i = 0; i < SENSORS_MAX; i++) {
        struct pair *p = &packets->pairs[i];
        if (p->is_ready && take_of_pair(p, out)) {
            return true;
        }
        if (p->is_ready) {
            drop(&p->eyes[0]);
            drop(&p->eyes[1]);
            p->is_ready = false;
        }
    }
    return false;
}

bool lum_bag_packets_next(lum_bag_packets *packets, lum_record *out)
{
    /* Once for what is ready, once for what comes in and its other half, once
     * more where it first made way for itself. */
    for (unsigned i = 0; i < 3u; i++) {
        if (take_ready(packets, out)) {
            return true;
        }
        if (packets->incoming.bytes == NULL) {
            return false;
        }
        place_incoming(packets);
    }
    return take_ready(packets, out);
}
