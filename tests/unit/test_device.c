#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/command.h"
#include "lum/host/yscan.h"
#include "lum/laser.h"
#include "lum/wire.h"
#include "sim/device.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SECOND INT64_C(1000000000)
#define BOOT   (17 * SECOND)

static const lum_device_peer alice = {0x0a2a0001u, 40000};
static const lum_device_peer bob = {0x0a2a0002u, 40001};

struct fixture {
    lum_device device;
    lum_device_effects fx;
    int64_t now;
    uint32_t sequence;
    uint8_t packet[LUM_DEVICE_REPLY_BYTES];
    size_t len;
    /* of the last reply */
    uint16_t status;
    unsigned debugs;
    char debug[LUM_DEVICE_REPLY_BYTES]; /* all of them, a line each */
};

static int set_up(void **state)
{
    struct fixture *f = calloc(1, sizeof *f);
    lum_layout layout;
    if (f == NULL) {
        return -1;
    }
    lum_layout_default(&layout);
    f->now = BOOT;
    f->sequence = 700;
    lum_device_init(&f->device, &layout, 64, LUM_DEVICE_BOOT_STATUS, 0, f->now);
    *state = f;
    return 0;
}

static int tear_down(void **state)
{
    free(*state);
    return 0;
}

/* From memory of the exact size, so that a sanitizer sees a read behind it. */
static void receive_from(struct fixture *f, lum_device_peer from,
                         const void *bytes, size_t len)
{
    uint8_t *exact = malloc(len > 0 ? len : 1);
    assert_non_null(exact);
    memcpy(exact, bytes, len);
    memset(&f->fx, 0xa5, sizeof f->fx);
    lum_device_receive(&f->device, f->now, from, exact, len, &f->fx);
    free(exact);
    assert_true(strlen(f->fx.note) > 0);
}

static void heartbeat(struct fixture *f, lum_device_peer from)
{
    uint8_t packet[LUM_HEARTBEAT_BYTES];
    lum_heartbeat_encode(packet);
    receive_from(f, from, packet, sizeof packet);
    assert_false(f->fx.has_reply);
}

/* Reads the reply: its sequence, a status first, then only debug texts. */
static void read_reply(struct fixture *f, uint32_t sequence)
{
    lum_tlv_reader reader;
    lum_tlv tlv;
    uint32_t found = 0;
    size_t used = 0;
    assert_true(f->fx.has_reply);
    assert_in_range(f->fx.reply_len, 1, LUM_DEVICE_REPLY_BYTES);
    assert_int_equal(
        lum_tlv_open(f->fx.reply, f->fx.reply_len, &found, &reader), LUM_OK);
    assert_int_equal(found, sequence);
    assert_int_equal(lum_tlv_next(&reader, &tlv), LUM_OK);
    assert_int_equal(tlv.type, 2);
    assert_int_equal(tlv.length, 2);
    assert_int_equal(lum_tlv_u16(&tlv, &f->status), LUM_OK);
    assert_int_equal(f->status, f->device.status);
    f->debugs = 0;
    lum_result result = LUM_OK;
    while ((result = lum_tlv_next(&reader, &tlv)) == LUM_OK) {
        assert_int_equal(tlv.type, 3);
        memcpy(f->debug + used, tlv.value, tlv.length);
        used += tlv.length;
        f->debug[used++] = '\n';
        f->debugs++;
    }
    assert_int_equal(result, LUM_END);
    f->debug[used] = '\0';
}

static lum_tlv_writer begin(struct fixture *f)
{
    lum_tlv_writer writer;
    assert_int_equal(
        lum_tlv_begin(&writer, f->packet, sizeof f->packet, ++f->sequence),
        LUM_OK);
    return writer;
}

static void add(lum_tlv_writer *writer, uint16_t type, const char *text)
{
    assert_int_equal(lum_tlv_add(writer, type, text, (uint16_t)strlen(text)),
                     LUM_OK);
}

static void send_packet(struct fixture *f, const lum_tlv_writer *writer)
{
    receive_from(f, alice, writer->out, writer->len);
    read_reply(f, f->sequence);
}

static void command(struct fixture *f, const char *text)
{
    lum_tlv_writer writer = begin(f);
    add(&writer, 1, text);
    send_packet(f, &writer);
}

static void table(struct fixture *f, const int16_t *elevations, size_t n)
{
    lum_tlv_writer writer = begin(f);
    assert_int_equal(lum_yscan_add(&writer, 4, elevations, n), LUM_OK);
    send_packet(f, &writer);
}

static void tick(struct fixture *f, int64_t by_ns)
{
    f->now += by_ns;
    memset(&f->fx, 0xa5, sizeof f->fx);
    lum_device_tick(&f->device, f->now, &f->fx);
}

static void switch_on(struct fixture *f)
{
    heartbeat(f, alice);
    command(f, "u");
    assert_true(lum_device_laser_is_up(&f->device));
}

