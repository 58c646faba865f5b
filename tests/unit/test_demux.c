#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "capture/demux_sensors.h"
#include "drive.h"

#include "lum/capture/demux.h"
#include "lum/wire.h"

#include <stdlib.h>
#include <string.h>

#define OTHER_SENSOR (DRIVE_SENSOR + 1u)

/* Counters as numbers, whatever their names. */
#define NUMBERS(type) (sizeof(type) / sizeof(uint64_t))

static lum_demux *begin(void)
{
    lum_demux_options options = {.struct_size = sizeof options};
    lum_layout_default(&options.layout);
    lum_assembler_config_default(&options.config);
    lum_demux *demux = NULL;
    assert_int_equal(lum_demux_new(&options, &demux, NULL), 0);
    assert_non_null(demux);
    return demux;
}

static void push(lum_demux *demux, const lum_record *record)
{
    while (lum_demux_push(demux, record, NULL) > 0) {
    }
}

static void push_bytes(lum_demux *demux, uint32_t sensor, const uint8_t *bytes,
                       size_t len)
{
    const lum_record record = {.payload = bytes,
                               .len = len,
                               .source = sensor,
                               .source_port = LUM_PORT,
                               .destination = DRIVE_CLIENT,
                               .kind = LUM_RECORD_DATAGRAM};
    push(demux, &record);
}

static void push_line(lum_demux *demux, uint32_t sensor)
{
    struct drive_line line;
    drive_pixels(&line, LUM_EYE_BLUE, 3, 1000, 0, LUM_LINE_PIXELS);
    for (size_t i = 0; i < line.count; i++) {
        const lum_record record = drive_record(&line, i, sensor, 0);
        push(demux, &record);
    }
}

/* The current sensor's, each with another number, as if it had counted them. */
static void count_all(const lum_demux *demux, uint64_t start)
{
    uint64_t numbers[NUMBERS(lum_assembly_counters)];
    const lum_assembler *a = lum_demux_current(demux);
    for (size_t i = 0; i < NUMBERS(lum_assembly_counters); i++) {
        numbers[i] = start + i;
    }
    memcpy((void *)(uintptr_t)lum_assembler_counters(a), numbers,
           sizeof numbers);
}

/* One of each kind but data. */
static void push_packets(lum_demux *demux, uint32_t sensor)
{
    struct drive_line line;
    uint8_t packet[LUM_TIMESTAMP_BYTES];
    uint8_t joined[2u * LUM_HEARTBEAT_BYTES];
    const uint8_t types[] = {LUM_TYPE_SET_IP, LUM_TYPE_TIMESTAMP, LUM_TYPE_TLV,
                             99};
    const lum_record cut = {.source = sensor,
                            .source_port = LUM_PORT,
                            .kind = LUM_RECORD_CUT_SHORT};
    push(demux, &cut);
    push_bytes(demux, sensor, packet, 0);
    for (size_t i = 0; i < sizeof types; i++) {
        memset(packet, 0, sizeof packet);
        lum_header_encode(packet, types[i]);
        push_bytes(demux, sensor, packet, sizeof packet);
    }
    lum_heartbeat_encode(packet);
    push_bytes(demux, sensor, packet, LUM_HEARTBEAT_BYTES);
    push_bytes(demux, sensor, packet, LUM_HEARTBEAT_BYTES + 1u);
    drive_pixels(&line, LUM_EYE_BLUE, 3, 1000, 0, 10);
    line.bytes[0][LUM_HEADER_BYTES] = 77; /* the tag */
    push_bytes(demux, sensor, line.bytes[0], line.len[0]);
    lum_heartbeat_encode(packet);
    memcpy(joined, packet, LUM_HEARTBEAT_BYTES);
    memcpy(joined + LUM_HEARTBEAT_BYTES, packet, LUM_HEARTBEAT_BYTES);
    push_bytes(demux, sensor, joined, sizeof joined);
}

