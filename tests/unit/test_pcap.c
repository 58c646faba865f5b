#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "capture/pcap.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    ETHERNET = 1,
    CAN = 227,
    SECTION = 0x0a0d0d0a,
    INTERFACE = 1,
    OBSOLETE_PACKET = 2,
    SIMPLE_PACKET = 3,
    ENHANCED_PACKET = 6,
    UNKNOWN = 0x0bad,
    COMMENT = 1,
    NAME = 2,
    RESOLUTION = 9,
    OFFSET = 14,
    MICRO = (int)0xa1b2c3d4,
    NANO = (int)0xa1b23c4d,
    KUZNETZOV = (int)0xa1b2cd34
};

/* A file in the making; grows. */
typedef struct image {
    uint8_t *bytes;
    size_t len;
    bool is_big;
    size_t block; /* where the one under way begins */
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

static void set_int(const image *im, size_t at, uint64_t value, size_t len)
{
    for (size_t i = 0; i < len; i++) {
        im->bytes[at + (im->is_big ? len - 1u - i : i)] =
            (uint8_t)(value >> (8u * i) & 0xffu);
    }
}

static void put_int(image *im, uint64_t value, size_t len)
{
    static const uint8_t zeros[8];
    put(im, zeros, len);
    set_int(im, im->len - len, value, len);
}

static void begin_block(image *im, uint32_t type)
{
    im->block = im->len;
    put_int(im, type, 4);
    put_int(im, 0, 4);
}

static void end_block(image *im)
{
    while (im->len % 4u != 0) {
        put_int(im, 0, 1);
    }
    put_int(im, 0, 4);
    set_int(im, im->block + 4u, im->len - im->block, 4);
    set_int(im, im->len - 4u, im->len - im->block, 4);
}

static void put_option(image *im, unsigned code, const void *value, size_t len)
{
    put_int(im, code, 2);
    put_int(im, len, 2);
    put(im, value, len);
    while (im->len % 4u != 0) {
        put_int(im, 0, 1);
    }
}

static void put_section(image *im)
{
    begin_block(im, SECTION);
    put_int(im, 0x1a2b3c4d, 4);
    put_int(im, 1, 2);
    put_int(im, 0, 2);
    put_int(im, UINT64_MAX, 8);
    end_block(im);
}

static void begin_interface(image *im, uint32_t link_type, uint32_t snap)
{
    begin_block(im, INTERFACE);
    put_int(im, link_type, 2);
    put_int(im, 0, 2);
    put_int(im, snap, 4);
}

static void put_interface(image *im, uint32_t link_type, uint32_t snap)
{
    begin_interface(im, link_type, snap);
    end_block(im);
}

static void put_resolution(image *im, unsigned resolution)
{
    const uint8_t value = (uint8_t)resolution;
    begin_interface(im, ETHERNET, 0);
    put_option(im, RESOLUTION, &value, 1);
    end_block(im);
}

static void begin_packet(image *im, uint32_t interface, uint64_t time,
                         const char *text, uint32_t whole)
{
    begin_block(im, ENHANCED_PACKET);
    put_int(im, interface, 4);
    put_int(im, time >> 32, 4);
    put_int(im, time & 0xffffffffu, 4);
    put_int(im, strlen(text), 4);
    put_int(im, whole, 4);
    put(im, text, strlen(text));
    while (im->len % 4u != 0) {
        put_int(im, 0, 1);
    }
}

static void put_packet(image *im, uint32_t interface, uint64_t time,
                       const char *text)
{
    begin_packet(im, interface, time, text, (uint32_t)strlen(text));
    end_block(im);
}

static void put_simple(image *im, const char *text, uint32_t whole)
{
    begin_block(im, SIMPLE_PACKET);
    put_int(im, whole, 4);
    put(im, text, strlen(text));
    end_block(im);
}

static void put_obsolete(image *im, unsigned interface, uint64_t time,
                         const char *text)
{
    begin_block(im, OBSOLETE_PACKET);
    put_int(im, interface, 2);
    put_int(im, 0xffff, 2);
    put_int(im, time >> 32, 4);
    put_int(im, time & 0xffffffffu, 4);
    put_int(im, strlen(text), 4);
    put_int(im, strlen(text), 4);
    put(im, text, strlen(text));
    end_block(im);
}

static image pcap(int magic, unsigned version, unsigned minor, uint32_t snap,
                  bool is_big)
{
    image im = {.is_big = is_big};
    put_int(&im, (uint32_t)magic, 4);
    put_int(&im, version, 2);
    put_int(&im, minor, 2);
    put_int(&im, 0, 8);
    put_int(&im, snap, 4);
    put_int(&im, ETHERNET, 4);
    return im;
}

static void put_record(image *im, uint32_t s, uint32_t fraction, uint32_t first,
                       uint32_t second)
{
    put_int(im, s, 4);
    put_int(im, fraction, 4);
    put_int(im, first, 4);
    put_int(im, second, 4);
}

/* A reader of an image, whose bytes are where a byte too far is noticed. */
struct reading {
    uint8_t *exact;
    lum_source *source;
    lum_pcap *reader;
    uint32_t link_type;
    int begun;
    lum_error error;
};

static struct reading reading_of(const image *im, size_t len)
{
    struct reading r = {.exact = malloc(len != 0 ? len : 1u)};
    assert_non_null(r.exact);
    if (len != 0) {
        memcpy(r.exact, im->bytes, len);
    }
    r.source = lum_source_from_memory("x.pcap", r.exact, len);
    assert_non_null(r.source);
    r.reader = lum_pcap_new(r.source);
    assert_non_null(r.reader);
    r.begun = lum_pcap_begin(r.reader, NULL, &r.link_type, &r.error);
    return r;
}

static void end_reading(struct reading *r)
{
    lum_pcap_free(r->reader);
    lum_source_close(r->source);
    free(r->exact);
}

static struct reading begun(const image *im)
{
    struct reading r = reading_of(im, im->len);
    if (r.begun != 1) {
        fail_msg("%s", r.error.text);
    }
    return r;
}

static void expect_packet(struct reading *r, int64_t time_ns, const char *text,
                          uint32_t whole)
{
    lum_pcap_record record;
    if (lum_pcap_next(r->reader, &record, &r->error) != 1) {
        fail_msg("%s", r->error.text);
    }
    assert_true(record.time_ns == time_ns);
    assert_int_equal(record.len, strlen(text));
    assert_memory_equal(record.bytes, text, strlen(text));
    assert_int_equal(record.whole, whole);
}

static void expect_text(const char *text, const char *part)
{
    if (strstr(text, part) == NULL) {
        fail_msg("\"%s\" is not in \"%s\"", part, text);
    }
}

/* With so many blocks that were passed over, the first at a byte. */
static void expect_end_with(struct reading *r, uint64_t damaged, size_t byte,
                            const char *part)
{
    lum_pcap_record record;
    char where[40];
    const char *first = "";
    assert_int_equal(lum_pcap_next(r->reader, &record, &r->error), 0);
    assert_int_equal(lum_pcap_damaged(r->reader, &first), damaged);
    (void)snprintf(where, sizeof where, "byte %zu: ", byte);
    expect_text(first, damaged != 0 ? where : "");
    expect_text(first, part);
    end_reading(r);
}

static void expect_end(struct reading *r)
{
    expect_end_with(r, 0, 0, "");
}

static void expect_failure(struct reading *r, size_t byte, const char *part)
{
    lum_pcap_record record;
    char where[40];
    assert_int_equal(lum_pcap_next(r->reader, &record, &r->error), -1);
    (void)snprintf(where, sizeof where, "byte %zu: ", byte);
    expect_text(r->error.text, where);
    expect_text(r->error.text, part);
    end_reading(r);
}

static void expect_refusal(image *im, const char *part)
{
    struct reading r = reading_of(im, im->len);
    assert_int_equal(r.begun, -1);
    expect_text(r.error.text, part);
    end_reading(&r);
    free(im->bytes);
}

static void pcap_of_all_kinds_is_read(void **state)
{
    static const struct {
        int magic;
        int64_t ns;
        size_t more;
    } kinds[] = {{MICRO, 1000, 0}, {NANO, 1, 0}, {KUZNETZOV, 1000, 8}};
    (void)state;
    for (size_t i = 0; i < 6; i++) {
        image im = pcap(kinds[i / 2u].magic, 2, 4, 0, i % 2u != 0);
        put_record(&im, 5, 999999, 3, 60);
        put_int(&im, 0, kinds[i / 2u].more);
        put(&im, "one", 3);
        put_record(&im, UINT32_MAX, UINT32_MAX, 0, 0);
        put_int(&im, 0, kinds[i / 2u].more);
        struct reading r = begun(&im);
        assert_int_equal(r.link_type, ETHERNET);
        expect_packet(&r, 5000000000 + 999999 * kinds[i / 2u].ns, "one", 60);
        expect_packet(&r,
                      UINT32_MAX * INT64_C(1000000000) +
                          UINT32_MAX * kinds[i / 2u].ns,
                      "", 0);
        expect_end(&r);
        free(im.bytes);
    }
}

static void old_versions_have_their_lengths_the_other_way(void **state)
{
    static const struct {
        unsigned version;
        unsigned minor;
        uint32_t first;
        uint32_t second;
    } versions[] = {{2, 0, 60, 3}, {2, 2, 60, 3}, {2, 3, 60, 3},  {2, 3, 4, 3},
                    {2, 3, 3, 60}, {2, 4, 3, 60}, {543, 0, 60, 3}};
    (void)state;
    for (size_t i = 0; i < sizeof versions / sizeof versions[0]; i++) {
        image im =
            pcap(MICRO, versions[i].version, versions[i].minor, 0, false);
        put_record(&im, 1, 0, versions[i].first, versions[i].second);
        put(&im, "one", 3);
        struct reading r = begun(&im);
        expect_packet(&r, 1000000000, "one",
                      versions[i].first + versions[i].second - 3u);
        expect_end(&r);
        free(im.bytes);
    }
}

static void unknown_versions_are_refused(void **state)
{
    static const unsigned versions[][2] = {{1, 4}, {2, 5}, {3, 0}, {543, 1}};
    (void)state;
    for (size_t i = 0; i < sizeof versions / sizeof versions[0]; i++) {
        image im = pcap(MICRO, versions[i][0], versions[i][1], 0, false);
        expect_refusal(&im, "2.0 to 2.4 can be read");
    }
}

static void a_record_is_as_long_as_it_says(void **state)
{
    static const uint32_t snaps[] = {0, 2, 19, 20, UINT32_MAX};
    (void)state;
    for (size_t i = 0; i < 2u * (sizeof snaps / sizeof snaps[0]); i++) {
        const bool is_longer = i % 2u != 0;
        image im =
            pcap(is_longer ? KUZNETZOV : MICRO, 2, 4, snaps[i / 2u], false);
        put_record(&im, 1, 0, 20, 22);
        put_int(&im, 0, is_longer ? 8 : 0);
        put(&im, "0123456789abcdefghij", 20);
        struct reading r = begun(&im);
        expect_packet(&r, 1000000000, "0123456789abcdefghij", 22);
        expect_end(&r);
        free(im.bytes);
    }
}

static void a_pcap_record_has_a_longest(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 2; i++) {
        image im = pcap(MICRO, 2, 4, 0, false);
        lum_pcap_record record;
        const uint32_t len = LUM_PCAP_BYTES_MAX + i;
        put_record(&im, 1, 0, len, len);
        uint8_t *bytes = calloc(1, len);
        put(&im, bytes, len);
        free(bytes);
        struct reading r = begun(&im);
        if (i == 0) {
            assert_int_equal(lum_pcap_next(r.reader, &record, &r.error), 1);
            assert_int_equal(record.len, len);
            expect_end(&r);
        } else {
            expect_failure(&r, 24, "at most 262144");
        }
        free(im.bytes);
    }
}

