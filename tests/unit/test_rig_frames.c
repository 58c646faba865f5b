#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drive.h"

#include "lum/capture/source.h"
#include "lum/frame/image.h"
#include "lum/frame/move.h"
#include "lum/frame/reader.h"
#include "lum/wire.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A rig of three: two of one address on two interfaces, and one more. A fourth
 * sensor sends data too, which no member names. */
#define SENSORS  4u
#define MEMBERS  3u
#define FRAMES   6u
#define LINES    32u
#define BEGIN_NS INT64_C(1700000000000000000)
#define FRAME_US 100000u
#define LINE_US  1500u
#define UNNAMED  3u

static const struct sensor {
    uint32_t address;
    unsigned interface;
    uint32_t clock_us; /* of its first line */
    int64_t skew_us;   /* when that is sent */
} sensors[SENSORS] = {
    {DRIVE_SENSOR, 0, 5000000, 0},
    {DRIVE_SENSOR, 1, 91000000, 300},
    {DRIVE_SENSOR + 5u, 0, 400000000, 700},
    {DRIVE_SENSOR + 9u, 1, 1000, 900},
};
static const char *const interfaces[] = {"eth0", "eth1"};
static const char file_path[] = "rig_frames.pcapng";
static const char index_path[] = "rig_frames.pcapng.lumindex";

struct bytes {
    uint8_t *at;
    size_t len;
    size_t room;
};

/* What the tests are about. */
struct rig {
    lum_layout layouts[MEMBERS];
    lum_calibration calibrations[MEMBERS];
    lum_pose poses[MEMBERS];
    lum_rig_member members[MEMBERS];
    bool left_out[MEMBERS];
    bool names_interfaces; /* as pcapng files do */
};

/* --- Captures --- */

static void put(struct bytes *b, const void *from, size_t len)
{
    if (b->len + len > b->room) {
        b->room = 2u * (b->len + len);
        b->at = realloc(b->at, b->room);
        assert_non_null(b->at);
    }
    memcpy(b->at + b->len, from, len);
    b->len += len;
}

static void put_le(struct bytes *b, uint64_t value, size_t len)
{
    for (size_t i = 0; i < len; i++) {
        const uint8_t byte = (uint8_t)(value >> (8u * i) & 0xffu);
        put(b, &byte, 1);
    }
}

static void put_be(struct bytes *b, uint64_t value, size_t len)
{
    for (size_t i = len; i-- > 0;) {
        const uint8_t byte = (uint8_t)(value >> (8u * i) & 0xffu);
        put(b, &byte, 1);
    }
}

/* Raw IPv4 in nanoseconds; pcap, which names no interfaces, or pcapng. */
static void put_head(struct bytes *b, bool names_interfaces)
{
    if (!names_interfaces) {
        put_le(b, 0xa1b23c4d, 4);
        put_le(b, 0x00040002, 4);
        put_le(b, 0, 8);
        put_le(b, 65535, 4);
        put_le(b, 228, 4);
        return;
    }
    put_le(b, 0x0a0d0d0a, 4);
    put_le(b, 28, 4);
    put_le(b, 0x1a2b3c4d, 4);
    put_le(b, 1, 4);
    put_le(b, UINT64_MAX, 8);
    put_le(b, 28, 4);
    for (unsigned i = 0; i < 2; i++) {
        put_le(b, 1, 4);
        put_le(b, 40, 4);
        put_le(b, 228, 4);
        put_le(b, 0, 4);
        put_le(b, 0x00040002, 4);
        put(b, interfaces[i], 4);
        put_le(b, 0x00010009, 4);
        put_le(b, 9, 4);
        put_le(b, 0, 4);
        put_le(b, 40, 4);
    }
}

