#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drive.h"
#include "fake_net.h"
#include "lum/frame/reader.h"
#include "lum/net/live.h"

#include <string.h>

#define MS     INT64_C(1000000)
#define SECOND (1000 * MS)
#define LINES  12u

static const lum_endpoint sensor_at = {DRIVE_SENSOR, 40001}; /* a relay's */

static lum_sensor *sensor;
static lum_record_source source = {.struct_size = sizeof source};
static lum_record record;
static lum_error error;

static int set_up(void **state)
{
    lum_sensor_options options;
    (void)state;
    fake_reset();
    lum_sensor_options_default(&options);
    options.sensor = sensor_at;
    options.owns = true;
    assert_int_equal(lum_sensor_open(&options, &sensor, &error), LUM_NET_OK);
    error.text[0] = '\0';
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    lum_sensor_close(sensor);
    sensor = NULL;
    return 0;
}

static void open_live(lum_live_options options)
{
    options.struct_size = sizeof options;
    options.sensor = sensor;
    assert_int_equal(lum_live_source(&options, &source, &error), 0);
}

static int next(void)
{
    return source.next(source.context, &record, &error);
}

/* One datagram at once. */
static void hear(void)
{
    const uint8_t byte = 1;
    fake_arrive(fake.now_ns, sensor_at, &byte, 1);
    assert_int_equal(next(), 1);
}

static void close_live(void)
{
    source.close(source.context);
}

static void datagrams_come_as_records_in_their_order(void **state)
{
    (void)state;
    open_live((lum_live_options){.duration_ms = 1000});
    const int64_t start_ns = fake.now_ns;
    for (uint8_t i = 0; i < 200; i++) { /* more than one receive takes */
        fake_arrive(start_ns + MS * (1 + i / 50), sensor_at, &i, 1);
    }
    for (uint8_t i = 0; i < 200; i++) {
        assert_int_equal(next(), 1);
        assert_int_equal(record.kind, LUM_RECORD_DATAGRAM);
        assert_int_equal(record.len, 1);
        assert_int_equal(record.payload[0], i);
        assert_int_equal(record.source, DRIVE_SENSOR);
        assert_int_equal(record.source_port, LUM_PORT);
        assert_true(record.time_ns >= start_ns + MS * (1 + i / 50));
        assert_int_equal(record.dropped_fragments, 0);
    }
    assert_int_equal(next(), 0);
    assert_int_equal(fake.now_ns, start_ns + SECOND);
    close_live();
}

static void heartbeats_are_sent_while_records_are_read(void **state)
{
    (void)state;
    open_live((lum_live_options){.duration_ms = 2000});
    hear();
    assert_int_equal(next(), 0);
    assert_true(fake_count_sent(LUM_TYPE_HEARTBEAT) >= 10);
    close_live();
}

static void a_sensor_that_never_pauses_does_not_prolong_a_duration(void **state)
{
    (void)state;
    open_live((lum_live_options){.duration_ms = 50});
    const int64_t end_ns = fake.now_ns + 50 * MS;
    fake.floods = UINT32_MAX;
    fake.flooder = sensor_at;
    fake.receive_ns = MS;
    unsigned records = 0;
    while (next() == 1) {
        assert_true(++records < 100000);
    }
    assert_true(records > 0);
    assert_in_range(fake.now_ns, end_ns, end_ns + 2 * MS);
    close_live();
}

static void silence_is_a_failure_that_says_so(void **state)
{
    (void)state;
    open_live((lum_live_options){.duration_ms = 0});
    const int64_t start_ns = fake.now_ns;
    const uint8_t byte = 1;
    fake_arrive(start_ns + 2 * SECOND, sensor_at, &byte, 1);
    assert_int_equal(next(), 1);
    assert_int_equal(next(), -1);
    assert_string_equal(error.text,
                        "nothing came from the sensor for 3000 ms; is it on, "
                        "connected, and at this address?");
    assert_int_equal(fake.now_ns,
                     start_ns + 2 * SECOND + LUM_SENSOR_SILENCE_MS * MS);
    close_live();
}

static void a_duration_that_ends_in_the_silence_is_an_end(void **state)
{
    (void)state;
    open_live((lum_live_options){.duration_ms = 100, .silence_ms = 100});
    hear();
    assert_int_equal(next(), 0);
    close_live();
    open_live((lum_live_options){.duration_ms = 101, .silence_ms = 100});
    hear();
    assert_int_equal(next(), -1);
    close_live();
}

static void a_duration_without_a_datagram_is_a_failure(void **state)
{
    (void)state;
    open_live((lum_live_options){.duration_ms = 2000});
    assert_int_equal(next(), -1);
    assert_non_null(strstr(error.text, "for 2000 ms"));
    assert_int_equal(next(), -1);
    close_live();
}

