#include "bag_packets.h"

#include "byte_order.h"
#include "datagram_packet.h"

#include "lum/calibration.h"
#include "lum/wire.h"

#include <stdlib.h>
#include <string.h>

#define SENSORS_MAX 4u
#define NS_PER_S    1000000000u

/* Most that waits for the other eye: batches of an eye, of 20 ms each, and
 * bytes of a sensor. */
#define BATCHES_MAX 64u
#define BYTES_MAX   ((size_t)32 << 20)

/* The number of a port that the sensor could have sent to: which one it was is
 * not recorded. */
#define CLIENT_PORT 50000u

/* A message: packets of one eye. Its parts point into it. */
struct batch {
    uint8_t *bytes; /* NULL: there is none */
    size_t len;
    uint32_t sensor;
    uint64_t begin;
    uint64_t end;
    bool is_last; /* of its stream */
    size_t count;
    const uint8_t *places;
    const uint8_t *stamps;
    const uint8_t *lengths;
    const uint8_t *data;
    size_t next; /* packet to be taken, and where it begins in data */
    size_t next_at;
};

/* Batches in the order in which they came, which is that of their numbers. */
struct eye {
    struct batch waiting[BATCHES_MAX]; /* a ring */
    size_t first;
    size_t count;
    uint64_t end; /* it has told all packets below this number */
};

struct stream {
    struct eye eyes[LUM_EYES];
    uint32_t sensor;
    size_t bytes; /* that wait */
    bool is_used;
    bool is_ending; /* all that waits is taken, whatever is missing */
};

struct lum_bag_packets {
    struct stream streams[SENSORS_MAX];
    size_t oldest;         /* the stream that gives way to a fifth sensor's */
    struct batch incoming; /* until what is before it has been taken */
    unsigned eye;          /* of it */
    bool has_ended;        /* no message follows */
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
    return at != NULL ? load_u32(at) : 0;
}

static uint64_t take_u64(struct bytes *b)
{
    const uint8_t *at = take(b, 8);
    return at != NULL ? load_u64(at) : 0;
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
static bool is_consistent(const struct batch *m, size_t data_len)
{
    size_t left = data_len;
    uint64_t least = 0;
    for (size_t i = 0; i < m->count; i++) {
        const uint64_t place = load_u16(m->places + 2u * i);
        const size_t len = load_u16(m->lengths + 2u * i);
        if (place < least || place >= m->end - m->begin ||
            len > LUM_DATAGRAM_BYTES_MAX || len > left ||
            load_u32(m->stamps + 8u * i + 4u) >= NS_PER_S) {
            return false;
        }
        least = place + 1u;
        left -= len;
    }
    return left == 0;
}

static bool parse(struct batch *m, size_t len, unsigned *eye)
{
    struct bytes b = {m->bytes, len, false};
    (void)take(&b, 12); /* the header's number and time */
    (void)take(&b, take_u32(&b));
    const uint8_t *which = take(&b, 1);
    m->sensor = take_u32(&b);
    m->begin = take_u64(&b);
    m->end = take_u64(&b);
    const uint8_t *last = take(&b, 1);
    if (b.is_short || *which >= LUM_EYES || m->begin > m->end || b.left < 4u) {
        return false;
    }
    m->is_last = *last != 0;
    *eye = *which;
    m->count = load_u32(b.at);
    m->places = take_array(&b, m->count, 2);
    m->stamps = take_array(&b, m->count, 8);
    m->lengths = take_array(&b, m->count, 2);
    const size_t data_len = b.is_short || b.left < 4u ? 0 : load_u32(b.at);
    m->data = take_array(&b, data_len, 1);
    return !b.is_short && b.left == 0 && is_consistent(m, data_len);
}

/* --- Batches --- */

static void drop(struct batch *m)
{
    free(m->bytes);
    *m = (struct batch){0};
}

lum_bag_packets *lum_bag_packets_new(void)
{
    return calloc(1, sizeof(lum_bag_packets));
}

static struct batch *first_of(struct eye *e)
{
    return &e->waiting[e->first];
}

static void drop_first(struct stream *s, struct eye *e)
{
    s->bytes -= first_of(e)->len;
    drop(first_of(e));
    e->first = (e->first + 1u) % BATCHES_MAX;
    e->count--;
}

void lum_bag_packets_free(lum_bag_packets *packets)
{
    if (packets == NULL) {
        return;
    }
    for (size_t i = 0; i < SENSORS_MAX; i++) {
        struct stream *s = &packets->streams[i];
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            while (s->eyes[eye].count > 0) {
                drop_first(s, &s->eyes[eye]);
            }
        }
    }
    drop(&packets->incoming);
    free(packets);
}

static bool has_waiting(const struct stream *s)
{
    return s->eyes[LUM_EYE_BLUE].count > 0 || s->eyes[LUM_EYE_GREEN].count > 0;
}

/* That of a sensor, or one for it that was not used or of which nothing waits;
 * where there is none, the oldest has to go first. */