static void put_ipv4(struct bytes *b, uint32_t from, const uint8_t *payload,
                     size_t len)
{
    put_be(b, 0x4500, 2);
    put_be(b, 28u + len, 2);
    put_be(b, 0, 4);
    put_be(b, 0x4011, 2);
    put_be(b, 0, 2);
    put_be(b, from, 4);
    put_be(b, DRIVE_CLIENT, 4);
    put_be(b, LUM_PORT, 2);
    put_be(b, 50000, 2);
    put_be(b, 8u + len, 2);
    put_be(b, 0, 2);
    put(b, payload, len);
}

static void put_packet(struct bytes *b, const struct rig *rig,
                       const struct sensor *sensor, int64_t time_ns,
                       const uint8_t *payload, size_t len)
{
    const size_t packet = 28u + len;
    const size_t padded = (packet + 3u) & ~(size_t)3u;
    const bool is_pcap = !rig->names_interfaces;
    const uint64_t ns = (uint64_t)time_ns;
    if (!is_pcap) {
        put_le(b, 6, 4);
        put_le(b, 32u + padded, 4);
        put_le(b, sensor->interface, 4);
    }
    put_le(b, is_pcap ? ns / 1000000000u : ns >> 32, 4);
    put_le(b, is_pcap ? ns % 1000000000u : ns & 0xffffffffu, 4);
    put_le(b, packet, 4);
    put_le(b, packet, 4);
    put_ipv4(b, sensor->address, payload, len);
    if (!is_pcap) {
        put_le(b, 0, padded - packet);
        put_le(b, 32u + padded, 4);
    }
}

static void put_line(struct bytes *b, const struct rig *rig, size_t sensor,
                     uint32_t frame, uint32_t line)
{
    static struct drive_line made;
    const struct sensor *s = &sensors[sensor];
    const uint32_t us = frame * FRAME_US + line * LINE_US;
    const lum_layout *layout = sensor < MEMBERS ? &rig->layouts[sensor] : NULL;
    const uint32_t unit_us =
        layout != NULL ? layout->profile.clock_unit_ns / 1000u : 1u;
    drive_use(layout);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        drive_pixels(&made, eye, line, (s->clock_us + us) / unit_us, 0,
                     200u + 10u * (uint32_t)sensor);
        for (size_t p = 0; p < made.count; p++) {
            put_packet(b, rig, s,
                       BEGIN_NS + ((int64_t)us + s->skew_us) * 1000 +
                           (int64_t)(LUM_EYES * p + eye) * 100,
                       made.bytes[p], made.len[p]);
        }
    }
    drive_use(NULL);
}

static struct bytes make_capture(const struct rig *rig)
{
    struct bytes b = {NULL, 0, 0};
    put_head(&b, rig->names_interfaces);
    for (uint32_t frame = 0; frame < FRAMES; frame++) {
        for (uint32_t line = 0; line < LINES; line++) {
            for (size_t sensor = 0; sensor < SENSORS; sensor++) {
                put_line(&b, rig, sensor, frame, line);
            }
        }
    }
    return b;
}

/* --- Rigs --- */

/* Other fields, orders and ticks than usual. */
static void set_profile(lum_layout *out, uint32_t clock_unit_ns)
{
    lum_profile p;
    lum_profile_default(&p);
    p.group[LUM_FIELD_LINE].order = LUM_ORDER_BIG;
    p.sample_order = LUM_ORDER_BIG;
    p.angle_order = LUM_ELEVATION_AZIMUTH;
    p.clock_unit_ns = clock_unit_ns;
    p.angle_lsb_pdeg = UINT64_C(900000000);
    assert_int_equal(lum_layout_init(out, &p, NULL, NULL), LUM_OK);
}

