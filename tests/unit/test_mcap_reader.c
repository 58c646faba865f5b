#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "mcap_image.h"

#include "base/crc32.h"
#include "capture/chunk.h"
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

/* How chunks are compressed. */
static const struct packing {
    const char *library;
    const lum_unpacker *const *unpacker; /* NULL: none is needed */
    void (*put_chunk)(image *im, image *records);
} packings[] = {{"", NULL, put_plain},
                {"libzstd", &lum_unpack_zstd, put_zstd},
                {"liblz4", &lum_unpack_lz4, put_lz4}};

#define PACKINGS (sizeof packings / sizeof packings[0])

static bool can_unpack(const struct packing *p)
{
    return p->unpacker == NULL || *p->unpacker != NULL;
}

/* Three datagrams in two chunks, and what is to be passed over. */
static image sample(const struct packing *p)
{
    image im = begin_file();
    image first = {.bytes = NULL};
    image second = {.bytes = NULL};
    put_schemas(&first);
    put_cloud(&first, 30);
    put_datagram(&first, 1, 8, 8);
    put_datagram(&first, 2, 3, 3);
    put_record(&im, OP_OWN, 3);
    p->put_chunk(&im, &first);
    put_datagram(&second, 3, 5, 5);
    put_cloud(&second, 1);
    p->put_chunk(&im, &second);
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
    uint64_t damaged;
    char first[LUM_ERROR_BYTES]; /* why the first part was passed over */
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

/* A pipe gives a few bytes at a time, and cannot be read from another place. */
static int64_t read_pipe(void *context, void *buffer, size_t room,
                         lum_error *error)
{
    lum_bytes_at *left = context;
    size_t n = left->len < 7u ? left->len : 7u;
    n = n < room ? n : room;
    (void)error;
    if (n != 0) {
        memcpy(buffer, left->at, n);
    }
    left->at += n;
    left->len -= n;
    return (int64_t)n;
}

static struct outcome outcome_from(lum_source *source)
{
    struct outcome o;
    uint32_t link_type = 0;
    const char *first = "";
    memset(&o, 0, sizeof o);
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
    o.damaged = lum_pcap_damaged(reader, &first);
    assert_true((o.damaged != 0) == (first[0] != '\0'));
    strcpy(o.first, first);
    lum_pcap_free(reader);
    lum_source_close(source);
    return o;
}

/* From memory where a byte too far is noticed. */
static struct outcome outcome_of(const uint8_t *bytes, size_t len)
{
    uint8_t *exact = malloc(len != 0 ? len : 1u);
    assert_non_null(exact);
    memcpy(exact, bytes, len);
    const struct outcome o =
        outcome_from(lum_source_from_memory("x.mcap", exact, len));
    free(exact);
    return o;
}

static struct outcome outcome_of_pipe(const image *im)
{
    lum_bytes_at left = {im->bytes, im->len};
    const lum_source_functions f = {
        .struct_size = sizeof f, .read = read_pipe, .context = &left};
    return outcome_from(lum_source_from_functions("pipe", &f, NULL));
}

/* The seconds of its records, as digits. */
static void expect_records(const struct outcome *o, const char *seconds)
{
    assert_int_equal(o->last, 0);
    assert_int_equal(o->count, strlen(seconds));
    for (size_t i = 0; i < o->count; i++) {
        assert_int_equal(o->records[i].time_ns / 1000000000, seconds[i] - '0');
    }
}

static void expect_text(const char *text, const char *part)
{
    if (strstr(text, part) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", text, part);
    }
}

/* Frees the image. */
static void expect_error(image *im, const char *text)
{
    const struct outcome o = outcome_of(im->bytes, im->len);
    assert_int_equal(o.last, -1);
    expect_text(o.error.text, text);
    free(im->bytes);
}

static bool begins_alike(const struct outcome *a, const struct outcome *b,
                         size_t count)
{
    return memcmp(a->records, b->records, count * sizeof a->records[0]) == 0;
}

/* Some of the same, in the same order. */
static bool is_part(const struct outcome *part, const struct outcome *whole)
{
    size_t at = 0;
    for (size_t i = 0; i < part->count; i++, at++) {
        while (at < whole->count &&
               memcmp(&part->records[i], &whole->records[at],
                      sizeof part->records[i]) != 0) {
            at++;
        }
        if (at == whole->count) {
            return false;
        }
    }
    return true;
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

/* --- Tests --- */

static void datagrams_of_chunks_are_read(void **state)
{
    (void)state;
    for (size_t i = 0; i < PACKINGS; i++) {
        image im = sample(&packings[i]);
        if (can_unpack(&packings[i])) {
            check_sample(&im);
            free(im.bytes);
        } else {
            expect_error(&im, packings[i].library);
        }
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
    for (size_t i = 0; i < PACKINGS; i++) {
        if (!can_unpack(&packings[i])) {
            continue;
        }
        image im = sample(&packings[i]);
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
    for (size_t i = 0; i < PACKINGS; i++) {
        if (!can_unpack(&packings[i])) {
            continue;
        }
        image im = sample(&packings[i]);
        const struct outcome whole = outcome_of(im.bytes, im.len);
        for (size_t bit = 0; bit < 8u * im.len; bit++) {
            im.bytes[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
            const struct outcome o = outcome_of(im.bytes, im.len);
            im.bytes[bit / 8u] ^= (uint8_t)(1u << bit % 8u);
            if (o.last == 0 && o.damaged == 0 && o.count != whole.count) {
                fail_msg("bit %zu of byte %zu: %zu records without an error",
                         bit % 8u, bit / 8u, o.count);
            }
            assert_true(is_part(&o, &whole));
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
    put_datagram(&im, 2, 4, 4);
    end_file(&im);
    const struct outcome bad = outcome_of(im.bytes, im.len);
    expect_records(&bad, "2");
    expect_text(bad.first, "does not hold a datagram");
    free(im.bytes);
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

static void a_file_of_nothing_else_is_refused(void **state)
{
    static const struct {
        struct chunk chunk;
        const char *text;
    } bad[] = {
        {{"", 1, 0, 0}, "its check sum is wrong"},
        {{"gzip", 0, 0, 0}, "by gzip, which is not supported"},
        {{"a\033b", 0, 0, 0}, "by a?b, which"},
        {{"0123456789012345678901234567890123", 0, 0, 0}, "a name of 34 bytes"},
        {{"", 0, 5, 0}, "an uncompressed chunk of 5 bytes has"},
        {{"", 0, 0, 100000}, "a chunk is shorter than it declares"},
        {{"", 0, UINT64_MAX, 0}, "at most 67108864 can be read: mcap "},
        {{"", 0, (UINT64_C(64) << 20) + 1u, 0}, "at most 67108864 can be read"},
        {{"", 0, 0, UINT64_MAX}, "a chunk is shorter than it declares"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        image im = file_with(&bad[i].chunk);
        expect_error(&im, bad[i].text);
    }
}

/* --- Damage --- */

/* Changes to a chunk of these records that the reader notices. */
static void put_bad_sum(image *im, const image *records)
{
    const struct chunk c = {"", 1, records->len, records->len};
    put_chunk_as(im, records, &c);
}

static void put_bad_zstd(image *im, const image *records)
{
    image packed = stored(records);
    const struct chunk c = {"zstd", 0, records->len, packed.len};
    packed.bytes[4] ^= 0xffu;
    put_chunk_as(im, &packed, &c);
    free(packed.bytes);
}

static void put_bad_lz4(image *im, const image *records)
{
    image packed = stored_lz4(records);
    const struct chunk c = {"lz4", 0, records->len, packed.len - 4u};
    packed.len -= 4u;
    put_chunk_as(im, &packed, &c);
    free(packed.bytes);
}

static void put_shorter(image *im, const image *records)
{
    image packed = stored(records);
    const struct chunk c = {"zstd", 0, records->len + 1u, packed.len};
    put_chunk_as(im, &packed, &c);
    free(packed.bytes);
}

static void put_longer(image *im, const image *records)
{
    image packed = stored(records);
    const struct chunk c = {"zstd", 0, records->len - 1u, packed.len};
    put_chunk_as(im, &packed, &c);
    free(packed.bytes);
}

static void put_too_large(image *im, const image *records)
{
    const struct chunk c = {"zstd", 0, (UINT64_C(64) << 20) + 1u, records->len};
    put_chunk_as(im, records, &c);
}

static void put_unknown(image *im, const image *records)
{
    const struct chunk c = {"zstE", 0, records->len, records->len};
    put_chunk_as(im, records, &c);
}

static void put_bad_length(image *im, const image *records)
{
    const struct chunk c = {"", 0, records->len + 1u, records->len + 1u};
    put_chunk_as(im, records, &c);
}

static void put_stub(image *im, const image *records)
{
    (void)records;
    put_record(im, OP_CHUNK, 31);
}

/* Its last record ends behind it. */
static void put_overrun(image *im, const image *records)
{
    const struct chunk c = {"", 0, records->len - 1u, records->len - 1u};
    image less = *records;
    less.len--;
    put_chunk_as(im, &less, &c);
}

/* A number in its place. */
static void put_rubbish(image *im, const image *records)
{
    image bytes = {.bytes = NULL};
    for (size_t i = 0; i < records->len; i++) {
        put_int(&bytes, 0xff, 1);
    }
    const struct chunk c = {"", 0, bytes.len, bytes.len};
    put_chunk_as(im, &bytes, &c);
    free(bytes.bytes);
}

static const struct damage {
    void (*put)(image *im, const image *records);
    const char *says;
} damages[] = {{put_bad_sum, "its check sum is wrong"},
               {put_bad_zstd, "zstd"},
               {put_bad_lz4, "lz4"},
               {put_shorter, "a chunk "},
               {put_longer, "a chunk "},
               {put_too_large, "at most 67108864 can be read: mcap "},
               {put_unknown, "by zstE, which is not supported"},
               {put_bad_length, "shorter than it declares"},
               {put_stub, "shorter than it declares"},
               {put_overrun, "longer than the rest of the chunk"},
               {put_rubbish, "longer than the rest of the chunk"}};

#define DAMAGES (sizeof damages / sizeof damages[0])

/* Four chunks of a datagram each, of which some are damaged; the first one has
 * the channels, and the summary again. */
static image with_damage(const struct damage *d, unsigned bad)
{
    image im = begin_file();
    image described = {.bytes = NULL};
    put_schemas(&described);
    for (unsigned i = 0; i < 4u; i++) {
        image records = {.bytes = NULL};
        if (i == 0) {
            put_schemas(&records);
        }
        put_datagram(&records, i, 4, 4);
        if ((bad >> i & 1u) != 0) {
            d->put(&im, &records);
            im.messages++;
            free(records.bytes);
        } else {
            put_plain(&im, &records);
        }
    }
    end_file_with(&im, &described);
    free(described.bytes);
    return im;
}

static void a_damaged_chunk_is_passed_over(void **state)
{
    static const struct {
        unsigned bad;
        uint64_t count;
        const char *left;
    } cases[] = {{1, 1, "123"}, {2, 1, "023"}, {4, 1, "013"},
                 {8, 1, "012"}, {7, 3, "3"},   {5, 2, "13"}};
    (void)state;
    for (size_t i = 0; i < DAMAGES * 6u; i++) {
        const struct damage *d = &damages[i / 6u];
        image im = with_damage(d, cases[i % 6u].bad);
        const struct outcome o = outcome_of(im.bytes, im.len);
        expect_text(o.first, d->says);
        expect_text(o.first, "byte ");
        expect_records(&o, cases[i % 6u].left);
        assert_int_equal(o.damaged, cases[i % 6u].count);
        free(im.bytes);
    }
}

/* What follows cannot be understood there, which is counted. */
static void a_pipe_cannot_look_for_channels_at_the_end(void **state)
{
    (void)state;
    for (size_t i = 0; i < DAMAGES; i++) {
        image im = with_damage(&damages[i], 4);
        struct outcome o = outcome_of_pipe(&im);
        expect_records(&o, "013");
        assert_int_equal(o.damaged, 1);
        free(im.bytes);
        im = with_damage(&damages[i], 1);
        o = outcome_of_pipe(&im);
        if (damages[i].put != put_overrun) {
            assert_int_equal(o.begun, -1);
            assert_int_equal(o.damaged, 4);
        } else { /* its channels could be read */
            expect_records(&o, "123");
            assert_int_equal(o.damaged, 1);
        }
        free(im.bytes);
    }
}

static void where_all_is_damaged_the_first_reason_is_told(void **state)
{
    (void)state;
    for (size_t i = 0; i < DAMAGES; i++) {
        image im = with_damage(&damages[i], 15);
        if (damages[i].put != put_overrun) { /* its channels can be read */
            expect_error(&im, damages[i].says);
        } else {
            free(im.bytes);
        }
    }
}

static void a_damaged_summary_does_no_harm(void **state)
{
    image im = with_damage(&damages[0], 1);
    const size_t footer = im.len - 8u - 20u;
    (void)state;
    for (uint64_t at = 0; at <= im.len + 1u; at++) {
        set_int(&im, footer, at, 8);
        const struct outcome o = outcome_of(im.bytes, im.len);
        assert_true(o.begun == -1 || o.count == 3u);
        assert_true(o.damaged == 1u || o.damaged == 4u);
    }
    free(im.bytes);
}

static void a_cut_file_with_damage_says_both(void **state)
{
    image im = with_damage(&damages[0], 2);
    const struct outcome whole = outcome_of(im.bytes, im.len);
    (void)state;
    for (size_t len = 0; len < im.len; len++) {
        const struct outcome o = outcome_of(im.bytes, len);
        assert_int_equal(o.last, -1);
        assert_true(o.error.text[0] != '\0' && o.damaged <= 1u);
        assert_true(begins_alike(&o, &whole, o.count));
    }
    free(im.bytes);
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

static void records_shorter_than_their_fields_are_passed_over(void **state)
{
    static const struct {
        unsigned opcode;
        size_t len;
    } bad[] = {{OP_SCHEMA, 0},  {OP_SCHEMA, 1},  {OP_SCHEMA, 9},
               {OP_CHANNEL, 3}, {OP_CHANNEL, 4}, {OP_CHANNEL, 11},
               {OP_MESSAGE, 0}, {OP_MESSAGE, 1}, {OP_CHUNK, 0},
               {OP_CHUNK, 31},  {OP_CHUNK, 39},  {OP_STATISTICS, 7}};
    (void)state;
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++) {
        image im = begin_file();
        put_schemas(&im);
        put_record(&im, bad[i].opcode, bad[i].len);
        put_datagram(&im, 1, 4, 4);
        end_file(&im);
        const struct outcome o = outcome_of(im.bytes, im.len);
        expect_records(&o, "1");
        assert_int_equal(o.damaged, 1);
        expect_text(o.first, "shorter than it declares");
        free(im.bytes);
    }
}

static void a_record_of_no_type_ends_the_reading(void **state)
{
    image im = begin_file();
    (void)state;
    put_schemas(&im);
    put_record(&im, 0, 4);
    expect_error(&im, "a record of type 0");
}

static void bytes_behind_the_end_are_not_passed_over(void **state)
{
    (void)state;
    image im = sample(&packings[0]);
    put_int(&im, 0, 1);
    expect_error(&im, "bytes follow its footer");
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
        cmocka_unit_test(a_file_of_nothing_else_is_refused),
        cmocka_unit_test(a_damaged_chunk_is_passed_over),
        cmocka_unit_test(a_pipe_cannot_look_for_channels_at_the_end),
        cmocka_unit_test(where_all_is_damaged_the_first_reason_is_told),
        cmocka_unit_test(a_damaged_summary_does_no_harm),
        cmocka_unit_test(a_cut_file_with_damage_says_both),
        cmocka_unit_test(a_record_of_a_huge_length_is_refused),
        cmocka_unit_test(records_shorter_than_their_fields_are_passed_over),
        cmocka_unit_test(a_record_of_no_type_ends_the_reading),
        cmocka_unit_test(bytes_behind_the_end_are_not_passed_over),
    };
    return cmocka_run_group_tests(tests, init_crc, NULL);
}