static void zeros_are_no_record(void **state)
{
    image im = pcap(MICRO, 2, 4, 0, false);
    (void)state;
    put_record(&im, 0, 1, 0, 0);
    put_record(&im, 0, 0, 0, 0);
    struct reading r = begun(&im);
    expect_packet(&r, 1000, "", 0);
    expect_failure(&r, 40, "zeros");
    free(im.bytes);
}

static image pcapng(bool is_big)
{
    image im = {.is_big = is_big};
    put_section(&im);
    put_interface(&im, ETHERNET, 0);
    return im;
}

static void all_packet_blocks_are_read(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        image im = pcapng(i != 0);
        put_packet(&im, 0, UINT64_C(1700000000123456), "enhanced");
        put_simple(&im, "simple", 6);
        put_obsolete(&im, 0, UINT64_C(0x100000000), "old");
        struct reading r = begun(&im);
        expect_packet(&r, INT64_C(1700000000123456000), "enhanced", 8);
        expect_packet(&r, 0, "simple", 6);
        expect_packet(&r, INT64_C(0x100000000) * 1000, "old", 3);
        expect_end(&r);
        free(im.bytes);
    }
}

static void a_simple_packet_is_cut_by_its_interface(void **state)
{
    image im = {.len = 0};
    (void)state;
    put_section(&im);
    put_interface(&im, ETHERNET, 5);
    put_simple(&im, "simpl", 60);
    put_simple(&im, "sim", 3);
    put_simple(&im, "longer than 5", 13); /* its bytes are there all the same */
    struct reading r = begun(&im);
    expect_packet(&r, 0, "simpl", 60);
    expect_packet(&r, 0, "sim", 3);
    expect_packet(&r, 0, "longer than 5", 13);
    expect_end(&r);
    free(im.bytes);
}