static void a_socket_that_breaks_is_a_failure(void **state)
{
    (void)state;
    open_live((lum_live_options){.duration_ms = 1000});
    fake.wait_breaks = true;
    assert_int_equal(next(), -1);
    assert_true(error.text[0] != '\0');
    close_live();
}

/* --- Events without datagrams --- */

static struct told {
    unsigned count;
    unsigned last; /* the event at which it says stop; 0: none */
    lum_sensor_event_kind kinds[8];
} told;

static bool take_event(void *context, const lum_sensor_event *event)
{
    assert_ptr_equal(context, &told);
    told.kinds[told.count++ % 8u] = event->kind;
    return told.count != told.last;
}

static void ask_status(void)
{
    assert_int_equal(lum_sensor_request(sensor, NULL, 0), LUM_OK);
}

static void what_brings_no_datagrams_is_told(void **state)
{
    (void)state;
    memset(&told, 0, sizeof told);
    open_live((lum_live_options){.silence_ms = 60000,
                                 .on_event = take_event,
                                 .context = &told,
                                 .duration_ms = 10000});
    hear();
    ask_status(); /* nobody answers */
    assert_int_equal(next(), 0);
    assert_int_equal(told.count, 1);
    assert_int_equal(told.kinds[0], LUM_SENSOR_NO_ANSWER);
    close_live();
}

static void data_is_told_now_and_then(void **state)
{
    (void)state;
    told = (struct told){.last = 4};
    open_live((lum_live_options){.on_event = take_event,
                                 .context = &told,
                                 .data_ms = 20,
                                 .silence_ms = 60000});
    const int64_t start_ns = fake.now_ns;
    for (unsigned i = 0; i < 5; i++) {
        hear();
        fake.now_ns = start_ns + MS * (i + 1u) * 10;
    }
    assert_int_equal(told.count, 3); /* after 0, 20 and 40 ms */
    assert_int_equal(told.kinds[2], LUM_SENSOR_DATAGRAMS);
    fake.now_ns += 20 * MS;
    const uint8_t byte = 1;
    fake_arrive(fake.now_ns, sensor_at, &byte, 1);
    assert_int_equal(next(), 0); /* who is told can end the stream */
    close_live();
}

static void who_is_told_can_end_the_stream(void **state)
{
    (void)state;
    const int64_t start_ns = fake.now_ns;
    told = (struct told){.last = 1};
    open_live((lum_live_options){
        .silence_ms = 60000, .on_event = take_event, .context = &told});
    ask_status();
    assert_int_equal(next(), 0);
    assert_true(fake.now_ns < start_ns + 10 * SECOND);
    close_live();
}

static void without_a_listener_events_are_passed_over(void **state)
{
    (void)state;
    open_live((lum_live_options){.silence_ms = 60000, .duration_ms = 10000});
    hear();
    ask_status();
    assert_int_equal(next(), 0);
    close_live();
}

static void a_cancel_ends_the_stream(void **state)
{
    lum_sensor_options options;
    lum_cancel *const any = (lum_cancel *)(void *)&fake;
    (void)state;
    lum_sensor_close(sensor);
    lum_sensor_options_default(&options);
    options.sensor = sensor_at;
    options.owns = true;
    options.cancel = any;
    assert_int_equal(lum_sensor_open(&options, &sensor, &error), LUM_NET_OK);
    open_live((lum_live_options){.duration_ms = 0});
    fake.is_raised = true;
    assert_int_equal(next(), 0);
    close_live();
}

/* --- Options, and the reader --- */

static void options_without_a_size_or_a_sensor_are_refused(void **state)
{
    (void)state;
    static const char unset[] = "struct_size of the live source's options is "
                                "not set; set it to sizeof(lum_live_options)";
    const struct {
        lum_live_options options;
        const char *says;
    } cases[] = {{{.struct_size = 0, .sensor = sensor}, unset},
                 {{.struct_size = sizeof(size_t), .sensor = sensor}, unset},
                 {{.struct_size = sizeof(lum_live_options), .sensor = NULL},
                  "a live source needs the session of a sensor"}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_int_equal(lum_live_source(&cases[i].options, &source, &error),
                         -1);
        assert_string_equal(error.text, cases[i].says);
    }
}

static void a_source_without_a_size_is_refused(void **state)
{
    const lum_live_options options = {.struct_size = sizeof options,
                                      .sensor = sensor};
    lum_record_source unset = {.next = NULL};
    (void)state;
    assert_int_equal(lum_live_source(&options, &unset, &error), -1);
    assert_string_equal(error.text,
                        "struct_size of the source of records is not set; set "
                        "it to sizeof(lum_record_source)");
    assert_null(unset.context);
}