/* A packet whose record stands far behind that of a later one. */
static void push_behind(lum_demux *demux, uint32_t sensor)
{
    struct drive_line line;
    for (uint32_t i = 0; i < 2; i++) {
        const uint32_t ms = i == 0 ? 200 : 0;
        drive_pixels(&line, LUM_EYE_BLUE, 3, 1000u + 1000u * ms, 0, 10);
        const lum_record record =
            drive_record(&line, 0, sensor, (int64_t)ms * 1000000);
        push(demux, &record);
    }
}

static void the_total_has_every_counter_of_every_assembler(void **state)
{
    uint64_t sum[NUMBERS(lum_assembly_counters)];
    lum_demux_counters total = {.struct_size = sizeof total};
    lum_demux *demux = begin();
    (void)state;
    push_line(demux, DRIVE_SENSOR);
    count_all(demux, 1000);
    push_line(demux, OTHER_SENSOR);
    count_all(demux, 20000);
    assert_int_equal(lum_demux_total(demux, &total), LUM_OK);
    memcpy(sum, &total.assembly, sizeof sum);
    for (size_t i = 0; i < NUMBERS(lum_assembly_counters); i++) {
        assert_int_equal(sum[i], 21000 + 2 * i);
    }
    for (size_t s = 0; s < 2; s++) {
        lum_demux_counters one = {.struct_size = sizeof one};
        assert_int_equal(lum_demux_count(demux, s, &one), LUM_OK);
        memcpy(sum, &one.assembly, sizeof sum);
        for (size_t i = 0; i < NUMBERS(lum_assembly_counters); i++) {
            assert_int_equal(sum[i], (s == 0 ? 1000 : 20000) + i);
        }
    }
    lum_demux_free(demux);
}

/* All behind the size but what no address has: other is the stream's. */
static void the_total_has_every_counter_of_every_address(void **state)
{
    uint64_t of[2][NUMBERS(lum_demux_counters)];
    uint64_t sum[NUMBERS(lum_demux_counters)];
    lum_demux_counters total = {.struct_size = sizeof total};
    lum_demux *demux = begin();
    (void)state;
    for (uint32_t s = 0; s < 2; s++) {
        push_packets(demux, DRIVE_SENSOR + s);
        push_line(demux, DRIVE_SENSOR + s);
        push_behind(demux, DRIVE_SENSOR + s);
        count_all(demux, 1);
    }
    for (size_t s = 0; s < 2; s++) {
        lum_demux_counters one = {.struct_size = sizeof one};
        assert_int_equal(lum_demux_count(demux, s, &one), LUM_OK);
        memcpy(of[s], &one, sizeof of[s]);
    }
    assert_int_equal(lum_demux_total(demux, &total), LUM_OK);
    memcpy(sum, &total, sizeof sum);
    for (size_t i = 1; i < NUMBERS(lum_demux_counters); i++) {
        const bool is_other =
            i == offsetof(lum_demux_counters, other) / sizeof *sum;
        assert_int_equal(sum[i], of[0][i] + of[1][i]);
        assert_int_equal(sum[i] == 0, is_other);
    }
    lum_demux_free(demux);
}

/* --- Joined datagrams --- */

#define EACH 32u /* bytes of each but the last */

/* A payload with the magic at each of these places. */
static void make_payload(uint8_t *out, size_t len, const size_t *places,
                         size_t count)
{
    uint8_t magic[LUM_HEADER_BYTES];
    lum_header_encode(magic, LUM_TYPE_HEARTBEAT);
    memset(out, 0xed, len);
    for (size_t i = 0; i < count; i++) {
        const size_t rest = len - places[i];
        memcpy(out + places[i], magic, rest < 8u ? rest : 8u);
    }
}

/* How many datagrams a record is: each of so many bytes, one after another, the
 * last of the rest. */
static size_t count_parts(const lum_record *record, size_t each)
{
    lum_joined joined = {.each = 0};
    lum_record part;
    size_t at = 0;
    size_t n = 0;
    assert_false(lum_joined_has_more(&joined, record));
    while (lum_joined_next(&joined, record, &part)) {
        const size_t rest = record->len - at;
        assert_ptr_equal(part.payload, record->payload + at);
        assert_int_equal(part.len, rest < each ? rest : each);
        assert_int_equal(part.dropped_fragments, n == 0 ? 3 : 0);
        assert_int_equal(part.time_ns, record->time_ns);
        at += part.len;
        n++;
        assert_int_equal(lum_joined_has_more(&joined, record),
                         at < record->len);
        assert_int_equal(part.kind, part.len < record->len ? LUM_RECORD_JOINED
                                                           : record->kind);
    }
    assert_int_equal(at, record->len);
    assert_int_equal(joined.each, 0);
    return n;
}