static struct stream *find_stream(lum_bag_packets *packets, uint32_t sensor)
{
    struct stream *vacant = NULL;
    for (size_t i = 0; i < SENSORS_MAX; i++) {
        struct stream *s = &packets->streams[i];
        if (s->is_used && s->sensor == sensor) {
            return s;
        }
        if (vacant == NULL || (vacant->is_used && !s->is_used)) {
            vacant = has_waiting(s) ? vacant : s;
        }
    }
    if (vacant != NULL) {
        *vacant = (struct stream){.is_used = true, .sensor = sensor};
        return vacant;
    }
    packets->streams[packets->oldest].is_ending = true;
    packets->oldest = (packets->oldest + 1u) % SENSORS_MAX;
    return NULL;
}

static bool is_full(const struct stream *s, const struct eye *e)
{
    return e->count > 0 && (e->count == BATCHES_MAX || s->bytes > BYTES_MAX);
}

/* Where numbers fall, another stream begins; what waits of the one before it
 * goes first, even if the other eye has not told all of it. */
static void place_incoming(lum_bag_packets *packets)
{
    struct batch *in = &packets->incoming;
    struct stream *s = find_stream(packets, in->sensor);
    if (s == NULL) {
        return;
    }
    struct eye *e = &s->eyes[packets->eye];
    if (in->begin < e->end) {
        s->is_ending = true;
        return;
    }
    e->waiting[(e->first + e->count) % BATCHES_MAX] = *in;
    e->count++;
    e->end = in->is_last ? UINT64_MAX : in->end;
    s->bytes += in->len;
    *in = (struct batch){0};
}

int lum_bag_packets_add(lum_bag_packets *packets, const uint8_t *message,
                        size_t len)
{
    struct batch m = {0};
    unsigned eye = 0;
    if (len == 0 || len > LUM_BAG_MESSAGE_MAX) {
        return 0;
    }
    m.len = len;
    m.bytes = malloc(len);
    if (m.bytes == NULL) {
        return -1;
    }
    memcpy(m.bytes, message, len);
    if (!parse(&m, len, &eye)) {
        drop(&m);
        return 0;
    }
    drop(&packets->incoming);
    packets->incoming = m;
    packets->eye = eye;
    return 1;
}

void lum_bag_packets_end(lum_bag_packets *packets)
{
    packets->has_ended = true;
}

/* --- Packets --- */

static uint64_t number_of(const struct batch *m)
{
    return m->begin + load_u16(m->places + 2u * m->next);
}

static void take_packet(struct batch *m, lum_record *out)
{
    const uint8_t *stamp = m->stamps + 8u * m->next;
    const size_t len = load_u16(m->lengths + 2u * m->next);
    *out = (lum_record){.time_ns = (int64_t)load_u32(stamp) * NS_PER_S +
                                   load_u32(stamp + 4),
                        .payload = m->data + m->next_at,
                        .len = len,
                        .source = m->sensor,
                        .source_port = LUM_PORT,
                        .destination_port = CLIENT_PORT,
                        .kind = LUM_RECORD_DATAGRAM};
    m->next++;
    m->next_at += len;
}

/* Packets below this number can be taken: both eyes have told all of them, or
 * too much waits. */
static uint64_t limit_of(const lum_bag_packets *packets, struct stream *s)
{
    if (s->is_ending || packets->has_ended) {
        return UINT64_MAX;
    }
    const uint64_t blue = s->eyes[LUM_EYE_BLUE].end;
    const uint64_t green = s->eyes[LUM_EYE_GREEN].end;
    uint64_t limit = blue < green ? blue : green;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        struct eye *e = &s->eyes[eye];
        if (is_full(s, e) && first_of(e)->end > limit) {
            limit = first_of(e)->end;
        }
    }
    return limit;
}

/* The eye's first batch with a packet that was not taken. */
static struct batch *open_batch(struct stream *s, struct eye *e)
{
    while (e->count > 0 && first_of(e)->next == first_of(e)->count) {
        drop_first(s, e);
    }
    return e->count > 0 ? first_of(e) : NULL;
}

static bool take_of_stream(const lum_bag_packets *packets, struct stream *s,
                           lum_record *out)
{
    struct batch *blue = open_batch(s, &s->eyes[LUM_EYE_BLUE]);
    struct batch *green = open_batch(s, &s->eyes[LUM_EYE_GREEN]);
    const uint64_t limit = limit_of(packets, s);
    const bool is_blue =
        blue != NULL && (green == NULL || number_of(blue) <= number_of(green));
    struct batch *lower = is_blue ? blue : green;
    if (lower == NULL || number_of(lower) >= limit) {
        return false;
    }
    take_packet(lower, out);
    return true;
}

static bool take_ready(lum_bag_packets *packets, lum_record *out)
{
    for (size_t i = 0; i < SENSORS_MAX; i++) {
        struct stream *s = &packets->streams[i];
        if (take_of_stream(packets, s, out)) {
            return true;
        }
        if (s->is_ending) {
            *s = (struct stream){0};
        }
    }
    return false;
}

bool lum_bag_packets_next(lum_bag_packets *packets, lum_record *out)
{
    while (!take_ready(packets, out)) {
        if (packets->incoming.bytes == NULL) {
            return false;
        }
        place_incoming(packets);
    }
    return true;
}
