#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/capture/capture.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char path[] = "/tmp/lum-comments-XXXXXX";

static int make_file(void **state)
{
    const int fd = mkstemp(path);
    (void)state;
    return fd < 0 ? -1 : close(fd);
}

static int remove_file(void **state)
{
    (void)state;
    return unlink(path);
}

static lum_datagram datagram_of(const char *payload, size_t len)
{
    return (lum_datagram){.time_ns = INT64_C(1700000000123456789),
                          .payload = (const uint8_t *)payload,
                          .len = len,
                          .source = 0x0a2a0025,
                          .destination = 0x0a2a0001,
                          .source_port = 5517,
                          .destination_port = 50000};
}

static lum_capture_writer *open_pcapng(const char *const *comments,
                                       size_t count)
{
    const lum_capture_writer_options o = {.struct_size = sizeof o,
                                          .format = LUM_CAPTURE_PCAPNG,
                                          .is_whole = true,
                                          .application = "test",
                                          .comments = comments,
                                          .comment_count = count};
    lum_capture_writer *w = NULL;
    lum_error error = {""};
    assert_int_equal(lum_capture_writer_open_as(path, &o, &w, &error), 0);
    return w;
}

static size_t read_file(uint8_t *out, size_t room)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t n = fread(out, 1, room, file);
    (void)fclose(file);
    return n;
}

static lum_capture *open_bytes(const uint8_t *bytes, size_t len)
{
    lum_capture *c = NULL;
    lum_error error = {""};
    lum_source *source = lum_source_from_memory("test", bytes, len);
    assert_non_null(source);
    assert_int_equal(lum_capture_open_source(source, &c, &error), 0);
    return c;
}

static void a_pcapng_is_as_written_here(void **state)
{
    static const uint8_t start[] = {
        0x0a, 0x0d, 0x0d, 0x0a, 48,   0,    0,    0,    0x4d, 0x3c, 0x2b, 0x1a,
        1,    0,    0,    0,    0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff,
        4,    0,    4,    0,    't',  'e',  's',  't',  1,    0,    3,    0,
        'o',  'n',  'e',  0,    0,    0,    0,    0,    48,   0,    0,    0,
        1,    0,    0,    0,    32,   0,    0,    0,    1,    0,    0,    0,
        0,    0,    4,    0,    9,    0,    1,    0,    9,    0,    0,    0,
        0,    0,    0,    0,    32,   0,    0,    0};
    /* 42 bytes of headers, 3 of payload, 3 of padding */
    static const uint8_t head[] = {
        6,    0,    0,    0,    80,   0,    0,  0, 0, 0, 0,  0, 0xfe, 0x9c,
        0x97, 0x17, 0x15, 0xcd, 0x85, 0x3d, 45, 0, 0, 0, 45, 0, 0,    0};
    static const uint8_t tail[] = {'a', 'b', 'c', 0, 0, 0, 80, 0, 0, 0};
    const char *const comments[] = {"one"};
    uint8_t bytes[512];
    (void)state;
    lum_capture_writer *w = open_pcapng(comments, 1);
    const lum_datagram d = datagram_of("abc", 3);
    assert_int_equal(lum_capture_writer_bytes(w), sizeof start);
    assert_int_equal(lum_capture_writer_add(w, &d, NULL), 0);
    assert_int_equal(lum_capture_writer_bytes(w), sizeof start + 80);
    assert_int_equal(lum_capture_writer_close(w, NULL), 0);
    assert_int_equal(read_file(bytes, sizeof bytes), sizeof start + 80);
    assert_memory_equal(bytes, start, sizeof start);
    assert_memory_equal(bytes + sizeof start, head, sizeof head);
    assert_memory_equal(bytes + sizeof start + 70, tail, sizeof tail);
}