static size_t parts_of(const uint8_t *bytes, size_t len, size_t each)
{
    uint8_t *exact = malloc(len + (len == 0));
    assert_non_null(exact);
    memcpy(exact, bytes, len);
    const lum_record record = {.time_ns = 5,
                               .payload = exact,
                               .len = len,
                               .dropped_fragments = 3,
                               .kind = LUM_RECORD_DATAGRAM};
    const size_t n = count_parts(&record, each);
    free(exact);
    return n;
}

/* Three, the last of up to 32 bytes. One that has no whole magic is none, so
 * the payload is one datagram. */
static void every_truncation_is_one_datagram_or_whole_ones(void **state)
{
    const size_t places[] = {0, EACH, 2u * EACH};
    uint8_t bytes[3u * EACH];
    (void)state;
    make_payload(bytes, sizeof bytes, places, 3);
    for (size_t len = 0; len <= sizeof bytes; len++) {
        const size_t last = len % EACH;
        const size_t parts = last >= 8u  ? len / EACH + 1u
                             : last == 0 ? len / EACH
                                         : 1u;
        const size_t expected = parts != 0 ? parts : 1u;
        assert_int_equal(parts_of(bytes, len, expected > 1u ? EACH : len),
                         expected);
    }
}

static void the_magic_stands_at_each_multiple_or_joins_nothing(void **state)
{
    static const struct {
        size_t len;
        size_t places[5];
        size_t count;
        size_t each; /* 0: it is one */
    } cases[] = {
        {24, {0, 12}, 2, 12},          /* the shortest packet twice */
        {22, {0, 11}, 2, 0},           /* no packet is as short */
        {16, {0, 8}, 2, 0},            /* nor so */
        {96, {0, 64}, 2, 64},          /* a shorter last one */
        {96, {0, 32}, 2, 0},           /* 64 lacks it */
        {96, {32, 64}, 2, 0},          /* the start lacks it */
        {96, {0, 33, 64}, 3, 0},       /* the next one counts */
        {96, {0, 32, 50, 64}, 4, 32},  /* once more within one */
        {96, {0, 32, 64, 76}, 4, 32},  /* within the last one */
        {40, {0, 32}, 2, 32},          /* the magic and no more */
        {39, {0, 32}, 2, 0},           /* less than it */
        {65507, {0, 65495}, 2, 65495}, /* the longest payload */
    };
    static uint8_t bytes[65507];
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const size_t len = cases[i].len;
        const size_t each = cases[i].each != 0 ? cases[i].each : len;
        make_payload(bytes, len, cases[i].places, cases[i].count);
        assert_int_equal(parts_of(bytes, len, each), (len + each - 1u) / each);
    }
}

/* What was taken apart is not taken apart again, and what is no datagram is
 * none. */
static void only_a_datagram_is_taken_apart(void **state)
{
    const size_t places[] = {0, EACH};
    const lum_record_kind kinds[] = {LUM_RECORD_CUT_SHORT, LUM_RECORD_FRAGMENT,
                                     LUM_RECORD_OTHER, LUM_RECORD_JOINED};
    uint8_t bytes[2u * EACH];
    (void)state;
    make_payload(bytes, sizeof bytes, places, 2);
    assert_int_equal(parts_of(bytes, sizeof bytes, EACH), 2);
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        const lum_record record = {.payload = bytes,
                                   .len = sizeof bytes,
                                   .dropped_fragments = 3,
                                   .kind = kinds[i]};
        assert_int_equal(count_parts(&record, sizeof bytes), 1);
    }
}

/* Lines of both eyes that close each other, packet by packet or joined as far
 * as their length is the same. */
struct stream {
    lum_demux *demux;
    uint8_t bytes[65536];
    size_t len;
    size_t each;
    size_t packets; /* of them */
    uint64_t joined;
    uint64_t events; /* lines and frames, in their order */
};

