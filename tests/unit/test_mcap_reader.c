#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "mcap_image.h"

#include "base/crc32.h"
#include "capture/mcap_chunk.h"
#include "capture/unpack.h"

#include <stdlib.h>
#include <string.h>

enum {
    CLOUDS = 1, /* channels */
    PACKETS = 7,
    RECORDS_MAX = 16,
    IPV4 = 228,
    HEADERS_BYTES = 28,
    DATAGRAM_MAX = 65507
};

#define SCHEMA "lumsdk_msgs/msg/Datagram"

static lum_crc32 crc;

static int init_crc(void **state)
{
    (void)state;
    lum_crc32_init(&crc);
    return 0;
}

/* --- Files in the making --- */

static void put_schemas(image *im)
{
    put_schema(im, 1, "sensor_msgs/msg/PointCloud2");
    put_schema(im, 2, SCHEMA);
    put_channel(im, CLOUDS, 1, "/topic", "cdr");
    put_channel(im, PACKETS, 2, "/topic", "cdr");
}

/* Of len bytes, of which whole were sent; at so many seconds. */
static void put_datagram(image *im, unsigned s, size_t len, size_t whole)
{
    const size_t from = begin_record(im, OP_MESSAGE);
    put_int(im, PACKETS, 2);
    put_int(im, 0, 4);
    put_int(im, 0, 8);
    put_int(im, 0, 8);
    put_int(im, 0x0100, 4);
    put_int(im, s, 4);
    put_int(im, 5, 4);
    put_int(im, 0x25002a0a, 4);
    put_int(im, 5517, 2);
    put_int(im, 0x01002a0a, 4);
    put_int(im, 50000, 2);
    put_int(im, whole, 4);
    put_int(im, len, 4);
    for (size_t i = 0; i < len; i++) {
        put_int(im, s + i, 1);
    }
    end_record(im, from);
    im->messages++;
}

static void put_cloud(image *im, size_t len)
{
    const size_t from = begin_record(im, OP_MESSAGE);
    put_int(im, CLOUDS, 2);
    for (size_t i = 0; i < len; i++) {
        put_int(im, 0xaa, 1);
    }
    end_record(im, from);
    im->messages++;
}

/* Three datagrams in two chunks, and what is to be passed over. */
static image sample(bool is_packed)
{
    void (*const put_chunk)(image *, image *) =
        is_packed ? put_zstd : put_plain;
    image im = begin_file();
    image first = {.bytes = NULL};
    image second = {.bytes = NULL};
    put_schemas(&first);
    put_cloud(&first, 30);
    put_datagram(&first, 1, 8, 8);
    put_datagram(&first, 2, 3, 3);
    put_record(&im, OP_OWN, 3);
    put_chunk(&im, &first);
    put_datagram(&second, 3, 5, 5);
    put_cloud(&second, 1);
    put_chunk(&im, &second);
    end_file(&im);
    return im;
}

/* --- Reading them --- */

/* All that a file gave, up to its end or to what was wrong. */
struct outcome {
    int begun;
    int last; /* of lum_pcap_next() */
    size_t count;
    struct {
        int64_t time_ns;
        uint32_t len;
        uint32_t whole;
        uint32_t sum;
    } records[RECORDS_MAX];
    lum_error error;
};

static void read_all(lum_pcap *reader, struct outcome *o)
{
    lum_pcap_record r;
    while ((o->last = lum_pcap_next(reader, &r, &o->error)) == 1) {
        assert_true(o->count < RECORDS_MAX);
        assert_int_equal(r.link_type, IPV4);
        o->records[o->count].time_ns = r.time_ns;
        o->records[o->count].len = r.len;
        o->records[o->count].whole = r.whole;
        o->records[o->count++].sum = lum_crc32_add(&crc, 0, r.bytes, r.len);
    }
    if (o->last == 0) {
        assert_int_equal(lum_pcap_next(reader, &r, &o->error), 0);
    }
}

