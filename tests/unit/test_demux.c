#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drive.h"

#include "lum/capture/demux.h"
#include "lum/wire.h"

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_total_has_every_counter_of_every_assembler),
        cmocka_unit_test(the_total_has_every_counter_of_every_address),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