static struct rig rig_of(bool has_profiles)
{
    struct rig rig = {.names_interfaces = true};
    static const double at[MEMBERS][3] = {
        {1.2, 0.0, 1.8}, {0.1, 0.9, 1.5}, {-2.5, -0.75, 2.25}};
    for (size_t i = 0; i < MEMBERS; i++) {
        lum_layout_default(&rig.layouts[i]);
        lum_calibration_default(&rig.calibrations[i]);
        rig.calibrations[i].tof_lsb_fs += 500u * (uint32_t)i;
        rig.calibrations[i].eye[0].mount_um[1] = 60000 + 7000 * (int32_t)i;
        rig.calibrations[i].eye[1].mount_pitch_udeg = -2000000 * (int32_t)i;
        rig.poses[i] = lum_pose_of_angles(
            at[i], 1.5 * (double)i, -4.0 + 5.0 * (double)i, 120.0 * (double)i);
    }
    if (has_profiles) {
        set_profile(&rig.layouts[1], 1000);
        set_profile(&rig.layouts[2], 10000);
    }
    return rig;
}

static const lum_rig_member *members_of(struct rig *rig)
{
    for (size_t i = 0; i < MEMBERS; i++) {
        rig->members[i] = (lum_rig_member){
            .address = sensors[i].address,
            .interface = i < 2 ? interfaces[sensors[i].interface] : NULL,
            .layout = &rig->layouts[i],
            .calibration = &rig->calibrations[i],
            .pose = &rig->poses[i],
            .is_left_out = rig->left_out[i]};
    }
    return rig->members;
}

static lum_view view_of_all(void)
{
    lum_view view;
    lum_view_default(&view);
    view.columns = LUM_COLUMNS_ALL;
    view.selection.edges = LUM_EDGES_BOTH;
    return view;
}

/* b: without memory, the file of the tests. */
static lum_reader *open_reader(const lum_framer_options *framer,
                               const struct bytes *b)
{
    lum_error error = {""};
    lum_reader *reader = NULL;
    const lum_reader_options options = {
        .struct_size = sizeof options,
        .path = b->at == NULL ? file_path : NULL,
        .source =
            b->at != NULL ? lum_source_from_memory("rig", b->at, b->len) : NULL,
        .framer = framer,
        .keeps_index = true};
    if (lum_reader_open(&options, &reader, &error) != 0) {
        fail_msg("%s", error.text);
    }
    return reader;
}

static lum_reader *open_rig(struct rig *rig, const struct bytes *b,
                            uint32_t threads)
{
    const lum_view view = view_of_all();
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .views = &view,
                                        .view_count = 1,
                                        .threads = threads,
                                        .members = members_of(rig),
                                        .member_count = MEMBERS};
    return open_reader(&options, b);
}

/* The run of one sensor by itself. */
static lum_reader *open_own(const struct rig *rig, size_t i,
                            const struct bytes *b)
{
    const lum_view view = view_of_all();
    const lum_framer_options options = {
        .struct_size = sizeof options,
        .views = &view,
        .view_count = 1,
        .layout = &rig->layouts[i],
        .calibration = &rig->calibrations[i],
        .has_sensor = true,
        .sensor = sensors[i].address,
        .sensor_interface = i < 2 ? interfaces[sensors[i].interface] : NULL};
    return open_reader(&options, b);
}

static const lum_frame *next(lum_reader *reader)
{
    lum_error error = {""};
    const lum_frame *frame = NULL;
    const int result = lum_reader_next_frame(reader, &frame, &error);
    if (result < 0) {
        fail_msg("%s", error.text);
    }
    return result == 1 ? frame : NULL;
}

static lum_frame_info info_of(const lum_frame *frame)
{
    lum_frame_info info = {.struct_size = sizeof info};
    assert_int_equal(lum_frame_get_info(frame, &info), LUM_OK);
    return info;
}

/* --- Comparing --- */

static void assert_placed(const lum_frame *placed, const lum_frame *own,
                          const lum_pose *pose)
{
    const lum_column axes[3] = {LUM_COLUMN_X, LUM_COLUMN_Y, LUM_COLUMN_Z};
    for (size_t i = 0; i < lum_frame_count(own); i++) {
        double at[3];
        for (unsigned k = 0; k < 3; k++) {
            at[k] = (double)lum_frame_floats(own, axes[k])[i];
        }
        lum_pose_apply(pose, at, at);
        for (unsigned k = 0; k < 3; k++) {
            const double is = (double)lum_frame_floats(placed, axes[k])[i];
            assert_true(fabs(is - at[k]) < 2e-5);
        }
    }
}

