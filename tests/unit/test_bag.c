#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "capture/bag_packets.h"
#include "capture/pcap.h"
#include "capture/unpack.h"
#include "lum/capture/source.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SENSOR 0x0a2a0025u

/* --- Bags in the making --- */

typedef struct image {
    uint8_t *bytes;
    size_t len;
} image;

static void put(image *im, const void *bytes, size_t len)
{
    uint8_t *more = realloc(im->bytes, im->len + len + 1u);
    assert_non_null(more);
    im->bytes = more;
    if (len != 0) {
        memcpy(im->bytes + im->len, bytes, len);
    }
    im->len += len;
}

static void put_int(image *im, uint64_t value, size_t len)
{
    uint8_t bytes[8];
    for (size_t i = 0; i < len; i++) {
        bytes[i] = (uint8_t)(value >> 8u * i);
    }
    put(im, bytes, len);
}

static void put_sized(image *im, const void *bytes, size_t len)
{
    put_int(im, len, 4);
    put(im, bytes, len);
}

static void put_field(image *im, const char *name, const void *value,
                      size_t len)
{
    put_int(im, strlen(name) + 1u + len, 4);
    put(im, name, strlen(name));
    put(im, "=", 1);
    put(im, value, len);
}

static void put_number(image *im, const char *name, uint32_t value)
{
    const uint8_t bytes[4] = {(uint8_t)value, (uint8_t)(value >> 8),
                              (uint8_t)(value >> 16), (uint8_t)(value >> 24)};
    put_field(im, name, bytes, sizeof bytes);
}

/* The fields and the data are taken over. */
static void put_record(image *im, uint8_t op, image *fields, image *data)
{
    put_field(fields, "op", &op, 1);
    put_sized(im, fields->bytes, fields->len);
    put_sized(im, data->bytes, data->len);
    free(fields->bytes);
    free(data->bytes);
    *fields = (image){0};
    *data = (image){0};
}

/* index: where connections stand again. */
static void put_begin(image *im, uint64_t index)
{
    image fields = {0};
    image data = {0};
    char padding[100];
    memset(padding, ' ', sizeof padding);
    put(im, "#ROSBAG V2.0\n", 13);
    put_number(&fields, "conn_count", 2);
    image number = {0};
    put_int(&number, index, 8);
    put_field(&fields, "index_pos", number.bytes, 8);
    free(number.bytes);
    put(&data, padding, sizeof padding);
    put_record(im, 3, &fields, &data);
}

static void put_magic(image *im)
{
    put_begin(im, 0);
}

static void put_connection(image *im, uint32_t id, const char *type)
{
    image fields = {0};
    image data = {0};
    put_number(&fields, "conn", id);
    put_field(&fields, "topic", "/x", 2);
    put_field(&data, "md5sum", "*", 1);
    put_field(&data, "type", type, strlen(type));
    put_record(im, 7, &fields, &data);
}

/* A packet of a batch: its number, and a payload of one byte, the same. */
static image batch_of(unsigned eye, uint32_t sensor, unsigned begin,
                      unsigned end, bool is_last, const char *numbers)
{
    const size_t n = strlen(numbers);
    image m = {0};
    put_int(&m, 1, 4);
    put_int(&m, 5, 8);
    put_sized(&m, "luminar", 7);
    put_int(&m, eye, 1);
    put_int(&m, sensor, 4);
    put_int(&m, begin, 8);
    put_int(&m, end, 8);
    put_int(&m, is_last, 1);
    put_int(&m, n, 4);
    for (size_t i = 0; i < n; i++) {
        put_int(&m, (unsigned)(numbers[i] - '0') - begin, 2);
    }
    put_int(&m, n, 4);
    for (size_t i = 0; i < n; i++) {
        put_int(&m, 2, 4);
        put_int(&m, (unsigned)(numbers[i] - '0'), 4);
    }
    put_int(&m, n, 4);
    for (size_t i = 0; i < n; i++) {
        put_int(&m, 1, 2);
    }
    put_sized(&m, numbers, n);
    return m;
}

static image message_of(unsigned eye, uint32_t sensor, unsigned begin,
                        unsigned end, const char *numbers)
{
    return batch_of(eye, sensor, begin, end, false, numbers);
}