static void send_joined(struct stream *s)
{
    const lum_record record = {.payload = s->bytes,
                               .len = s->len,
                               .source = DRIVE_SENSOR,
                               .source_port = LUM_PORT,
                               .kind = LUM_RECORD_DATAGRAM};
    lum_packet_kind kind = LUM_PACKET_KINDS;
    lum_result r = LUM_OK;
    while (s->len > 0 && (r = lum_demux_push(s->demux, &record, &kind)) > 0) {
        const lum_assembler *a = lum_demux_current(s->demux);
        s->events = s->events * 31u + (uint64_t)r;
        if (r == LUM_LINE_READY) {
            s->events = s->events * 31u + lum_assembler_line(a)->number;
        }
    }
    assert_int_equal(r, LUM_OK);
    assert_int_equal(kind, s->len > 0 ? LUM_PACKET_DATA : LUM_PACKET_KINDS);
    s->joined += s->packets > 1 ? s->packets : 0;
    s->len = 0;
    s->packets = 0;
}

/* As a receiving kernel: a shorter one is the last. */
static void add_packet(struct stream *s, const uint8_t *bytes, size_t len,
                       size_t most)
{
    if (s->packets == most || (s->packets > 0 && len > s->each)) {
        send_joined(s);
    }
    s->each = s->packets == 0 ? len : s->each;
    memcpy(s->bytes + s->len, bytes, len);
    s->len += len;
    s->packets++;
    if (len < s->each) {
        send_joined(s);
    }
}

static void send_stream(struct stream *s, size_t most)
{
    static struct drive_line line;
    *s = (struct stream){.demux = begin()};
    for (uint32_t i = 0; i < 60; i++) {
        drive_pixels(&line, i % 2u, i / 2u % 12u, 1000u + 500u * i, 0,
                     i % 3u == 0 ? 1000u : 328u);
        for (size_t p = 0; p < line.count; p++) {
            add_packet(s, line.bytes[p], line.len[p], most);
        }
    }
    send_joined(s);
}

static void joined_datagrams_are_those_that_were_sent(void **state)
{
    static struct stream one;
    static struct stream many;
    lum_demux_counters a = {.struct_size = sizeof a};
    lum_demux_counters b = {.struct_size = sizeof b};
    (void)state;
    send_stream(&one, 1);
    for (size_t most = 2; most <= 45; most++) {
        send_stream(&many, most);
        assert_int_equal(lum_demux_total(one.demux, &a), LUM_OK);
        assert_int_equal(lum_demux_total(many.demux, &b), LUM_OK);
        assert_int_equal(a.joined, 0);
        assert_int_equal(b.joined, many.joined);
        assert_true(b.joined > b.packets[LUM_PACKET_DATA] / 2u);
        b.joined = 0;
        assert_memory_equal(&a, &b, sizeof a);
        assert_int_equal(one.events, many.events);
        lum_demux_free(many.demux);
    }
    lum_demux_free(one.demux);
}

/* A record of a clock, and how far it stands behind. */
static int64_t behind(lum_order *order, const lum_field *field, int64_t time_ns,
                      uint64_t ticks)
{
    const lum_group group = {.clock_raw = ticks};
    return lum_order_behind_ns(order, field, 1000, INT64_MAX, time_ns, &group);
}

/* Records of 1 ms each, by their places, each 100 ms or more apart a break. */
static size_t count_behind(const int *places, size_t count)
{
    const lum_field field = {.at = 20, .bytes = 4};
    lum_order order = {false};
    size_t n = 0;
    for (size_t i = 0; i < count; i++) {
        const lum_group group = {.clock_raw = 1000u * (uint64_t)places[i]};
        n += lum_order_behind_ns(&order, &field, 1000, 100000000,
                                 places[i] * INT64_C(1000000), &group) != 0;
    }
    return n;
}