/* All but x y z and what tells the sensor in another way. */
static void assert_same(const lum_frame *a, const lum_frame *b)
{
    static const size_t bytes[] = {[LUM_TYPE_FLOAT] = 4,
                                   [LUM_TYPE_UINT32] = 4,
                                   [LUM_TYPE_UINT16] = 2,
                                   [LUM_TYPE_UINT8] = 1};
    const lum_frame_info of_a = info_of(a);
    const lum_frame_info of_b = info_of(b);
    assert_int_equal(of_a.number, of_b.number);
    assert_int_equal(of_a.sensor, of_b.sensor);
    assert_int_equal(of_a.is_complete, of_b.is_complete);
    assert_memory_equal(&of_a.times, &of_b.times, sizeof of_a.times);
    assert_int_equal(of_a.points, of_b.points);
    assert_memory_equal(of_a.lines, of_b.lines, sizeof of_a.lines);
    for (unsigned c = LUM_COLUMN_RANGE; c < LUM_COLUMN_COUNT; c++) {
        assert_memory_equal(lum_frame_column(a, (lum_column)c),
                            lum_frame_column(b, (lum_column)c),
                            lum_frame_count(a) *
                                bytes[lum_column_get_type((lum_column)c)]);
    }
}

/* One member's frames of the rig, and those of its own run. */
static void assert_own_run(struct rig *rig, const struct bytes *b, size_t i,
                           uint32_t threads)
{
    lum_reader *joined = open_rig(rig, b, threads);
    lum_reader *own = open_own(rig, i, b);
    const lum_frame *frame = NULL;
    size_t count = 0;
    while ((frame = next(joined)) != NULL) {
        const lum_frame_info info = info_of(frame);
        const lum_pose pose = lum_frame_pose(frame);
        if (info.member != i + 1u) {
            continue;
        }
        const size_t sensor = lum_framer_sensor(lum_reader_framer(joined));
        assert_int_equal(lum_framer_member(lum_reader_framer(joined), sensor),
                         i);
        assert_memory_equal(pose.at, rig->poses[i].at, sizeof pose.at);
        const lum_frame *alone = next(own);
        assert_non_null(alone);
        assert_int_equal(info_of(alone).member, 0);
        assert_true(info.points >= LINES * 400u);
        assert_same(frame, alone);
        assert_placed(frame, alone, &rig->poses[i]);
        count++;
    }
    assert_int_equal(count, FRAMES);
    assert_null(next(own));
    lum_reader_close(own);
    lum_reader_close(joined);
}

static void assert_own_runs(bool has_profiles, uint32_t threads)
{
    struct rig rig = rig_of(has_profiles);
    struct bytes b = make_capture(&rig);
    for (size_t i = 0; i < MEMBERS; i++) {
        assert_own_run(&rig, &b, i, threads);
    }
    free(b.at);
}

static void each_sensor_is_as_in_a_run_of_its_own_but_placed(void **state)
{
    (void)state;
    assert_own_runs(false, 1);
}

static void each_has_its_own_profile(void **state)
{
    (void)state;
    assert_own_runs(true, 1);
}

static void threads_change_nothing(void **state)
{
    (void)state;
    assert_own_runs(true, 3);
}

/* --- Which sensors there are --- */