static void a_fresh_sensor_is_dark_and_silent(void **state)
{
    struct fixture *f = *state;
    const lum_device_settings *s = &f->device.settings;
    assert_int_equal(f->device.status, LUM_LASER_HEARTBEAT_TIMEOUT);
    assert_false(lum_device_laser_is_up(&f->device));
    assert_false(f->device.is_streaming);
    assert_false(f->device.has_client);
    assert_true(lum_device_next_ns(&f->device) == INT64_MAX);
    assert_int_equal(lum_device_clock_us(&f->device, f->now), 0);
    assert_true(lum_device_gain(&f->device, f->now) == 0.0f);
    assert_int_equal(s->power, 100);
    assert_int_equal(s->threshold[LUM_EYE_BLUE], 50);
    assert_int_equal(s->threshold[LUM_EYE_GREEN], 50);
    assert_int_equal(s->holdoff, 200);
    assert_int_equal(s->offset[0] + s->offset[1], 0);
    assert_int_equal(s->lines, 64);
    assert_int_equal(s->fov_deg, 0);
    assert_int_equal(s->yscan_count, 0);
    tick(f, 100 * SECOND);
    assert_false(f->fx.has_reply || f->fx.status_changed ||
                 f->fx.laser_changed || f->fx.streaming_changed);
}

static void boot(struct fixture *f, uint16_t status)
{
    const lum_layout layout = f->device.layout;
    lum_device_init(&f->device, &layout, 64, status, 0, f->now);
}

static void a_status_at_boot_is_kept(void **state)
{
    struct fixture *f = *state;
    boot(f, 0xffff);
    assert_int_equal(f->device.status, 0xf7ff);
    boot(f, 0);
    assert_true(lum_device_next_ns(&f->device) ==
                f->now + LUM_DEVICE_TIMEOUT_NS);
    heartbeat(f, alice);
    assert_int_equal(f->device.status, 0);
    assert_false(lum_device_laser_is_up(&f->device));
    boot(f, 0);
    command(f, "u"); /* refused, as without any heartbeats */
    assert_int_equal(f->device.status, 0);
    tick(f, LUM_DEVICE_TIMEOUT_NS);
    assert_int_equal(f->device.status, LUM_LASER_HEARTBEAT_TIMEOUT);
    assert_false(f->fx.streaming_changed);
}

static void ask_time(struct fixture *f, uint32_t sequence)
{
    uint8_t packet[LUM_TIMESTAMP_BYTES];
    const lum_timestamp request = {sequence, 0xffffffffu};
    lum_timestamp_encode(packet, &request);
    receive_from(f, bob, packet, sizeof packet);
}

static void expect_time(struct fixture *f, uint32_t sequence, uint32_t clock)
{
    lum_timestamp answer = {0, 0};
    ask_time(f, sequence);
    assert_true(f->fx.has_reply);
    assert_int_equal(f->fx.reply_len, LUM_TIMESTAMP_BYTES);
    assert_int_equal(
        lum_timestamp_decode(f->fx.reply, f->fx.reply_len, &answer), LUM_OK);
    assert_int_equal(answer.sequence, sequence);
    assert_int_equal(answer.clock_us, clock);
    assert_string_equal(f->fx.note, "timestamp");
}

static void timestamps_tell_the_clock_since_boot(void **state)
{
    struct fixture *f = *state;
    expect_time(f, 1, 0);
    f->now += 1999;
    expect_time(f, 0xffffffffu, 1);
    f->now = BOOT + 100 * SECOND;
    expect_time(f, 0, 100000000);
    assert_false(f->device.has_client);
}

static void the_clock_wraps_at_32_bits(void **state)
{
    struct fixture *f = *state;
    const lum_layout layout = f->device.layout;
    lum_device_init(&f->device, &layout, 64, LUM_DEVICE_BOOT_STATUS,
                    0xfffffff0u, f->now);
    expect_time(f, 1, 0xfffffff0u);
    f->now += 15000;
    expect_time(f, 2, 0xffffffffu);
    f->now += 1000;
    expect_time(f, 3, 0);
    /* Longer than any 32 bits of microseconds. */
    f->now += (INT64_C(3) << 32) * 1000 + 5000;
    expect_time(f, 4, 5);
}

static void a_heartbeat_starts_the_data_to_its_sender(void **state)
{
    struct fixture *f = *state;
    heartbeat(f, alice);
    assert_true(f->device.is_streaming);
    assert_true(f->fx.streaming_changed && f->fx.status_changed);
    assert_int_equal(f->device.client.address, alice.address);
    assert_int_equal(f->device.client.port, alice.port);
    assert_int_equal(f->device.status, 0);
    assert_false(lum_device_laser_is_up(&f->device));
    heartbeat(f, alice);
    assert_false(f->fx.streaming_changed || f->fx.status_changed);
    heartbeat(f, bob);
    assert_true(f->fx.streaming_changed);
    assert_int_equal(f->device.client.address, bob.address);
    assert_int_equal(f->device.client.port, bob.port);
}