/* From memory where a byte too far is noticed. */
static struct outcome outcome_of(const uint8_t *bytes, size_t len)
{
    struct outcome o;
    uint32_t link_type = 0;
    memset(&o, 0, sizeof o);
    uint8_t *exact = malloc(len != 0 ? len : 1u);
    assert_non_null(exact);
    memcpy(exact, bytes, len);
    lum_source *source = lum_source_from_memory("x.mcap", exact, len);
    assert_non_null(source);
    lum_pcap *reader = lum_pcap_new(source);
    assert_non_null(reader);
    o.last = -1;
    o.begun = lum_pcap_begin(reader, NULL, &link_type, &o.error);
    if (o.begun > 0) {
        assert_int_equal(link_type, IPV4);
        assert_false(lum_pcap_can_seek(reader));
        read_all(reader, &o);
    }
    lum_pcap_free(reader);
    lum_source_close(source);
    free(exact);
    return o;
}

/* Frees the image. */
static void expect_error(image *im, const char *text)
{
    const struct outcome o = outcome_of(im->bytes, im->len);
    assert_int_equal(o.last, -1);
    if (strstr(o.error.text, text) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", o.error.text, text);
    }
    free(im->bytes);
}

static bool begins_alike(const struct outcome *a, const struct outcome *b,
                         size_t count)
{
    return memcmp(a->records, b->records, count * sizeof a->records[0]) == 0;
}

static void check_sample(const image *im)
{
    const struct outcome o = outcome_of(im->bytes, im->len);
    static const uint32_t lengths[] = {8, 3, 5};
    assert_int_equal(o.begun, 1);
    assert_int_equal(o.last, 0);
    assert_int_equal(o.count, 3);
    for (size_t i = 0; i < 3u; i++) {
        assert_int_equal(o.records[i].time_ns, (i + 1u) * 1000000000u + 5u);
        assert_int_equal(o.records[i].len, HEADERS_BYTES + lengths[i]);
        assert_int_equal(o.records[i].whole, HEADERS_BYTES + lengths[i]);
    }
}

static bool can_unpack(void)
{
    return lum_unpack_zstd != NULL;
}

/* --- Tests --- */

static void datagrams_of_chunks_are_read(void **state)
{
    (void)state;
    image plain = sample(false);
    check_sample(&plain);
    free(plain.bytes);
    image packed = sample(true);
    if (can_unpack()) {
        check_sample(&packed);
        free(packed.bytes);
    } else {
        expect_error(&packed, "this build has no libzstd");
    }
}

static void datagrams_without_a_chunk_are_read(void **state)
{
    (void)state;
    image im = begin_file();
    put_schemas(&im);
    put_datagram(&im, 1, 8, 8);
    put_cloud(&im, 40);
    put_datagram(&im, 2, 3, 3);
    put_datagram(&im, 3, 5, 5);
    end_file(&im);
    check_sample(&im);
    free(im.bytes);
}

static void a_packet_has_the_headers_it_had(void **state)
{
    static const uint8_t expected[] = {
        0x45, 0,  0, 31, 0,    0,    0,    0,    64, 17, 0, 0, 10, 42, 0, 37,
        10,   42, 0, 1,  0x15, 0x8d, 0xc3, 0x50, 0,  11, 0, 0, 1,  2,  3};
    (void)state;
    image im = begin_file();
    put_schemas(&im);
    put_datagram(&im, 1, 3, 3);
    end_file(&im);
    const struct outcome o = outcome_of(im.bytes, im.len);
    assert_int_equal(o.count, 1);
    assert_int_equal(o.records[0].sum,
                     lum_crc32_add(&crc, 0, expected, sizeof expected));
    free(im.bytes);
}

/* What was read before is kept; only the whole file ends without an error. */
static void a_file_cut_anywhere_says_so(void **state)
{
    (void)state;
    for (int packed = 0; packed <= (can_unpack() ? 1 : 0); packed++) {
        image im = sample(packed != 0);
        const struct outcome whole = outcome_of(im.bytes, im.len);
        for (size_t len = 0; len < im.len; len++) {
            const struct outcome o = outcome_of(im.bytes, len);
            assert_int_equal(o.last, -1);
            assert_true(o.error.text[0] != '\0');
            assert_true(begins_alike(&o, &whole, o.count));
        }
        free(im.bytes);
    }
}

static void all_whole_chunks_of_a_cut_file_are_read(void **state)
{
    (void)state;
    image im = begin_file();
    image records = {.bytes = NULL};
    put_schemas(&records);
    put_datagram(&records, 1, 8, 8);
    put_plain(&im, &records);
    const struct outcome o = outcome_of(im.bytes, im.len);
    assert_int_equal(o.count, 1);
    expect_error(&im, "ends without a footer");
}