static void the_one_that_no_member_names_is_known_and_not_assembled(
    void **state)
{
    struct rig rig = rig_of(true);
    struct bytes b = make_capture(&rig);
    lum_reader *reader = open_rig(&rig, &b, 1);
    lum_demux_counters counters = {.struct_size = sizeof counters};
    lum_error remark;
    (void)state;
    while (next(reader) != NULL) {
    }
    const lum_framer *framer = lum_reader_framer(reader);
    const lum_demux *demux = lum_framer_demux(framer);
    assert_int_equal(lum_demux_sensor_count(demux), SENSORS);
    for (size_t i = 0; i < SENSORS; i++) {
        assert_int_equal(lum_framer_member(framer, i),
                         i == UNNAMED ? -1 : (int)i);
        assert_int_equal(lum_demux_is_requested(demux, i), i != UNNAMED);
        assert_int_equal(lum_demux_count(demux, i, &counters), LUM_OK);
        assert_int_equal(counters.assembly.lines != 0, i != UNNAMED);
    }
    assert_int_equal(lum_framer_member(framer, SENSORS), -1);
    assert_true(lum_reader_remark(reader, 0, &remark));
    assert_string_equal(remark.text,
                        "1 sensor sent data and is not in the rig, so it was "
                        "left out; to have it, name in the rig: "
                        "10.42.0.46");
    assert_false(lum_reader_remark(reader, 1, &remark));
    lum_reader_close(reader);
    free(b.at);
}

static void one_that_is_left_out_is_known_and_not_assembled(void **state)
{
    struct rig rig = rig_of(true);
    struct bytes b = make_capture(&rig);
    lum_demux_counters wanted = {.struct_size = sizeof wanted};
    lum_demux_counters total = {.struct_size = sizeof total};
    (void)state;
    rig.left_out[0] = true;
    rig.left_out[2] = true;
    assert_own_run(&rig, &b, 1, 1);
    lum_reader *reader = open_rig(&rig, &b, 1);
    const lum_frame *frame = NULL;
    while ((frame = next(reader)) != NULL) {
        assert_int_equal(info_of(frame).member, 2);
    }
    const lum_framer *framer = lum_reader_framer(reader);
    const lum_demux *demux = lum_framer_demux(framer);
    lum_error remark = {""};
    assert_int_equal(lum_demux_sensor_count(demux), SENSORS);
    for (size_t i = 0; i < MEMBERS; i++) {
        lum_demux_counters c = {.struct_size = sizeof c};
        assert_int_equal(lum_framer_member(framer, i), i);
        assert_int_equal(lum_demux_is_requested(demux, i), i == 1);
        assert_int_equal(lum_demux_count(demux, i, &c), LUM_OK);
        assert_int_equal(c.assembly.lines != 0, i == 1);
        assert_int_equal(c.packets[LUM_PACKET_UNKNOWN_TYPE], 0);
    }
    assert_int_equal(lum_demux_count(demux, 1, &wanted), LUM_OK);
    assert_int_equal(lum_demux_total(demux, &total), LUM_OK);
    assert_memory_equal(total.packets, wanted.packets, sizeof total.packets);
    assert_true(lum_reader_remark(reader, 0, &remark));
    assert_non_null(strstr(remark.text, "name in the rig: 10.42.0.46"));
    assert_false(lum_reader_remark(reader, 1, &remark));
    lum_reader_close(reader);
    free(b.at);
}

/* Counts the frames of each member, and returns the first remark.
 * without: a member that names no interface. */
static lum_error count_frames(struct rig *rig, size_t without,
                              size_t out[MEMBERS])
{
    struct bytes b = make_capture(rig);
    (void)members_of(rig);
    rig->members[without].interface = NULL;
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .members = rig->members,
                                        .member_count = MEMBERS};
    lum_reader *reader = open_reader(&options, &b);
    const lum_frame *frame = NULL;
    lum_error remark = {""};
    memset(out, 0, MEMBERS * sizeof out[0]);
    while ((frame = next(reader)) != NULL) {
        out[info_of(frame).member - 1u]++;
    }
    assert_true(lum_reader_remark(reader, 0, &remark));
    lum_reader_close(reader);
    free(b.at);
    return remark;
}

