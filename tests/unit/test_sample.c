#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lumctl/monitor.h"

#include "lum/laser.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TIME_NS INT64_C(1795836717809000000) /* 2026-11-28T03:31:57.809Z */

/* Nothing is known but that it does not answer. */
static struct sample make_silent(const struct monitor *v)
{
    return (struct sample){.sensor = "10.42.0.37",
                           .utc_ns = TIME_NS,
                           .monitor = v,
                           .is_owned = true,
                           .age_s = -1.0};
}

static struct monitor make_well(void)
{
    return (struct monitor){.knows = true,
                            .answers = true,
                            .has_status = true,
                            .status = LUM_LASER_TLV_CMD_ON,
                            .hazards.since = LUM_LASER_FAN_PWM_BAD,
                            .hazards.count = 3,
                            .hazards.seen_utc_ns = 1500000000,
                            .answered_ns = 1,
                            .round_trip_ns = 1234567};
}

static struct sample make_full(const struct monitor *v)
{
    struct sample g = make_silent(v);
    g.age_s = 0.25;
    g.has_clock = true;
    g.clock.clock_us = 77;
    g.clock.error_ns = 150227;
    g.clock.has_drift = true;
    g.clock.drift_ppb = -7210;
    g.clock.drift_error_ppb = 34;
    g.clock.resets = 2;
    g.utc_offset_ns = -INT64_C(1500000001);
    g.has_counts = true;
    g.session.datagrams = 5;
    g.session.bytes = 6;
    g.session.kernel_drops = 7;
    g.losses.lines = 8;
    g.losses.lines_incomplete = 9;
    g.losses.lines_missing = 10;
    g.losses.words_lost = 11;
    g.losses.refused = 12;
    return g;
}

static const char *json_of(const struct sample *g)
{
    static char text[4096];
    FILE *out = fmemopen(text, sizeof text, "w");
    assert_non_null(out);
    sample_json(g, out);
    assert_int_equal(fclose(out), 0);
    return text;
}

static void silence_is_said_in_every_form(void **state)
{
    const struct monitor v = {.knows = true};
    const struct sample g = make_silent(&v);
    char row[SAMPLE_ROW_BYTES];
    char page[SAMPLE_PAGE_BYTES];
    (void)state;
    sample_text(&g, row);
    assert_string_equal(
        row, "2026-11-28T03:31:57.809Z 10.42.0.37: does not answer\n");
    sample_csv(&g, row);
    assert_string_equal(
        row, "2026-11-28T03:31:57.809Z,10.42.0.37,0,,,,,,,,,,,,,,,\n");
    assert_string_equal(json_of(&g),
                        "{\"time\": \"2026-11-28T03:31:57.809Z\", \"sensor\": "
                        "\"10.42.0.37\", \"answers\": false, "
                        "\"hazards_since\": \"\"}\n");
    sample_page(&g, page);
    assert_string_equal(
        page, "# HELP lumsdk_up Whether the sensor answers.\n"
              "# TYPE lumsdk_up gauge\n"
              "lumsdk_up{sensor=\"10.42.0.37\"} 0\n"
              "# HELP lumsdk_hazards_total Times that a hazard began.\n"
              "# TYPE lumsdk_hazards_total counter\n"
              "lumsdk_hazards_total{sensor=\"10.42.0.37\"} 0\n");
}

static void all_that_is_known_is_in_every_form(void **state)
{
    const struct monitor v = make_well();
    const struct sample g = make_full(&v);
    char row[SAMPLE_ROW_BYTES];
    (void)state;
    sample_text(&g, row);
    assert_string_equal(row, "2026-11-28T03:31:57.809Z 10.42.0.37: laser up: "
                             "TLV_CMD_ON, round trip 1.23 ms, 5 packets, 11 "
                             "words lost; meanwhile: FAN_PWM_BAD\n");
    sample_csv(&g, row);
    assert_string_equal(row, "2026-11-28T03:31:57.809Z,10.42.0.37,1,0.250,up,"
                             "2048,,FAN_PWM_BAD,1.235,"
                             "-1.500000001,0.000150227,-7.210,5,6,7,9,10,11\n");
    assert_string_equal(
        json_of(&g),
        "{\"time\": \"2026-11-28T03:31:57.809Z\", \"sensor\": \"10.42.0.37\", "
        "\"answers\": true, \"answer_age_s\": 0.250, \"status\": 2048, "
        "\"status_hex\": \"0x0800\", "
        "\"bits\": [\"TLV_CMD_ON\"], \"hazards\": [], \"laser\": \"up\", "
        "\"idle\": false, \"hazards_since\": \"FAN_PWM_BAD\", "
        "\"round_trip_ms\": 1.235, \"clock_us\": 77, \"offset_ns\": "
        "-1500000001, \"error_ns\": 150227, \"restarts\": 2, \"drift_ppb\": "
        "-7210, \"drift_error_ppb\": 34, \"packets\": 5, \"bytes\": 6, "
        "\"kernel_drops\": 7, \"lines\": 8, \"lines_incomplete\": 9, "
        "\"lines_missing\": 10, \"lost_words\": 11, \"refused\": 12}\n");
}