static void a_flipped_bit_gives_an_error_or_the_same(void **state)
{
    (void)state;
    for (int packed = 0; packed <= (can_unpack() ? 1 : 0); packed++) {
        image im = sample(packed != 0);
        const struct outcome whole = outcome_of(im.bytes, im.len);
        for (size_t bit = 0; bit < 8u * im.len; bit++) {
            im.bytes[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
            const struct outcome o = outcome_of(im.bytes, im.len);
            im.bytes[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
            if (o.last == 0 && o.count != whole.count) {
                fail_msg("bit %zu of byte %zu: %zu records without an error",
                         bit % 8u, bit / 8u, o.count);
            }
            assert_true(begins_alike(&o, &whole, o.count));
            assert_true(o.last == 0 || o.error.text[0] != '\0');
        }
        free(im.bytes);
    }
}

static void a_datagram_may_be_cut_short_and_have_any_length(void **state)
{
    (void)state;
    image im = begin_file();
    put_schemas(&im);
    put_datagram(&im, 1, 4, 100);
    put_datagram(&im, 2, 0, 0);
    put_datagram(&im, 3, DATAGRAM_MAX, DATAGRAM_MAX);
    end_file(&im);
    const struct outcome o = outcome_of(im.bytes, im.len);
    assert_int_equal(o.last, 0);
    assert_int_equal(o.count, 3);
    assert_int_equal(o.records[0].len, HEADERS_BYTES + 4);
    assert_int_equal(o.records[0].whole, HEADERS_BYTES + 100);
    assert_int_equal(o.records[1].len, HEADERS_BYTES);
    assert_int_equal(o.records[2].len, HEADERS_BYTES + DATAGRAM_MAX);
    free(im.bytes);
    im = begin_file();
    put_schemas(&im);
    put_datagram(&im, 1, 4, DATAGRAM_MAX + 1);
    expect_error(&im, "does not hold a datagram");
}

static void what_has_no_datagrams_says_what_it_has(void **state)
{
    (void)state;
    image im = begin_file();
    put_schema(&im, 1, "sensor_msgs/msg/PointCloud2");
    put_channel(&im, CLOUDS, 1, "/topic", "cdr");
    put_cloud(&im, 10);
    end_file(&im);
    expect_error(&im, "only messages such as sensor_msgs/msg/PointCloud2; "
                      "clouds cannot be decoded again");
    im = begin_file();
    end_file(&im);
    expect_error(&im, "and no messages");
    im = begin_file();
    put_schema(&im, 2, SCHEMA);
    put_channel(&im, PACKETS, 2, "/topic", "json");
    put_datagram(&im, 1, 4, 4);
    end_file(&im);
    expect_error(&im, "no packets of a sensor");
}

static image file_with(const struct chunk *c)
{
    image im = begin_file();
    image records = {.bytes = NULL};
    put_schemas(&records);
    put_datagram(&records, 1, 4, 4);
    struct chunk all = *c;
    all.packed = c->packed != 0 ? c->packed : records.len;
    all.unpacked = c->unpacked != 0 ? c->unpacked : records.len;
    put_chunk_as(&im, &records, &all);
    im.messages = 1;
    free(records.bytes);
    end_file(&im);
    return im;
}

static void a_chunk_without_a_check_sum_is_read(void **state)
{
    (void)state;
    const struct chunk c = {"", 0, 0, 0};
    image im = file_with(&c);
    const struct outcome o = outcome_of(im.bytes, im.len);
    assert_int_equal(o.last, 0);
    assert_int_equal(o.count, 1);
    free(im.bytes);
}

static void a_chunk_that_cannot_be_is_refused(void **state)
{
    static const struct {
        struct chunk chunk;
        const char *text;
    } bad[] = {
        {{"", 1, 0, 0}, "its check sum is wrong"},
        {{"lz4", 0, 0, 0}, "by lz4, which is not read: use mcap compress"},
        {{"a\033b", 0, 0, 0}, "by a?b, which"},
        {{"0123456789012345678901234567890123", 0, 0, 0}, "a name of 34 bytes"},
        {{"", 0, 5, 0}, "an uncompressed chunk of 5 bytes has"},
        {{"", 0, 0, 100000}, "a chunk is shorter than what it says it has"},
        {{"", 0, UINT64_MAX, 0}, "at most 67108864 can be read"},
        {{"", 0, (UINT64_C(64) << 20) + 1u, 0}, "at most 67108864 can be read"},
        {{"", 0, 0, UINT64_MAX}, "a chunk is shorter than what it says it has"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        image im = file_with(&bad[i].chunk);
        expect_error(&im, bad[i].text);
    }
}

static void a_packed_chunk_of_another_length_is_refused(void **state)
{
    (void)state;
    for (uint64_t wrong = 0; can_unpack() && wrong < 3u; wrong++) {
        image im = begin_file();
        image records = {.bytes = NULL};
        put_schemas(&records);
        image packed = stored(&records);
        const uint64_t lengths[] = {records.len - 1u, records.len + 1u,
                                    UINT64_C(64) << 20};
        const struct chunk c = {"zstd", 0, lengths[wrong], packed.len};
        put_chunk_as(&im, &packed, &c);
        free(packed.bytes);
        free(records.bytes);
        expect_error(&im, "does not unpack to the");
    }
}

static void a_record_of_a_huge_length_is_refused(void **state)
{
    static const unsigned opcodes[] = {OP_SCHEMA, OP_CHANNEL, OP_CHUNK,
                                       OP_STATISTICS, OP_OWN};
    static const uint64_t lengths[] = {UINT64_MAX, UINT64_MAX - 8u,
                                       UINT64_C(1) << 63, UINT32_MAX, 2000000};
    (void)state;
    for (size_t i = 0; i < 25u; i++) {
        image im = begin_file();
        put_schemas(&im);
        put_datagram(&im, 1, 4, 4);
        const size_t from = begin_record(&im, opcodes[i / 5u]);
        put_int(&im, 1, 8);
        set_int(&im, from + 1u, lengths[i % 5u], 8);
        const struct outcome o = outcome_of(im.bytes, im.len);
        assert_int_equal(o.count, 1);
        expect_error(&im, "byte ");
    }
}

static void records_shorter_than_their_fields_are_refused(void **state)
{
    static const struct {
        unsigned opcode;
        size_t len;
    } bad[] = {{OP_SCHEMA, 0},  {OP_SCHEMA, 1},  {OP_SCHEMA, 9},
               {OP_CHANNEL, 3}, {OP_CHANNEL, 4}, {OP_CHANNEL, 11},
               {OP_MESSAGE, 0}, {OP_MESSAGE, 1}, {OP_CHUNK, 0},
               {OP_CHUNK, 31},  {OP_CHUNK, 39},  {OP_STATISTICS, 7},
               {0, 4}};
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        image im = begin_file();
        put_schemas(&im);
        put_record(&im, bad[i].opcode, bad[i].len);
        end_file(&im);
        expect_error(&im, "byte ");
    }
}

static void bytes_behind_the_end_are_not_passed_over(void **state)
{
    (void)state;
    image im = sample(false);
    put_int(&im, 0, 1);
    expect_error(&im, "there are bytes behind its footer");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(datagrams_of_chunks_are_read),
        cmocka_unit_test(datagrams_without_a_chunk_are_read),
        cmocka_unit_test(a_packet_has_the_headers_it_had),
        cmocka_unit_test(a_file_cut_anywhere_says_so),
        cmocka_unit_test(all_whole_chunks_of_a_cut_file_are_read),
        cmocka_unit_test(a_flipped_bit_gives_an_error_or_the_same),
        cmocka_unit_test(a_datagram_may_be_cut_short_and_have_any_length),
        cmocka_unit_test(what_has_no_datagrams_says_what_it_has),
        cmocka_unit_test(a_chunk_without_a_check_sum_is_read),
        cmocka_unit_test(a_chunk_that_cannot_be_is_refused),
        cmocka_unit_test(a_packed_chunk_of_another_length_is_refused),
        cmocka_unit_test(a_record_of_a_huge_length_is_refused),
        cmocka_unit_test(records_shorter_than_their_fields_are_refused),
        cmocka_unit_test(bytes_behind_the_end_are_not_passed_over),
    };
    return cmocka_run_group_tests(tests, init_crc, NULL);
}
