/* One address on several interfaces: one sensor, or several. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "capture/demux_state.h"
#include "capture/remarks.h"
#include "capture/trial.h"
#include "drive.h"

#include "lum/capture/demux.h"
#include "lum/wire.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINES    200u /* of each sensor */
#define PACKETS  16384u
#define START_NS INT64_C(1700000000000000000)

/* A packet on its way into a capture. */
struct sent {
    int64_t time_ns;
    size_t order;
    const char *interface;
    uint32_t sensor;
    size_t len;
    uint8_t *bytes;
};

/* Of a frame, and how long each takes. */
static uint32_t frame_lines = 640;
static uint32_t line_us = 156;

static struct sent *all;
static size_t count;

/* How a sensor sends. */
struct way {
    const char *interface;
    uint32_t clock;     /* when it begins, us */
    uint32_t phase;     /* its first line */
    uint32_t first;     /* its first pixel with a range */
    int64_t begin_ns;   /* of its first packet, from the start on */
    uint32_t lines;     /* 0: LINES */
    uint32_t sensor;    /* 0: DRIVE_SENSOR */
    uint32_t from_line; /* it is heard from this one on */
};

static void add(const struct sent *packet)
{
    assert_true(count < PACKETS);
    all[count] = *packet;
    all[count].order = count;
    all[count].bytes = malloc(packet->len);
    assert_non_null(all[count].bytes);
    memcpy(all[count].bytes, packet->bytes, packet->len);
    count++;
}

static void send(const struct way *w)
{
    static struct drive_line line;
    const uint32_t lines = w->lines != 0 ? w->lines : LINES;
    for (uint32_t i = 2u * w->from_line; i < 2u * lines; i++) {
        drive_pixels(&line, i % 2u, (w->phase + i / 2u) % frame_lines,
                     w->clock + line_us * (i / 2u), w->first, 600);
        for (size_t p = 0; p < line.count; p++) {
            const int64_t us =
                (int64_t)(line_us * (i / 2u) + 15u * p + 7u * (i % 2u));
            const struct sent packet = {
                .time_ns = START_NS + w->begin_ns + 1000 * us,
                .interface = w->interface,
                .sensor = w->sensor != 0 ? w->sensor : DRIVE_SENSOR,
                .len = line.len[p],
                .bytes = line.bytes[p]};
            add(&packet);
        }
    }
}

static int by_time(const void *a, const void *b)
{
    const struct sent *p = a;
    const struct sent *q = b;
    if (p->time_ns != q->time_ns) {
        return p->time_ns < q->time_ns ? -1 : 1;
    }
    return p->order < q->order ? -1 : 1;
}

static int begin(void **state)
{
    (void)state;
    all = calloc(PACKETS, sizeof *all);
    assert_non_null(all);
    count = 0;
    return 0;
}

static void forget(void)
{
    while (count > 0) {
        free(all[--count].bytes);
    }
}

static int end(void **state)
{
    (void)state;
    forget();
    free(all);
    return 0;
}

/* --- What comes of it --- */

struct result {
    size_t sensors;
    lum_demux_mixture mixture;
    lum_error remark;                      /* the first one; empty: none */
    uint64_t lines[LUM_DEMUX_SENSORS_MAX]; /* a sum of all that is in them */
    lum_demux_counters counted[LUM_DEMUX_SENSORS_MAX];
    lum_demux_counters total;
};

static void mix(uint64_t *sum, uint64_t value)
{
    *sum = (*sum ^ value) * UINT64_C(1099511628211);
    *sum ^= *sum >> 29;
}

static void note_line(const lum_demux *demux, struct result *out)
{
    const lum_line *line = lum_assembler_line(lum_demux_current(demux));
    uint64_t *sum = &out->lines[lum_demux_current_index(demux)];
    const uint64_t values[] = {
        (uint64_t)line->frame,   (uint64_t)line->clock_us,
        (uint64_t)line->arrival, line->number,
        line->word_count,        line->lost_words,
        line->angle_count,       line->eye};
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
        mix(sum, values[i]);
    }
    for (uint32_t i = 0; i < line->word_count; i++) {
        mix(sum, line->words[i]);
    }
}