static void without_names_of_interfaces_members_on_them_are_not_found(
    void **state)
{
    struct rig rig = rig_of(false);
    size_t frames[MEMBERS];
    (void)state;
    rig.names_interfaces = false;
    const lum_error remark = count_frames(&rig, 2, frames);
    assert_int_equal(frames[0], 0);
    assert_int_equal(frames[1], 0);
    assert_int_equal(frames[2], FRAMES);
    assert_non_null(strstr(remark.text,
                           "the rig's sensor 10.42.0.37%eth0 sent no data; "
                           "10.42.0.37 did, on an unknown interface"));
}

static void one_without_an_interface_is_the_first_that_no_other_names(
    void **state)
{
    (void)state;
    for (size_t without = 0; without < 2; without++) {
        struct rig rig = rig_of(true);
        size_t frames[MEMBERS];
        const lum_error remark = count_frames(&rig, without, frames);
        for (size_t i = 0; i < MEMBERS; i++) {
            assert_int_equal(frames[i], FRAMES);
        }
        assert_non_null(strstr(remark.text, "10.42.0.46"));
    }
}

/* --- Other ways to the same frames --- */

static void a_frame_that_is_sought_is_the_same(void **state)
{
    struct rig rig = rig_of(true);
    struct bytes b = make_capture(&rig);
    lum_reader *read = open_rig(&rig, &b, 1);
    lum_reader *sought = open_rig(&rig, &b, 1);
    lum_error error = {""};
    const lum_frame *frame = NULL;
    (void)state;
    while (next(sought) != NULL) {
    }
    for (uint64_t i = 0; i < MEMBERS * FRAMES; i++) {
        frame = next(read);
        assert_non_null(frame);
        const uint64_t back = MEMBERS * FRAMES - 1u - i;
        assert_int_equal(lum_reader_seek_frame(sought, back, &error), 0);
        assert_non_null(next(sought));
        assert_int_equal(lum_reader_seek_frame(sought, i, &error), 0);
        const lum_frame *found = next(sought);
        assert_non_null(found);
        const lum_pose identity = lum_pose_identity();
        assert_int_equal(info_of(found).member, info_of(frame).member);
        assert_same(found, frame);
        assert_placed(found, frame, &identity);
    }
    lum_reader_close(read);
    lum_reader_close(sought);
    free(b.at);
}

/* Returns what lum_reader_load_index() does. */
static int load_index(lum_reader *reader)
{
    lum_error error = {""};
    const int result = lum_reader_load_index(reader, NULL, &error);
    assert_true(result >= 0 || error.text[0] != '\0');
    lum_reader_close(reader);
    return result;
}

static void an_index_of_other_members_is_not_used(void **state)
{
    static const struct bytes of_file = {NULL, 0, 0};
    struct rig rig = rig_of(true);
    struct bytes b = make_capture(&rig);
    FILE *file = fopen(file_path, "wb");
    (void)state;
    assert_non_null(file);
    assert_int_equal(fwrite(b.at, 1, b.len, file), b.len);
    assert_int_equal(fclose(file), 0);
    free(b.at);
    lum_reader *reader = open_rig(&rig, &of_file, 1);
    while (next(reader) != NULL) {
    }
    assert_int_equal(lum_reader_save_index(reader, NULL, NULL), 0);
    lum_reader_close(reader);
    assert_int_equal(load_index(open_rig(&rig, &of_file, 1)), 1);
    rig.poses[1].at[0] += 1.0; /* which frames there are is the same */
    assert_int_equal(load_index(open_rig(&rig, &of_file, 1)), 1);
    assert_int_equal(load_index(open_own(&rig, 0, &of_file)), -1);
    rig.left_out[0] = true;
    assert_int_equal(load_index(open_rig(&rig, &of_file, 1)), -1);
    rig.left_out[0] = false;
    set_profile(&rig.layouts[2], 20000);
    assert_int_equal(load_index(open_rig(&rig, &of_file, 1)), -1);
    (void)remove(file_path);
    (void)remove(index_path);
}