static void three_seconds_without_one_end_laser_and_data(void **state)
{
    struct fixture *f = *state;
    switch_on(f);
    assert_true(lum_device_next_ns(&f->device) == BOOT + LUM_DEVICE_TIMEOUT_NS);
    tick(f, LUM_DEVICE_TIMEOUT_NS - 1);
    assert_true(lum_device_laser_is_up(&f->device));
    assert_true(f->device.is_streaming);
    assert_false(f->fx.status_changed || f->fx.has_reply);
    tick(f, 1);
    assert_false(lum_device_laser_is_up(&f->device));
    assert_false(f->device.is_streaming);
    assert_true(f->fx.laser_changed && f->fx.streaming_changed);
    assert_true(f->fx.status_changed);
    assert_string_equal(f->fx.note, "heartbeat timeout");
    assert_true(lum_device_next_ns(&f->device) == INT64_MAX);
    read_reply(f, 0);
    assert_int_equal(f->status,
                     LUM_LASER_HEARTBEAT_TIMEOUT | LUM_LASER_TLV_CMD_OFF);
    tick(f, SECOND);
    assert_false(f->fx.status_changed || f->fx.has_reply);
}

static void heartbeats_keep_the_laser_on(void **state)
{
    struct fixture *f = *state;
    switch_on(f);
    for (unsigned i = 0; i < 20; i++) {
        tick(f, LUM_DEVICE_TIMEOUT_NS - 1);
        assert_true(lum_device_laser_is_up(&f->device));
        heartbeat(f, i % 2 == 0 ? alice : bob);
        assert_true(f->device.is_streaming);
    }
}

static void nothing_else_counts_as_a_heartbeat(void **state)
{
    struct fixture *f = *state;
    switch_on(f);
    for (unsigned i = 0; i < 3; i++) {
        f->now += SECOND;
        ask_time(f, i);
        command(f, "50p");
    }
    assert_false(lum_device_laser_is_up(&f->device));
    assert_int_equal(f->status,
                     LUM_LASER_HEARTBEAT_TIMEOUT | LUM_LASER_TLV_CMD_OFF);
}

static void a_datagram_finds_the_timeout_done(void **state)
{
    struct fixture *f = *state;
    switch_on(f);
    f->now += LUM_DEVICE_TIMEOUT_NS;
    ask_time(f, 1);
    assert_true(f->fx.laser_changed && f->fx.streaming_changed);
    assert_string_equal(f->fx.note, "heartbeat timeout; timestamp");
    switch_on(f);
    f->now += LUM_DEVICE_TIMEOUT_NS;
    heartbeat(f, alice);
    assert_true(f->fx.laser_changed);
    assert_false(lum_device_laser_is_up(&f->device));
}

static void after_a_timeout_data_resumes_and_the_laser_waits(void **state)
{
    struct fixture *f = *state;
    switch_on(f);
    tick(f, 5 * SECOND);
    heartbeat(f, alice);
    assert_true(f->fx.streaming_changed && f->fx.status_changed);
    assert_true(f->device.is_streaming);
    assert_false(lum_device_laser_is_up(&f->device));
    assert_false(f->device.status & LUM_LASER_HEARTBEAT_TIMEOUT);
    assert_true(lum_laser_is_down(f->device.status));
    command(f, "u");
    assert_true(lum_device_laser_is_up(&f->device));
}

static void no_u_without_heartbeat(void **state)
{
    struct fixture *f = *state;
    for (unsigned i = 0; i < 2; i++) {
        command(f, "u");
        assert_int_equal(f->debugs, 1);
        assert_non_null(strstr(f->debug, "refused u: no heartbeat"));
        assert_string_equal(f->fx.note, "refused u");
        assert_false(f->status & LUM_LASER_TLV_CMD_ON);
        heartbeat(f, alice);
        assert_false(lum_device_laser_is_up(&f->device));
        command(f, "u");
        assert_true(lum_device_laser_is_up(&f->device));
        tick(f, 3 * SECOND);
    }
}

static void u_and_d_switch_the_laser(void **state)
{
    struct fixture *f = *state;
    heartbeat(f, alice);
    command(f, "u");
    assert_int_equal(f->status, LUM_LASER_TLV_CMD_ON);
    assert_true(f->fx.laser_changed && f->fx.status_changed);
    assert_string_equal(f->fx.note, "u");
    command(f, "u");
    assert_int_equal(f->status, LUM_LASER_TLV_CMD_ON);
    assert_false(f->fx.laser_changed || f->fx.status_changed);
    command(f, "d");
    assert_int_equal(f->status, LUM_LASER_TLV_CMD_OFF);
    assert_true(f->fx.laser_changed && f->fx.status_changed);
    assert_false(lum_device_laser_is_up(&f->device));
    assert_int_equal(f->debugs, 0);
}

static void returns_come_to_full_strength_in_time(void **state)
{
    struct fixture *f = *state;
    float before = 0.05f;
    switch_on(f);
    assert_float_equal(lum_device_gain(&f->device, f->now), 0.1, 1e-6);
    for (unsigned i = 1; i <= 10; i++) {
        const float gain = lum_device_gain(
            &f->device, f->now + (int64_t)i * LUM_DEVICE_WARM_UP_NS / 10);
        assert_true(gain > before);
        before = gain;
    }
    assert_float_equal(before, 1.0, 1e-6);
    assert_float_equal(lum_device_gain(&f->device, f->now + 2 * SECOND), 0.7,
                       1e-6);
    /* A repeated u does not cool it. */
    f->now += 2 * SECOND;
    command(f, "u");
    assert_float_equal(lum_device_gain(&f->device, f->now), 0.7, 1e-6);
    command(f, "50p");
    assert_float_equal(lum_device_gain(&f->device, f->now), 0.35, 1e-6);
    command(f, "d");
    assert_true(lum_device_gain(&f->device, f->now) == 0.0f);
    command(f, "u");
    assert_float_equal(lum_device_gain(&f->device, f->now), 0.05, 1e-6);
}