static lum_demux *new_demux(const char *asked)
{
    lum_demux *demux = NULL;
    lum_demux_options options = {.struct_size = sizeof options,
                                 .has_sensor = asked != NULL,
                                 .sensor = DRIVE_SENSOR,
                                 .sensor_interface = asked};
    lum_layout_default(&options.layout);
    lum_assembler_config_default(&options.config);
    assert_int_equal(lum_demux_new(&options, &demux, NULL), 0);
    return demux;
}

static void push(lum_demux *demux, const struct sent *s, struct result *out)
{
    const lum_record record = {.time_ns = s->time_ns,
                               .payload = s->bytes,
                               .len = s->len,
                               .source = s->sensor,
                               .source_port = LUM_PORT,
                               .destination = DRIVE_CLIENT,
                               .kind = LUM_RECORD_DATAGRAM};
    lum_result r = LUM_OK;
    while ((r = lum_demux_push(demux, &record, NULL)) > 0) {
        if (r == LUM_LINE_READY) {
            note_line(demux, out);
        }
    }
    assert_int_equal(r, LUM_OK);
}

static void finish(lum_demux *demux, struct result *out)
{
    lum_result r = LUM_OK;
    while ((r = lum_demux_flush(demux)) > 0) {
        if (r == LUM_LINE_READY) {
            note_line(demux, out);
        }
    }
    assert_int_equal(r, LUM_OK);
    out->sensors = lum_demux_sensor_count(demux);
    const lum_remarks none = {.way_count = 0};
    out->mixture = lum_demux_mixed(demux);
    if (!lum_remarks_get(&none, demux, LUM_PORT, 0, &out->remark)) {
        out->remark.text[0] = '\0';
    }
    for (size_t i = 0; i < out->sensors; i++) {
        out->counted[i].struct_size = sizeof out->counted[i];
        assert_int_equal(lum_demux_count(demux, i, &out->counted[i]), LUM_OK);
    }
    out->total.struct_size = sizeof out->total;
    assert_int_equal(lum_demux_total(demux, &out->total), LUM_OK);
}

/* only: records of one interface; NULL: all. names: whether they are named. */
static void run(const char *only, bool names, struct result *out)
{
    lum_demux *demux = new_demux(NULL);
    memset(out, 0, sizeof *out);
    qsort(all, count, sizeof *all, by_time);
    for (size_t i = 0; i < count; i++) {
        if (only == NULL || strcmp(all[i].interface, only) == 0) {
            lum_demux_set_interface(demux, names ? all[i].interface : NULL);
            push(demux, &all[i], out);
        }
    }
    finish(demux, out);
    lum_demux_free(demux);
}

static void assert_same_counters(const lum_demux_counters *a,
                                 const lum_demux_counters *b)
{
    assert_memory_equal(&a->packets, &b->packets,
                        sizeof *a - offsetof(lum_demux_counters, packets));
}

/* One sensor, as where no interface has a name. */
static void assert_as_ever(void)
{
    struct result named;
    struct result plain;
    run(NULL, true, &named);
    run(NULL, false, &plain);
    assert_int_equal(plain.sensors, 1);
    assert_int_equal(named.sensors, 1);
    assert_int_equal(plain.mixture.contradicting, 0);
    assert_int_equal(named.mixture.contradicting, 0);
    assert_true(named.lines[0] == plain.lines[0]);
    assert_same_counters(&named.total, &plain.total);
    assert_same_counters(&named.counted[0], &plain.counted[0]);
    forget();
}

/* Two sensors, each as it is alone. */
static void assert_two(void)
{
    struct result both;
    qsort(all, count, sizeof *all, by_time);
    const char *first = all[0].interface;
    const char *second = strcmp(first, "eth0") == 0 ? "eth1" : "eth0";
    run(NULL, true, &both);
    assert_int_equal(both.sensors, 2);
    assert_int_equal(both.mixture.contradicting, 0);
    for (size_t i = 0; i < 2; i++) {
        struct result alone;
        run(i == 0 ? first : second, true, &alone);
        assert_int_equal(alone.sensors, 1);
        assert_true(both.lines[i] == alone.lines[0]);
        assert_same_counters(&both.counted[i], &alone.counted[0]);
    }
    forget();
}

