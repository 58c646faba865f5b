#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/capture/capture.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum {
    FILE_HEADER = 24,
    RECORD_HEADER = 16,
    FRAME = 14 + 20 + 8 + 4,
    RECORD = RECORD_HEADER + FRAME,
    ETHERNET = 1,
    NOBODY = 65534 /* a user without rights */
};

static const uint8_t frame[FRAME] = {
    2, 0,  0,    0,    0,    1,    2,  0,  0, 0, 0,   2,   8,   0,  0x45, 0,
    0, 32, 0,    1,    0,    0,    64, 17, 0, 0, 10,  42,  0,   37, 10,   42,
    0, 1,  0x15, 0x8d, 0xc3, 0x50, 0,  12, 0, 0, 'd', 'a', 't', 'a'};

/* The bytes of a capture file in the making. */
typedef struct image {
    uint8_t bytes[4096];
    size_t len;
    bool big_endian;
} image;

static void put(image *im, const void *bytes, size_t len)
{
    assert_true(len <= sizeof im->bytes - im->len);
    memcpy(im->bytes + im->len, bytes, len);
    im->len += len;
}

static void put_int(image *im, uint32_t value, size_t len)
{
    uint8_t bytes[4];
    for (size_t i = 0; i < len; i++) {
        const size_t shift = 8u * (im->big_endian ? len - 1u - i : i);
        bytes[i] = (uint8_t)(value >> shift);
    }
    put(im, bytes, len);
}

static void put_u32s(image *im, const uint32_t *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        put_int(im, values[i], 4);
    }
}

static image pcap(uint32_t magic, uint32_t link_type, bool big_endian)
{
    image im = {.big_endian = big_endian};
    put_int(&im, magic, 4);
    put_int(&im, 2, 2);
    put_int(&im, 4, 2);
    put_u32s(&im, (const uint32_t[]){0, 0, 65535, link_type}, 4);
    return im;
}

static void put_record(image *im, uint32_t s, uint32_t fraction, uint32_t len)
{
    put_u32s(im, (const uint32_t[]){s, fraction, len, FRAME}, 4);
    put(im, frame, len);
}

static image pcap_of_3(void)
{
    image im = pcap(0xa1b2c3d4, ETHERNET, false);
    for (uint32_t i = 0; i < 3; i++) {
        put_record(&im, 100 + i, 5, FRAME);
    }
    return im;
}

static void put_section(image *im)
{
    put_u32s(im, (const uint32_t[]){0x0a0d0d0a, 28, 0x1a2b3c4d}, 3);
    put_int(im, 1, 2);
    put_int(im, 0, 2);
    put_u32s(im, (const uint32_t[]){0xffffffff, 0xffffffff, 28}, 3);
}

/* An interface with nanoseconds. */
static void put_interface(image *im, uint32_t link_type)
{
    put_u32s(im, (const uint32_t[]){1, 32}, 2);
    put_int(im, link_type, 2);
    put_int(im, 0, 2);
    put_int(im, 65535, 4);
    put_int(im, 9, 2);
    put_int(im, 1, 2);
    put(im, "\x09\0\0\0", 4);
    put_u32s(im, (const uint32_t[]){0, 32}, 2);
}

static void put_packet(image *im, uint32_t interface, uint64_t time_ns)
{
    const uint32_t padded = (FRAME + 3u) / 4u * 4u;
    const uint32_t block = 32u + padded;
    put_u32s(im,
             (const uint32_t[]){6, block, interface, (uint32_t)(time_ns >> 32),
                                (uint32_t)time_ns, FRAME, FRAME},
             7);
    put(im, frame, FRAME);
    put(im, "\0\0\0", padded - FRAME);
    put_int(im, block, 4);
}

static int open_image(const image *im, lum_capture **out, lum_error *error)
{
    lum_source *source = lum_source_from_memory("x.pcap", im->bytes, im->len);
    assert_non_null(source);
    return lum_capture_open_source(source, out, error);
}

static lum_capture *opened(const image *im)
{
    lum_capture *c = NULL;
    lum_error error = {""};
    if (open_image(im, &c, &error) != 0) {
        fail_msg("%s", error.text);
    }
    return c;
}

static void expect_golden(lum_capture *c, int64_t time_ns)
{
    lum_record r;
    lum_error error;
    assert_int_equal(lum_capture_next(c, &r, &error), 1);
    assert_int_equal(r.kind, LUM_RECORD_DATAGRAM);
    assert_true(r.time_ns == time_ns);
    assert_int_equal(r.source, 0x0a2a0025);
    assert_int_equal(r.destination, 0x0a2a0001);
    assert_int_equal(r.source_port, 5517);
    assert_int_equal(r.destination_port, 50000);
    assert_int_equal(r.len, 4);
    assert_memory_equal(r.payload, "data", 4);
    assert_int_equal(r.dropped_fragments, 0);
}

/* Twice: the end stays the end. */
static void expect_end(lum_capture *c)
{
    lum_record r;
    lum_error error;
    for (int i = 0; i < 2; i++) {
        assert_int_equal(lum_capture_next(c, &r, &error), 0);
        assert_int_equal(r.dropped_fragments, 0);
    }
    lum_capture_close(c);
}

static void expect_text(const lum_error *error, const char *part)
{
    if (strstr(error->text, part) == NULL) {
        fail_msg("\"%s\" is not in \"%s\"", part, error->text);
    }
}