static void put_message(image *im, uint32_t id, image message)
{
    image fields = {0};
    put_number(&fields, "conn", id);
    put_field(&fields, "time", "12345678", 8);
    put_record(im, 2, &fields, &message);
}

/* Chunks hold records as they stand beside them. */
static void put_chunk(image *im, const char *compression, image *records)
{
    image fields = {0};
    put_field(&fields, "compression", compression, strlen(compression));
    put_number(&fields, "size", (uint32_t)records->len);
    put_record(im, 5, &fields, records);
}

/* Clouds beside packets of both eyes, in a chunk. */
static image make_bag(void)
{
    image bag = {0};
    image records = {0};
    image cloud = {0};
    put_magic(&bag);
    put_connection(&records, 0, "sensor_msgs/PointCloud2");
    put_connection(&records, 1, "lumsdk_ros/Packets");
    put_connection(&records, 9, "lumsdk_ros/Packets");
    put_message(&records, 1, message_of(0, SENSOR, 0, 4, "02"));
    put(&cloud, "not packets", 11);
    put_message(&records, 0, cloud);
    put_message(&records, 9, message_of(1, SENSOR, 0, 4, "13"));
    put_chunk(&bag, "none", &records);
    put_message(&bag, 9, message_of(1, SENSOR, 4, 6, "4"));
    put_message(&bag, 1, message_of(0, SENSOR, 4, 6, "5"));
    put_connection(&bag, 1, "lumsdk_ros/Packets");
    return bag;
}

/* --- Reading --- */

struct outcome {
    char payloads[96]; /* a byte of each packet */
    size_t count;
    int end; /* of lum_pcap_begin() or lum_pcap_next() */
    lum_error error;
    uint64_t damaged;
    char why[LUM_ERROR_BYTES]; /* the first part was passed over */
    lum_pcap_record first;
    uint8_t headers[28]; /* of the first */
};

static void read_bytes(const uint8_t *bytes, size_t len, struct outcome *o)
{
    uint32_t link_type = 0;
    lum_pcap_record record;
    lum_source *source = lum_source_from_memory("bag", bytes, len);
    assert_non_null(source);
    lum_pcap *reader = lum_pcap_new(source);
    assert_non_null(reader);
    memset(o, 0, sizeof *o);
    o->end = lum_pcap_begin(reader, NULL, &link_type, &o->error);
    while (o->end > 0 &&
           (o->end = lum_pcap_next(reader, &record, &o->error)) > 0) {
        assert_true(record.len == 29 && o->count + 1u < sizeof o->payloads);
        if (o->count == 0) {
            o->first = record;
            memcpy(o->headers, record.bytes, sizeof o->headers);
        }
        o->payloads[o->count++] = (char)record.bytes[28];
    }
    const char *why = "";
    o->damaged = lum_pcap_damaged(reader, &why);
    strcpy(o->why, why);
    lum_pcap_free(reader);
    lum_source_close(source);
}

static void expect(image *bag, const char *payloads, const char *error)
{
    struct outcome o;
    read_bytes(bag->bytes, bag->len, &o);
    assert_string_equal(o.payloads, payloads);
    assert_int_equal(o.end, error == NULL ? 0 : -1);
    assert_int_equal(o.damaged, 0);
    if (error != NULL && strstr(o.error.text, error) == NULL) {
        fail_msg("'%s' is not in '%s'", error, o.error.text);
    }
    free(bag->bytes);
}

static void expect_text(const char *text, const char *part)
{
    if (strstr(text, part) == NULL) {
        fail_msg("'%s' is not in '%s'", part, text);
    }
}

/* Of a bag that is read to its end; frees it. */
static void expect_damage(image *bag, const char *payloads, uint64_t damaged,
                          const char *why)
{
    struct outcome o;
    read_bytes(bag->bytes, bag->len, &o);
    assert_string_equal(o.payloads, payloads);
    assert_int_equal(o.end, 0);
    assert_int_equal(o.damaged, damaged);
    expect_text(o.why, why);
    free(bag->bytes);
}

static void packets_come_by_their_numbers(void **state)
{
    image bag = make_bag();
    (void)state;
    expect(&bag, "012345", NULL);
}