/* --- Facts --- */

static void send_alike(uint32_t clock, uint32_t phase, int64_t late_ns)
{
    const struct way a = {.interface = "eth0", .clock = 1000000};
    /* a clock runs from its boot on, whenever it is heard */
    const struct way other = {.interface = "eth1",
                              .clock =
                                  1000000u + clock + (uint32_t)(late_ns / 1000),
                              .phase = phase,
                              .first = 50,
                              .begin_ns = late_ns};
    send(&a);
    send(&other);
}

static void two_sensors_are_two_however_alike(void **state)
{
    static const uint32_t clocks[] = {
        0,    3,          150,   1500,    4000,          0u - 4000u,
        9000, 0u - 9000u, 50000, 3000000, 0u - 3000000u, 0x80000000u};
    static const uint32_t phases[] = {0, 1, 5, 300};
    static const int64_t begins_ns[] = {5000, -20000000};
    (void)state;
    for (size_t i = 0; i < 2; i++) {
        frame_lines = i == 0 ? 640 : 64;
        line_us = i == 0 ? 156 : 1562;
        for (size_t c = 0; c < sizeof clocks / sizeof clocks[0]; c++) {
            for (size_t p = 0; p < sizeof phases / sizeof phases[0]; p++) {
                send_alike(clocks[c], phases[p], begins_ns[(c + p) % 2u]);
                assert_two();
            }
        }
    }
    frame_lines = 640;
    line_us = 156;
}

static void assert_warned(const struct result *result)
{
    assert_non_null(
        strstr(result->remark.text, "dumpcap -i eth0 -i eth1 -w out"));
    assert_null(strchr(result->remark.text, '\n'));
}

/* Also where all packets of one of them are late, or both seem whole. */
static void two_sensors_on_one_interface_are_told(void **state)
{
    static const uint32_t clocks[] = {3000, 10000, 0u - 10000u, 50000};
    static const uint32_t phases[] = {0, 1, 5, 30};
    (void)state;
    frame_lines = 64;
    line_us = 1562;
    for (size_t c = 0; c < sizeof clocks / sizeof clocks[0]; c++) {
        for (size_t p = 0; p < sizeof phases / sizeof phases[0]; p++) {
            struct result mixed;
            send_alike(clocks[c], phases[p], 5000);
            run(NULL, false, &mixed);
            assert_int_equal(mixed.sensors, 1);
            assert_in_range(mixed.mixture.contradicting, 3,
                            mixed.mixture.compared);
            assert_warned(&mixed);
            forget();
        }
    }
    frame_lines = 640;
    line_us = 156;
}

/* Two that come on one interface, and are no mixture by what is compared. */
static void run_as_one(const struct way *first, const struct way *second,
                       struct result *out)
{
    send(first);
    send(second);
    run(NULL, false, out);
    assert_int_equal(out->sensors, 1);
    assert_int_equal(out->mixture.contradicting, 0);
    forget();
}

/* Nothing next to its packets is remembered. */
static void a_second_sensor_far_behind_is_told(void **state)
{
    const struct way first = {
        .clock = 1000000, .interface = "eth0", .lines = 700};
    const struct way second = {.clock = 920000,
                               .interface = "eth0",
                               .phase = 30,
                               .first = 50,
                               .begin_ns = 5000,
                               .lines = 700};
    struct result result;
    (void)state;
    run_as_one(&first, &second, &result);
    assert_warned(&result);
    assert_non_null(
        strstr(result.remark.text, " packets came after newer lines"));
}