static void expect_read_error(lum_capture *c, const char *part)
{
    lum_record r;
    lum_error error = {""};
    assert_int_equal(lum_capture_next(c, &r, &error), -1);
    expect_text(&error, "x.pcap");
    expect_text(&error, part);
    assert_int_equal(lum_capture_next(c, &r, &error), 0);
    lum_capture_close(c);
}

static void expect_refused(const char *path, const char *part)
{
    lum_capture *c = NULL;
    lum_error error = {""};
    assert_int_equal(lum_capture_open(path, &c, &error), -1);
    assert_null(c);
    expect_text(&error, path);
    expect_text(&error, part);
}

static void expect_image_refused(const void *bytes, size_t len,
                                 const char *part)
{
    image im = {.len = 0};
    lum_capture *c = NULL;
    lum_error error = {""};
    put(&im, bytes, len);
    assert_int_equal(open_image(&im, &c, &error), -1);
    assert_null(c);
    expect_text(&error, "x.pcap");
    expect_text(&error, part);
}

static void both_byte_orders_and_both_precisions_are_read(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++) {
        const bool nano = i / 2 != 0;
        image im = pcap(nano ? 0xa1b23c4d : 0xa1b2c3d4, ETHERNET, i % 2 != 0);
        put_record(&im, 4294967295, 123456, FRAME);
        lum_capture *c = opened(&im);
        expect_golden(c, 4294967295 * INT64_C(1000000000) +
                             (nano ? 123456 : 123456000));
        expect_end(c);
    }
}

static void pcapng_is_read(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        image im = {.big_endian = i != 0};
        put_section(&im);
        put_interface(&im, ETHERNET);
        put_packet(&im, 0, UINT64_C(1700000000123456789));
        lum_capture *c = opened(&im);
        expect_golden(c, INT64_C(1700000000123456789));
        expect_end(c);
    }
}

/* A capture of a car's network has Ethernet beside CAN. */
static void packets_of_other_links_are_other(void **state)
{
    image im = {.len = 0};
    lum_record r;
    lum_error error;
    (void)state;
    put_section(&im);
    put_interface(&im, 227);
    put_interface(&im, ETHERNET);
    for (uint32_t i = 0; i < 6; i++) {
        put_packet(&im, i % 2u, i);
    }
    lum_capture *c = opened(&im);
    for (int64_t i = 0; i < 6; i += 2) {
        assert_int_equal(lum_capture_next(c, &r, &error), 1);
        assert_int_equal(r.kind, LUM_RECORD_OTHER);
        assert_true(r.time_ns == i);
        expect_golden(c, i + 1);
    }
    expect_end(c);
}

static void without_a_link_that_is_read_the_first_is_named(void **state)
{
    image im = {.len = 0};
    (void)state;
    put_section(&im);
    put_interface(&im, 227);
    put_interface(&im, 105);
    expect_image_refused(im.bytes, im.len, "link type 227 (CAN)");
}

/* Two of CAN, behind which there is Ethernet in the same section or in another.
 */
static void a_link_that_is_read_may_come_behind_packets_of_others(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        image im = {.len = 0};
        lum_record r;
        lum_error error;
        put_section(&im);
        put_interface(&im, 227);
        put_packet(&im, 0, 5);
        put_packet(&im, 0, 6);
        if (i > 0) {
            im.big_endian = i == 2;
            put_section(&im);
            put_interface(&im, 105);
        }
        put_interface(&im, ETHERNET);
        put_packet(&im, 1, 7);
        lum_capture *c = opened(&im);
        for (int64_t t = 5; t < 7; t++) {
            assert_int_equal(lum_capture_next(c, &r, &error), 1);
            assert_int_equal(r.kind, LUM_RECORD_OTHER);
            assert_true(r.time_ns == t);
        }
        expect_golden(c, 7);
        expect_end(c);
    }
}

/* It shows only at the end that there is none. */
static void packets_of_others_alone_end_in_an_error(void **state)
{
    image im = {.len = 0};
    lum_record r;
    lum_error error = {""};
    (void)state;
    put_section(&im);
    put_interface(&im, 227);
    put_packet(&im, 0, 1);
    put_section(&im);
    put_interface(&im, 105);
    put_packet(&im, 0, 2);
    lum_capture *c = opened(&im);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(lum_capture_next(c, &r, &error), 1);
        assert_int_equal(r.kind, LUM_RECORD_OTHER);
    }
    expect_read_error(c, "link type 227 (CAN) is not supported; supported are "
                         "Ethernet");
}

static void times_beyond_all_clocks_are_held(void **state)
{
    image im = {.len = 0};
    lum_record r;
    lum_error error;
    (void)state;
    put_section(&im);
    put_u32s(&im, (const uint32_t[]){1, 32, ETHERNET, 0}, 4);
    put_int(&im, 9, 2); /* if_tsresol: seconds */
    put_int(&im, 1, 2);
    put_u32s(&im, (const uint32_t[]){0, 0, 32}, 3);
    put_packet(&im, 0, UINT64_MAX);
    lum_capture *c = opened(&im);
    assert_int_equal(lum_capture_next(c, &r, &error), 1);
    assert_true(r.time_ns == INT64_C(4500000000000000000));
    expect_end(c);
}