static void options_of_a_shorter_version_have_defaults_beyond(void **state)
{
    (void)state;
    lum_live_options options;
    memset(&options, 0xa5, sizeof options);
    options.struct_size = offsetof(lum_live_options, duration_ms);
    options.sensor = sensor;
    assert_int_equal(lum_live_source(&options, &source, &error), 0);
    assert_int_equal(next(), -1);
    assert_non_null(strstr(error.text, "for 3000 ms"));
    close_live();
}

static void a_reader_makes_frames_of_a_live_sensor(void **state)
{
    static struct drive_line line;
    lum_record_source live = {.struct_size = sizeof live};
    lum_reader *reader = NULL;
    const lum_frame *frame = NULL;
    size_t points = 0;
    (void)state;
    const lum_live_options options = {
        .struct_size = sizeof options, .sensor = sensor, .duration_ms = 1000};
    assert_int_equal(lum_live_source(&options, &live, &error), 0);
    const int64_t start_ns = fake.now_ns;
    for (uint32_t i = 0; i < 2 * LINES; i++) {
        drive_pixels(&line, LUM_EYE_BLUE, i % LINES, 1000000u + 1000u * i, 0,
                     LUM_LINE_PIXELS);
        for (size_t p = 0; p < line.count; p++) {
            fake_arrive(start_ns + MS * (i + 1), sensor_at, line.bytes[p],
                        line.len[p]);
        }
    }
    const lum_reader_options from = {.struct_size = sizeof from,
                                     .records = &live};
    assert_int_equal(lum_reader_open(&from, &reader, &error), 0);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(lum_reader_next_frame(reader, &frame, &error), 1);
        points += lum_frame_count(frame);
    }
    assert_int_equal(lum_reader_next_frame(reader, &frame, &error), 0);
    assert_int_equal(points, 2 * LINES * LUM_LINE_PIXELS);
    lum_reader_close(reader);
}

/* --- Whether to go on --- */

static unsigned questions;
static int64_t asked_ns;

/* Never longer than 50 ms after the last time. */
static bool answer(void *context)
{
    const int64_t *until_ns = context;
    assert_true(questions == 0 || fake.now_ns - asked_ns <= 50 * MS);
    asked_ns = fake.now_ns;
    questions++;
    return fake.now_ns < *until_ns;
}

static void whoever_reads_is_asked_while_nothing_comes(void **state)
{
    lum_record_source live = {.struct_size = sizeof live};
    lum_reader *reader = NULL;
    const lum_frame *frame = NULL;
    const int64_t until_ns = fake.now_ns + 2 * SECOND;
    (void)state;
    questions = 0;
    const lum_live_options options = {.struct_size = sizeof options,
                                      .sensor = sensor};
    assert_int_equal(lum_live_source(&options, &live, &error), 0);
    const lum_reader_options from = {.struct_size = sizeof from,
                                     .records = &live,
                                     .go_on = answer,
                                     .go_on_context =
                                         (void *)(uintptr_t)&until_ns};
    assert_int_equal(lum_reader_open(&from, &reader, &error), 0);
    for (unsigned i = 0; i < 2; i++) {
        error.text[0] = '\0';
        assert_int_equal(lum_reader_next_frame(reader, &frame, &error), -1);
        assert_string_equal(error.text, "stopped by the caller");
        assert_in_range(fake.now_ns, until_ns, until_ns + 50 * MS);
    }
    assert_true(fake_count_sent(LUM_TYPE_HEARTBEAT) >= 10);
    lum_reader_close(reader);
}

#define FRESH(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        FRESH(datagrams_come_as_records_in_their_order),
        FRESH(heartbeats_are_sent_while_records_are_read),
        FRESH(a_sensor_that_never_pauses_does_not_prolong_a_duration),
        FRESH(silence_is_a_failure_that_says_so),
        FRESH(a_duration_that_ends_in_the_silence_is_an_end),
        FRESH(a_duration_without_a_datagram_is_a_failure),
        FRESH(a_socket_that_breaks_is_a_failure),
        FRESH(what_brings_no_datagrams_is_told),
        FRESH(data_is_told_now_and_then),
        FRESH(who_is_told_can_end_the_stream),
        FRESH(without_a_listener_events_are_passed_over),
        FRESH(a_cancel_ends_the_stream),
        FRESH(options_without_a_size_or_a_sensor_are_refused),
        FRESH(a_source_without_a_size_is_refused),
        FRESH(options_of_a_shorter_version_have_defaults_beyond),
        FRESH(a_reader_makes_frames_of_a_live_sensor),
        FRESH(whoever_reads_is_asked_while_nothing_comes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