/* Its clock comes again where it was; the frame, elsewhere. */
static void a_sensor_that_begins_anew_is_one(void **state)
{
    const struct way first = {
        .clock = 1000000, .interface = "eth0", .lines = 100};
    const struct way second = {.clock = 1000000,
                               .interface = "eth0",
                               .phase = 30,
                               .first = 50,
                               .begin_ns = INT64_C(3000000000),
                               .lines = 600};
    struct result result;
    (void)state;
    run_as_one(&first, &second, &result);
}

/* A copy of each packet of eth0, so much later. */
static void mirror(int64_t later_ns, size_t from, unsigned keeps_of_ten)
{
    const size_t n = count;
    uint32_t seed = 1;
    for (size_t i = from; i < n; i++) {
        struct sent copy = all[i];
        seed = seed * 1664525u + 1013904223u;
        copy.interface = "eth1";
        copy.time_ns += later_ns;
        if ((seed >> 16) % 10u < keeps_of_ten) {
            add(&copy);
        }
        if ((seed >> 20) % 10u >= keeps_of_ten) {
            all[i].time_ns = INT64_MAX; /* lost */
        }
    }
    for (size_t i = 0; i < count; i++) {
        while (i < count && all[i].time_ns == INT64_MAX) {
            free(all[i].bytes);
            all[i] = all[--count];
        }
    }
}

static void repeats_are_repeats(void **state)
{
    static const int64_t laters_ns[] = {0,       20000,    -20000,
                                        3000000, -3000000, 50000000};
    static const size_t froms[] = {0, 1, 7, 1000};
    const struct way a = {.interface = "eth0", .clock = 1000000};
    (void)state;
    for (size_t l = 0; l < sizeof laters_ns / sizeof laters_ns[0]; l++) {
        for (size_t f = 0; f < 4; f++) {
            for (unsigned keeps = 5; keeps <= 10; keeps += 5) {
                send(&a);
                mirror(laters_ns[l], froms[f], keeps);
                assert_as_ever();
            }
        }
    }
}

/* Later than a break of the clock, by as much as they are remembered. */
static void late_repeats_are_late(void **state)
{
    static const int64_t laters_ms[] = {101, 150, 200, 300};
    const struct way a = {.interface = "eth0", .clock = 0u - 200000u};
    (void)state;
    line_us = 1562;
    for (size_t l = 0; l < sizeof laters_ms / sizeof laters_ms[0]; l++) {
        for (unsigned keeps = 5; keeps <= 10; keeps += 5) {
            struct result both;
            struct result alone;
            send(&a);
            mirror(1000000 * laters_ms[l], 0, keeps);
            run(NULL, true, &both);
            run("eth0", true, &alone);
            assert_int_equal(both.sensors, 1);
            assert_int_equal(both.mixture.contradicting, 0);
            /* at the end they fill what lacks in the last lines */
            assert_true(keeps < 10 || both.lines[0] == alone.lines[0]);
            assert_int_equal(both.total.assembly.stray, 0);
            assert_true(both.total.assembly.late > count / 3u);
            forget();
        }
    }
    line_us = 156;
}

static void damaged_repeats_prove_nothing(void **state)
{
    const struct way a = {.interface = "eth0", .clock = 1000000};
    (void)state;
    for (unsigned every = 1; every < 40; every += 3) {
        send(&a);
        mirror(1000, 0, 10);
        for (size_t i = 0; i < count; i++) {
            /* clock, line or sample */
            const size_t at = i % 3u == 0 ? 22 : i % 3u == 1u ? 14 : 40;
            if (all[i].order % (8u + every) == 0) {
                all[i].bytes[at] ^= 0x40;
            }
        }
        assert_as_ever();
    }
}

static void a_sensor_may_be_heard_on_either_interface_in_turn(void **state)
{
    const struct way a = {.interface = "eth0", .clock = 1000000};
    (void)state;
    for (size_t turn = 1; turn < 60; turn += 7) {
        send(&a);
        for (size_t i = 0; i < count; i++) {
            all[i].interface = i / turn % 2u != 0 ? "eth1" : "eth0";
        }
        assert_as_ever();
    }
}