static void the_fewer_of_two_that_stand_apart_are_out_of_order(void **state)
{
    static const int early[] = {1, 2, 900, 3, 4, 5, 6, 900, 901, 902};
    static const int first[] = {900, 1, 2, 3, 4, 5, 6};
    static const int late[] = {500, 501, 502, 503, 1, 504, 505};
    static const int halves[] = {500, 501, 502, 503, 1, 2, 3, 4};
    static const int more[] = {500, 501, 1, 2, 3, 4, 5, 502, 503};
    static const int back[] = {1500, 1200, 900, 600, 300};
    (void)state;
    assert_int_equal(count_behind(early, 10), 1);
    assert_int_equal(count_behind(first, 7), 1);
    assert_int_equal(count_behind(late, 7), 1);
    assert_int_equal(count_behind(halves, 8), 4);
    assert_int_equal(count_behind(more, 9), 2);
    assert_int_equal(count_behind(back, 5), 4);
}

static void what_stands_behind_by_both_clocks_is_out_of_order(void **state)
{
    enum {
        MS = 1000000
    };
    const lum_field wide = {.at = 20, .bytes = 4};
    const lum_field narrow = {.at = 20, .bytes = 1};
    const lum_field none = {.at = 20};
    const uint32_t end = UINT32_MAX;
    lum_order order = {false};
    (void)state;
    assert_int_equal(behind(&order, &wide, 100 * MS, end), 0);
    assert_int_equal(behind(&order, &wide, 110 * MS, 9999), 0);
    assert_int_equal(behind(&order, &wide, 102 * MS, 1999), 8 * MS);
    assert_int_equal(behind(&order, &wide, 100 * MS, end), 10 * MS);
    assert_int_equal(behind(&order, &wide, 102 * MS, 9999), 0);
    assert_int_equal(behind(&order, &wide, 102 * MS, 10999), 0);
    assert_int_equal(behind(&order, &wide, 109 * MS, 1999), 0);
    assert_int_equal(behind(&order, &wide, INT64_MIN / 2, 1999), 0);
    order = (lum_order){
        .has_newest = true, .newest_ns = 1 * MS, .newest_ticks = 10};
    assert_int_equal(behind(&order, &narrow, 1 * MS - 20000, 246), 20000);
    assert_int_equal(behind(&order, &none, 0, 0), 1 * MS);
}

/* --- Members --- */

static const lum_demux_member members[] = {
    {.address = DRIVE_SENSOR, .interface = "eth0"},
    {.address = DRIVE_SENSOR, .interface = "eth1"},
    {.address = DRIVE_SENSOR + 99u},
};

static lum_demux *begin_with(const lum_demux_member of[3])
{
    lum_demux_options options = {
        .struct_size = sizeof options, .members = of, .member_count = 3};
    lum_demux *demux = NULL;
    lum_layout_default(&options.layout);
    lum_assembler_config_default(&options.config);
    assert_int_equal(lum_demux_new(&options, &demux, NULL), 0);
    return demux;
}

static lum_demux *begin_members(void)
{
    return begin_with(members);
}

static void members_need_an_array(void **state)
{
    const lum_demux_options options = {.struct_size = sizeof options,
                                       .member_count = 3};
    lum_demux *demux = NULL;
    lum_error error = {""};
    (void)state;
    assert_int_equal(lum_demux_new(&options, &demux, &error), -1);
    assert_string_equal(error.text,
                        "members is NULL, but 3 members are announced; give "
                        "members, or 0 as their number");
}

static void assert_remark(const lum_demux *demux, size_t i, const char *text)
{
    lum_error remark = {""};
    assert_true(lum_capture_remark(NULL, demux, 0, i, &remark));
    assert_string_equal(remark.text, text);
}

static void members_that_sent_nothing_are_told(void **state)
{
    lum_demux *demux = begin_members();
    (void)state;
    assert_remark(demux, 0,
                  "the rig's sensor 10.42.0.37%eth0 sent no data; no "
                  "sensor did");
    lum_demux_set_interface(demux, "eth1");
    push_line(demux, DRIVE_SENSOR);
    assert_true(lum_demux_is_wanted(demux));
    assert_int_equal(lum_demux_member_of(demux, 0), 1);
    assert_remark(demux, 0,
                  "the rig's sensor 10.42.0.37%eth0 sent no data; "
                  "these did: 10.42.0.37%eth1");
    assert_remark(demux, 1,
                  "the rig's sensor 10.42.0.136 sent no data; these "
                  "did: 10.42.0.37");
    push_line(demux, OTHER_SENSOR);
    assert_false(lum_demux_is_wanted(demux));
    push_line(demux, OTHER_SENSOR + 1u);
    assert_remark(demux, 2,
                  "2 sensors sent data and are not in the rig, so "
                  "they were left out; to have them, name in the "
                  "rig: 10.42.0.38, 10.42.0.39");
    lum_demux_free(demux);
}