static void an_interface_has_its_name_or_its_number(void **state)
{
    static const char longest[] = "0123456789012345678901234567890123456789"
                                  "01234567890123456789012";
    static const struct {
        const char *bytes; /* NULL: none is stated */
        size_t len;
        const char *name;
    } cases[] = {
        {NULL, 0, "0"},
        {"eth0", 4, "eth0"},
        {"eth0", 5, "eth0"}, /* with its NUL */
        {"", 0, "3"},
        {"\\Device\\NPF_{1B}", 16, "\\Device\\NPF_{1B}"},
        {"Local Area", 10, "5"},
        {"\xc3\xa4", 2, "6"},
        {"a\0b", 3, "7"},
        {longest, 63, longest},
        {longest, 64, longest}, /* with its NUL */
        {"0123456789012345678901234567890123456789012345678901234567890123", 64,
         "10"},
    };
    const size_t count = sizeof cases / sizeof cases[0];
    image im = {.len = 0};
    lum_pcap_record record;
    (void)state;
    put_section(&im);
    for (size_t i = 0; i < count; i++) {
        begin_interface(&im, ETHERNET, 0);
        if (cases[i].bytes != NULL) {
            put_option(&im, NAME, cases[i].bytes, cases[i].len);
        }
        end_block(&im);
    }
    for (uint32_t i = 0; i < count; i++) {
        put_packet(&im, i, 0, "x");
    }
    put_simple(&im, "x", 1);
    struct reading r = begun(&im);
    for (size_t i = 0; i <= count; i++) {
        assert_int_equal(lum_pcap_next(r.reader, &record, &r.error), 1);
        assert_string_equal(record.name, cases[i % count].name);
    }
    expect_end(&r);
    free(im.bytes);
    im = pcap(MICRO, 2, 4, 0, false);
    put_record(&im, 1, 0, 0, 0);
    r = begun(&im);
    assert_int_equal(lum_pcap_next(r.reader, &record, &r.error), 1);
    assert_null(record.name);
    expect_end(&r);
    free(im.bytes);
}

static void each_interface_has_its_link_and_limits(void **state)
{
    static const uint32_t links[] = {CAN, ETHERNET, 65535};
    image im = {.len = 0};
    (void)state;
    put_section(&im);
    for (uint32_t i = 0; i < 3; i++) {
        put_interface(&im, links[i], 100 * i);
    }
    for (uint32_t i = 0; i < 3; i++) {
        put_packet(&im, 2 - i, i, "x");
    }
    struct reading r = begun(&im);
    assert_int_equal(r.link_type, CAN);
    for (uint32_t i = 0; i < 3; i++) {
        lum_pcap_record record;
        assert_int_equal(lum_pcap_next(r.reader, &record, &r.error), 1);
        assert_int_equal(record.interface, 2 - i);
        assert_int_equal(record.link_type, links[2 - i]);
    }
    assert_int_equal(r.reader->interfaces[2].snap, 200);
    expect_end(&r);
    free(im.bytes);
}

static bool is_can(uint32_t link_type)
{
    return link_type == CAN;
}