static void packets_of_any_length_come_back(void **state)
{
    static uint8_t bytes[8192];
    static const char payload[] = "0123456789abcdef";
    lum_record r;
    (void)state;
    lum_capture_writer *w = open_pcapng(NULL, 0);
    for (size_t n = 0; n < sizeof payload; n++) {
        const lum_datagram d = datagram_of(payload, n);
        assert_int_equal(lum_capture_writer_add(w, &d, NULL), 0);
    }
    assert_int_equal(lum_capture_writer_close(w, NULL), 0);
    lum_capture *c = open_bytes(bytes, read_file(bytes, sizeof bytes));
    assert_int_equal(lum_capture_comment_count(c, 0), 0);
    for (size_t n = 0; n < sizeof payload; n++) {
        assert_int_equal(lum_capture_next(c, &r, NULL), 1);
        assert_int_equal(r.kind, LUM_RECORD_DATAGRAM);
        assert_int_equal(r.len, n);
        assert_memory_equal(r.payload, payload, n);
        assert_true(r.time_ns == INT64_C(1700000000123456789));
    }
    assert_int_equal(lum_capture_next(c, &r, NULL), 0);
    lum_capture_close(c);
}

static void the_longest_packet_comes_back(void **state)
{
    enum {
        LONGEST = 65507
    };
    static uint8_t bytes[LONGEST + 512];
    static char payload[LONGEST];
    lum_record r;
    (void)state;
    memset(payload, 'x', sizeof payload);
    lum_capture_writer *w = open_pcapng(NULL, 0);
    const lum_datagram d = datagram_of(payload, sizeof payload);
    assert_int_equal(lum_capture_writer_add(w, &d, NULL), 0);
    assert_int_equal(lum_capture_writer_close(w, NULL), 0);
    lum_capture *c = open_bytes(bytes, read_file(bytes, sizeof bytes));
    assert_int_equal(lum_capture_next(c, &r, NULL), 1);
    assert_int_equal(r.len, LONGEST);
    assert_memory_equal(r.payload, payload, LONGEST);
    lum_capture_close(c);
}

static lum_capture_writer *open_interfaces(const char *const *names,
                                           size_t count)
{
    const lum_capture_writer_options o = {.struct_size = sizeof o,
                                          .format = LUM_CAPTURE_PCAPNG,
                                          .is_whole = true,
                                          .interfaces = names,
                                          .interface_count = count};
    lum_capture_writer *w = NULL;
    lum_error error = {""};
    assert_int_equal(lum_capture_writer_open_as(path, &o, &w, &error), 0);
    return w;
}

static void datagrams_come_back_from_their_interfaces(void **state)
{
    enum {
        LAST = LUM_CAPTURE_INTERFACES_MAX - 1
    };
    static uint8_t bytes[8192];
    static char longest[LUM_INTERFACE_BYTES];
    const char *names[LUM_CAPTURE_INTERFACES_MAX];
    lum_error error = {""};
    lum_record r;
    (void)state;
    memset(longest, 'i', sizeof longest - 1u);
    for (size_t i = 0; i < LAST; i++) {
        names[i] = i % 2u == 0 ? "eth0" : "enp3s0";
    }
    names[0] = "";
    names[LAST] = longest;
    lum_capture_writer *w = open_interfaces(names, LUM_CAPTURE_INTERFACES_MAX);
    const lum_datagram d = datagram_of("abc", 3);
    for (size_t i = LUM_CAPTURE_INTERFACES_MAX; i-- > 0;) {
        assert_int_equal(lum_capture_writer_add_from(w, i, &d, NULL), 0);
    }
    assert_int_equal(lum_capture_writer_add(w, &d, NULL), 0);
    assert_int_equal(
        lum_capture_writer_add_from(w, LUM_CAPTURE_INTERFACES_MAX, &d, &error),
        -1);
    assert_non_null(strstr(error.text, "use 0 to 15"));
    assert_int_equal(lum_capture_writer_close(w, NULL), 0);
    lum_capture *c = open_bytes(bytes, read_file(bytes, sizeof bytes));
    for (size_t i = LUM_CAPTURE_INTERFACES_MAX; i-- > 0;) {
        assert_int_equal(lum_capture_next(c, &r, NULL), 1);
        assert_int_equal(r.len, 3);
        assert_string_equal(lum_capture_interface(c), i == 0 ? "0" : names[i]);
    }
    assert_int_equal(lum_capture_next(c, &r, NULL), 1);
    assert_string_equal(lum_capture_interface(c), "0");
    assert_int_equal(lum_capture_next(c, &r, NULL), 0);
    lum_capture_close(c);
}