static void other_link_types_are_read(void **state)
{
    static const struct {
        uint32_t link_type;
        uint32_t header;
        uint8_t bytes[20];
    } links[] = {
        {101, 0, {0}},        {228, 0, {0}},          {0, 4, {2, 0, 0, 0}},
        {0, 4, {0, 0, 0, 2}}, {108, 4, {0, 0, 0, 2}}, {113, 16, {[14] = 8}},
        {276, 20, {8}},
    };
    (void)state;
    for (size_t i = 0; i < sizeof links / sizeof links[0]; i++) {
        const uint32_t len = links[i].header + FRAME - 14u;
        image im = pcap(0xa1b2c3d4, links[i].link_type, false);
        put_u32s(&im, (const uint32_t[]){1, 0, len, len}, 4);
        put(&im, links[i].bytes, links[i].header);
        put(&im, frame + 14, FRAME - 14u);
        lum_capture *c = opened(&im);
        expect_golden(c, 1000000000);
        expect_end(c);
    }
}

static void an_unsupported_link_type_is_named(void **state)
{
    image im = pcap(0xa1b2c3d4, 105, false);
    (void)state;
    expect_image_refused(im.bytes, im.len,
                         "link type 105 (Wi-Fi: IEEE 802.11)");
    im = pcap(0xa1b2c3d4, 60000, false);
    expect_image_refused(im.bytes, im.len, "link type 60000 (unknown)");
    expect_image_refused(im.bytes, im.len, "Linux cooked v1 and v2");
}

static void what_is_no_capture_is_refused(void **state)
{
    (void)state;
    expect_image_refused("", 0, "is empty");
    expect_image_refused("x,y,z\n1,2,3\n4,5,6\n7,8,9\n0,1,2\n", 30,
                         "not a capture");
    expect_image_refused("\xfd"
                         "7zXgarbage",
                         11, "xz -dc");
    expect_image_refused("BZh9garbage", 11, "bzip2");
    expect_image_refused("PK\3\4garbage", 11, "unzip");
}

static void what_cannot_be_opened_is_refused(void **state)
{
    (void)state;
    expect_refused("/nonexistent.pcap", "No such file or directory");
    expect_refused("/", "Is a directory");
    expect_refused("/dev/null", "is empty");
}

static void an_unreadable_file_is_refused(void **state)
{
    char path[] = "/tmp/lum_capture_XXXXXX";
    const int fd = mkstemp(path);
    const uid_t user = geteuid();
    lum_capture *c = NULL;
    lum_error error = {""};
    (void)state;
    assert_int_equal(fchmod(fd, 0), 0);
    assert_int_equal(close(fd), 0);
    if (user == 0 && seteuid(NOBODY) != 0) { /* root may read all */
        (void)unlink(path);
        skip();
    }
    const int opened = lum_capture_open(path, &c, &error);
    assert_true(user != 0 || seteuid(user) == 0);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(opened, -1);
    expect_text(&error, "Permission denied");
}

/* The records before the cut, then the end or an error. */
static void read_cut(const image *im)
{
    lum_record r;
    lum_error error = {""};
    const size_t rest = im->len - FILE_HEADER;
    lum_capture *c = opened(im);
    for (size_t i = 0; i < rest / RECORD; i++) {
        expect_golden(c, INT64_C(1000000000) * (int64_t)(100 + i) + 5000);
    }
    assert_int_equal(lum_capture_next(c, &r, &error),
                     rest % RECORD == 0 ? 0 : -1);
    assert_true((rest % RECORD == 0) == (error.text[0] == '\0'));
    lum_capture_close(c);
}

static void a_cut_anywhere_keeps_what_is_before_it(void **state)
{
    image im = pcap_of_3();
    const size_t whole = im.len;
    (void)state;
    for (im.len = 0; im.len < FILE_HEADER; im.len++) {
        expect_image_refused(im.bytes, im.len,
                             im.len == 0 ? "is empty" : "not a capture");
    }
    for (; im.len <= whole; im.len++) {
        read_cut(&im);
    }
}

static void a_cut_pcapng_ends(void **state)
{
    image im = {.len = 0};
    (void)state;
    put_section(&im);
    put_interface(&im, ETHERNET);
    const size_t headers = im.len;
    put_packet(&im, 0, 1);
    const size_t whole = im.len;
    for (im.len = 1; im.len < headers; im.len++) {
        expect_image_refused(im.bytes, im.len, "not a capture");
    }
    for (; im.len < whole; im.len++) {
        lum_record r;
        lum_error error;
        lum_capture *c = opened(&im);
        assert_int_equal(lum_capture_next(c, &r, &error),
                         im.len == headers ? 0 : -1);
        lum_capture_close(c);
    }
}

static void a_tail_of_zeros_is_a_read_error(void **state)
{
    static const uint8_t zeros[100];
    image im = pcap_of_3();
    (void)state;
    put(&im, zeros, sizeof zeros);
    lum_capture *c = opened(&im);
    for (int64_t i = 0; i < 3; i++) {
        expect_golden(c, INT64_C(1000000000) * (100 + i) + 5000);
    }
    expect_read_error(c, "zeros");
}