static int begin_for_can(const image *im, uint32_t *link_type)
{
    lum_error error;
    lum_source *s = lum_source_from_memory("x", im->bytes, im->len);
    assert_non_null(s);
    lum_pcap *reader = lum_pcap_new(s);
    assert_non_null(reader);
    const int result = lum_pcap_begin(reader, is_can, link_type, &error);
    lum_pcap_free(reader);
    lum_source_close(s);
    return result;
}

static void a_wanted_link_is_looked_for_up_to_the_first_packet(void **state)
{
    image im = pcapng(false);
    uint32_t link_type = 0;
    (void)state;
    assert_int_equal(begin_for_can(&im, &link_type), 0);
    assert_int_equal(link_type, ETHERNET);
    const size_t before = im.len;
    put_interface(&im, CAN, 0);
    assert_int_equal(begin_for_can(&im, &link_type), 1);
    assert_int_equal(link_type, CAN);
    im.len = before;
    put_packet(&im, 0, 0, "x");
    put_interface(&im, CAN, 0);
    assert_int_equal(begin_for_can(&im, &link_type), 2);
    assert_int_equal(link_type, ETHERNET);
    free(im.bytes);
}

static void times_are_in_units_of_their_interface(void **state)
{
    static const struct {
        unsigned resolution;
        uint64_t time;
        int64_t ns;
    } times[] = {
        {0, 4499999999, INT64_C(4499999999000000000)},
        {0, 4500000000, INT64_C(4500000000000000000)},
        {0, UINT64_MAX, INT64_C(4500000000000000000)},
        {3, 1234, 1234000000},
        {6, UINT64_MAX, INT64_C(4500000000000000000)},
        {9, UINT64_C(1700000000123456789), INT64_C(1700000000123456789)},
        {12, UINT64_C(1999999999999), 1999999999},
        {19, UINT64_C(10000000000000000000), 1000000000},
        {19, UINT64_MAX, 1844674407},
        {0x80, 7, 7000000000},
        {0x81, 3, 1500000000},
        {0x9e, (UINT64_C(1) << 31) + 1, 2000000000},
        {0xa0, (UINT64_C(1) << 32) + (UINT64_C(1) << 31), 1500000000},
        {0xa2, (UINT64_C(1) << 34) - 1, 999999999},
        {0xa3, (UINT64_C(1) << 35) - 1, 999999999},
        {0xbf, (UINT64_C(1) << 63) - 1, 999999999},
        {0xbf, UINT64_MAX, 1999999999},
        {0xbf, UINT64_C(3) << 62, 1500000000},
    };
    (void)state;
    for (size_t i = 0; i < sizeof times / sizeof times[0]; i++) {
        image im = {.is_big = i % 2u != 0};
        put_section(&im);
        put_resolution(&im, times[i].resolution);
        put_packet(&im, 0, times[i].time, "x");
        struct reading r = begun(&im);
        expect_packet(&r, times[i].ns, "x", 1);
        expect_end(&r);
        free(im.bytes);
    }
}

static void an_offset_is_added(void **state)
{
    static const struct {
        int64_t offset_s;
        uint64_t time;
        int64_t ns;
    } times[] = {
        {-1, 3, 2000000000},
        {-3, 1, -2000000000},
        {1700000000, 0, INT64_C(1700000000000000000)},
        {INT64_MAX, UINT64_MAX, INT64_C(4500000000000000000)},
        {INT64_MIN, 5, INT64_C(-4500000000000000000)},
        {INT64_MIN, UINT64_C(0x8000000000000007), 7000000000},
        {-1, 4500000003, INT64_C(4500000000000000000)},
        {1, 4500000001, INT64_C(4500000000000000000)},
        {-4500000003, 0, INT64_C(-4500000000000000000)},
        {-4500000000, 0, INT64_C(-4500000000000000000)},
        {-4499999999, 0, INT64_C(-4499999999000000000)},
        {1, UINT64_MAX, INT64_C(4500000000000000000)},
    };
    (void)state;
    for (size_t i = 0; i < sizeof times / sizeof times[0]; i++) {
        image im = {.is_big = i % 2u != 0};
        const uint8_t seconds = 0;
        put_section(&im);
        begin_interface(&im, ETHERNET, 0);
        put_option(&im, RESOLUTION, &seconds, 1);
        put_int(&im, OFFSET, 2);
        put_int(&im, 8, 2);
        put_int(&im, (uint64_t)times[i].offset_s, 8);
        put_option(&im, 0, NULL, 0);
        end_block(&im);
        put_packet(&im, 0, times[i].time, "x");
        struct reading r = begun(&im);
        expect_packet(&r, times[i].ns, "x", 1);
        expect_end(&r);
        free(im.bytes);
    }
}