static void without_names_there_is_one_interface(void **state)
{
    uint8_t bytes[512];
    lum_record r;
    (void)state;
    lum_capture_writer *w = open_pcapng(NULL, 0);
    const lum_datagram d = datagram_of("abc", 3);
    assert_int_equal(lum_capture_writer_add_from(w, 0, &d, NULL), 0);
    assert_int_equal(lum_capture_writer_add_from(w, 1, &d, NULL), -1);
    assert_int_equal(lum_capture_writer_close(w, NULL), 0);
    lum_capture *c = open_bytes(bytes, read_file(bytes, sizeof bytes));
    assert_int_equal(lum_capture_next(c, &r, NULL), 1);
    assert_string_equal(lum_capture_interface(c), "0"); /* its number */
    lum_capture_close(c);
}

static void comments_come_back(void **state)
{
    static uint8_t bytes[LUM_CAPTURE_COMMENT_BYTES_MAX + 1024u];
    static char longest[LUM_CAPTURE_COMMENT_BYTES_MAX + 1u];
    size_t len = 0;
    (void)state;
    memset(longest, 'c', sizeof longest - 1u);
    const char *const comments[] = {"# a\nb: 1\n", longest, "", "# a\nb: 1\n"};
    lum_capture_writer *w = open_pcapng(comments, 4);
    assert_int_equal(lum_capture_writer_close(w, NULL), 0);
    lum_capture *c = open_bytes(bytes, read_file(bytes, sizeof bytes));
    assert_int_equal(lum_capture_comment_count(c, 0), 3); /* two are equal */
    for (size_t i = 0; i < 3; i++) {
        assert_string_equal(lum_capture_comment(c, 0, i, &len), comments[i]);
        assert_int_equal(len, strlen(comments[i]));
    }
    assert_int_equal(lum_capture_comments_left_out(c, 0), 0);
    lum_capture_close(c);
}

static void refuse(const lum_capture_writer_options *o)
{
    lum_capture_writer *w = NULL;
    lum_error error = {""};
    errno = 0;
    assert_int_equal(lum_capture_writer_open_as(path, o, &w, &error), -1);
    assert_int_equal(errno, EINVAL);
    assert_null(w);
    assert_string_not_equal(error.text, "");
}

static void what_a_file_has_no_room_for_is_refused(void **state)
{
    static char longer[LUM_CAPTURE_COMMENT_BYTES_MAX + 2u];
    const char *comments[LUM_CAPTURE_COMMENTS_MAX + 1u] = {longer};
    lum_capture_writer_options o = {.struct_size = sizeof o,
                                    .format = LUM_CAPTURE_PCAPNG,
                                    .comments = comments,
                                    .comment_count = 1};
    (void)state;
    memset(longer, 'c', sizeof longer - 1u);
    refuse(&o);
    o.comment_count = 0;
    o.application = longer;
    refuse(&o);
    o.application = "test";
    o.format = LUM_CAPTURE_PCAP;
    refuse(&o);
    for (size_t i = 0; i <= LUM_CAPTURE_COMMENTS_MAX; i++) {
        comments[i] = "c";
    }
    o.format = LUM_CAPTURE_PCAPNG;
    o.comment_count = LUM_CAPTURE_COMMENTS_MAX + 1u;
    refuse(&o);
    o.comment_count = 0;
    o.application = NULL;
    o.format = (lum_capture_format)7;
    refuse(&o);
    o.format = LUM_CAPTURE_PCAPNG;
    o.struct_size = 0;
    refuse(&o);
}