static void an_impossible_record_length_is_a_read_error(void **state)
{
    image im = pcap_of_3();
    (void)state;
    put_u32s(&im, (const uint32_t[]){1, 1, 0x7fffffff, 0x7fffffff}, 4);
    put(&im, frame, FRAME);
    lum_capture *c = opened(&im);
    for (int64_t i = 0; i < 3; i++) {
        expect_golden(c, INT64_C(1000000000) * (100 + i) + 5000);
    }
    expect_read_error(c, "beyond record 3");
}

static void snap_length_cuts_short(void **state)
{
    (void)state;
    for (uint32_t n = 1; n < FRAME; n++) {
        image im = pcap(0xa1b2c3d4, ETHERNET, false);
        lum_record r;
        lum_error error;
        put_record(&im, 1, 0, n);
        lum_capture *c = opened(&im);
        assert_int_equal(lum_capture_next(c, &r, &error), 1);
        assert_int_equal(r.kind,
                         n < 34 ? LUM_RECORD_OTHER : LUM_RECORD_CUT_SHORT);
        assert_int_equal(r.source_port, n < 38 ? 0 : 5517);
        expect_end(c);
    }
}

/* Two of 8 bytes each, the UDP header and a payload of 8. */
static void put_fragment(image *im, uint32_t s, uint32_t us, bool last)
{
    uint8_t bytes[14 + 20 + 8];
    memcpy(bytes, frame, sizeof bytes);
    bytes[17] = 28;
    bytes[20] = last ? 0 : 0x20;
    bytes[21] = last ? 1 : 0;
    bytes[39] = 16;
    put_u32s(im, (const uint32_t[]){s, us, sizeof bytes, sizeof bytes}, 4);
    put(im, bytes, sizeof bytes);
}

static void expect_record(lum_capture *c, lum_record_kind kind,
                          uint32_t dropped_fragments)
{
    lum_record r;
    lum_error error;
    assert_int_equal(lum_capture_next(c, &r, &error), 1);
    assert_int_equal(r.kind, kind);
    assert_int_equal(r.dropped_fragments, dropped_fragments);
    assert_int_equal(r.len, kind == LUM_RECORD_DATAGRAM ? 8 : 0);
}

static void fragments_become_a_datagram(void **state)
{
    image im = pcap(0xa1b2c3d4, ETHERNET, false);
    (void)state;
    put_fragment(&im, 1, 0, true);
    put_fragment(&im, 1, 500000, false);
    lum_capture *c = opened(&im);
    expect_record(c, LUM_RECORD_FRAGMENT, 0);
    expect_record(c, LUM_RECORD_DATAGRAM, 0);
    expect_end(c);
}

static void fragments_given_up_are_counted(void **state)
{
    image im = pcap(0xa1b2c3d4, ETHERNET, false);
    lum_record r;
    lum_error error;
    (void)state;
    put_fragment(&im, 1, 0, true);
    put_fragment(&im, 1, 500001, false);
    lum_capture *c = opened(&im);
    expect_record(c, LUM_RECORD_FRAGMENT, 0);
    expect_record(c, LUM_RECORD_FRAGMENT, 1);
    assert_int_equal(lum_capture_next(c, &r, &error), 0);
    assert_int_equal(r.dropped_fragments, 1);
    expect_end(c);
    im.len--;
    c = opened(&im);
    expect_record(c, LUM_RECORD_FRAGMENT, 0);
    assert_int_equal(lum_capture_next(c, &r, &error), -1);
    assert_int_equal(r.dropped_fragments, 1);
    expect_end(c);
}

static void progress_reaches_the_file_size(void **state)
{
    image im = pcap_of_3();
    lum_capture *c = opened(&im);
    uint64_t done = 1;
    uint64_t total = 1;
    (void)state;
    lum_capture_progress(c, &done, &total);
    assert_int_equal(total, im.len);
    assert_int_equal(done, FILE_HEADER);
    expect_golden(c, INT64_C(100000005000));
    lum_capture_progress(c, &done, &total);
    assert_int_equal(done, FILE_HEADER + RECORD);
    lum_capture_close(c);
}

static void progress_through_a_pipe_has_no_total(void **state)
{
    image im = pcap_of_3();
    int ends[2];
    char name[32];
    lum_capture *c = NULL;
    lum_error error;
    uint64_t done = 1;
    uint64_t total = 1;
    (void)state;
    assert_int_equal(pipe(ends), 0);
    assert_int_equal(write(ends[1], im.bytes, im.len), im.len);
    assert_int_equal(close(ends[1]), 0);
    (void)snprintf(name, sizeof name, "/dev/fd/%d", ends[0]);
    assert_int_equal(lum_capture_open(name, &c, &error), 0);
    assert_int_equal(close(ends[0]), 0);
    expect_golden(c, INT64_C(100000005000));
    lum_capture_progress(c, &done, &total);
    assert_int_equal(total, 0);
    assert_int_equal(done, FILE_HEADER + RECORD);
    lum_capture_close(c);
}

static void closing_nothing_is_allowed(void **state)
{
    lum_error error;
    (void)state;
    lum_capture_close(NULL);
    assert_int_equal(lum_capture_writer_close(NULL, &error), 0);
}

/* A file of its own for the writer's tests. */
typedef struct scratch {
    char path[64];
    uint8_t payload[65507];
} scratch;