static void a_member_whose_data_is_anothers_is_told(void **state)
{
    lum_demux *demux = begin_members();
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        lum_demux_set_interface(demux, i == 0 ? "eth0" : "eth1");
        push_line(demux, DRIVE_SENSOR);
    }
    while (lum_demux_flush(demux) > 0) {
    }
    assert_int_equal(lum_demux_sensor_count(demux), 1);
    assert_remark(
        demux, 0,
        "the rig's sensor 10.42.0.37%eth1 is not another sensor: its data "
        "duplicates that of 10.42.0.37%eth0; leave one of them out of the rig");
    lum_demux_free(demux);
}

static void members_keep_their_places(void **state)
{
    lum_demux *demux = begin_members();
    (void)state;
    for (uint32_t i = 1; i <= LUM_DEMUX_SENSORS_MAX; i++) {
        push_line(demux, DRIVE_SENSOR + i);
    }
    assert_int_equal(lum_demux_sensor_count(demux), LUM_DEMUX_SENSORS_MAX - 3u);
    push_line(demux, DRIVE_SENSOR + 99u);
    assert_int_equal(lum_demux_sensor_count(demux), LUM_DEMUX_SENSORS_MAX - 2u);
    assert_int_equal(lum_demux_member_of(demux, LUM_DEMUX_SENSORS_MAX - 3u), 2);
    push_line(demux, DRIVE_SENSOR + 98u);
    assert_int_equal(lum_demux_sensor_count(demux), LUM_DEMUX_SENSORS_MAX - 2u);
    lum_demux_free(demux);
}

static void those_left_out_are_not_missed_and_have_no_places(void **state)
{
    lum_demux_member of[3] = {members[0], members[1], members[2]};
    lum_error remark = {""};
    of[0].is_left_out = true;
    of[2].is_left_out = true;
    lum_demux *demux = begin_with(of);
    (void)state;
    assert_remark(demux, 0,
                  "the rig's sensor 10.42.0.37%eth1 sent no data; no "
                  "sensor did");
    assert_false(lum_capture_remark(NULL, demux, 0, 1, &remark));
    lum_demux_set_interface(demux, "eth0");
    push_line(demux, DRIVE_SENSOR);
    assert_false(lum_demux_is_wanted(demux));
    assert_false(lum_demux_is_requested(demux, 0));
    assert_int_equal(lum_demux_member_of(demux, 0), 0);
    for (uint32_t i = 1; i <= LUM_DEMUX_SENSORS_MAX; i++) {
        push_line(demux, DRIVE_SENSOR + i);
    }
    assert_int_equal(lum_demux_sensor_count(demux), LUM_DEMUX_SENSORS_MAX - 1u);
    lum_demux_free(demux);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_total_has_every_counter_of_every_assembler),
        cmocka_unit_test(the_total_has_every_counter_of_every_address),
        cmocka_unit_test(every_truncation_is_one_datagram_or_whole_ones),
        cmocka_unit_test(the_magic_stands_at_each_multiple_or_joins_nothing),
        cmocka_unit_test(only_a_datagram_is_taken_apart),
        cmocka_unit_test(joined_datagrams_are_those_that_were_sent),
        cmocka_unit_test(what_stands_behind_by_both_clocks_is_out_of_order),
        cmocka_unit_test(the_fewer_of_two_that_stand_apart_are_out_of_order),
        cmocka_unit_test(members_need_an_array),
        cmocka_unit_test(members_that_sent_nothing_are_told),
        cmocka_unit_test(a_member_whose_data_is_anothers_is_told),
        cmocka_unit_test(those_left_out_are_not_missed_and_have_no_places),
        cmocka_unit_test(members_keep_their_places),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