static void set_hazards(struct fixture *f, uint16_t set, uint16_t clear)
{
    memset(&f->fx, 0xa5, sizeof f->fx);
    lum_device_set_hazards(&f->device, set, clear, f->now, &f->fx);
}

static void a_hazard_keeps_the_laser_down(void **state)
{
    struct fixture *f = *state;
    switch_on(f);
    f->now += SECOND;
    set_hazards(f, LUM_LASER_FAN_PWM_BAD | LUM_LASER_BOARD_OVER_105, 0);
    assert_true(f->fx.laser_changed && f->fx.status_changed);
    assert_false(f->fx.streaming_changed);
    assert_string_equal(f->fx.note, "BOARD_OVER_105 set; FAN_PWM_BAD set");
    read_reply(f, 0);
    assert_int_equal(f->status, 0x0860);
    assert_false(lum_device_laser_is_up(&f->device));
    command(f, "d");
    command(f, "u");
    assert_int_equal(f->status, 0x0860);
    assert_false(lum_device_laser_is_up(&f->device));
    set_hazards(f, 0, LUM_LASER_FAN_PWM_BAD);
    assert_false(lum_device_laser_is_up(&f->device));
    read_reply(f, 0);
    set_hazards(f, 0, LUM_LASER_FAN_PWM_BAD);
    assert_false(f->fx.status_changed || f->fx.has_reply);
    set_hazards(f, 0, LUM_LASER_BOARD_OVER_105);
    assert_true(lum_device_laser_is_up(&f->device));
    assert_true(f->fx.laser_changed);
    assert_float_equal(lum_device_gain(&f->device, f->now), 0.1, 1e-6);
}

static void hazards_leave_the_bits_of_commands_alone(void **state)
{
    struct fixture *f = *state;
    heartbeat(f, alice);
    set_hazards(f, 0xffff, 0);
    assert_int_equal(f->device.status, 0xffff & ~0x0a10);
    set_hazards(f, 0, 0xffff);
    assert_int_equal(f->device.status, 0);
}

static void nobody_is_alerted_before_a_client_came(void **state)
{
    struct fixture *f = *state;
    set_hazards(f, LUM_LASER_FAN_PWM_BAD, 0);
    assert_true(f->fx.status_changed);
    assert_false(f->fx.has_reply);
}

static void every_command_sets_its_own_setting(void **state)
{
    struct fixture *f = *state;
    const lum_device_settings *s = &f->device.settings;
    command(f, "1p 2g 3b 0f 11y 250h 29G 30B d");
    assert_string_equal(f->fx.note, "1p; 2g; 3b; 0f; 11y; 250h; 29G; 30B; d");
    assert_int_equal(f->debugs, 0);
    assert_true(f->fx.settings_changed && f->fx.geometry_changed);
    assert_int_equal(s->power, 1);
    assert_int_equal(s->threshold[LUM_EYE_GREEN], 2);
    assert_int_equal(s->threshold[LUM_EYE_BLUE], 3);
    assert_int_equal(s->lines, 640);
    assert_int_equal(s->fov_deg, 11);
    assert_int_equal(s->holdoff, 250);
    assert_int_equal(s->offset[LUM_EYE_GREEN], 29);
    assert_int_equal(s->offset[LUM_EYE_BLUE], 30);
    command(f, "1p 2g 3b 0f 11y 250h 29G 30B d");
    assert_false(f->fx.settings_changed || f->fx.geometry_changed);
    command(f, "2p");
    assert_true(f->fx.settings_changed);
    assert_false(f->fx.geometry_changed);
    command(f, "1f");
    assert_true(f->fx.settings_changed && f->fx.geometry_changed);
    assert_int_equal(s->lines, 64);
    assert_int_equal(s->fov_deg, 11);
}

static bool set_changes(struct fixture *f, unsigned id, uint16_t value)
{
    char text[16];
    (void)snprintf(text, sizeof text, "%u%c", (unsigned)value,
                   lum_command_specs[id].letter);
    command(f, text);
    assert_int_equal(f->debugs, 0);
    return f->fx.settings_changed;
}

/* Of all commands that there are. */
static void another_value_is_a_change_of_settings(void **state)
{
    struct fixture *f = *state;
    for (unsigned id = 0; id < LUM_COMMANDS; id++) {
        const lum_command_spec *spec = &lum_command_specs[id];
        if (spec->has_value) {
            (void)set_changes(f, id, spec->min);
            assert_true(set_changes(f, id, spec->max));
            assert_false(set_changes(f, id, spec->max));
            assert_true(set_changes(f, id, spec->min));
        }
    }
}