static void a_packet_has_the_sensor_and_its_time(void **state)
{
    static const uint8_t want[28] = {
        0x45, 0,  0, 29, 0, 0, 0,    0,    64,   17,   0, 0, 10, 42,
        0,    37, 0, 0,  0, 0, 0x15, 0x8d, 0xc3, 0x50, 0, 9, 0,  0};
    image bag = make_bag();
    struct outcome o;
    (void)state;
    read_bytes(bag.bytes, bag.len, &o);
    assert_int_equal(o.first.time_ns, 2000000000);
    assert_int_equal(o.first.whole, 29);
    assert_memory_equal(o.headers, want, sizeof want);
    free(bag.bytes);
}

static void a_bag_cut_anywhere_gives_what_came_before(void **state)
{
    image bag = make_bag();
    struct outcome whole;
    (void)state;
    read_bytes(bag.bytes, bag.len, &whole);
    for (size_t len = 0; len < bag.len; len++) {
        uint8_t *const cut = malloc(len + 1u);
        struct outcome o;
        assert_non_null(cut);
        memcpy(cut, bag.bytes, len);
        read_bytes(cut, len, &o);
        /* The end of a record may be that of a bag without an index. */
        assert_true(o.end == -1 || o.end == 0);
        assert_true(o.end == 0 || o.error.text[0] != '\0');
        assert_true(o.count <= whole.count);
        for (size_t i = 0; i + 1u < o.count; i++) {
            assert_true(o.payloads[i] < o.payloads[i + 1u]);
        }
        free(cut);
    }
    free(bag.bytes);
}