static void what_cannot_be_a_time_is_refused(void **state)
{
    static const struct {
        unsigned code;
        size_t len;
        uint8_t first;
        const char *says;
    } options[] = {
        {RESOLUTION, 1, 20, "resolution"}, {RESOLUTION, 1, 0xc0, "resolution"},
        {RESOLUTION, 2, 6, "resolution"},  {RESOLUTION, 0, 0, "resolution"},
        {OFFSET, 7, 0, "offset"},          {OFFSET, 9, 0, "offset"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof options / sizeof options[0]; i++) {
        image im = {.len = 0};
        uint8_t value[12] = {0};
        value[0] = options[i].first;
        put_section(&im);
        begin_interface(&im, ETHERNET, 0);
        put_option(&im, options[i].code, value, options[i].len);
        end_block(&im);
        expect_refusal(&im, options[i].says);
    }
    image im = {.len = 0};
    put_section(&im);
    begin_interface(&im, ETHERNET, 0);
    put_option(&im, RESOLUTION, "\6", 1);
    put_option(&im, RESOLUTION, "\6", 1);
    end_block(&im);
    expect_refusal(&im, "two");
}

static void sections_have_their_own_order_and_interfaces(void **state)
{
    image im = {.len = 0};
    (void)state;
    put_section(&im);
    put_interface(&im, ETHERNET, 0);
    put_interface(&im, CAN, 0);
    put_packet(&im, 1, 1, "one");
    im.is_big = true;
    put_section(&im);
    put_interface(&im, ETHERNET, 0);
    put_packet(&im, 0, 2, "two");
    const size_t bad = im.len;
    put_packet(&im, 1, 3, "three");
    put_packet(&im, 0, 4, "four");
    struct reading r = begun(&im);
    expect_packet(&r, 1000, "one", 3);
    expect_packet(&r, 2000, "two", 3);
    expect_packet(&r, 4000, "four", 4);
    expect_end_with(&r, 1, bad, "interface 1; its section has 1");
    free(im.bytes);
}

static void a_section_without_interfaces_has_no_packets(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        image im = pcapng(false);
        put_section(&im);
        const size_t bad = im.len;
        if (i == 0) {
            put_simple(&im, "x", 1);
        } else {
            put_packet(&im, 0, 0, "x");
        }
        struct reading r = begun(&im);
        expect_end_with(&r, 1, bad, "interface 0; its section has 0");
        free(im.bytes);
    }
}

static void a_section_of_another_version_is_refused(void **state)
{
    image im = pcapng(false);
    (void)state;
    im.bytes[12] = 2;
    expect_refusal(&im, "version 2");
}

/* A block of so many bytes, of which both ends say so. */
static void put_block(image *im, uint32_t type, size_t len)
{
    uint8_t *zeros = calloc(1, len);
    assert_non_null(zeros);
    begin_block(im, type);
    put(im, zeros, len - 12u);
    end_block(im);
    free(zeros);
}

/* Too short, or of another version. */
static void put_bad_section(image *im, bool is_short)
{
    const size_t from = im->len;
    if (is_short) {
        begin_block(im, SECTION);
        put_int(im, 0x1a2b3c4d, 4);
        put_int(im, 1, 8);
        end_block(im);
    } else {
        put_section(im);
        im->bytes[from + 12u] = 2;
    }
}

static void a_section_whose_header_is_damaged_is_passed_over(void **state)
{
    (void)state;
    for (int is_short = 0; is_short < 2; is_short++) {
        image im = pcapng(false);
        const size_t bad = im.len;
        put_bad_section(&im, is_short != 0);
        put_interface(&im, ETHERNET, 0);
        put_packet(&im, 0, 1, "lost");
        put_simple(&im, "lost", 4);
        put_section(&im);
        put_interface(&im, ETHERNET, 0);
        put_packet(&im, 0, 2, "good");
        struct reading r = begun(&im);
        expect_packet(&r, 2000, "good", 4);
        expect_end_with(&r, 4, bad,
                        is_short != 0 ? "too few for it" : "version 2");
        free(im.bytes);
    }
}

/* More than the window holds, too. */
static void what_is_unknown_is_skipped(void **state)
{
    static const size_t lens[] = {0, 4, 1000, 40u * 1024u * 1024u};
    image im = {.len = 0};
    (void)state;
    put_section(&im);
    for (size_t i = 0; i < sizeof lens / sizeof lens[0]; i++) {
        uint8_t *bytes = calloc(1, lens[i] + 1u);
        assert_non_null(bytes);
        begin_block(&im, UNKNOWN + (uint32_t)i);
        put(&im, bytes, lens[i]);
        end_block(&im);
        free(bytes);
        if (i == 0) {
            put_interface(&im, ETHERNET, 0);
        }
        put_packet(&im, 0, i, "x");
    }
    struct reading r = begun(&im);
    for (int64_t i = 0; i < 4; i++) {
        expect_packet(&r, i * 1000, "x", 1);
    }
    expect_end(&r);
    free(im.bytes);
}

static void ten_thousand_interfaces_are_read(void **state)
{
    image im = {.len = 0};
    (void)state;
    put_section(&im);
    for (uint32_t i = 0; i < 10000; i++) {
        put_interface(&im, i % 2u != 0 ? ETHERNET : CAN, 0);
    }
    put_packet(&im, 9999, 1, "last");
    put_packet(&im, 0, 2, "first");
    struct reading r = begun(&im);
    expect_packet(&r, 1000, "last", 4);
    expect_packet(&r, 2000, "first", 5);
    expect_end(&r);
    free(im.bytes);
}

static void interfaces_without_end_are_refused(void **state)
{
    image im = {.len = 0};
    (void)state;
    put_section(&im);
    put_interface(&im, ETHERNET, 0);
    const size_t first = im.len - 20u;
    uint8_t block[20];
    memcpy(block, im.bytes + first, sizeof block);
    uint8_t *many = malloc((size_t)LUM_PCAPNG_INTERFACES_MAX * sizeof block);
    assert_non_null(many);
    for (size_t i = 0; i < LUM_PCAPNG_INTERFACES_MAX; i++) {
        memcpy(many + i * sizeof block, block, sizeof block);
    }
    put(&im, many, (size_t)LUM_PCAPNG_INTERFACES_MAX * sizeof block);
    free(many);
    struct reading r = begun(&im);
    expect_failure(&r, im.len - 20u, "more than 65536 interfaces");
    free(im.bytes);
}