/* But for the Y scan, which begins without a width. */
static void a_fresh_sensor_has_values_that_can_be_set(void **state)
{
    for (unsigned id = 0; id < LUM_COMMANDS; id++) {
        const lum_command_spec *spec = &lum_command_specs[id];
        bool is_there = !spec->has_value || id == LUM_COMMAND_YSCAN;
        for (unsigned v = spec->min; v <= spec->max && !is_there;
             v += spec->step) {
            assert_int_equal(tear_down(state), 0);
            assert_int_equal(set_up(state), 0);
            is_there = !set_changes(*state, id, (uint16_t)v);
        }
        assert_true(is_there);
    }
}

static void commands_may_come_in_several_tlvs(void **state)
{
    struct fixture *f = *state;
    lum_tlv_writer writer = begin(f);
    add(&writer, 1, "10p");
    add(&writer, 1, "");
    add(&writer, 99, "30p");
    add(&writer, 2, "\x01\x02");
    add(&writer, 3, "40p");
    add(&writer, 1, "20g");
    send_packet(f, &writer);
    assert_int_equal(f->debugs, 0);
    assert_int_equal(f->device.settings.power, 10);
    assert_int_equal(f->device.settings.threshold[LUM_EYE_GREEN], 20);
    assert_string_equal(f->fx.note,
                        "10p; empty command text; passed over TLV 99; passed "
                        "over TLV 2; passed over TLV 3; 20g");
}

/* The layout is never written; its padding may be anything. */
static void assert_same(const lum_device *a, const lum_device *b)
{
    const size_t from = offsetof(lum_device, settings);
    assert_memory_equal((const char *)a + from, (const char *)b + from,
                        sizeof *a - from);
}

static void a_packet_without_tlvs_polls_the_status(void **state)
{
    struct fixture *f = *state;
    const lum_device before = f->device;
    const lum_tlv_writer writer = begin(f);
    send_packet(f, &writer);
    assert_int_equal(f->fx.reply_len, 22);
    assert_int_equal(f->debugs, 0);
    assert_string_equal(f->fx.note, "status poll");
    assert_same(&before, &f->device);
}

static void each_refused_command_is_named_and_changes_nothing(void **state)
{
    static const struct {
        const char *text;
        const char *debug;
    } cases[] = {
        {"50q", "refused 50q: not a command\n"},
        {"101p", "refused 101p: p takes 0 to 100\n"},
        {"165h", "refused 165h: h takes 150 to 250 in steps of 10\n"},
        {"10y", "refused 10y: y takes 11 to 30\n"},
        {"99999999999999999999g",
         "refused 99999999999999999999g: g takes 0 to 100\n"},
        {"050p", "refused 050p: not a command\n"},
        {"+5p", "refused +5p: not a command\n"},
        {"-5p", "refused -5p: not a command\n"},
        {"p", "refused p: not a command\n"},
        {"1u", "refused 1u: not a command\n"},
        {"u1p", "refused u1p: not a command\n"},
        {"Of", "refused Of: not a command\n"},
        {"5", "refused 5: not a command\n"},
        {"5\tp\x7f\xff", "refused 5?p??: not a command\n"},
        {"1234567890123456789012345678901234567890p",
         "refused 1234567890123456789012345678901234567890...: p takes 0 to "
         "100\n"},
        {" 5p", "refused \" 5p\": separate commands by one space, with none at "
                "the ends\n"},
        {"5p ", "refused \"5p \": separate commands by one space, with none at "
                "the ends\n"},
        {" ", "refused \" \": separate commands by one space, with none at the "
              "ends\n"},
    };
    struct fixture *f = *state;
    heartbeat(f, alice);
    const lum_device before = f->device;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        command(f, cases[i].text);
        assert_string_equal(f->debug, cases[i].debug);
        assert_int_equal(strncmp(f->fx.note, "refused ", 8), 0);
        assert_same(&before, &f->device);
    }
}

static void each_command_stands_for_itself(void **state)
{
    struct fixture *f = *state;
    command(f, "10p 101g 11b what 20G");
    assert_int_equal(f->debugs, 2);
    assert_int_equal(f->device.settings.power, 10);
    assert_int_equal(f->device.settings.threshold[LUM_EYE_GREEN], 50);
    assert_int_equal(f->device.settings.threshold[LUM_EYE_BLUE], 11);
    assert_int_equal(f->device.settings.offset[LUM_EYE_GREEN], 20);
    assert_string_equal(f->fx.note,
                        "10p; refused 101g; 11b; refused what; 20G");
}

static void a_text_that_cannot_be_cut_is_refused_from_there(void **state)
{
    struct fixture *f = *state;
    lum_tlv_writer writer = begin(f);
    add(&writer, 1, "10p  11g 12b");
    add(&writer, 1, "13G");
    send_packet(f, &writer);
    assert_int_equal(f->debugs, 1);
    assert_int_equal(f->device.settings.power, 10);
    assert_int_equal(f->device.settings.threshold[LUM_EYE_GREEN], 50);
    assert_int_equal(f->device.settings.threshold[LUM_EYE_BLUE], 50);
    assert_int_equal(f->device.settings.offset[LUM_EYE_GREEN], 13);
    assert_string_equal(f->fx.note, "10p; refused \" 11g 12b\"; 13G");
}

