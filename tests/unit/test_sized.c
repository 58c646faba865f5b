/* Structs that tell their size: callers that were compiled with an earlier
 * header, with a later one, or that forgot to set it. */
#define _POSIX_C_SOURCE 200809L
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/sized.h"
#include "lum/capture/capture.h"
#include "lum/capture/demux.h"
#include "lum/capture/source.h"
#include "lum/cloud/writer.h"
#include "lum/frame/reader.h"
#include "lum/net/sensor.h"
#include "support.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    STAYS = 0xa5
};

static char path[] = "/tmp/lum_sized_XXXXXX";

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

/* What a caller of an earlier header places: the sanitizer guards the byte
 * behind it. */
static void *shortened(const void *sized, size_t size)
{
    uint8_t *copy = exact_copy(sized, size);
    memcpy(copy, &size, sizeof size);
    return copy;
}

#define BEFORE(object, member)                                                 \
    shortened(&(object),                                                       \
              (size_t)((uint8_t *)&(object).member - (uint8_t *)&(object)))

/* --- The two functions --- */

struct known {
    size_t struct_size;
    uint32_t a;
    uint32_t b;
};

static void what_is_missing_is_0(void **state)
{
    struct known given = {sizeof given, 1, 2};
    struct known out = {0, 9, 9};
    (void)state;
    void *early = BEFORE(given, b);
    assert_int_equal(
        lum_sized_take(&out, sizeof out, early, "this", "known", NULL), 0);
    assert_int_equal(out.struct_size, sizeof out);
    assert_int_equal(out.a, 1);
    assert_int_equal(out.b, 0);
    free(early);
}

static void what_is_not_known_is_left_alone(void **state)
{
    struct {
        struct known known;
        uint64_t later;
    } there = {{sizeof there, 1, 2}, 3};
    const struct known here = {sizeof here, 4, 5};
    struct known out;
    (void)state;
    assert_int_equal(
        lum_sized_take(&out, sizeof out, &there, "this", "known", NULL), 0);
    assert_int_equal(out.struct_size, sizeof out);
    assert_int_equal(out.b, 2);
    assert_true(lum_sized_fill(&there, &here, sizeof here));
    assert_int_equal(there.known.struct_size, sizeof there);
    assert_int_equal(there.known.a, 4);
    assert_int_equal(there.known.b, 5);
    assert_int_equal(there.later, 3);
}

static void nothing_is_given_where_nothing_is_known(void **state)
{
    const struct known here = {sizeof here, 4, 5};
    struct known out = {0, 9, 9};
    (void)state;
    for (out.struct_size = 0; out.struct_size <= sizeof(size_t);
         out.struct_size++) {
        assert_false(lum_sized_fill(&out, &here, sizeof here));
        assert_int_equal(out.a, 9);
        assert_int_equal(out.b, 9);
    }
}

/* --- A size that is not set --- */

static void assert_says(const lum_error *error, const char *what,
                        const char *type)
{
    char expected[LUM_ERROR_BYTES];
    (void)snprintf(expected, sizeof expected,
                   "struct_size of %s is not set; set it to sizeof(%s)", what,
                   type);
    assert_string_equal(error->text, expected);
}

static void the_smallest_size_has_a_member(void **state)
{
    struct known given = {0, 1, 2};
    struct known out;
    lum_error error = {""};
    (void)state;
    for (given.struct_size = 0; given.struct_size <= sizeof(size_t);
         given.struct_size++) {
        errno = 0;
        assert_int_equal(
            lum_sized_take(&out, sizeof out, &given, "this", "known", &error),
            -1);
        assert_int_equal(errno, EINVAL);
        assert_says(&error, "this", "known");
    }
    assert_int_equal(
        lum_sized_take(&out, sizeof out, &given, "this", "known", NULL), 0);
}