/* The bytes after a good packet, and the message about them. */
static void blocks_of_no_certain_length_end_the_reading(void **state)
{
    static const struct {
        uint32_t type;
        uint32_t len;
        const char *says;
    } blocks[] = {
        {ENHANCED_PACKET, 0, "a block of 0 bytes"},
        {ENHANCED_PACKET, 8, "a block of 8 bytes"},
        {ENHANCED_PACKET, 11, "a block of 11 bytes"},
        {ENHANCED_PACKET, 33, "a block of 33 bytes"},
        {ENHANCED_PACKET, 0xffffffff, "a block of 4294967295 bytes"},
        {ENHANCED_PACKET, 0xfffffffc, "of its 4294967292 bytes are there"},
        {ENHANCED_PACKET, 16777220, "of its 16777220 bytes are there"},
        {ENHANCED_PACKET, 16777216, "of its 16777216 bytes are there"},
        {UNKNOWN, 0xffffffff, "a block of 4294967295 bytes"},
        {UNKNOWN, 0xfffffffc, "of its 4294967292 bytes are there"},
        {UNKNOWN, 0, "a block of 0 bytes"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof blocks / sizeof blocks[0]; i++) {
        image im = pcapng(i % 2u != 0);
        put_packet(&im, 0, 1, "good");
        const size_t bad = im.len;
        put_int(&im, blocks[i].type, 4);
        put_int(&im, blocks[i].len, 4);
        for (int k = 0; k < 32; k += 4) { /* also where the trailer may be */
            put_int(&im, blocks[i].len, 4);
        }
        struct reading r = begun(&im);
        expect_packet(&r, 1000, "good", 4);
        expect_failure(&r, bad, blocks[i].says);
        free(im.bytes);
    }
}

/* The first, one between others, and the last of a file. */
static void damaged_blocks_are_passed_over(void **state)
{
    static const struct {
        uint32_t type;
        size_t len;
        const char *says;
    } blocks[] = {{ENHANCED_PACKET, 28, "too few for it"},
                  {SIMPLE_PACKET, 12, "too few for it"},
                  {OBSOLETE_PACKET, 28, "too few for it"},
                  {INTERFACE, 16, "too few for it"},
                  {ENHANCED_PACKET, (16u << 20) + 4u, "at most 16777216"}};
    (void)state;
    for (size_t i = 0; i < 5u * 3u; i++) {
        image im = pcapng(i % 2u != 0);
        const size_t at = i % 3u;
        size_t bad = 0;
        for (size_t k = 0; k < 3u; k++) {
            if (k == at) {
                bad = im.len;
                put_block(&im, blocks[i / 3u].type, blocks[i / 3u].len);
            } else {
                put_packet(&im, 0, k, "good");
            }
        }
        struct reading r = begun(&im);
        expect_packet(&r, at == 0 ? 1000 : 0, "good", 4);
        expect_packet(&r, at == 2 ? 1000 : 2000, "good", 4);
        expect_end_with(&r, 1, bad, blocks[i / 3u].says);
        free(im.bytes);
    }
}

/* Options that end behind it, or say what cannot be. */
static void put_bad_interface(image *im, int how)
{
    begin_interface(im, ETHERNET, 0);
    if (how == 0) {
        put_int(im, COMMENT, 2);
        put_int(im, 5, 2);
    } else {
        put_option(im, RESOLUTION, "\x14", 1);
    }
    end_block(im);
}

/* Its packets are lost, and those of the next one are not taken for them. */
static void a_damaged_interface_keeps_its_place(void **state)
{
    (void)state;
    for (int how = 0; how < 2; how++) {
        for (int is_late = 0; is_late < 2; is_late++) {
            image im = {.len = 0};
            put_section(&im);
            if (is_late != 0) {
                put_resolution(&im, 6);
            }
            const size_t bad = im.len;
            put_bad_interface(&im, how);
            if (is_late == 0) {
                put_resolution(&im, 6);
            }
            put_packet(&im, (uint32_t)is_late, 1, "lost");
            put_packet(&im, 1u - (uint32_t)is_late, 2, "good");
            put_packet(&im, (uint32_t)is_late, 3, "lost");
            struct reading r = begun(&im);
            expect_packet(&r, 2000, "good", 4);
            expect_end_with(&r, 3, bad, how == 0 ? "cut short" : "resolution");
            free(im.bytes);
        }
    }
}

static void a_capture_of_a_damaged_interface_is_refused(void **state)
{
    (void)state;
    for (int has_packet = 0; has_packet < 2; has_packet++) {
        image im = {.len = 0};
        put_section(&im);
        put_bad_interface(&im, 0);
        if (has_packet != 0) {
            put_packet(&im, 0, 1, "lost");
        }
        expect_refusal(&im, "options are cut short");
    }
}

/* What was described before a place comes with it, lost ones too. */
static void damage_counts_once_where_a_file_is_read_again(void **state)
{
    image im = pcapng(false);
    lum_pack to = {.written = NULL};
    (void)state;
    const size_t bad = im.len;
    put_bad_interface(&im, 0);
    put_packet(&im, 0, 1, "first");
    put_packet(&im, 1, 2, "lost");
    put_packet(&im, 0, 3, "good");
    struct reading r = begun(&im);
    expect_packet(&r, 1000, "first", 5);
    const uint64_t place = lum_source_offset(r.source);
    assert_true(lum_pcap_pack(r.reader, &to));
    expect_packet(&r, 3000, "good", 4);
    for (int i = 0; i < 2; i++) {
        lum_pack from = lum_pack_of(to.written, to.len);
        assert_int_equal(lum_source_seek(r.source, place, NULL), 0);
        assert_true(lum_pcap_pack(r.reader, &from));
        expect_packet(&r, 3000, "good", 4);
    }
    lum_pack_reset(&to);
    expect_end_with(&r, 2, bad, "cut short");
    free(im.bytes);
}

static void both_lengths_of_a_block_agree(void **state)
{
    static const uint32_t types[] = {SECTION, INTERFACE, ENHANCED_PACKET,
                                     UNKNOWN};
    (void)state;
    for (size_t i = 0; i < 2u * (sizeof types / sizeof types[0]); i++) {
        image im = pcapng(false);
        put_packet(&im, 0, 1, "good");
        const size_t bad = im.len;
        const uint32_t type = types[i / 2u];
        if (type == SECTION) {
            put_section(&im);
        } else if (type == INTERFACE) {
            put_interface(&im, ETHERNET, 0);
        } else if (type == ENHANCED_PACKET) {
            put_packet(&im, 0, 2, "bad");
        } else {
            begin_block(&im, UNKNOWN);
            end_block(&im);
        }
        im.bytes[im.len - 4u] =
            (uint8_t)(im.bytes[im.len - 4u] + (i % 2u != 0 ? 4 : -4));
        struct reading r = begun(&im);
        expect_packet(&r, 1000, "good", 4);
        expect_failure(&r, bad, "at its end");
        free(im.bytes);
    }
}

static void a_packet_stays_within_its_block(void **state)
{
    (void)state;
    for (uint32_t type = OBSOLETE_PACKET; type <= ENHANCED_PACKET; type++) {
        if (type == 4 || type == 5) {
            continue;
        }
        image im = pcapng(false);
        const size_t bad = im.len;
        size_t length = bad + 20u;
        if (type == SIMPLE_PACKET) {
            put_simple(&im, "1234", 4);
            length = bad + 8u;
        } else if (type == OBSOLETE_PACKET) {
            put_obsolete(&im, 0, 0, "1234");
        } else {
            put_packet(&im, 0, 0, "1234");
        }
        im.bytes[length]++;
        put_packet(&im, 0, 1, "good");
        struct reading r = begun(&im);
        expect_packet(&r, 1000, "good", 4);
        expect_end_with(&r, 1, bad,
                        "a packet of 5 bytes in a block with room for");
        free(im.bytes);
    }
}

static void a_packet_before_an_interface_is_no_capture(void **state)
{
    (void)state;
    for (int i = 0; i < 3; i++) {
        image im = {.len = 0};
        put_section(&im);
        if (i == 0) {
            put_packet(&im, 0, 0, "x");
        } else if (i == 1) {
            put_simple(&im, "x", 1);
        }
        expect_refusal(&im, "no interface");
    }
}

static void interface_options_that_are_cut_are_refused(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        image im = {.len = 0};
        put_section(&im);
        begin_interface(&im, ETHERNET, 0);
        put_int(&im, COMMENT, 2);
        put_int(&im, i == 0 ? 5 : 65535, 2);
        put_int(&im, 0, 4);
        end_block(&im);
        expect_refusal(&im, "cut short");
    }
}