static void interfaces_without_a_good_name_are_refused(void **state)
{
    static char longer[LUM_INTERFACE_BYTES + 1u];
    const char *names[LUM_CAPTURE_INTERFACES_MAX + 1u] = {"eth0", longer};
    lum_capture_writer_options o = {
        .struct_size = sizeof o, .interfaces = names, .interface_count = 1};
    (void)state;
    refuse(&o); /* pcap */
    o.format = LUM_CAPTURE_PCAPNG;
    o.interface_count = 2;
    memset(longer, 'i', sizeof longer - 1u);
    refuse(&o);
    for (size_t i = 0; i <= LUM_CAPTURE_INTERFACES_MAX; i++) {
        names[i] = "eth0";
    }
    o.interface_count = LUM_CAPTURE_INTERFACES_MAX + 1u;
    refuse(&o);
}

/* A section with one comment of n equal bytes, and an interface. */
static size_t put_section(uint8_t *out, char fill, size_t n)
{
    static char comment[64];
    const char *const comments[] = {comment};
    uint8_t bytes[256];
    memset(comment, fill, sizeof comment);
    comment[n] = '\0';
    lum_capture_writer *w = open_pcapng(comments, 1);
    assert_int_equal(lum_capture_writer_close(w, NULL), 0);
    const size_t len = read_file(bytes, sizeof bytes);
    memcpy(out, bytes, len);
    return len;
}

static void comments_of_later_sections_come_when_they_are_read(void **state)
{
    uint8_t bytes[512];
    lum_record r;
    size_t len = 0;
    (void)state;
    size_t n = put_section(bytes, 'a', 5);
    n += put_section(bytes + n, 'b', 6);
    lum_capture *c = open_bytes(bytes, n);
    assert_int_equal(lum_capture_comment_count(c, 0), 1);
    assert_string_equal(lum_capture_comment(c, 0, 0, &len), "aaaaa");
    assert_int_equal(lum_capture_next(c, &r, NULL), 0);
    assert_int_equal(lum_capture_comment_count(c, 0), 2);
    assert_string_equal(lum_capture_comment(c, 0, 1, &len), "bbbbbb");
    lum_capture_close(c);
}

static void more_comments_than_are_kept_are_counted(void **state)
{
    enum {
        SECTIONS = LUM_CAPTURE_COMMENTS_MAX + 3
    };
    static uint8_t bytes[SECTIONS * 256];
    lum_record r;
    size_t n = 0;
    (void)state;
    for (int i = 0; i < SECTIONS; i++) {
        n += put_section(bytes + n, (char)('a' + i), 9);
    }
    lum_capture *c = open_bytes(bytes, n);
    assert_int_equal(lum_capture_next(c, &r, NULL), 0);
    assert_int_equal(lum_capture_comment_count(c, 0), LUM_CAPTURE_COMMENTS_MAX);
    assert_int_equal(lum_capture_comments_left_out(c, 0), 3);
    lum_capture_close(c);
}

static void a_comment_may_hold_any_bytes(void **state)
{
    static const uint8_t any[] = {0xff, 0, 0x1b, 0x80, '\n'};
    uint8_t bytes[256];
    size_t len = 0;
    (void)state;
    const size_t n = put_section(bytes, 'a', sizeof any);
    uint8_t *at = bytes + 24;
    while (memcmp(at, "aaaaa", 5) != 0) {
        at++;
    }
    memcpy(at, any, sizeof any);
    lum_capture *c = open_bytes(bytes, n);
    const char *text = lum_capture_comment(c, 0, 0, &len);
    assert_int_equal(len, sizeof any);
    assert_memory_equal(text, any, sizeof any);
    assert_int_equal(text[len], '\0');
    lum_capture_close(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pcapng_is_as_written_here),
        cmocka_unit_test(packets_of_any_length_come_back),
        cmocka_unit_test(the_longest_packet_comes_back),
        cmocka_unit_test(datagrams_come_back_from_their_interfaces),
        cmocka_unit_test(without_names_there_is_one_interface),
        cmocka_unit_test(comments_come_back),
        cmocka_unit_test(what_a_file_has_no_room_for_is_refused),
        cmocka_unit_test(interfaces_without_a_good_name_are_refused),
        cmocka_unit_test(comments_of_later_sections_come_when_they_are_read),
        cmocka_unit_test(more_comments_than_are_kept_are_counted),
        cmocka_unit_test(a_comment_may_hold_any_bytes),
    };
    return cmocka_run_group_tests(tests, make_file, remove_file);
}