static int begin_scratch(void **state)
{
    scratch *s = calloc(1, sizeof *s);
    assert_non_null(s);
    (void)snprintf(s->path, sizeof s->path, "/tmp/lum_writer_XXXXXX");
    const int fd = mkstemp(s->path);
    assert_true(fd >= 0);
    (void)close(fd);
    for (size_t i = 0; i < sizeof s->payload; i++) {
        s->payload[i] = (uint8_t)(i * 31u + i / 256u);
    }
    *state = s;
    return 0;
}

static int end_scratch(void **state)
{
    scratch *s = *state;
    (void)unlink(s->path);
    free(s);
    return 0;
}

static lum_datagram datagram_of(const scratch *s, size_t len, int64_t time_ns)
{
    return (lum_datagram){time_ns,    s->payload, len,  0x0a2a0025,
                          0xc0a80102, 5517,       50000};
}

static const size_t lens[] = {0, 1, 2, 3, 1400, 1401, 65506, 65507};
#define LENS (sizeof lens / sizeof lens[0])

static void write_lens(const scratch *s)
{
    lum_capture_writer *w = NULL;
    lum_error error = {""};
    assert_int_equal(lum_capture_writer_open(s->path, &w, &error), 0);
    for (size_t i = 0; i < LENS; i++) {
        const lum_datagram d =
            datagram_of(s, lens[i], INT64_C(1700000000123456789) + (int64_t)i);
        assert_int_equal(lum_capture_writer_add(w, &d, &error), 0);
    }
    assert_int_equal(lum_capture_writer_close(w, &error), 0);
}

/* Nobody needs to ask why. */
static void an_empty_file_beside_another_is_read_over(void **state)
{
    const scratch *s = *state;
    const char *const paths[] = {"/dev/null", s->path};
    lum_capture *c = NULL;
    lum_record r;
    lum_error error = {""};
    size_t count = 0;
    int status = 1;
    write_lens(s);
    assert_int_equal(lum_capture_open_several(paths, 2, &c, NULL), 0);
    while ((status = lum_capture_next(c, &r, &error)) > 0) {
        count++;
    }
    assert_int_equal(status, -1);
    assert_int_equal(count, LENS);
    assert_non_null(strstr(error.text, "/dev/null: is empty"));
    lum_capture_close(c);
    assert_int_equal(lum_capture_open_several(paths, 1, &c, NULL), -1);
}

static void what_is_written_is_read_back(void **state)
{
    scratch *s = *state;
    lum_capture *c = NULL;
    lum_error error;
    write_lens(s);
    assert_int_equal(lum_capture_open(s->path, &c, &error), 0);
    for (size_t i = 0; i < LENS; i++) {
        lum_record r;
        assert_int_equal(lum_capture_next(c, &r, &error), 1);
        assert_int_equal(r.kind, LUM_RECORD_DATAGRAM);
        assert_true(r.time_ns == INT64_C(1700000000123456789) + (int64_t)i);
        assert_int_equal(r.source, 0x0a2a0025);
        assert_int_equal(r.destination, 0xc0a80102);
        assert_int_equal(r.source_port, 5517);
        assert_int_equal(r.destination_port, 50000);
        assert_int_equal(r.len, lens[i]);
        assert_memory_equal(r.payload, s->payload, r.len);
    }
    expect_end(c);
}

/* A right checksum makes the sum of all 16-bit words 0xffff. */
static uint32_t folded(const uint8_t *p, size_t len, uint32_t sum)
{
    for (size_t i = 0; i < len; i++) {
        sum += i % 2u == 0 ? (uint32_t)p[i] << 8 : p[i];
        sum = (sum & 0xffffu) + (sum >> 16);
    }
    return sum;
}

static void checksums_are_right(void **state)
{
    scratch *s = *state;
    uint8_t header[RECORD_HEADER];
    uint8_t *bytes = malloc(65549);
    write_lens(s);
    FILE *file = fopen(s->path, "rb");
    assert_non_null(bytes);
    assert_non_null(file);
    assert_int_equal(fseek(file, FILE_HEADER, SEEK_SET), 0);
    for (size_t i = 0; i < LENS; i++) {
        const size_t udp = 8u + lens[i];
        const uint8_t pseudo[4] = {0, 17, (uint8_t)(udp >> 8), (uint8_t)udp};
        assert_int_equal(fread(header, 1, sizeof header, file), sizeof header);
        assert_int_equal(fread(bytes, 1, 34u + udp, file), 34u + udp);
        assert_int_equal(folded(bytes + 14, 20, 0), 0xffff);
        const uint32_t sum = folded(pseudo, 4, folded(bytes + 26, 8, 0));
        assert_int_equal(folded(bytes + 34, udp, sum), 0xffff);
        assert_true(bytes[40] != 0 || bytes[41] != 0);
    }
    assert_int_equal(fgetc(file), EOF);
    (void)fclose(file);
    free(bytes);
}

/* With 0 for its sum a datagram would claim to have none. */
static void a_checksum_of_zero_is_sent_as_all_ones(void **state)
{
    scratch *s = *state;
    lum_capture_writer *w = NULL;
    lum_error error;
    uint8_t bytes[FILE_HEADER + RECORD_HEADER + 44];
    /* 17 + 10 + 10 + 0xffda = 0xffff */
    lum_datagram d = {0, (const uint8_t *)"\xff\xda", 2, 0, 0, 0, 0};
    assert_int_equal(lum_capture_writer_open(s->path, &w, &error), 0);
    assert_int_equal(lum_capture_writer_add(w, &d, &error), 0);
    assert_int_equal(lum_capture_writer_close(w, &error), 0);
    FILE *file = fopen(s->path, "rb");
    assert_non_null(file);
    assert_int_equal(fread(bytes, 1, sizeof bytes, file), sizeof bytes);
    (void)fclose(file);
    assert_int_equal(bytes[FILE_HEADER + RECORD_HEADER + 40], 0xff);
    assert_int_equal(bytes[FILE_HEADER + RECORD_HEADER + 41], 0xff);
}