/* Nothing is cut short where the source fails between two packets. */
static void a_source_that_fails_says_why(void **state)
{
    (void)state;
    for (int is_pcapng = 0; is_pcapng < 2; is_pcapng++) {
        image im = is_pcapng != 0 ? pcapng(false) : pcap(MICRO, 2, 4, 0, false);
        struct reading r = begun(&im);
        char text[80];
        (void)snprintf(text, sizeof text, "byte %zu: the store is gone",
                       im.len);
        r.source->has_failed = true;
        (void)lum_error_set(&r.source->error, "the store is gone");
        lum_pcap_record record;
        assert_int_equal(lum_pcap_next(r.reader, &record, &r.error), -1);
        assert_string_equal(r.error.text, text);
        end_reading(&r);
        free(im.bytes);
    }
}

/* Golden records, all kinds of blocks. */
static image everything(bool is_big, bool is_pcapng)
{
    image im = pcap(MICRO, 2, 4, 0, is_big);
    for (uint32_t i = 1; i <= 3 && !is_pcapng; i++) {
        put_record(&im, 0, i, 5, 5);
        put(&im, "bytes", 5);
    }
    if (is_pcapng) {
        im.len = 0;
        put_section(&im);
        begin_block(&im, UNKNOWN);
        put_int(&im, 7, 8);
        end_block(&im);
        put_resolution(&im, 6);
        put_packet(&im, 0, 1, "bytes");
        put_section(&im);
        put_resolution(&im, 6);
        put_obsolete(&im, 0, 2, "bytes");
        put_packet(&im, 0, 3, "bytes");
    }
    return im;
}

/* A prefix gives its complete records, and reports the incomplete one. */
static void every_truncation_keeps_what_is_before_it(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        image im = everything(i % 2 != 0, i / 2 != 0);
        int64_t most = 0;
        for (size_t len = 0; len <= im.len; len++) {
            struct reading r = reading_of(&im, len);
            lum_pcap_record record;
            int64_t count = 0;
            int result = r.begun;
            while (result == 1 &&
                   (result = lum_pcap_next(r.reader, &record, &r.error)) == 1) {
                count++;
                assert_true(record.time_ns == count * 1000);
                assert_int_equal(record.len, 5);
                assert_memory_equal(record.bytes, "bytes", 5);
            }
            assert_true(count >= most && count <= most + 1);
            assert_true(result == 0 || r.error.text[0] != '\0');
            most = count;
            end_reading(&r);
        }
        assert_int_equal(most, 3);
        free(im.bytes);
    }
}

/* The same bytes from memory and from pieces of any size. */
struct pieces {
    const image *im;
    size_t at;
    size_t piece;
};

static int64_t read_piece(void *context, void *buffer, size_t room,
                          lum_error *error)
{
    struct pieces *p = context;
    size_t n = p->im->len - p->at;
    (void)error;
    n = n < p->piece ? n : p->piece;
    n = n < room ? n : room;
    memcpy(buffer, p->im->bytes + p->at, n);
    p->at += n;
    return (int64_t)n;
}