/* There is no check sum, so other numbers or bytes may come out. */
static void a_flipped_bit_breaks_nothing(void **state)
{
    image bag = make_bag();
    (void)state;
    for (size_t bit = 0; bit < 8u * bag.len; bit++) {
        uint8_t *const damaged = malloc(bag.len);
        uint32_t link_type = 0;
        lum_pcap_record record;
        lum_error error = {""};
        assert_non_null(damaged);
        memcpy(damaged, bag.bytes, bag.len);
        damaged[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
        lum_source *source = lum_source_from_memory("bag", damaged, bag.len);
        assert_non_null(source);
        lum_pcap *reader = lum_pcap_new(source);
        assert_non_null(reader);
        int got = lum_pcap_begin(reader, NULL, &link_type, &error);
        unsigned packets = 0;
        while (got > 0 && (got = lum_pcap_next(reader, &record, &error)) > 0) {
            packets++;
            assert_true(packets <= 6u);
        }
        assert_true(got == 0 || error.text[0] != '\0');
        lum_pcap_free(reader);
        lum_source_close(source);
        free(damaged);
    }
    free(bag.bytes);
}

/* --- Batches --- */

static image begin_bag(void)
{
    image bag = {0};
    put_magic(&bag);
    put_connection(&bag, 1, "lumsdk_ros/Packets");
    return bag;
}

static void a_batch_without_its_other_half_is_given_too(void **state)
{
    image bag = begin_bag();
    (void)state;
    put_message(&bag, 1, message_of(0, SENSOR, 0, 2, "0"));
    put_message(&bag, 1, message_of(0, SENSOR, 2, 4, "2"));
    put_message(&bag, 1, message_of(1, SENSOR, 2, 4, "3"));
    put_message(&bag, 1, message_of(1, SENSOR, 4, 6, "4"));
    put_message(&bag, 1, message_of(0, SENSOR, 6, 8, "7"));
    expect(&bag, "02347", NULL);
}

static void an_eye_far_ahead_waits_for_the_other(void **state)
{
    image bag = begin_bag();
    (void)state;
    put_message(&bag, 1, message_of(0, SENSOR, 0, 2, "0"));
    put_message(&bag, 1, message_of(0, SENSOR, 2, 4, "2"));
    put_message(&bag, 1, message_of(0, SENSOR, 4, 6, "5"));
    put_message(&bag, 1, message_of(1, SENSOR, 0, 2, "1"));
    put_message(&bag, 1, message_of(1, SENSOR, 2, 4, "3"));
    put_message(&bag, 1, message_of(1, SENSOR, 4, 6, "4"));
    expect(&bag, "012345", NULL);
}

static void what_waits_is_given_before_the_failure(void **state)
{
    image bag = begin_bag();
    (void)state;
    put_message(&bag, 1, message_of(0, SENSOR, 0, 2, "0"));
    put_message(&bag, 1, message_of(0, SENSOR, 2, 4, "23"));
    put_int(&bag, 5, 4);
    expect(&bag, "023", "cut");
}

/* The other eye is not waited for. */
static void after_the_last_batch_nothing_of_its_eye_follows(void **state)
{
    lum_record record;
    image last = batch_of(0, SENSOR, 0, 2, true, "0");
    image first = message_of(1, SENSOR, 0, 9, "8");
    lum_bag_packets *packets = lum_bag_packets_new();
    (void)state;
    assert_non_null(packets);
    assert_int_equal(lum_bag_packets_add(packets, last.bytes, last.len), 1);
    assert_false(lum_bag_packets_next(packets, &record));
    assert_int_equal(lum_bag_packets_add(packets, first.bytes, first.len), 1);
    assert_true(lum_bag_packets_next(packets, &record));
    assert_int_equal(*record.payload, '0');
    assert_true(lum_bag_packets_next(packets, &record));
    assert_int_equal(*record.payload, '8');
    assert_false(lum_bag_packets_next(packets, &record));
    lum_bag_packets_free(packets);
    free(last.bytes);
    free(first.bytes);
}

static void a_fifth_sensor_takes_the_place_of_one_that_waits_for_nothing(
    void **state)
{
    image bag = begin_bag();
    (void)state;
    put_message(&bag, 1, message_of(0, 1, 0, 2, "0"));
    for (unsigned sensor = 2; sensor <= 6u; sensor++) {
        put_message(&bag, 1, message_of(0, sensor, 0, 2, "1"));
        put_message(&bag, 1, message_of(1, sensor, 0, 2, ""));
    }
    put_message(&bag, 1, message_of(1, 1, 0, 2, ""));
    expect(&bag, "111110", NULL);
}

static void an_eye_waits_for_64_batches_of_the_other(void **state)
{
    image bag = begin_bag();
    (void)state;
    for (unsigned i = 0; i < 66u; i++) {
        const char number[2] = {(char)('0' + i), '\0'};
        put_message(&bag, 1, message_of(0, SENSOR, i, i + 1u, number));
    }
    put_message(&bag, 1, message_of(1, SENSOR, 0, 66, "14"));
    expect(&bag,
           "01213445"
           "6789:;<=>?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_`abcdefghijklmnopq",
           NULL);
}

static void large_batches_do_not_wait_for_64(void **state)
{
    static char many[4 << 20];
    image bag = begin_bag();
    (void)state;
    for (unsigned i = 0; i < 10u; i++) {
        const char number[2] = {(char)('0' + i), '\0'};
        image m = message_of(0, SENSOR, i, i + 1u, number);
        /* A long frame_id. */
        image large = {0};
        put(&large, m.bytes, 12);
        put_sized(&large, many, sizeof many);
        put(&large, m.bytes + 23, m.len - 23u);
        free(m.bytes);
        put_message(&bag, 1, large);
    }
    put_message(&bag, 1, message_of(1, SENSOR, 0, 10, "0"));
    expect(&bag, "01203456789", NULL);
}

static void another_stream_begins_where_numbers_fall(void **state)
{
    image bag = begin_bag();
    (void)state;
    for (unsigned i = 0; i < 2u; i++) {
        put_message(&bag, 1, message_of(0, SENSOR, 0, 2, "0"));
        put_message(&bag, 1, message_of(1, SENSOR, 0, 2, "1"));
        put_message(&bag, 1, message_of(1, SENSOR, 2, 4, "3"));
    }
    expect(&bag, "013013", NULL);
}

static void each_sensor_has_its_own_batches(void **state)
{
    image bag = begin_bag();
    (void)state;
    put_message(&bag, 1, message_of(0, 1, 0, 4, "02"));
    put_message(&bag, 1, message_of(0, 2, 0, 4, "01"));
    put_message(&bag, 1, message_of(1, 1, 0, 4, "13"));
    put_message(&bag, 1, message_of(1, 2, 0, 4, "23"));
    expect(&bag, "01230123", NULL);
    bag = begin_bag();
    for (unsigned sensor = 1; sensor <= 6u; sensor++) {
        const char number[2] = {(char)('0' + sensor), '\0'};
        put_message(&bag, 1, message_of(0, sensor, 0, 9, number));
    }
    expect(&bag, "125634", NULL);
}

static void an_empty_batch_is_a_half_too(void **state)
{
    image bag = begin_bag();
    (void)state;
    put_message(&bag, 1, message_of(0, SENSOR, 0, 2, "01"));
    put_message(&bag, 1, message_of(1, SENSOR, 0, 2, ""));
    put_message(&bag, 1, message_of(1, SENSOR, 2, 4, "23"));
    expect(&bag, "0123", NULL);
}

/* --- Refusals --- */

/* A bag whose chunks are records in a frame of lz4 that did not make them
 * shorter. */
static void put_lz4(image *im, image *records)
{
    image fields = {0};
    image packed = {0};
    put(&packed, "\x04\x22\x4d\x18\x60\x40\x82", 7);
    put_int(&packed, records->len | UINT32_C(0x80000000), 4);
    put(&packed, records->bytes, records->len);
    put_int(&packed, 0, 4);
    put_field(&fields, "compression", "lz4", 3);
    put_number(&fields, "size", (uint32_t)records->len);
    put_record(im, 5, &fields, &packed);
    free(records->bytes);
    *records = (image){0};
}

/* Changes to a chunk of these records that the reader notices. */
static void put_garbage(image *im, image *records)
{
    memset(records->bytes, 0xff, records->len);
    put_chunk(im, "lz4", records);
}

static void put_bz2_garbage(image *im, image *records)
{
    put_chunk(im, "bz2", records);
}

static void put_unknown(image *im, image *records)
{
    put_chunk(im, "zstd", records);
}

static void put_no_name(image *im, image *records)
{
    image fields = {0};
    put_number(&fields, "size", (uint32_t)records->len);
    put_record(im, 5, &fields, records);
}

static void put_too_large(image *im, image *records)
{
    image fields = {0};
    put_field(&fields, "compression", "lz4", 3);
    put_number(&fields, "size", (64u << 20) + 1u);
    put_record(im, 5, &fields, records);
}

/* Its first record ends behind it. */
static void put_overrun(image *im, image *records)
{
    records->bytes[2] = 1;
    put_chunk(im, "none", records);
}

static void put_overrun_packed(image *im, image *records)
{
    records->bytes[3] = 1;
    put_lz4(im, records);
}

/* What it has is read. */
static void put_another_size(image *im, image *records)
{
    image fields = {0};
    put_field(&fields, "compression", "none", 4);
    put_number(&fields, "size", (uint32_t)records->len + 1u);
    put_record(im, 5, &fields, records);
}

static void put_no_type(image *im, image *records)
{
    for (size_t i = 0; i + 4u < records->len; i++) {
        if (memcmp(records->bytes + i, "op=", 3) == 0) {
            records->bytes[i] = 'x';
        }
    }
    put_chunk(im, "none", records);
}

static const struct damage {
    void (*put)(image *im, image *records);
    const char *says;
    uint64_t count;
} damages[] = {
    {put_garbage, "lz4", 1},
    {put_bz2_garbage, "bz", 1},
    {put_unknown, "compressed by zstd, which is not supported", 1},
    {put_no_name, "compressed by ?", 1},
    {put_too_large, "at most 67108864 can be read: rosbag decompress", 1},
    {put_overrun, "longer than the rest of the chunk", 1},
    {put_overrun_packed, "lz4", 1},
    {put_no_type, "a record without a type", 2}};

#define DAMAGES (sizeof damages / sizeof damages[0])

/* Three chunks of a batch of each eye, of which one is damaged; the index has
 * the connections again. */
static image with_damage(const struct damage *d, size_t bad, bool has_index)
{
    static const char *const numbers[] = {"0", "1", "2", "3", "4", "5"};
    image bag = {0};
    for (unsigned pass = 0; pass < 2u; pass++) {
        const uint64_t index = bag.len; /* of the pass before */
        free(bag.bytes);
        bag = (image){0};
        put_begin(&bag, has_index ? index : 0);
        for (unsigned i = 0; i < 3u; i++) {
            image records = {0};
            if (i == 0) {
                put_connection(&records, 1, "lumsdk_ros/Packets");
            }
            put_message(
                &records, 1,
                message_of(0, SENSOR, 2u * i, 2u * i + 2u, numbers[2u * i]));
            put_message(&records, 1,
                        message_of(1, SENSOR, 2u * i, 2u * i + 2u,
                                   numbers[2u * i + 1u]));
            if (i == bad) {
                d->put(&bag, &records);
            } else {
                put_chunk(&bag, "none", &records);
            }
        }
    }
    put_connection(&bag, 1, "lumsdk_ros/Packets");
    return bag;
}

static void a_damaged_chunk_is_passed_over(void **state)
{
    static const char *const left[] = {"2345", "0145", "0123"};
    (void)state;
    for (size_t i = 0; i < DAMAGES * 3u; i++) {
        const struct damage *d = &damages[i / 3u];
        image bag = with_damage(d, i % 3u, true);
        if (d->put == put_no_type && i % 3u == 0) {
            expect_damage(&bag, left[0], 3, d->says);
        } else if (d->put == put_overrun_packed && lum_unpack_lz4 != NULL) {
            expect_damage(&bag, left[i % 3u], 1,
                          "longer than the rest of the chunk");
        } else {
            expect_damage(&bag, left[i % 3u], d->count, d->says);
        }
    }
}

/* What follows cannot be understood there. */
static void a_bag_without_an_index_loses_what_was_described(void **state)
{
    struct outcome o;
    image bag = with_damage(&damages[0], 0, false);
    (void)state;
    read_bytes(bag.bytes, bag.len, &o);
    assert_int_equal(o.end, -1); /* its connection comes last */
    assert_int_equal(o.damaged, 5);
    expect_text(o.error.text, "nothing of it can be read: byte ");
    expect_text(o.error.text, "lz4");
    free(bag.bytes);
}

static void a_chunk_of_another_length_than_it_says_is_read_and_counted(
    void **state)
{
    static const struct damage size = {put_another_size, "", 1};
    (void)state;
    for (unsigned i = 0; i < 3u; i++) {
        image bag = with_damage(&size, i, false);
        expect_damage(&bag, "012345", 1, "an uncompressed chunk of ");
    }
}

static void a_damaged_index_does_no_harm(void **state)
{
    image bag = with_damage(&damages[0], 0, true);
    const size_t len = bag.len;
    (void)state;
    for (size_t at = 0; at < len + 2u; at++) {
        struct outcome o;
        uint8_t *const field = bag.bytes + 13 + 4 + 4 + 15 + 4 + 10;
        assert_memory_equal(field - 10, "index_pos=", 10);
        for (size_t i = 0; i < 8u; i++) {
            field[i] = (uint8_t)((uint64_t)at >> 8u * i);
        }
        read_bytes(bag.bytes, len, &o);
        assert_true(o.end == -1 || strcmp(o.payloads, "2345") == 0);
    }
    free(bag.bytes);
}

static void chunks_by_lz4_are_read(void **state)
{
    static const struct damage none = {put_lz4, "", 0};
    (void)state;
    for (unsigned i = 0; i < 3u; i++) {
        image bag = with_damage(&none, i, true);
        if (lum_unpack_lz4 != NULL) {
            expect(&bag, "012345", NULL);
        } else {
            free(bag.bytes);
        }
    }
}

static void a_message_nobody_described_is_counted(void **state)
{
    image bag = begin_bag();
    (void)state;
    put_message(&bag, 7, message_of(0, SENSOR, 0, 2, "0"));
    put_message(&bag, 1, message_of(0, SENSOR, 0, 2, "1"));
    expect_damage(&bag, "1", 1, "a message of connection 7, which was not");
}

static void a_bag_without_packets_says_so(void **state)
{
    image bag = {0};
    (void)state;
    put_magic(&bag);
    put_connection(&bag, 1, "sensor_msgs/PointCloud2");
    expect(&bag, "", "no messages of lumsdk_ros/Packets");
    bag = (image){0};
    put_magic(&bag);
    put_connection(&bag, 70000, "lumsdk_ros/Packets");
    expect(&bag, "", "no messages of lumsdk_ros/Packets");
}

static void huge_lengths_are_refused(void **state)
{
    image bag = {0};
    image fields = {0};
    (void)state;
    put_magic(&bag);
    put_int(&bag, UINT32_MAX, 4);
    expect(&bag, "", "the header of a record has 4294967295 bytes");
    bag = begin_bag();
    put_number(&fields, "conn", 1);
    put_field(&fields, "op", "\2", 1);
    put_sized(&bag, fields.bytes, fields.len);
    put_int(&bag, UINT32_MAX, 4);
    expect(&bag, "", "a record is cut short");
    free(fields.bytes);
}

static void a_record_without_a_type_is_refused(void **state)
{
    image bag = begin_bag();
    (void)state;
    put_sized(&bag, "", 0);
    put_sized(&bag, "", 0);
    expect(&bag, "", "a record without a type");
}

/* Each of its parts at its limits. */
static void a_message_that_contradicts_itself_is_passed_over(void **state)
{
    static const struct {
        size_t at;
        uint8_t value;
    } changes[] = {{23, 2}, /* the eye */
                   {28, 9}, /* begin, behind the end */
                   {49, 4}, /* a place, behind the batch */
                   {62, 0x40} /* a stamp's nanoseconds */};
    (void)state;
    for (size_t i = 0; i < sizeof changes / sizeof changes[0]; i++) {
        image bag = begin_bag();
        image m = message_of(0, SENSOR, 0, 4, "0");
        m.bytes[changes[i].at] = changes[i].value;
        put_message(&bag, 1, m);
        put_message(&bag, 1, message_of(0, SENSOR, 0, 4, "1"));
        expect_damage(&bag, "1", 1, "contradicts itself");
    }
}

static void numbers_rise(void **state)
{
    static const char *const refused[] = {"20", "11"};
    (void)state;
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        image bag = begin_bag();
        put_message(&bag, 1, message_of(0, SENSOR, 0, 4, refused[i]));
        expect_damage(&bag, "", 1, "contradicts itself");
    }
}