#define POSES 20u

/* A vehicle that drives and turns, 0.1 s a pose; of it, or of a sensor on it.
 */
static lum_poses *drive_of(const lum_pose *sensor)
{
    const double turn[] = {0.6, -0.8, 0.5, 1};
    int64_t times_ns[POSES];
    lum_pose poses[POSES];
    lum_poses *out = NULL;
    lum_error error = {""};
    for (size_t i = 0; i < POSES; i++) {
        const double at[3] = {2.0 * (double)i, 30.0, 0.1 * (double)i};
        times_ns[i] = BEGIN_NS + ((int64_t)i - 5) * 100000000;
        poses[i] = lum_pose_of_angles(at, turn[i % 4u], turn[(i + 1u) % 4u],
                                      4.0 * (double)i);
        poses[i] = lum_pose_compose(&poses[i], sensor);
    }
    if (lum_poses_new(times_ns, poses, POSES, NULL, &out, &error) != 0) {
        fail_msg("%s", error.text);
    }
    return out;
}

struct moved {
    size_t count;
    float *at[3];
};

static struct moved move(const lum_frame *frame, const lum_pose *sensor)
{
    lum_poses *poses = drive_of(sensor);
    const lum_move_options options = {
        .struct_size = sizeof options, .poses = poses, .to = LUM_MOVE_TO_WORLD};
    lum_move_counts counts = {0};
    lum_error error = {""};
    struct moved out = {.count = lum_frame_count(frame)};
    for (unsigned k = 0; k < 3; k++) {
        out.at[k] = malloc(out.count * sizeof *out.at[k]);
        assert_non_null(out.at[k]);
    }
    if (lum_frame_move(frame, &options, out.at[0], out.at[1], out.at[2],
                       &counts, &error) != 0) {
        fail_msg("%s", error.text);
    }
    assert_int_equal(counts.points, out.count);
    assert_int_equal(lum_move_counts_without(&counts), 0);
    lum_poses_free(poses);
    return out;
}

/* Poses of the vehicle move what is placed as those of the sensor move what is
 * not. */
static void placed_points_are_moved_by_the_vehicle(void **state)
{
    struct rig rig = rig_of(false);
    struct bytes b = make_capture(&rig);
    const lum_pose still = lum_pose_identity();
    (void)state;
    for (size_t i = 0; i < MEMBERS; i++) {
        lum_reader *joined = open_rig(&rig, &b, 1);
        lum_reader *own = open_own(&rig, i, &b);
        const struct moved alone = move(next(own), &rig.poses[i]);
        const lum_frame *frame = next(joined);
        while (info_of(frame).member != i + 1u) {
            frame = next(joined);
        }
        const struct moved placed = move(frame, &still);
        assert_true(alone.count > 1000 && alone.count == placed.count);
        for (unsigned k = 0; k < 3; k++) {
            for (size_t p = 0; p < alone.count; p++) {
                const double a = (double)alone.at[k][p];
                assert_true(fabs(a - (double)placed.at[k][p]) < 3e-4);
            }
            free(alone.at[k]);
            free(placed.at[k]);
        }
        lum_reader_close(own);
        lum_reader_close(joined);
    }
    free(b.at);
}