static void what_a_capture_cannot_hold_is_refused(void **state)
{
    scratch *s = *state;
    lum_capture_writer *w = NULL;
    lum_error error;
    lum_datagram d = datagram_of(s, 65508, 0);
    assert_int_equal(lum_capture_writer_open(s->path, &w, &error), 0);
    assert_int_equal(lum_capture_writer_add(w, &d, &error), -1);
    expect_text(&error, "at most 65507");
    d = datagram_of(s, 1, -1);
    assert_int_equal(lum_capture_writer_add(w, &d, &error), -1);
    expect_text(&error, "since 1970");
    d = datagram_of(s, 1, INT64_C(4294967296000000000));
    assert_int_equal(lum_capture_writer_add(w, &d, &error), -1);
    d = datagram_of(s, 1, INT64_C(4294967295999999999));
    assert_int_equal(lum_capture_writer_add(w, &d, &error), 0);
    assert_int_equal(lum_capture_writer_close(w, &error), 0);
}

static void what_was_flushed_can_be_read_before_the_end(void **state)
{
    scratch *s = *state;
    lum_capture_writer *w = NULL;
    lum_capture *c = NULL;
    lum_record r;
    lum_error error;
    const lum_datagram d = datagram_of(s, 100, 5);
    assert_int_equal(lum_capture_writer_open(s->path, &w, &error), 0);
    assert_int_equal(lum_capture_writer_bytes(w), FILE_HEADER);
    assert_int_equal(lum_capture_writer_add(w, &d, &error), 0);
    assert_int_equal(lum_capture_writer_flush(w, &error), 0);
    assert_int_equal(lum_capture_writer_bytes(w),
                     FILE_HEADER + RECORD_HEADER + 42 + 100);
    assert_int_equal(lum_capture_open(s->path, &c, &error), 0);
    assert_int_equal(lum_capture_next(c, &r, &error), 1);
    assert_int_equal(r.len, 100);
    expect_end(c);
    assert_int_equal(lum_capture_writer_close(w, &error), 0);
}

static void a_flush_tells_that_the_reader_has_left(void **state)
{
    lum_capture_writer *w = NULL;
    lum_error error = {""};
    int ends[2];
    char name[32];
    (void)state;
    assert_int_equal(pipe(ends), 0);
    (void)snprintf(name, sizeof name, "/dev/fd/%d", ends[1]);
    assert_int_equal(lum_capture_writer_open(name, &w, &error), 0);
    assert_int_equal(lum_capture_writer_flush(w, &error), 0);
    (void)close(ends[0]);
    assert_int_equal(lum_capture_writer_flush(w, &error), -1);
    assert_int_equal(errno, EPIPE);
    assert_int_equal(lum_capture_writer_close(w, &error), 0);
    (void)close(ends[1]);
}

static void a_full_disk_is_told_by_a_flush(void **state)
{
    scratch *s = *state;
    lum_capture_writer *w = NULL;
    lum_error error = {""};
    const lum_datagram d = datagram_of(s, 100, 0);
    assert_int_equal(lum_capture_writer_open("/dev/full", &w, &error), 0);
    assert_int_equal(lum_capture_writer_add(w, &d, &error), 0);
    assert_int_equal(lum_capture_writer_flush(w, &error), -1);
    assert_int_equal(errno, ENOSPC);
    expect_text(&error, "No space left");
    assert_int_equal(lum_capture_writer_close(w, &error), -1);
}

static void a_writer_needs_its_directory(void **state)
{
    lum_capture_writer *w = NULL;
    lum_error error = {""};
    (void)state;
    assert_int_equal(lum_capture_writer_open("/nonexistent/x.pcap", &w, &error),
                     -1);
    assert_null(w);
    expect_text(&error, "/nonexistent/x.pcap");
    expect_text(&error, "the directory does not exist");
    assert_int_equal(lum_capture_writer_open("/", &w, &error), -1);
    expect_text(&error, "is a directory");
}

static void a_full_disk_is_told_at_the_end(void **state)
{
    scratch *s = *state;
    lum_capture_writer *w = NULL;
    lum_error error = {""};
    const lum_datagram d = datagram_of(s, 1400, 0);
    assert_int_equal(lum_capture_writer_open("/dev/full", &w, &error), 0);
    assert_int_equal(lum_capture_writer_add(w, &d, &error), 0);
    errno = 0;
    assert_int_equal(lum_capture_writer_close(w, &error), -1);
    assert_int_equal(errno, ENOSPC);
    expect_text(&error, "/dev/full");
    expect_text(&error, "No space left");
}