static void what_an_answer_cannot_name_it_counts(void **state)
{
    struct fixture *f = *state;
    char text[1401];
    for (unsigned i = 0; i < 1400; i++) {
        text[i] = i % 2 == 0 ? 'q' : ' ';
    }
    text[1399] = '\0';
    command(f, text);
    assert_int_equal(strlen(f->fx.note), sizeof f->fx.note - 1);
    const char *last = strstr(f->debug, " more refused");
    assert_non_null(last);
    while (last > f->debug && last[-1] != '\n') {
        last--;
    }
    assert_int_equal(f->debugs - 1 + (unsigned)strtoul(last, NULL, 10), 700);
    assert_true(f->debugs > 30);
}

static void fill(int16_t *out, size_t n, int16_t first, int16_t step)
{
    for (size_t i = 0; i < n; i++) {
        out[i] = (int16_t)(first + step * (int)i);
    }
}

static void a_table_sets_the_lines(void **state)
{
    struct fixture *f = *state;
    const lum_device_settings *s = &f->device.settings;
    int16_t lines[640];
    fill(lines, 64, 30000, -900);
    table(f, lines, 64);
    assert_int_equal(f->debugs, 0);
    assert_true(f->fx.settings_changed && f->fx.geometry_changed);
    assert_int_equal(s->yscan_count, 64);
    assert_memory_equal(s->yscan, lines, 64 * sizeof lines[0]);
    assert_string_equal(f->fx.note, "Y-scan table of 64");
    table(f, lines, 64);
    assert_false(f->fx.settings_changed);
    lines[63]--;
    table(f, lines, 64);
    assert_true(f->fx.geometry_changed);
    fill(lines, 64, -30000, 900);
    table(f, lines, 64);
    assert_int_equal(f->debugs, 0);
    fill(lines, 64, 5, 0);
    table(f, lines, 64);
    assert_int_equal(f->debugs, 0);
    assert_int_equal(s->yscan[63], 5);
}

static void a_table_of_the_line_mode_before_it_in_the_packet_fits(void **state)
{
    struct fixture *f = *state;
    int16_t lines[640];
    fill(lines, 640, 32000, -100);
    lum_tlv_writer writer = begin(f);
    add(&writer, 1, "0f");
    assert_int_equal(lum_yscan_add(&writer, 4, lines, 640), LUM_OK);
    send_packet(f, &writer);
    assert_int_equal(f->debugs, 0);
    assert_int_equal(f->device.settings.yscan_count, 640);
}

static void line_mode_and_fov_clear_the_table(void **state)
{
    static const char *const texts[] = {"1f", "0f", "20y"};
    struct fixture *f = *state;
    int16_t lines[64];
    fill(lines, 64, 30000, -900);
    for (unsigned i = 0; i < 3; i++) {
        command(f, "1f");
        table(f, lines, 64);
        assert_int_equal(f->device.settings.yscan_count, 64);
        command(f, texts[i]);
        assert_int_equal(f->device.settings.yscan_count, 0);
        assert_true(f->fx.geometry_changed);
    }
}

static void a_bad_table_is_refused(void **state)
{
    struct fixture *f = *state;
    int16_t lines[701];
    fill(lines, 701, 1000, -1);
    table(f, lines, 63);
    assert_string_equal(f->debug, "refused Y-scan table: 63 elevations, 64 "
                                  "lines need one each\n");
    table(f, lines, 0);
    assert_int_equal(f->debugs, 1);
    table(f, lines, 701);
    assert_string_equal(f->debug, "refused Y-scan table: 701 elevations, 64 "
                                  "lines need one each\n");
    lines[63] = lines[61];
    table(f, lines, 64);
    assert_string_equal(f->debug, "refused Y-scan table: it turns; elevations "
                                  "must fall or rise\n");
    lum_tlv_writer writer = begin(f);
    add(&writer, 4, "abc");
    send_packet(f, &writer);
    assert_string_equal(f->debug, "refused Y-scan table: odd length, an "
                                  "elevation has 2 bytes\n");
    assert_int_equal(f->device.settings.yscan_count, 0);
    assert_false(f->fx.settings_changed);
}

static void elevations_follow_the_settings(void **state)
{
    struct fixture *f = *state;
    lum_calibration c;
    lum_layout layout = f->device.layout;
    lum_device_settings *s = &f->device.settings;
    int32_t udeg[640] = {7};
    lum_calibration_default(&c);
    assert_false(lum_device_elevations(s, &layout, &c.eye[0], udeg));
    assert_int_equal(udeg[0], 7);
    command(f, "0f 16y");
    assert_true(lum_device_elevations(s, &layout, &c.eye[0], udeg));
    /* 8 degrees up to 8 down, of which 3 up are in the span. */
    assert_int_equal(udeg[0], 3000000);
    assert_int_equal(udeg[199], 3000000);
    assert_int_equal(udeg[200], 2987500);
    assert_int_equal(udeg[320], -12500);
    assert_int_equal(udeg[639], -7987500);
    command(f, "1f");
    int16_t lines[64];
    fill(lines, 64, INT16_MAX, -1040);
    lines[63] = INT16_MIN;
    table(f, lines, 64);
    assert_true(lum_device_elevations(s, &layout, &c.eye[0], udeg));
    assert_in_range(udeg[0] + 17000000, 19999000, 20000000);
    assert_int_equal(udeg[63], -17000000);
    layout.profile.angle_lsb_pdeg = UINT64_C(1000000000); /* 0.001 degree */
    assert_true(lum_device_elevations(s, &layout, &c.eye[1], udeg));
    assert_int_equal(udeg[0], 3000000);
    assert_int_equal(udeg[31], -7000000 + (INT16_MAX - 31 * 1040) * 1000);
    assert_int_equal(udeg[63], -17000000);
}