static void a_sensor_that_goes_on_elsewhere_is_the_same(void **state)
{
    static const int64_t pauses_ns[] = {0, 50000000, 500000000,
                                        INT64_C(3600) * 1000000000};
    (void)state;
    for (size_t i = 0; i < 4; i++) {
        const struct way a = {.interface = "eth0", .lines = 150};
        const struct way b = {
            .interface = "eth1",
            .clock = (uint32_t)(pauses_ns[i] / 1000 + pauses_ns[i] / 50000000),
            .begin_ns = pauses_ns[i],
            .from_line = 150};
        send(&a);
        send(&b);
        assert_as_ever();
    }
    /* its clock does not go on */
    const struct way a = {.interface = "eth0", .lines = 150};
    const struct way b = {
        .interface = "eth1", .clock = 7000000, .begin_ns = 500000000};
    send(&a);
    send(&b);
    assert_two();
}

static void a_corrupt_clock_there_costs_that_packet_alone(void **state)
{
    const struct way a = {.interface = "eth0", .clock = 1100000, .lines = 150};
    const struct way b = {
        .interface = "eth1", .clock = 1100000, .from_line = 150, .lines = 400};
    (void)state;
    send(&a);
    const size_t first = count;
    send(&b);
    all[(first + count) / 2u].bytes[22] ^= 0x04; /* 0.26 s ahead */
    assert_as_ever();
}

/* As on an interface that shows a packet of another host. */
static void one_packet_makes_no_sensor(void **state)
{
    const struct way a = {.interface = "eth0", .clock = 1000000};
    (void)state;
    send(&a);
    all[500].interface = "eth1";
    all[500].bytes[22] ^= 0x40; /* its clock */
    assert_as_ever();
}

static void without_a_clock_repeats_and_lines_tell(void **state)
{
    static const struct {
        lum_seen seen;
        int64_t time_ns;
        lum_stand stand;
    } cases[] = {
        {{.sum = 1, .line = 10}, 5, LUM_STAND_REPEAT},
        {{.sum = 2, .line = 10}, 5, LUM_STAND_ELSEWHERE},
        {{.sum = 2, .line = 18}, 5, LUM_STAND_FITS},
        {{.sum = 2, .line = 2}, 5, LUM_STAND_FITS},
        {{.sum = 2, .line = 19}, 5, LUM_STAND_ASTRAY},
        {{.sum = 2, .line = 1}, 5, LUM_STAND_ASTRAY},
        {{.sum = 2, .line = 19, .eye = 1}, 5, LUM_STAND_AHEAD},
        {{.sum = 2, .line = 19}, 100000001, LUM_STAND_NEXT},
    };
    lum_profile profile;
    lum_profile_default(&profile);
    profile.group[LUM_FIELD_TIMESTAMP].bytes = 0;
    const lum_measure m = lum_measure_of(&profile, 100000, 8);
    lum_recent *recent = calloc(1, sizeof *recent);
    (void)state;
    assert_non_null(recent);
    lum_recent_note(recent, &cases[0].seen, 0, 1);
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        const lum_seen *seen = &cases[i].seen;
        const lum_place_among place =
            lum_recent_place(recent, &m, seen, cases[i].time_ns);
        assert_int_equal(lum_place_stand(&place, &m, seen), cases[i].stand);
    }
    free(recent);
}

static void send_two(void)
{
    const struct way a = {.interface = "eth0", .clock = 1000000};
    const struct way b = {
        .interface = "eth1", .clock = 9000000, .first = 50, .begin_ns = 5000};
    send(&a);
    send(&b);
    qsort(all, count, sizeof *all, by_time);
}