static void a_picture_is_seen_from_the_sensor(void **state)
{
    struct rig rig = rig_of(false);
    struct bytes b = make_capture(&rig);
    (void)state;
    for (size_t i = 0; i < MEMBERS; i++) {
        lum_reader *joined = open_rig(&rig, &b, 1);
        lum_reader *own = open_own(&rig, i, &b);
        const lum_frame *alone = next(own);
        const lum_frame *placed = next(joined);
        while (info_of(placed).member != i + 1u) {
            placed = next(joined);
        }
        lum_image_options options = {.struct_size = sizeof options};
        assert_int_equal(
            lum_frame_image_default(alone, LUM_IMAGE_BOTH, &options), LUM_OK);
        const size_t n = (size_t)options.view.rows * options.view.columns;
        uint32_t *index[2] = {malloc(n * sizeof **index),
                              malloc(n * sizeof **index)};
        assert_true(index[0] != NULL && index[1] != NULL);
        assert_int_equal(
            lum_frame_image_index(alone, &options, index[0], NULL, NULL),
            LUM_OK);
        assert_int_equal(
            lum_frame_image_index(placed, &options, index[1], NULL, NULL),
            LUM_OK);
        size_t filled = 0;
        size_t other = 0; /* on the edge of a pixel, by rounding */
        for (size_t p = 0; p < n; p++) {
            filled += index[0][p] != LUM_FRAME_MISSING;
            other += index[0][p] != index[1][p];
        }
        assert_true(filled > 1000 && 200u * other < filled);
        free(index[0]);
        free(index[1]);
        lum_reader_close(own);
        lum_reader_close(joined);
    }
    free(b.at);
}

/* --- Refused --- */

static void assert_refused(const lum_framer_options *options, const char *why)
{
    lum_framer *framer = NULL;
    lum_error error = {""};
    assert_int_equal(lum_framer_new(options, &framer, &error), -1);
    assert_null(framer);
    assert_string_equal(error.text, why);
}

static void what_does_not_go_together_is_refused(void **state)
{
    struct rig rig = rig_of(false);
    lum_rig_member *m = rig.members;
    (void)members_of(&rig);
    lum_framer_options o = {.struct_size = sizeof o,
                            .members = m,
                            .member_count = MEMBERS,
                            .only_first = true};
    (void)state;
    assert_refused(
        &o,
        "members do not go with only_first or has_sensor; give one of them");
    o.only_first = false;
    o.has_sensor = true;
    assert_refused(
        &o,
        "members do not go with only_first or has_sensor; give one of them");
    o.has_sensor = false;
    o.member_count = LUM_RIG_MEMBERS_MAX + 1u;
    assert_refused(&o, "9 members; at most 8 are accepted");
    o.member_count = MEMBERS;
    o.members = NULL;
    assert_refused(&o, "members is NULL, but 3 members are announced; give "
                       "members, or 0 as their number");
    o.members = m;
    m[1].interface = m[0].interface;
    assert_refused(&o, "members 0 and 1 are the same sensor; members with one "
                       "address need different interfaces");
    m[0].interface = NULL;
    m[1].interface = NULL;
    assert_refused(&o, "members 0 and 1 are the same sensor; members with one "
                       "address need different interfaces");
    (void)members_of(&rig);
    rig.poses[2].turn[0] = NAN;
    assert_refused(&o, "member 2: its pose has a number that is not finite, or "
                       "a quaternion of length 0");
    rig.calibrations[1].tof_lsb_fs = 0;
    assert_refused(&o, "member 1: a value of the calibration is out of range: "
                       "lum_calibration_fault 2, eye 0");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_sensor_is_as_in_a_run_of_its_own_but_placed),
        cmocka_unit_test(each_has_its_own_profile),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(
            the_one_that_no_member_names_is_known_and_not_assembled),
        cmocka_unit_test(one_that_is_left_out_is_known_and_not_assembled),
        cmocka_unit_test(
            without_names_of_interfaces_members_on_them_are_not_found),
        cmocka_unit_test(
            one_without_an_interface_is_the_first_that_no_other_names),
        cmocka_unit_test(a_frame_that_is_sought_is_the_same),
        cmocka_unit_test(an_index_of_other_members_is_not_used),
        cmocka_unit_test(placed_points_are_moved_by_the_vehicle),
        cmocka_unit_test(a_picture_is_seen_from_the_sensor),
        cmocka_unit_test(what_does_not_go_together_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