/* Although the table fits only after the line mode that follows it. */
static void a_repeated_packet_changes_nothing(void **state)
{
    struct fixture *f = *state;
    int16_t lines[640];
    fill(lines, 640, 32000, -100);
    heartbeat(f, alice);
    command(f, "20y");
    for (unsigned i = 0; i < 3; i++) {
        lum_tlv_writer writer = begin(f);
        assert_int_equal(lum_yscan_add(&writer, 4, lines, 640), LUM_OK);
        add(&writer, 1, "d 0f 7p u");
        send_packet(f, &writer);
        assert_true(i == 0 ||
                    !(f->fx.settings_changed || f->fx.status_changed));
        assert_int_equal(f->debugs, i == 0 ? 1 : 0);
        assert_int_equal(f->device.settings.fov_deg, 20);
        assert_int_equal(f->device.settings.yscan_count, 0);
    }
}

static void send_set_ip(struct fixture *f, uint32_t address)
{
    const uint8_t tail[4] = {
        (uint8_t)(address >> 24), (uint8_t)(address >> 16 & 0xffu),
        (uint8_t)(address >> 8 & 0xffu), (uint8_t)(address & 0xffu)};
    lum_header_encode(f->packet, LUM_TYPE_SET_IP);
    memcpy(f->packet + 12, tail, 4);
    receive_from(f, alice, f->packet, LUM_SET_IP_BYTES);
    assert_false(f->fx.has_reply);
}

static void set_ip_moves_the_sensor_and_nothing_else(void **state)
{
    struct fixture *f = *state;
    switch_on(f);
    const lum_device before = f->device;
    send_set_ip(f, 0xc0a80107u);
    assert_true(f->fx.has_address);
    assert_int_equal(f->fx.address, 0xc0a80107u);
    assert_string_equal(f->fx.note, "set IP 192.168.1.7");
    assert_same(&before, &f->device);
}

static void set_ip_follows_the_profiles_order(void **state)
{
    struct fixture *f = *state;
    f->device.layout.profile.set_ip_order = LUM_SET_IP_LITTLE;
    send_set_ip(f, 0xc0a80107u);
    assert_int_equal(f->fx.address, 0x0701a8c0u);
}

static void addresses_that_no_host_has_are_refused(void **state)
{
    static const uint32_t bad[] = {0, 0xffffffffu, 0xe0000001u, 0xefffffffu};
    struct fixture *f = *state;
    for (unsigned i = 0; i < 4; i++) {
        send_set_ip(f, bad[i]);
        assert_false(f->fx.has_address);
        assert_int_equal(strncmp(f->fx.note, "refused set IP ", 15), 0);
        assert_int_equal(f->device.malformed, i + 1);
    }
}

static void foreign_and_unknown_packets_are_counted_and_ignored(void **state)
{
    struct fixture *f = *state;
    uint8_t data[64] = {0};
    lum_header_encode(f->packet, LUM_TYPE_HEARTBEAT);
    for (size_t len = 0; len < LUM_HEADER_BYTES; len++) {
        receive_from(f, alice, f->packet, len);
    }
    assert_int_equal(f->device.ignored, 12);
    receive_from(f, alice, data, sizeof data);
    assert_string_equal(f->fx.note, "ignored: no magic");
    lum_header_encode(data, LUM_TYPE_HEARTBEAT);
    receive_from(f, alice, data, sizeof data);
    assert_string_equal(f->fx.note, "ignored: data");
    receive_from(f, alice, data, 13);
    lum_header_encode(data, 9);
    receive_from(f, alice, data, 12);
    assert_string_equal(f->fx.note, "ignored: unknown type");
    lum_header_encode(data, LUM_TYPE_HEARTBEAT);
    data[10] = 1;
    receive_from(f, alice, data, 12);
    assert_string_equal(f->fx.note, "ignored: reserved bytes set");
    assert_int_equal(f->device.ignored, 17);
    assert_int_equal(f->device.malformed, 0);
    assert_false(f->device.has_client);
    assert_false(f->fx.has_reply);
}

static void short_packets_are_malformed(void **state)
{
    struct fixture *f = *state;
    static const uint8_t types[] = {LUM_TYPE_SET_IP, LUM_TYPE_TIMESTAMP,
                                    LUM_TYPE_TLV};
    static const size_t least[] = {16, 20, 16};
    uint64_t expected = 0;
    for (unsigned i = 0; i < 3; i++) {
        memset(f->packet, 0, 64);
        lum_header_encode(f->packet, types[i]);
        for (size_t len = 12; len < least[i]; len++) {
            receive_from(f, alice, f->packet, len);
            assert_false(f->fx.has_reply || f->fx.has_address);
            assert_int_equal(f->device.malformed, ++expected);
        }
    }
}