static void a_capture_names_what_is_not_set(void **state)
{
    const lum_demux_options demux_options = {.struct_size = 0};
    const lum_source_functions functions = {.struct_size = 0};
    const lum_capture_writer_options options = {.struct_size = 0};
    lum_demux *demux = NULL;
    lum_capture_writer *writer = NULL;
    lum_error error = {""};
    (void)state;
    assert_int_equal(lum_demux_new(&demux_options, &demux, &error), -1);
    assert_null(demux);
    assert_says(&error, "the demultiplexer's options", "lum_demux_options");
    assert_null(lum_source_from_functions("x", &functions, &error));
    assert_says(&error, "the source's functions", "lum_source_functions");
    assert_int_equal(
        lum_capture_writer_open_as(path, &options, &writer, &error), -1);
    assert_says(&error, "the capture writer's options",
                "lum_capture_writer_options");
}

static void a_cloud_names_what_is_not_set(void **state)
{
    lum_writer_options options = {.format = LUM_FORMAT_XYZ};
    const lum_sample sample = {.return_number = 1};
    lum_line_samples line = {.samples = &sample, .count = 1};
    lum_writer *writer = NULL;
    lum_error error = {""};
    (void)state;
    assert_int_equal(lum_writer_open(path, &options, &writer, &error), -1);
    assert_says(&error, "the writer's options", "lum_writer_options");
    error.text[0] = '\0';
    assert_int_equal(lum_writer_rehearse(&options, &writer, &error), -1);
    assert_says(&error, "the writer's options", "lum_writer_options");
    options.struct_size = sizeof options;
    assert_int_equal(lum_writer_open(path, &options, &writer, &error), 0);
    assert_int_equal(lum_writer_add(writer, &line, &error), -1);
    assert_says(&error, "the line", "lum_line_samples");
    line.struct_size = sizeof line;
    assert_int_equal(lum_writer_add(writer, &line, &error), 0);
    assert_int_equal(lum_writer_close(writer, &error), 0);
}

static void a_session_names_what_is_not_set(void **state)
{
    const lum_socket_options socket_options = {.struct_size = 0};
    lum_sensor_options options;
    lum_socket *socket = NULL;
    lum_sensor *sensor = NULL;
    lum_error error = {""};
    (void)state;
    assert_int_equal(lum_socket_open(&socket_options, &socket, &error),
                     LUM_NET_FAILED);
    assert_says(&error, "the socket's options", "lum_socket_options");
    lum_sensor_options_default(&options);
    assert_int_equal(options.struct_size, sizeof options);
    options.struct_size = 0;
    assert_int_equal(lum_sensor_open(&options, &sensor, &error),
                     LUM_NET_FAILED);
    assert_says(&error, "the session's options", "lum_sensor_options");
}

static void a_reader_names_what_is_not_set(void **state)
{
    const lum_record_source records = {.next = NULL};
    lum_reader_options options = {.records = &records};
    const lum_framer_options framer_options = {.points_max = 1};
    lum_framer *framer = NULL;
    lum_reader *reader = NULL;
    lum_error error = {""};
    (void)state;
    assert_int_equal(lum_reader_open(&options, &reader, &error), -1);
    assert_says(&error, "the reader's options", "lum_reader_options");
    options.struct_size = sizeof options;
    assert_int_equal(lum_reader_open(&options, &reader, &error), -1);
    assert_says(&error, "the source of records", "lum_record_source");
    assert_int_equal(lum_framer_new(&framer_options, &framer, &error), -1);
    assert_says(&error, "the framer's options", "lum_framer_options");
}

/* --- An earlier caller --- */

static int64_t give_nothing(void *context, void *buffer, size_t room,
                            lum_error *error)
{
    (void)context;
    (void)buffer;
    (void)room;
    (void)error;
    return 0;
}

static void an_earlier_source_has_no_total(void **state)
{
    const lum_source_functions functions = {
        .struct_size = sizeof functions, .read = give_nothing, .total = 1000};
    lum_capture *capture = NULL;
    lum_error error = {""};
    (void)state;
    void *early = BEFORE(functions, total);
    lum_source *source = lum_source_from_functions("early", early, &error);
    assert_non_null(source);
    assert_int_equal(lum_capture_open_source(source, &capture, &error), -1);
    assert_non_null(strstr(error.text, "early"));
    free(early);
}