static void a_datagram_has_at_most_65507_bytes(void **state)
{
    (void)state;
    for (unsigned len = 65507; len <= 65508u; len++) {
        lum_bag_packets *packets = lum_bag_packets_new();
        image m = message_of(0, SENSOR, 0, 4, "0");
        uint8_t *payload = calloc(1, len);
        lum_record record;
        assert_true(packets != NULL && payload != NULL);
        m.len -= 4u + 2u + 1u; /* the length, that of data, data */
        put_int(&m, len, 2);
        put_sized(&m, payload, len);
        assert_int_equal(lum_bag_packets_add(packets, m.bytes, m.len),
                         len == 65507u);
        lum_bag_packets_end(packets);
        assert_int_equal(lum_bag_packets_next(packets, &record), len == 65507u);
        assert_false(lum_bag_packets_next(packets, &record));
        lum_bag_packets_free(packets);
        free(payload);
        free(m.bytes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(packets_come_by_their_numbers),
        cmocka_unit_test(a_packet_has_the_sensor_and_its_time),
        cmocka_unit_test(a_bag_cut_anywhere_gives_what_came_before),
        cmocka_unit_test(a_flipped_bit_breaks_nothing),
        cmocka_unit_test(a_batch_without_its_other_half_is_given_too),
        cmocka_unit_test(an_eye_far_ahead_waits_for_the_other),
        cmocka_unit_test(what_waits_is_given_before_the_failure),
        cmocka_unit_test(after_the_last_batch_nothing_of_its_eye_follows),
        cmocka_unit_test(
            a_fifth_sensor_takes_the_place_of_one_that_waits_for_nothing),
        cmocka_unit_test(an_eye_waits_for_64_batches_of_the_other),
        cmocka_unit_test(large_batches_do_not_wait_for_64),
        cmocka_unit_test(another_stream_begins_where_numbers_fall),
        cmocka_unit_test(each_sensor_has_its_own_batches),
        cmocka_unit_test(an_empty_batch_is_a_half_too),
        cmocka_unit_test(a_damaged_chunk_is_passed_over),
        cmocka_unit_test(a_bag_without_an_index_loses_what_was_described),
        cmocka_unit_test(
            a_chunk_of_another_length_than_it_says_is_read_and_counted),
        cmocka_unit_test(a_damaged_index_does_no_harm),
        cmocka_unit_test(chunks_by_lz4_are_read),
        cmocka_unit_test(a_message_nobody_described_is_counted),
        cmocka_unit_test(a_bag_without_packets_says_so),
        cmocka_unit_test(huge_lengths_are_refused),
        cmocka_unit_test(a_record_without_a_type_is_refused),
        cmocka_unit_test(a_message_that_contradicts_itself_is_passed_over),
        cmocka_unit_test(numbers_rise),
        cmocka_unit_test(a_datagram_has_at_most_65507_bytes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