static void pieces_of_any_size_give_the_same(void **state)
{
    (void)state;
    for (size_t i = 0; i < 8; i++) {
        image im = everything(i % 2u != 0, i / 4u != 0);
        struct pieces p = {&im, 0, i / 2u % 2u != 0 ? 1 : 17};
        struct reading r = {.exact = NULL};
        r.source = lum_source_from_functions(
            "pieces",
            &(lum_source_functions){.struct_size = sizeof(lum_source_functions),
                                    .read = read_piece,
                                    .context = &p},
            NULL);
        assert_non_null(r.source);
        r.reader = lum_pcap_new(r.source);
        assert_non_null(r.reader);
        assert_int_equal(lum_pcap_begin(r.reader, NULL, &r.link_type, &r.error),
                         1);
        for (int64_t k = 1; k <= 3; k++) {
            expect_packet(&r, k * 1000, "bytes", 5);
        }
        expect_end(&r);
        free(im.bytes);
    }
}

/* place, code, length and first byte of each option, as text */
static void note(void *context, lum_pcap_place place, unsigned code,
                 const uint8_t *value, size_t len)
{
    char *text = context;
    const size_t used = strlen(text);
    (void)snprintf(text + used, 200 - used, "%d:%u:%zu:%c ", (int)place, code,
                   len, len != 0 ? value[0] : '-');
}

static void options_are_handed_out_where_they_stand(void **state)
{
    image im = {.is_big = true};
    char text[200] = "";
    uint32_t link_type = 0;
    lum_pcap_record record;
    lum_error error;
    (void)state;
    begin_block(&im, SECTION);
    put_int(&im, 0x1a2b3c4d, 4);
    put_int(&im, 1, 2);
    put_int(&im, 0, 2);
    put_int(&im, UINT64_MAX, 8);
    put_option(&im, COMMENT, "Section", 7);
    put_option(&im, 4, "Program", 7);
    put_option(&im, 0, NULL, 0);
    put_option(&im, COMMENT, "behind the end", 14);
    end_block(&im);
    begin_interface(&im, ETHERNET, 0);
    put_option(&im, COMMENT, "Interface", 9);
    end_block(&im);
    begin_packet(&im, 0, 1, "12345", 5);
    put_option(&im, COMMENT, "Packet", 6);
    put_int(&im, COMMENT, 2); /* is cut short */
    put_int(&im, 100, 2);
    end_block(&im);
    lum_source *s = lum_source_from_memory("x", im.bytes, im.len);
    assert_non_null(s);
    lum_pcap *reader = lum_pcap_new(s);
    assert_non_null(reader);
    lum_pcap_take_options(reader, note, text);
    assert_int_equal(lum_pcap_begin(reader, NULL, &link_type, &error), 1);
    assert_string_equal(text, "0:1:7:S 0:4:7:P 1:1:9:I ");
    assert_int_equal(lum_pcap_next(reader, &record, &error), 1);
    assert_string_equal(text, "0:1:7:S 0:4:7:P 1:1:9:I 2:1:6:P ");
    lum_pcap_free(reader);
    lum_pcap_free(NULL);
    lum_source_close(s);
    free(im.bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pcap_of_all_kinds_is_read),
        cmocka_unit_test(old_versions_have_their_lengths_the_other_way),
        cmocka_unit_test(unknown_versions_are_refused),
        cmocka_unit_test(a_record_is_as_long_as_it_says),
        cmocka_unit_test(a_pcap_record_has_a_longest),
        cmocka_unit_test(zeros_are_no_record),
        cmocka_unit_test(all_packet_blocks_are_read),
        cmocka_unit_test(a_simple_packet_is_cut_by_its_interface),
        cmocka_unit_test(an_interface_has_its_name_or_its_number),
        cmocka_unit_test(each_interface_has_its_link_and_limits),
        cmocka_unit_test(a_wanted_link_is_looked_for_up_to_the_first_packet),
        cmocka_unit_test(times_are_in_units_of_their_interface),
        cmocka_unit_test(an_offset_is_added),
        cmocka_unit_test(what_cannot_be_a_time_is_refused),
        cmocka_unit_test(sections_have_their_own_order_and_interfaces),
        cmocka_unit_test(a_section_without_interfaces_has_no_packets),
        cmocka_unit_test(a_section_of_another_version_is_refused),
        cmocka_unit_test(a_section_whose_header_is_damaged_is_passed_over),
        cmocka_unit_test(what_is_unknown_is_skipped),
        cmocka_unit_test(ten_thousand_interfaces_are_read),
        cmocka_unit_test(interfaces_without_end_are_refused),
        cmocka_unit_test(blocks_of_no_certain_length_end_the_reading),
        cmocka_unit_test(damaged_blocks_are_passed_over),
        cmocka_unit_test(a_damaged_interface_keeps_its_place),
        cmocka_unit_test(a_capture_of_a_damaged_interface_is_refused),
        cmocka_unit_test(damage_counts_once_where_a_file_is_read_again),
        cmocka_unit_test(both_lengths_of_a_block_agree),
        cmocka_unit_test(a_packet_stays_within_its_block),
        cmocka_unit_test(a_packet_before_an_interface_is_no_capture),
        cmocka_unit_test(interface_options_that_are_cut_are_refused),
        cmocka_unit_test(every_truncation_keeps_what_is_before_it),
        cmocka_unit_test(pieces_of_any_size_give_the_same),
        cmocka_unit_test(options_are_handed_out_where_they_stand),
        cmocka_unit_test(a_source_that_fails_says_why),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