static void a_source_needs_a_function_that_reads(void **state)
{
    const lum_source_functions functions = {.struct_size = sizeof functions,
                                            .total = 1000};
    lum_error error = {""};
    (void)state;
    assert_null(lum_source_from_functions("x", &functions, &error));
    assert_non_null(strstr(error.text, "reads"));
}

static void write_capture(void)
{
    const char *const comments[] = {"one"};
    const lum_capture_writer_options o = {.struct_size = sizeof o,
                                          .format = LUM_CAPTURE_PCAPNG,
                                          .is_whole = true,
                                          .application = "early",
                                          .comments = comments,
                                          .comment_count = 1};
    const lum_datagram datagram = {.payload = (const uint8_t *)"abc",
                                   .len = 3,
                                   .source = 0x0a2a0025,
                                   .destination = 0x0a2a0001,
                                   .source_port = 5517};
    lum_capture_writer *writer = NULL;
    void *early = BEFORE(o, comments);
    assert_int_equal(lum_capture_writer_open_as(path, early, &writer, NULL), 0);
    assert_int_equal(lum_capture_writer_add(writer, &datagram, NULL), 0);
    assert_int_equal(lum_capture_writer_close(writer, NULL), 0);
    free(early);
}

static void an_earlier_caller_learns_of_a_source_what_it_knows(void **state)
{
    lum_capture *capture = NULL;
    lum_record record;
    lum_capture_source whole;
    (void)state;
    write_capture();
    assert_int_equal(lum_capture_open(path, &capture, NULL), 0);
    assert_int_equal(lum_capture_comment_count(capture, 0), 0);
    memset(&whole, 0, sizeof whole);
    assert_int_equal(lum_capture_get_source(capture, 0, &whole), LUM_E_VALUE);
    assert_null(whole.name);
    while (lum_capture_next(capture, &record, NULL) > 0) {
    }
    memset(&whole, STAYS, sizeof whole);
    lum_capture_source *early = BEFORE(whole, first_ns);
    assert_int_equal(lum_capture_get_source(capture, 0, early), LUM_OK);
    assert_string_equal(early->name, path);
    assert_int_equal(early->records, 1);
    assert_int_equal(early->struct_size,
                     offsetof(lum_capture_source, first_ns));
    free(early);
    whole.struct_size = sizeof whole;
    assert_int_equal(lum_capture_get_source(capture, 0, &whole), LUM_OK);
    assert_int_equal(whole.end, LUM_CAPTURE_WHOLE);
    lum_capture_close(capture);
}

/* The sensor that is asked for is beyond what this caller knows of. */
static void an_earlier_demultiplexer_takes_every_sensor(void **state)
{
    static const uint8_t heartbeat[LUM_HEARTBEAT_BYTES] = {
        0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe, 0x34, 0x12, 8, 0, 0, 0};
    const lum_record record = {.payload = heartbeat,
                               .len = sizeof heartbeat,
                               .source = 2,
                               .destination = 3,
                               .source_port = LUM_PORT,
                               .destination_port = LUM_PORT,
                               .kind = LUM_RECORD_DATAGRAM};
    lum_demux_options options = {
        .struct_size = sizeof options, .has_sensor = true, .sensor = 1};
    lum_demux_counters all = {.struct_size = sizeof all};
    lum_demux *demux = NULL;
    (void)state;
    lum_layout_default(&options.layout);
    lum_assembler_config_default(&options.config);
    void *early = BEFORE(options, has_sensor);
    assert_int_equal(lum_demux_new(early, &demux, NULL), 0);
    assert_int_equal(lum_demux_push(demux, &record, NULL), LUM_OK);
    assert_int_equal(lum_demux_total(demux, &all), LUM_OK);
    assert_int_equal(all.packets[LUM_PACKET_HEARTBEAT], 1);
    free(early);

    lum_demux_counters filled;
    memset(&filled, STAYS, sizeof filled);
    lum_demux_counters *counters = BEFORE(filled, angle_packets);
    assert_int_equal(lum_demux_total(demux, counters), LUM_OK);
    assert_int_equal(counters->packets[LUM_PACKET_HEARTBEAT], 1);
    assert_int_equal(counters->struct_size,
                     offsetof(lum_demux_counters, angle_packets));
    free(counters);
    all = (lum_demux_counters){.struct_size = 0};
    assert_int_equal(lum_demux_total(demux, &all), LUM_E_VALUE);
    assert_int_equal(all.packets[LUM_PACKET_HEARTBEAT], 0);
    lum_demux_free(demux);
}