static void a_full_disk_is_told_while_writing(void **state)
{
    scratch *s = *state;
    lum_capture_writer *w = NULL;
    lum_error error = {""};
    const lum_datagram d = datagram_of(s, 65000, 0);
    int result = 0;
    assert_int_equal(lum_capture_writer_open("/dev/full", &w, &error), 0);
    for (int i = 0; i < 100 && result == 0; i++) {
        result = lum_capture_writer_add(w, &d, &error);
    }
    assert_int_equal(result, -1);
    assert_int_equal(errno, ENOSPC);
    expect_text(&error, "No space left");
    assert_int_equal(lum_capture_writer_close(w, &error), -1);
}

static void a_link_is_written_through(void **state)
{
    scratch *s = *state;
    char link[80];
    struct stat st;
    lum_capture_writer *w = NULL;
    lum_error error;
    (void)snprintf(link, sizeof link, "%s.link", s->path);
    assert_int_equal(symlink(s->path, link), 0);
    const lum_datagram d = datagram_of(s, 100, 5);
    assert_int_equal(lum_capture_writer_open(link, &w, &error), 0);
    assert_int_equal(lum_capture_writer_add(w, &d, &error), 0);
    assert_int_equal(lum_capture_writer_close(w, &error), 0);
    assert_int_equal(lstat(link, &st), 0);
    assert_true(S_ISLNK(st.st_mode));
    assert_int_equal(stat(s->path, &st), 0);
    assert_int_equal(st.st_size, FILE_HEADER + RECORD_HEADER + 42 + 100);
    assert_int_equal(unlink(link), 0);
}

static long size_of(const char *path)
{
    struct stat st;
    return stat(path, &st) == 0 ? (long)st.st_size : -1L;
}

/* What is there when a run begins is lost by none that records nothing. */
static void a_recording_replaces_with_its_first_datagram(void **state)
{
    scratch *s = *state;
    lum_capture_writer *w = NULL;
    const lum_datagram d = datagram_of(s, 100, 5);
    const long whole = FILE_HEADER + RECORD_HEADER + 42 + 100;
    for (int i = 0; i < 3; i++) {
        assert_int_equal(lum_capture_writer_open(s->path, &w, NULL), 0);
        assert_int_equal(lum_capture_writer_flush(w, NULL), 0);
        assert_int_equal(size_of(s->path), i == 0 ? 0 : whole);
        if (i == 0) {
            assert_int_equal(lum_capture_writer_add(w, &d, NULL), 0);
        }
        if (i < 2) {
            lum_capture_writer_abort(w);
        } else {
            assert_int_equal(lum_capture_writer_close(w, NULL), 0);
        }
        assert_int_equal(size_of(s->path), whole);
    }
    lum_capture_writer_abort(NULL);
}

static void a_recording_of_nothing_leaves_no_file(void **state)
{
    scratch *s = *state;
    char name[80];
    lum_capture_writer *w = NULL;
    (void)snprintf(name, sizeof name, "%s.new", s->path);
    assert_int_equal(lum_capture_writer_open(name, &w, NULL), 0);
    assert_int_equal(lum_capture_writer_close(w, NULL), 0);
    assert_int_equal(size_of(name), -1);
    assert_int_equal(lum_capture_writer_open_whole(name, &w, NULL), 0);
    assert_int_equal(lum_capture_writer_close(w, NULL), 0);
    assert_int_equal(size_of(name), FILE_HEADER);
    assert_int_equal(unlink(name), 0);
}

/* Root may write everywhere, so it becomes nobody first. 0, or what failed. */
static int record_as_nobody(const scratch *s, const char *name)
{
    const lum_datagram d = datagram_of(s, 100, 5);
    lum_capture_writer *w = NULL;
    if (geteuid() == 0 && (setgid(NOBODY) != 0 || setuid(NOBODY) != 0)) {
        return 1;
    }
    for (int i = 0; i < 2; i++) {
        if (lum_capture_writer_open(name, &w, NULL) != 0 ||
            lum_capture_writer_flush(w, NULL) != 0 || size_of(name) != 5) {
            return 2;
        }
        if (i == 0) {
            lum_capture_writer_abort(w);
        } else if (lum_capture_writer_close(w, NULL) != 0) {
            return 3;
        }
        if (size_of(name) != 5) {
            return 4;
        }
    }
    return lum_capture_writer_open(name, &w, NULL) == 0 &&
                   lum_capture_writer_add(w, &d, NULL) == 0 &&
                   lum_capture_writer_close(w, NULL) == 0 &&
                   size_of(name) == FILE_HEADER + RECORD_HEADER + 42 + 100
               ? 0
               : 5;
}