static void the_sensor_that_is_asked_for_is_taken_alone(void **state)
{
    static const char *const asked[] = {"", "eth0", "eth1", "eth2"};
    (void)state;
    send_two();
    for (size_t k = 0; k < 4; k++) {
        struct result got = {.sensors = 0};
        struct result alone;
        lum_demux *demux = new_demux(asked[k]);
        size_t wanted = 0;
        for (size_t i = 0; i < count; i++) {
            lum_demux_set_interface(demux, all[i].interface);
            push(demux, &all[i], &got);
            wanted += lum_demux_is_wanted(demux);
        }
        finish(demux, &got);
        assert_int_equal(got.sensors, 2);
        const char *taken = k == 0 ? "eth0" : asked[k];
        run(taken, true, &alone);
        assert_same_counters(&got.total, &alone.total);
        assert_int_equal(wanted, alone.total.packets[LUM_PACKET_DATA]);
        for (size_t i = 0; i < 2; i++) {
            const bool is_taken =
                strcmp(lum_demux_interface(demux, i), taken) == 0;
            assert_int_equal(lum_demux_is_requested(demux, i), is_taken);
            assert_true(got.lines[i] == (is_taken ? alone.lines[0] : 0));
        }
        lum_demux_free(demux);
    }
}

static void names_tell_them_apart_and_stay(void **state)
{
    char name[LUM_SENSOR_NAME_BYTES];
    const struct way third = {
        .clock = 5000000, .sensor = DRIVE_SENSOR + 1u, .interface = "eth1"};
    struct result out = {.sensors = 0};
    (void)state;
    send_two();
    send(&third);
    lum_demux *demux = new_demux(NULL);
    for (size_t i = 0; i < count; i++) {
        lum_demux_set_interface(demux, all[i].interface);
        push(demux, &all[i], &out);
        assert_string_equal(lum_demux_name(demux, 0, name), "10.42.0.37");
    }
    assert_int_equal(lum_demux_sensor_count(demux), 3);
    assert_string_equal(lum_demux_name(demux, 1, name), "10.42.0.37%eth1");
    assert_string_equal(lum_demux_name(demux, 2, name), "10.42.0.38");
    assert_string_equal(lum_demux_interface(demux, 0), "eth0");
    assert_true(lum_demux_is_shared(demux, 0));
    assert_true(lum_demux_is_shared(demux, 1));
    assert_false(lum_demux_is_shared(demux, 2));
    lum_demux_free(demux);
}

static void sensors_too_many_are_other(void **state)
{
    static char names[LUM_DEMUX_SENSORS_MAX + 2u][8];
    struct result out;
    (void)state;
    for (uint32_t i = 0; i < LUM_DEMUX_SENSORS_MAX + 2u; i++) {
        (void)snprintf(names[i], sizeof names[i], "eth%u", (unsigned)i);
        const struct way w = {.interface = names[i],
                              .clock = 1000000u * i,
                              .lines = 30,
                              .begin_ns = 1000 * (int64_t)i};
        send(&w);
    }
    const size_t each = count / (LUM_DEMUX_SENSORS_MAX + 2u);
    run(NULL, true, &out);
    assert_int_equal(out.sensors, LUM_DEMUX_SENSORS_MAX);
    assert_int_equal(out.total.other, 2u * each);
    for (size_t i = 0; i < out.sensors; i++) {
        assert_int_equal(out.counted[i].packets[LUM_PACKET_DATA], each);
        assert_int_equal(out.counted[i].assembly.stray, 0);
    }
}

#define FACT(name) cmocka_unit_test_setup_teardown(name, begin, end)

int main(void)
{
    const struct CMUnitTest tests[] = {
        FACT(two_sensors_are_two_however_alike),
        FACT(two_sensors_on_one_interface_are_told),
        FACT(a_second_sensor_far_behind_is_told),
        FACT(a_sensor_that_begins_anew_is_one),
        FACT(repeats_are_repeats),
        FACT(late_repeats_are_late),
        FACT(damaged_repeats_prove_nothing),
        FACT(a_sensor_may_be_heard_on_either_interface_in_turn),
        FACT(a_sensor_that_goes_on_elsewhere_is_the_same),
        FACT(a_corrupt_clock_there_costs_that_packet_alone),
        FACT(one_packet_makes_no_sensor),
        FACT(without_a_clock_repeats_and_lines_tell),
        FACT(the_sensor_that_is_asked_for_is_taken_alone),
        FACT(names_tell_them_apart_and_stay),
        FACT(sensors_too_many_are_other),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