/* The value of a metric of the page; NULL: it has none. */
static const char *find(const char *page, const char *metric)
{
    char begin[80];
    (void)snprintf(begin, sizeof begin, "\nlumsdk_%s{sensor=\"10.42.0.37\"",
                   metric);
    const char *at = strstr(page, begin);
    return at != NULL ? strchr(at, '}') + 2 : NULL;
}

static void assert_metric(const char *page, const char *metric,
                          const char *value)
{
    const char *at = find(page, metric);
    assert_non_null(at);
    assert_int_equal(strcspn(at, "\n"), strlen(value));
    assert_memory_equal(at, value, strlen(value));
}

static void a_page_has_all_metrics(void **state)
{
    const struct monitor v = make_well();
    const struct sample g = make_full(&v);
    char page[SAMPLE_PAGE_BYTES];
    (void)state;
    sample_page(&g, page);
    assert_metric(page, "up", "1");
    assert_metric(page, "answer_age_seconds", "0.25");
    assert_metric(page, "round_trip_seconds", "0.001234567");
    assert_metric(page, "laser_up", "1");
    assert_metric(page, "hazard", "0");
    assert_metric(page, "hazards_total", "3");
    assert_metric(page, "last_hazard_timestamp_seconds", "1.500000000");
    assert_metric(page, "clock_offset_seconds", "-1.500000001");
    assert_metric(page, "clock_error_seconds", "0.000150227");
    assert_metric(page, "clock_drift_ratio", "-7.21e-06");
    assert_metric(page, "restarts_total", "2");
    assert_metric(page, "packets_total", "5");
    assert_metric(page, "bytes_total", "6");
    assert_metric(page, "kernel_drops_total", "7");
    assert_metric(page, "incomplete_lines_total", "9");
    assert_metric(page, "missing_lines", "10");
    assert_metric(page, "lost_words_total", "11");
    assert_non_null(strstr(page, "bit=\"TLV_CMD_ON\"} 1\n"));
    assert_non_null(strstr(page, "bit=\"FAN_PWM_BAD\"} 0\n"));
}

/* A clock of before a silence may have restarted in it. */
static void a_silent_sensor_has_no_old_values(void **state)
{
    struct monitor v = make_well();
    const struct sample g = make_full(&v);
    char page[SAMPLE_PAGE_BYTES];
    char row[SAMPLE_ROW_BYTES];
    (void)state;
    v.answers = false;
    sample_page(&g, page);
    assert_metric(page, "up", "0");
    assert_metric(page, "answer_age_seconds", "0.25");
    assert_null(find(page, "laser_up"));
    assert_null(find(page, "status_bit"));
    assert_null(find(page, "round_trip_seconds"));
    assert_null(find(page, "clock_offset_seconds"));
    sample_csv(&g, row);
    assert_non_null(strstr(row, ",0,0.250,,,,FAN_PWM_BAD,,"));
    v.status = LUM_LASER_FAN_PWM_BAD;
    sample_text(&g, row);
    assert_non_null(strstr(row, "does not answer"));
    assert_non_null(strstr(row, "; meanwhile: FAN_PWM_BAD"));
}

static size_t count(const char *text, char c)
{
    size_t n = 0;
    for (; *text != '\0'; text++) {
        n += *text == c ? 1u : 0u;
    }
    return n;
}

/* The longest values have room, and are no more columns. */
static void limits_have_room(void **state)
{
    struct monitor v = make_well();
    struct sample g = make_full(&v);
    char row[SAMPLE_ROW_BYTES];
    char page[SAMPLE_PAGE_BYTES];
    (void)state;
    v.status = UINT16_MAX;
    v.hazards.since = UINT16_MAX;
    v.round_trip_ns = INT64_MAX;
    g.sensor = "255.255.255.255%abcdefghijklmno:65535";
    g.utc_offset_ns = INT64_MIN;
    g.clock.error_ns = INT64_MAX;
    g.clock.drift_ppb = INT32_MIN;
    memset(&g.losses, 0xff, sizeof g.losses);
    memset(&g.session, 0xff, sizeof g.session);
    sample_csv(&g, row);
    assert_int_equal(row[strlen(row) - 1], '\n');
    assert_int_equal(count(row, ','), count(sample_csv_header, ','));
    v.status = LUM_LASER_TLV_CMD_ON;
    sample_text(&g, row);
    assert_int_equal(row[strlen(row) - 1], '\n');
    v.status = UINT16_MAX;
    v.hazards.since = 0;
    sample_text(&g, row);
    assert_int_equal(row[strlen(row) - 1], '\n');
    sample_page(&g, page);
    assert_int_equal(page[strlen(page) - 1], '\n');
    assert_true(strlen(page) < SAMPLE_PAGE_BYTES - 1024);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(silence_is_said_in_every_form),
        cmocka_unit_test(all_that_is_known_is_in_every_form),
        cmocka_unit_test(a_page_has_all_metrics),
        cmocka_unit_test(a_silent_sensor_has_no_old_values),
        cmocka_unit_test(limits_have_room)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