static void read_text(char *out, size_t room)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t n = fread(out, 1, room - 1u, file);
    out[n] = '\0';
    (void)fclose(file);
}

/* No comment, and the line and the eye of each line are 0. */
static void an_earlier_writer_writes_what_it_knows(void **state)
{
    const lum_writer_options options = {.struct_size = sizeof options,
                                        .format = LUM_FORMAT_CSV,
                                        .comment = "later"};
    const lum_sample sample = {.return_number = 1};
    const lum_line_samples line = {.struct_size = sizeof line,
                                   .samples = &sample,
                                   .count = 1,
                                   .frame = 77,
                                   .timestamp_us = 88,
                                   .line = 99,
                                   .eye = 1};
    char text[1000];
    lum_writer *writer = NULL;
    (void)state;
    void *early_options = BEFORE(options, comment);
    void *early_line = BEFORE(line, line);
    assert_int_equal(lum_writer_open(path, early_options, &writer, NULL), 0);
    assert_int_equal(lum_writer_add(writer, early_line, NULL), 0);
    assert_int_equal(lum_writer_close(writer, NULL), 0);
    free(early_options);
    free(early_line);
    read_text(text, sizeof text);
    assert_null(strstr(text, "later"));
    assert_non_null(strstr(text, ",88,77,0,0,"));
    assert_null(strstr(text, "99"));
}

static void an_earlier_session_is_one(void **state)
{
    lum_sensor_options options;
    lum_sensor_counters counters;
    lum_sensor *sensor = NULL;
    (void)state;
    lum_sensor_options_default(&options);
    options.cancel = (lum_cancel *)(void *)&options; /* would crash */
    void *early = BEFORE(options, cancel);
    assert_int_equal(lum_sensor_open(early, &sensor, NULL), LUM_NET_OK);
    free(early);
    memset(&counters, STAYS, sizeof counters);
    lum_sensor_counters *known = BEFORE(counters, bytes);
    assert_int_equal(lum_sensor_count(sensor, known), LUM_OK);
    assert_int_equal(known->datagrams, 0);
    assert_int_equal(known->struct_size, offsetof(lum_sensor_counters, bytes));
    free(known);
    counters.struct_size = 0;
    assert_int_equal(lum_sensor_count(sensor, &counters), LUM_E_VALUE);
    lum_sensor_close(sensor);
}

static void an_earlier_socket_has_the_systems_buffer(void **state)
{
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .interface_name = "nonesuch0"};
    lum_socket *socket = NULL;
    (void)state;
    void *early = BEFORE(options, interface_name);
    assert_int_equal(lum_socket_open(early, &socket, NULL), LUM_NET_OK);
    lum_socket_close(socket);
    free(early);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_missing_is_0),
        cmocka_unit_test(what_is_not_known_is_left_alone),
        cmocka_unit_test(nothing_is_given_where_nothing_is_known),
        cmocka_unit_test(the_smallest_size_has_a_member),
        cmocka_unit_test(a_capture_names_what_is_not_set),
        cmocka_unit_test(a_cloud_names_what_is_not_set),
        cmocka_unit_test(a_session_names_what_is_not_set),
        cmocka_unit_test(a_reader_names_what_is_not_set),
        cmocka_unit_test(an_earlier_source_has_no_total),
        cmocka_unit_test(a_source_needs_a_function_that_reads),
        cmocka_unit_test(an_earlier_caller_learns_of_a_source_what_it_knows),
        cmocka_unit_test(an_earlier_demultiplexer_takes_every_sensor),
        cmocka_unit_test(an_earlier_writer_writes_what_it_knows),
        cmocka_unit_test(an_earlier_session_is_one),
        cmocka_unit_test(an_earlier_socket_has_the_systems_buffer),
    };
    return cmocka_run_group_tests(tests, make_file, remove_file);
}