static void what_came_before_a_broken_tlv_stands(void **state)
{
    struct fixture *f = *state;
    lum_tlv_writer writer = begin(f);
    add(&writer, 1, "10p");
    add(&writer, 1, "20p");
    for (size_t len = 24; len < 30; len++) {
        f->device.settings.power = 100;
        receive_from(f, alice, f->packet, len);
        read_reply(f, f->sequence);
        assert_int_equal(f->debugs, 1);
        assert_int_equal(f->device.settings.power, 10);
        assert_non_null(strstr(f->debug, "from byte 23 on"));
    }
    assert_int_equal(f->device.malformed, 6);
}

static void numbers_of_tlvs_are_the_profiles(void **state)
{
    struct fixture *f = *state;
    lum_profile profile = f->device.layout.profile;
    lum_layout layout;
    profile.tlv[LUM_TLV_COMMAND] = 20;
    profile.tlv[LUM_TLV_STATUS] = 1;
    profile.tlv[LUM_TLV_DEBUG] = 0x1234;
    profile.tlv[LUM_TLV_YSCAN] = 3;
    assert_int_equal(lum_layout_init(&layout, &profile, NULL, NULL), LUM_OK);
    lum_device_init(&f->device, &layout, 64, LUM_DEVICE_BOOT_STATUS, 0, f->now);
    lum_tlv_writer writer = begin(f);
    add(&writer, 20, "10p nonsense");
    receive_from(f, alice, writer.out, writer.len);
    assert_int_equal(f->device.settings.power, 10);
    assert_int_equal(f->fx.reply[16], 1);
    assert_int_equal(f->fx.reply[22], 0x34);
    assert_int_equal(f->fx.reply[23], 0x12);
}

static void each_command_of_the_table_has_an_effect(void **state)
{
    struct fixture *f = *state;
    heartbeat(f, alice);
    for (unsigned id = 0; id < LUM_COMMANDS; id++) {
        const lum_command_spec *spec = &lum_command_specs[id];
        char text[8] = {spec->letter, '\0'};
        const lum_device before = f->device;
        if (spec->has_value) {
            (void)snprintf(text, sizeof text, "%u%c", spec->min, spec->letter);
            command(f, text);
            (void)snprintf(text, sizeof text, "%u%c", spec->max, spec->letter);
        }
        const lum_device_settings low = f->device.settings;
        command(f, text);
        if (memcmp(&low, &f->device.settings, sizeof low) == 0 &&
            before.status == f->device.status) {
            fail_msg("%s changes nothing", text);
        }
    }
}

int main(void)
{
#define FACT(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        FACT(a_fresh_sensor_is_dark_and_silent),
        FACT(a_status_at_boot_is_kept),
        FACT(timestamps_tell_the_clock_since_boot),
        FACT(the_clock_wraps_at_32_bits),
        FACT(a_heartbeat_starts_the_data_to_its_sender),
        FACT(three_seconds_without_one_end_laser_and_data),
        FACT(heartbeats_keep_the_laser_on),
        FACT(nothing_else_counts_as_a_heartbeat),
        FACT(a_datagram_finds_the_timeout_done),
        FACT(after_a_timeout_data_resumes_and_the_laser_waits),
        FACT(no_u_without_heartbeat),
        FACT(u_and_d_switch_the_laser),
        FACT(returns_come_to_full_strength_in_time),
        FACT(a_hazard_keeps_the_laser_down),
        FACT(hazards_leave_the_bits_of_commands_alone),
        FACT(nobody_is_alerted_before_a_client_came),
        FACT(every_command_sets_its_own_setting),
        FACT(another_value_is_a_change_of_settings),
        FACT(a_fresh_sensor_has_values_that_can_be_set),
        FACT(each_command_of_the_table_has_an_effect),
        FACT(commands_may_come_in_several_tlvs),
        FACT(a_packet_without_tlvs_polls_the_status),
        FACT(each_refused_command_is_named_and_changes_nothing),
        FACT(each_command_stands_for_itself),
        FACT(a_text_that_cannot_be_cut_is_refused_from_there),
        FACT(what_an_answer_cannot_name_it_counts),
        FACT(a_table_sets_the_lines),
        FACT(a_table_of_the_line_mode_before_it_in_the_packet_fits),
        FACT(line_mode_and_fov_clear_the_table),
        FACT(a_bad_table_is_refused),
        FACT(a_repeated_packet_changes_nothing),
        FACT(elevations_follow_the_settings),
        FACT(set_ip_moves_the_sensor_and_nothing_else),
        FACT(set_ip_follows_the_profiles_order),
        FACT(addresses_that_no_host_has_are_refused),
        FACT(foreign_and_unknown_packets_are_counted_and_ignored),
        FACT(short_packets_are_malformed),
        FACT(what_came_before_a_broken_tlv_stands),
        FACT(numbers_of_tlvs_are_the_profiles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