static void a_file_in_a_closed_directory_stays_until_the_first_datagram(
    void **state)
{
    scratch *s = *state;
    char directory[] = "/tmp/lum-capture-closed-XXXXXX";
    char name[80];
    int status = -1;
    assert_non_null(mkdtemp(directory));
    (void)snprintf(name, sizeof name, "%s/a.pcap", directory);
    FILE *file = fopen(name, "w");
    assert_non_null(file);
    assert_int_equal(fputs("older", file) >= 0 && fclose(file) == 0, 1);
    assert_int_equal(chmod(name, 0666), 0);
    assert_int_equal(chmod(directory, 0555), 0);
    fflush(NULL);
    const pid_t child = fork();
    if (child == 0) {
        _exit(record_as_nobody(s, name));
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    assert_int_equal(chmod(directory, 0755), 0);
    assert_int_equal(unlink(name), 0);
    assert_int_equal(rmdir(directory), 0);
}

/* Its reader gets a capture without records. */
static void a_pipe_gets_the_header_of_a_recording_of_nothing(void **state)
{
    int ends[2];
    char name[32];
    uint8_t bytes[FILE_HEADER + 1];
    lum_capture_writer *w = NULL;
    (void)state;
    assert_int_equal(pipe(ends), 0);
    (void)snprintf(name, sizeof name, "/dev/fd/%d", ends[1]);
    assert_int_equal(lum_capture_writer_open(name, &w, NULL), 0);
    assert_int_equal(lum_capture_writer_close(w, NULL), 0);
    assert_int_equal(read(ends[0], bytes, sizeof bytes), FILE_HEADER);
    (void)close(ends[0]);
    (void)close(ends[1]);
}

static void a_whole_capture_replaces_at_its_end(void **state)
{
    scratch *s = *state;
    lum_capture_writer *w = NULL;
    lum_capture_writer *second = NULL;
    lum_error error;
    const lum_datagram d = datagram_of(s, 100, 5);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(lum_capture_writer_open_whole(s->path, &w, NULL), 0);
        assert_int_equal(
            lum_capture_writer_open_whole(s->path, &second, &error), -1);
        assert_int_equal(errno, EBUSY);
        expect_text(&error, "is writing it");
        assert_int_equal(lum_capture_writer_add(w, &d, NULL), 0);
        assert_int_equal(size_of(s->path), 0);
        if (i == 0) {
            lum_capture_writer_abort(w);
        } else {
            assert_int_equal(lum_capture_writer_close(w, NULL), 0);
        }
    }
    assert_int_equal(size_of(s->path), FILE_HEADER + RECORD_HEADER + 42 + 100);
}

static void an_abort_does_not_wait_for_a_reader(void **state)
{
    scratch *s = *state;
    int ends[2];
    char name[32];
    lum_capture_writer *w = NULL;
    const lum_datagram d = datagram_of(s, 65000, 5);
    assert_int_equal(pipe(ends), 0);
    (void)snprintf(name, sizeof name, "/dev/fd/%d", ends[1]);
    assert_int_equal(lum_capture_writer_open(name, &w, NULL), 0);
    for (int i = 0; i < 4; i++) {
        assert_int_equal(lum_capture_writer_add(w, &d, NULL), 0);
    }
    (void)alarm(600);
    lum_capture_writer_abort(w);
    (void)alarm(0);
    (void)close(ends[0]);
    (void)close(ends[1]);
}

#define WRITER_FACT(name)                                                      \
    cmocka_unit_test_setup_teardown(name, begin_scratch, end_scratch)

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(both_byte_orders_and_both_precisions_are_read),
        cmocka_unit_test(pcapng_is_read),
        cmocka_unit_test(packets_of_other_links_are_other),
        cmocka_unit_test(without_a_link_that_is_read_the_first_is_named),
        cmocka_unit_test(a_link_that_is_read_may_come_behind_packets_of_others),
        cmocka_unit_test(packets_of_others_alone_end_in_an_error),
        cmocka_unit_test(times_beyond_all_clocks_are_held),
        cmocka_unit_test(other_link_types_are_read),
        cmocka_unit_test(an_unsupported_link_type_is_named),
        cmocka_unit_test(what_is_no_capture_is_refused),
        cmocka_unit_test(what_cannot_be_opened_is_refused),
        cmocka_unit_test(an_unreadable_file_is_refused),
        cmocka_unit_test(a_cut_anywhere_keeps_what_is_before_it),
        cmocka_unit_test(a_cut_pcapng_ends),
        cmocka_unit_test(a_tail_of_zeros_is_a_read_error),
        cmocka_unit_test(an_impossible_record_length_is_a_read_error),
        cmocka_unit_test(snap_length_cuts_short),
        cmocka_unit_test(fragments_become_a_datagram),
        cmocka_unit_test(fragments_given_up_are_counted),
        cmocka_unit_test(progress_reaches_the_file_size),
        cmocka_unit_test(progress_through_a_pipe_has_no_total),
        cmocka_unit_test(closing_nothing_is_allowed),
        WRITER_FACT(an_empty_file_beside_another_is_read_over),
        WRITER_FACT(what_is_written_is_read_back),
        WRITER_FACT(checksums_are_right),
        WRITER_FACT(a_checksum_of_zero_is_sent_as_all_ones),
        WRITER_FACT(what_a_capture_cannot_hold_is_refused),
        WRITER_FACT(what_was_flushed_can_be_read_before_the_end),
        WRITER_FACT(a_flush_tells_that_the_reader_has_left),
        WRITER_FACT(a_full_disk_is_told_by_a_flush),
        cmocka_unit_test(a_writer_needs_its_directory),
        WRITER_FACT(a_full_disk_is_told_at_the_end),
        WRITER_FACT(a_full_disk_is_told_while_writing),
        WRITER_FACT(a_link_is_written_through),
        WRITER_FACT(a_recording_replaces_with_its_first_datagram),
        WRITER_FACT(a_recording_of_nothing_leaves_no_file),
        WRITER_FACT(
            a_file_in_a_closed_directory_stays_until_the_first_datagram),
        cmocka_unit_test(a_pipe_gets_the_header_of_a_recording_of_nothing),
        WRITER_FACT(a_whole_capture_replaces_at_its_end),
        WRITER_FACT(an_abort_does_not_wait_for_a_reader),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
