#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "stage.h"
#include "thread_monitor.h"
#include "view.h"

#include "lum/capture/demux.h"
#include "lum/wire.h"
#include "sim/packets.h"
#include "sim/render.h"

#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#define FRAMES   6
#define LINES    16u
#define SENSOR   0x0a2a0025u /* 10.42.0.37 */
#define OTHER    0x0a2a0026u
#define START_NS INT64_C(1700000000000000000)
#define WINDOW   31u

static char directory[] = "/tmp/lum-feed-XXXXXX";
static char street[64];

/* What is in each frame, by number; from the library, not from the feed. */
struct content {
    uint64_t packets;
    uint64_t bytes;
    uint64_t points;
    uint64_t rising[FRAMES + 1];
    uint64_t falling[FRAMES + 1];
    uint64_t lines[FRAMES + 1];
    int64_t arrival_ns[FRAMES + 1];
    int64_t clock_us[FRAMES + 1];
};

static struct content content;

static const char *in_directory(const char *name)
{
    static char path[64];
    (void)snprintf(path, sizeof path, "%s/%s", directory, name);
    return path;
}

static void write_line(lum_capture_writer *writer, lum_render *render,
                       const lum_layout *layout, int64_t frame, uint32_t number,
                       uint32_t sensor)
{
    static lum_packet_batch batches[LUM_EYES];
    static lum_sim_line line;
    static lum_sim_packet *order[LUM_EYES * LUM_PACKETS_LINE_MAX];
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        assert_int_equal(lum_render_line(render, frame, number, eye, &line),
                         LUM_OK);
        assert_int_equal(lum_packets_build(layout, &line, &batches[eye]),
                         LUM_OK);
    }
    const size_t count = lum_packets_spread(batches, 1e8 / LINES, order);
    for (size_t i = 0; i < count; i++) {
        const lum_datagram datagram = {.time_ns = START_NS + order[i]->time_ns,
                                       .payload = order[i]->bytes,
                                       .len = order[i]->len,
                                       .source = sensor,
                                       .destination = 0x0a2a0001u,
                                       .source_port = LUM_PORT,
                                       .destination_port = 50000};
        assert_int_equal(lum_capture_writer_add(writer, &datagram, NULL), 0);
    }
}

/* A drive as each of the sensors saw it. */
static void make_capture(const char *path, const uint32_t *sensors,
                         size_t sensor_count)
{
    lum_capture_writer *writer = NULL;
    lum_render_options options;
    lum_render render;
    lum_render_options_default(&options);
    options.lines = LINES;
    assert_int_equal(lum_render_init(&render, &options), LUM_OK);
    assert_int_equal(lum_capture_writer_open(path, &writer, NULL), 0);
    for (int64_t frame = 1; frame <= FRAMES; frame++) {
        for (uint32_t line = 0; line < LINES; line++) {
            for (size_t i = 0; i < sensor_count; i++) {
                write_line(writer, &render, &options.layout, frame, line,
                           sensors[i]);
            }
        }
    }
    assert_int_equal(lum_capture_writer_close(writer, NULL), 0);
    lum_render_free(&render);
}

static void note_line(const lum_projector *projector, const lum_line *line)
{
    lum_point_losses losses = {0, 0};
    uint64_t rising = 0;
    uint64_t falling = 0;
    const size_t f = (size_t)line->frame;
    assert_in_range(line->frame, 1, FRAMES);
    if (content.lines[f] == 0 || line->clock_us < content.clock_us[f]) {
        content.clock_us[f] = line->clock_us;
        content.arrival_ns[f] = line->arrival;
    }
    content.lines[f]++;
    lum_points_count(projector, line, &rising, &falling, &losses);
    content.rising[f] += rising;
    content.falling[f] += falling;
}

static void look_into(const char *path)
{
    lum_demux_options options = {.struct_size = sizeof options,
                                 .has_sensor = false};
    lum_calibration calibration;
    lum_projector projector;
    lum_profile profile;
    lum_capture *capture = NULL;
    lum_record record;
    lum_result r = LUM_OK;
    lum_profile_default(&profile);
    lum_calibration_default(&calibration);
    lum_assembler_config_default(&options.config);
    assert_int_equal(lum_layout_init(&options.layout, &profile, NULL, NULL),
                     LUM_OK);
    assert_int_equal(
        lum_projector_init(&projector, &calibration, &options.layout), LUM_OK);
    lum_demux *demux = NULL;
    assert_int_equal(lum_demux_new(&options, &demux, NULL), 0);
    assert_int_equal(lum_capture_open(path, &capture, NULL), 0);
    while (lum_capture_next(capture, &record, NULL) > 0) {
        content.packets++;
        content.bytes += record.len;
        while ((r = lum_demux_push(demux, &record, NULL)) > 0) {
            if (r == LUM_LINE_READY) {
                note_line(&projector,
                          lum_assembler_line(lum_demux_current(demux)));
            }
        }
    }
    while ((r = lum_demux_flush(demux)) > 0) {
        if (r == LUM_LINE_READY) {
            note_line(&projector, lum_assembler_line(lum_demux_current(demux)));
        }
    }
    for (size_t f = 1; f <= FRAMES; f++) {
        content.points += content.rising[f];
    }
    lum_capture_close(capture);
    lum_demux_free(demux);
}

static int set_up(void **state)
{
    static const uint32_t sensor = SENSOR;
    (void)state;
    assert_non_null(mkdtemp(directory));
    (void)snprintf(street, sizeof street, "%s", in_directory("street.pcap"));
    make_capture(street, &sensor, 1);
    look_into(street);
    assert_true(content.points > 0);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    (void)unlink(street);
    return rmdir(directory);
}

static void close_well(struct viewer *viewer)
{
    lum_error error = {""};
    assert_int_equal(viewer_close(viewer, &error), 0);
}

static void open_paused(struct viewer *viewer)
{
    viewer_init(viewer, street);
    viewer->options.play.paused = true;
    viewer_open(viewer);
    (void)viewer_wait(viewer, shows_frame, 1);
    (void)viewer_wait(viewer, has_range, 0);
}

static void assert_frame(const struct frame *frame, size_t number,
                         uint64_t points)
{
    assert_int_equal(frame_points(frame), points);
    assert_true(frame_double(frame, 8) == (double)number);
    assert_true(frame_double(frame, 16) == (double)content.clock_us[number]);
    assert_true(fabs(frame_double(frame, 24) -
                     (double)content.arrival_ns[number] * 1e-9) < 1e-5);
    assert_int_equal(frame_u32(frame, 40), content.lines[number]);
    assert_int_equal(frame_u32(frame, 44), 0);
    assert_int_equal(frame_u32(frame, 48), SENSOR);
}

static void each_frame_has_the_points_that_are_in_it(void **state)
{
    static const struct feed_view views[] = {{LUM_EDGES_RISING, 0},
                                             {LUM_EDGES_FALLING, 0},
                                             {LUM_EDGES_BOTH, 0},
                                             {LUM_EDGES_BOTH, WINDOW}};
    struct viewer v;
    (void)state;
    open_paused(&v);
    feed_want(v.feed, views, 4);
    for (size_t f = 1; f <= FRAMES; f++) {
        const uint64_t points[] = {content.rising[f], content.falling[f],
                                   content.rising[f] + content.falling[f],
                                   content.rising[f] + content.falling[f]};
        feed_seek(v.feed, (int64_t)f);
        (void)viewer_wait(&v, shows_frame, (int64_t)f);
        for (size_t i = 0; i < 4; i++) {
            struct frame *frame =
                viewer_wait_frame(&v, views[i].edges, views[i].smooth);
            assert_frame(frame, f, points[i]);
            assert_int_equal(frame_u32(frame, 36) & 0xffffu,
                             (unsigned)views[i].edges | views[i].smooth << 8);
            frame_release(frame);
        }
    }
    close_well(&v);
}

/* The second profile's points are behind, of the same frame, wherever a jump
 * leads. By it both eyes' packets are the other's. */
static void a_second_profile_follows_the_first(void **state)
{
    static const size_t jumps[] = {1, FRAMES, 2, 3, 1};
    lum_profile second;
    struct viewer v;
    (void)state;
    lum_profile_default(&second);
    second.eye_values[LUM_EYE_BLUE] = 1;
    second.eye_values[LUM_EYE_GREEN] = 0;
    viewer_init(&v, street);
    v.second = &second;
    v.options.play.paused = true;
    viewer_open(&v);
    (void)viewer_wait(&v, has_range, 0);
    assert_int_equal(feed_profile(v.feed, true)->eye_values[LUM_EYE_BLUE], 1);
    for (size_t i = 0; i < sizeof jumps / sizeof jumps[0]; i++) {
        feed_seek(v.feed, (int64_t)jumps[i]);
        (void)viewer_wait(&v, shows_frame, (int64_t)jumps[i]);
        struct frame *frame = viewer_wait_frame(&v, LUM_EDGES_RISING, 0);
        const uint64_t points = content.rising[jumps[i]];
        assert_frame(frame, jumps[i], 2u * points);
        assert_int_equal(frame_u32(frame, 72), points);
        frame_release(frame);
    }
    close_well(&v);
}

static void a_capture_plays_to_its_end_and_counts_what_lumdump_counts(
    void **state)
{
    struct viewer v;
    (void)state;
    viewer_init(&v, street);
    v.options.play.speed = 20.0;
    viewer_open(&v);
    const struct feed_status s = viewer_wait(&v, is_in_state, FEED_ENDED);
    assert_int_equal(s.frames, FRAMES);
    assert_int_equal(s.frame, FRAMES);
    assert_int_equal(s.decoded.points, content.points);
    assert_int_equal(s.received.packets, content.packets);
    assert_int_equal(s.received.bytes, content.bytes);
    assert_int_equal(
        s.decoded.lost_words + s.decoded.lost_lines + s.decoded.refused, 0);
    assert_false(s.is_live);
    assert_false(s.has_laser);
    assert_string_equal(s.texts[FEED_MESSAGE], "");
    close_well(&v);
}

/* The drive without some of its packets. */
static void make_without(const char *path, uint64_t first, uint64_t count)
{
    lum_capture *from = NULL;
    lum_capture_writer *to = NULL;
    lum_record r;
    assert_int_equal(lum_capture_open(street, &from, NULL), 0);
    assert_int_equal(lum_capture_writer_open(path, &to, NULL), 0);
    for (uint64_t i = 0; lum_capture_next(from, &r, NULL) > 0; i++) {
        const lum_datagram datagram = {.time_ns = r.time_ns,
                                       .payload = r.payload,
                                       .len = r.len,
                                       .source = r.source,
                                       .destination = r.destination,
                                       .source_port = r.source_port,
                                       .destination_port = r.destination_port};
        if (i < first || i - first >= count) {
            assert_int_equal(lum_capture_writer_add(to, &datagram, NULL), 0);
        }
    }
    assert_int_equal(lum_capture_writer_close(to, NULL), 0);
    lum_capture_close(from);
}

static void what_was_under_way_when_a_stream_was_joined_is_no_loss(void **state)
{
    struct viewer v;
    const char *joined = in_directory("joined.pcap");
    (void)state;
    make_without(joined, 0, 5);
    viewer_init(&v, joined);
    v.options.play.speed = 20.0;
    viewer_open(&v);
    const struct feed_status s = viewer_wait(&v, is_in_state, FEED_ENDED);
    assert_int_not_equal(s.decoded.lost_lines, 0);
    assert_int_equal(s.decoded.lost_lines, s.decoded.joined_lines);
    assert_int_equal(s.decoded.lost_words, s.decoded.joined_words);
    close_well(&v);
    (void)unlink(joined);
}

/* The third frame, in which packets of both eyes are missing. */
static void what_a_capture_lacks_is_marked(void **state)
{
    struct viewer v;
    static struct feed_marks marks;
    const char *path = in_directory("lossy.pcap");
    (void)state;
    make_without(path, content.packets * 5u / (2u * FRAMES), 4);
    viewer_init(&v, path);
    v.options.play.paused = true;
    viewer_open(&v);
    const struct feed_status s = viewer_wait(&v, has_range, 0);
    feed_look_marks(v.feed, &marks);
    assert_int_equal(s.marks, 1);
    assert_int_equal(marks.count, 1);
    assert_int_equal(marks.frames, 1);
    assert_int_equal(marks.at[0].frame, 3);
    assert_true(marks.at[0].loss.words + marks.at[0].loss.lines > 0);
    assert_int_equal(marks.at[0].loss.pauses, 0);
    close_well(&v);
    (void)unlink(path);
}

static void ignore(void *context)
{
    (void)context;
}

static void marks_are_of_more_frames_where_there_are_many(void **state)
{
    static struct stage stage;
    static const struct feed_loss loss = {3, 2, 1};
    struct feed_loss sum = {0, 0, 0};
    (void)state;
    assert_true(stage_init(&stage, ignore, NULL));
    for (int64_t frame = 999; frame >= -1; frame--) {
        stage_mark(&stage, frame, &loss);
    }
    const struct feed_marks *m = &stage.marks;
    assert_int_equal(m->frames, 4);
    assert_int_equal(m->count, 251);
    for (size_t i = 0; i < m->count; i++) {
        assert_int_equal(m->at[i].frame, ((int64_t)i - 1) * 4);
        loss_add(&sum, &m->at[i].loss);
    }
    assert_int_equal(sum.words, 3003);
    assert_int_equal(sum.lines, 2002);
    assert_int_equal(sum.pauses, 1001);
    stage_end(&stage);
}

static void the_first_and_the_last_frame_become_known(void **state)
{
    struct viewer v;
    (void)state;
    open_paused(&v);
    const struct feed_status s = viewer_wait(&v, has_range, 0);
    assert_int_equal(s.first_frame, 1);
    assert_int_equal(s.last_frame, FRAMES);
    assert_true(s.scanned >= 1);
    close_well(&v);
}

static void play_at_the_end_begins_anew(void **state)
{
    struct viewer v;
    (void)state;
    viewer_init(&v, street);
    v.options.play.speed = 100.0;
    viewer_open(&v);
    (void)viewer_wait(&v, is_in_state, FEED_ENDED);
    feed_play(v.feed, true);
    (void)viewer_wait(&v, has_shown, 2 * FRAMES);
    (void)viewer_wait(&v, is_in_state, FEED_ENDED);
    /* the same from a pause on the last frame */
    feed_play(v.feed, false);
    (void)viewer_wait(&v, is_in_state, FEED_PAUSED);
    feed_play(v.feed, true);
    const struct feed_status s = viewer_wait(&v, has_shown, 3 * FRAMES);
    assert_int_equal(s.decoded.points, 3u * content.points);
    close_well(&v);
}

static void a_pause_stands_until_play(void **state)
{
    struct viewer v;
    (void)state;
    open_paused(&v);
    const struct feed_status s = viewer_wait(&v, is_in_state, FEED_PAUSED);
    assert_int_equal(s.frames, 1);
    feed_speed(v.feed, 100.0);
    feed_play(v.feed, true);
    (void)viewer_wait(&v, is_in_state, FEED_ENDED);
    close_well(&v);
}

static void steps_lead_forward_and_back_and_end_at_the_ends(void **state)
{
    struct viewer v;
    (void)state;
    open_paused(&v);
    feed_step(v.feed, 1);
    (void)viewer_wait(&v, shows_frame, 2);
    feed_step(v.feed, 3);
    (void)viewer_wait(&v, shows_frame, 5);
    feed_step(v.feed, -2);
    (void)viewer_wait(&v, shows_frame, 3);
    feed_step(v.feed, -1);
    (void)viewer_wait(&v, shows_frame, 2);
    feed_step(v.feed, 1000);
    (void)viewer_wait(&v, shows_frame, FRAMES);
    feed_step(v.feed, INT64_MIN);
    (void)viewer_wait(&v, shows_frame, 1);
    feed_step(v.feed, INT64_MAX);
    (void)viewer_wait(&v, shows_frame, FRAMES);
    const struct feed_status s = viewer_wait(&v, is_in_state, FEED_PAUSED);
    assert_int_equal(s.frames, 8);
    close_well(&v);
}

static void steps_that_come_together_add_up(void **state)
{
    struct viewer v;
    (void)state;
    open_paused(&v);
    feed_step(v.feed, 1);
    feed_step(v.feed, 1);
    feed_step(v.feed, 1);
    (void)viewer_wait(&v, shows_frame, 4);
    feed_seek(v.feed, 2);
    feed_step(v.feed, 3);
    (void)viewer_wait(&v, shows_frame, 5);
    close_well(&v);
}

/* Those before the frame that is shown, so many with it, and no others. */
static void assert_past(struct viewer *v, int64_t shown, int64_t frames)
{
    static const struct feed_view rising = {LUM_EDGES_RISING, 0};
    for (int64_t f = 1; f <= FRAMES; f++) {
        struct frame *frame = feed_past(v->feed, &rising, f);
        if (f < shown && f > shown - frames) {
            assert_non_null(frame);
            assert_frame(frame, (size_t)f, content.rising[f]);
        } else {
            assert_null(frame);
        }
        frame_release(frame);
    }
}

static void frames_at_once_end_at_the_one_that_is_shown(void **state)
{
    static const int64_t jumps[] = {FRAMES, 2, 5, 3, 4};
    struct viewer v;
    (void)state;
    open_paused(&v);
    assert_past(&v, 1, 1);
    feed_keep(v.feed, 3);
    for (size_t i = 0; i < sizeof jumps / sizeof jumps[0]; i++) {
        feed_seek(v.feed, jumps[i]);
        (void)viewer_wait(&v, shows_frame, jumps[i]);
        assert_past(&v, jumps[i], 3);
    }
    const int64_t shown = (int64_t)viewer_wait(&v, shows_frame, 4).frames;
    feed_keep(v.feed, 4); /* it is shown again, with one more */
    (void)viewer_wait(&v, has_shown, shown + 1);
    assert_past(&v, 4, 4);
    feed_seek(v.feed, INT64_MAX);
    (void)viewer_wait(&v, shows_frame, FRAMES);
    assert_past(&v, FRAMES, 4);
    feed_loop(v.feed, true);
    feed_play(v.feed, true); /* anew */
    (void)viewer_wait(&v, shows_frame, 2);
    feed_play(v.feed, false);
    const struct feed_status s = viewer_wait(&v, is_in_state, FEED_PAUSED);
    assert_past(&v, s.frame, 4);
    close_well(&v);
}

/* What goes by is kept too. */
static void a_capture_that_plays_keeps_frames(void **state)
{
    struct viewer v;
    (void)state;
    viewer_init(&v, street);
    v.options.play.speed = 20.0;
    viewer_open(&v);
    feed_keep(v.feed, FRAMES);
    (void)viewer_wait(&v, is_in_state, FEED_ENDED);
    assert_past(&v, FRAMES, FRAMES);
    close_well(&v);
}

static void a_step_pauses(void **state)
{
    struct viewer v;
    (void)state;
    viewer_init(&v, street);
    v.options.play.speed = 0.01;
    viewer_open(&v);
    (void)viewer_wait(&v, shows_frame, 1);
    (void)viewer_wait(&v, is_in_state, FEED_PLAYING);
    feed_step(v.feed, 1);
    (void)viewer_wait(&v, shows_frame, 2);
    (void)viewer_wait(&v, is_in_state, FEED_PAUSED);
    close_well(&v);
}

static void a_jump_leads_to_the_nearest_frame(void **state)
{
    static const int64_t jumps[][2] = {{4, 4},        {2, 2},
                                       {-5, 1},       {FRAMES + 1, FRAMES},
                                       {1, 1},        {INT64_MAX, FRAMES},
                                       {INT64_MIN, 1}};
    struct viewer v;
    (void)state;
    open_paused(&v);
    for (size_t i = 0; i < sizeof jumps / sizeof *jumps; i++) {
        feed_seek(v.feed, jumps[i][0]);
        (void)viewer_wait(&v, shows_frame, jumps[i][1]);
    }
    (void)viewer_wait(&v, is_in_state, FEED_PAUSED);
    close_well(&v);
}

static void a_jump_before_the_ends_are_known_leads_there_too(void **state)
{
    struct viewer v;
    (void)state;
    viewer_init(&v, street);
    v.options.play.paused = true;
    viewer_open(&v);
    feed_seek(v.feed, 1000);
    (void)viewer_wait(&v, shows_frame, FRAMES);
    close_well(&v);
}

/* Bytes of a piece of a frame. */
static size_t piece_len(const uint8_t *piece)
{
    return (size_t)piece[80] | (size_t)piece[81] << 8 | (size_t)piece[82] << 16;
}

/* All of a frame but when it was shown. */
static void assert_same_frame(struct viewer *v, const struct frame *before)
{
    size_t len = 0;
    size_t len_before = 0;
    struct frame *now = viewer_wait_frame(v, LUM_EDGES_BOTH, WINDOW);
    const uint8_t *bytes = frame_bytes(now, &len);
    const uint8_t *bytes_before = frame_bytes(before, &len_before);
    assert_int_equal(len, len_before);
    for (size_t at = 0; at < len;) {
        const size_t rest = piece_len(bytes + at);
        assert_int_equal(rest, piece_len(bytes_before + at));
        assert_memory_equal(bytes + at, bytes_before + at, 52);
        assert_memory_equal(bytes + at + 64, bytes_before + at + 64, rest - 64);
        at += rest;
    }
    frame_release(now);
}

/* The second frame, in the file, and the begin of the third. */
static void damage(const char *path)
{
    struct stat st;
    FILE *file = fopen(path, "r+b");
    assert_non_null(file);
    assert_int_equal(fstat(fileno(file), &st), 0);
    assert_int_equal(fseek(file, st.st_size / FRAMES + 4096, SEEK_SET), 0);
    for (int64_t i = 0; i < st.st_size / FRAMES; i++) {
        assert_int_equal(fputc(0, file), 0);
    }
    assert_int_equal(fclose(file), 0);
}

/* Of two sensors, so that data of one is passed over. */
static void a_jump_gives_the_same_frames_and_reads_nothing_before_them(
    void **state)
{
    static const uint32_t sensors[] = {SENSOR, OTHER};
    static const size_t jumps[] = {FRAMES, 2, 4, 5, 1, 3};
    struct frame *frames[FRAMES + 1];
    const char *path = in_directory("jumps.pcap");
    struct viewer v;
    (void)state;
    make_capture(path, sensors, 2);
    viewer_init(&v, path);
    v.options.play.paused = true;
    viewer_open(&v);
    viewer_want(&v, LUM_EDGES_BOTH, WINDOW);
    (void)viewer_wait(&v, has_range, 0);
    for (size_t f = 1; f <= FRAMES; f++) {
        (void)viewer_wait(&v, shows_frame, (int64_t)f);
        frames[f] = viewer_wait_frame(&v, LUM_EDGES_BOTH, WINDOW);
        feed_step(v.feed, 1);
    }
    for (size_t i = 0; i < sizeof jumps / sizeof jumps[0]; i++) {
        feed_seek(v.feed, (int64_t)jumps[i]);
        (void)viewer_wait(&v, shows_frame, (int64_t)jumps[i]);
        assert_same_frame(&v, frames[jumps[i]]);
    }
    damage(path);
    for (size_t f = FRAMES; f > 3; f--) {
        feed_seek(v.feed, (int64_t)f);
        (void)viewer_wait(&v, shows_frame, (int64_t)f);
        assert_same_frame(&v, frames[f]);
    }
    for (size_t f = 1; f <= FRAMES; f++) {
        frame_release(frames[f]);
    }
    close_well(&v);
    (void)unlink(path);
}

static void a_jump_keeps_playing(void **state)
{
    struct viewer v;
    (void)state;
    viewer_init(&v, street);
    v.options.play.speed = 0.01;
    viewer_open(&v);
    (void)viewer_wait(&v, shows_frame, 1);
    feed_seek(v.feed, 4);
    (void)viewer_wait(&v, shows_frame, 4);
    feed_seek(v.feed, 2);
    (void)viewer_wait(&v, shows_frame, 2);
    feed_speed(v.feed, 100.0);
    const struct feed_status s = viewer_wait(&v, is_in_state, FEED_ENDED);
    /* 1, 4, and from 2 to the end */
    assert_int_equal(s.frames, 2 + FRAMES - 1);
    close_well(&v);
}

static void what_is_passed_over_is_not_counted(void **state)
{
    struct viewer v;
    (void)state;
    open_paused(&v);
    feed_seek(v.feed, FRAMES);
    const struct feed_status s = viewer_wait(&v, shows_frame, FRAMES);
    assert_true(s.decoded.points < content.rising[1] + content.rising[2] +
                                       content.rising[FRAMES] +
                                       content.rising[1]);
    assert_true(s.decoded.points >= content.rising[1] + content.rising[FRAMES]);
    assert_true(s.received.packets < content.packets * 4u / 6u);
    close_well(&v);
}

static void a_loop_goes_round_until_it_is_ended(void **state)
{
    struct viewer v;
    (void)state;
    viewer_init(&v, street);
    v.options.play.loops = true;
    v.options.play.speed = 100.0;
    viewer_open(&v);
    struct feed_status s = viewer_wait(&v, has_shown, 3 * FRAMES);
    assert_true(s.loops);
    assert_int_equal(s.state, FEED_PLAYING);
    feed_loop(v.feed, false);
    s = viewer_wait(&v, is_in_state, FEED_ENDED);
    assert_int_equal(s.frames % FRAMES, 0);
    feed_loop(v.feed, true);
    (void)viewer_wait(&v, has_shown, (int64_t)s.frames + 2 * FRAMES);
    close_well(&v);
}

static void speed_changes_what_is_waited_for_now(void **state)
{
    struct viewer v;
    (void)state;
    viewer_init(&v, street);
    v.options.play.speed = 0.0;
    viewer_open(&v);
    struct feed_status s = viewer_wait(&v, shows_frame, 1);
    assert_true(s.speed == 0.01);
    feed_speed(v.feed, 1e6);
    s = viewer_wait(&v, is_in_state, FEED_ENDED);
    assert_true(s.speed == 100.0);
    assert_int_equal(s.frames, FRAMES);
    close_well(&v);
}

static void nothing_plays_while_nobody_looks(void **state)
{
    struct viewer v;
    struct feed_status s;
    (void)state;
    viewer_init(&v, street);
    v.options.play.speed = 100.0;
    viewer_open(&v);
    feed_want(v.feed, NULL, 0);
    (void)viewer_wait(&v, has_range, 0);
    feed_look(v.feed, &s);
    assert_int_not_equal(s.state, FEED_ENDED);
    viewer_want(&v, LUM_EDGES_BOTH, 0);
    s = viewer_wait(&v, is_in_state, FEED_ENDED);
    assert_int_equal(s.frame, FRAMES);
    close_well(&v);
}

static void a_view_that_is_wanted_in_a_pause_is_made_of_the_same_frame(
    void **state)
{
    struct viewer v;
    (void)state;
    open_paused(&v);
    feed_seek(v.feed, 3);
    (void)viewer_wait(&v, shows_frame, 3);
    viewer_want(&v, LUM_EDGES_FALLING, 0);
    struct frame *frame = viewer_wait_frame(&v, LUM_EDGES_FALLING, 0);
    assert_frame(frame, 3, content.falling[3]);
    frame_release(frame);
    viewer_want(&v, LUM_EDGES_BOTH, WINDOW);
    frame = viewer_wait_frame(&v, LUM_EDGES_BOTH, WINDOW);
    assert_frame(frame, 3, content.rising[3] + content.falling[3]);
    frame_release(frame);
    (void)viewer_wait(&v, is_in_state, FEED_PAUSED);
    close_well(&v);
}

static void a_view_that_is_wanted_at_the_end_is_made_and_the_end_stays(
    void **state)
{
    struct viewer v;
    (void)state;
    viewer_init(&v, street);
    v.options.play.speed = 100.0;
    viewer_open(&v);
    (void)viewer_wait(&v, is_in_state, FEED_ENDED);
    viewer_want(&v, LUM_EDGES_FALLING, 0);
    struct frame *frame = viewer_wait_frame(&v, LUM_EDGES_FALLING, 0);
    assert_frame(frame, FRAMES, content.falling[FRAMES]);
    frame_release(frame);
    const struct feed_status s = viewer_wait(&v, is_in_state, FEED_ENDED);
    assert_int_equal(s.frame, FRAMES);
    close_well(&v);
}

static void a_view_that_is_wanted_in_slow_motion_does_not_wait(void **state)
{
    struct viewer v;
    (void)state;
    viewer_init(&v, street);
    v.options.play.speed = 0.01;
    viewer_open(&v);
    (void)viewer_wait(&v, shows_frame, 1);
    viewer_want(&v, LUM_EDGES_FALLING, 0);
    struct frame *frame = viewer_wait_frame(&v, LUM_EDGES_FALLING, 0);
    assert_frame(frame, 1, content.falling[1]);
    frame_release(frame);
    close_well(&v);
}

static void smoothing_moves_points_and_loses_none(void **state)
{
    struct viewer v;
    (void)state;
    open_paused(&v);
    struct frame *plain = viewer_wait_frame(&v, LUM_EDGES_RISING, 0);
    viewer_want(&v, LUM_EDGES_RISING, WINDOW);
    struct frame *smooth = viewer_wait_frame(&v, LUM_EDGES_RISING, WINDOW);
    struct unpacked a = frame_arrays(plain);
    struct unpacked b = frame_arrays(smooth);
    assert_int_equal(a.count, b.count);
    assert_memory_not_equal(a.xyz, b.xyz, a.count * sizeof *a.xyz);
    assert_memory_equal(a.width, b.width, a.count * sizeof *a.width);
    assert_memory_equal(a.line, b.line, a.count * sizeof *a.line);
    assert_memory_equal(a.pixel, b.pixel, a.count * sizeof *a.pixel);
    assert_memory_equal(a.turn, b.turn, a.count);
    assert_memory_equal(a.bits, b.bits, a.count);
    unpacked_free(&a);
    unpacked_free(&b);
    frame_release(plain);
    frame_release(smooth);
    close_well(&v);
}

static void frames_that_are_kept_outlive_the_feed(void **state)
{
    struct viewer v;
    (void)state;
    open_paused(&v);
    struct frame *frame = viewer_wait_frame(&v, LUM_EDGES_RISING, 0);
    close_well(&v);
    assert_frame(frame, 1, content.rising[1]);
    frame_release(frame);
}

static void a_feed_ends_whatever_it_is_at(void **state)
{
    struct viewer v;
    (void)state;
    for (unsigned i = 0; i < 20; i++) {
        viewer_init(&v, street);
        v.options.play.loops = true;
        v.options.play.speed = 100.0;
        viewer_open(&v);
        if (i % 2 == 0) {
            (void)viewer_wait(&v, has_shown, i);
        }
        feed_seek(v.feed, (int64_t)(i * 7u % FRAMES));
        feed_step(v.feed, -(int64_t)(i % 3u));
        close_well(&v);
    }
}

static void orders_may_come_faster_than_frames(void **state)
{
    struct viewer v;
    (void)state;
    open_paused(&v);
    for (int64_t i = 0; i < 500; i++) {
        feed_seek(v.feed, 1 + i * 5 % FRAMES);
        viewer_want(&v, i % 2 == 0 ? LUM_EDGES_BOTH : LUM_EDGES_FALLING, 0);
        feed_play(v.feed, i % 3 == 0);
        feed_step(v.feed, i % 4 - 2);
    }
    feed_seek(v.feed, 5);
    (void)viewer_wait(&v, shows_frame, 5);
    struct frame *frame = viewer_wait_frame(&v, LUM_EDGES_FALLING, 0);
    assert_frame(frame, 5, content.falling[5]);
    frame_release(frame);
    close_well(&v);
}

static void of_several_sensors_the_first_is_shown_and_the_others_named(
    void **state)
{
    static const uint32_t sensors[] = {OTHER, SENSOR};
    char path[64];
    struct viewer v;
    (void)state;
    (void)snprintf(path, sizeof path, "%s", in_directory("two.pcap"));
    make_capture(path, sensors, 2);
    viewer_init(&v, path);
    v.options.play.speed = 100.0;
    viewer_open(&v);
    struct feed_status s = viewer_wait(&v, is_in_state, FEED_ENDED);
    assert_int_equal(s.decoded.points, content.points);
    assert_int_equal(s.received.packets, content.packets);
    assert_int_equal(s.received.bytes, content.bytes);
    assert_int_equal(s.frames, FRAMES);
    assert_string_equal(s.texts[FEED_MESSAGE],
                        "10.42.0.38 is shown; there is also 10.42.0.37: choose "
                        "by lumview --sensor, or show all by a rig: lumview "
                        "--rig, or a rig file dropped on lumview.html");
    close_well(&v);
    viewer_init(&v, path);
    v.options.sensor.is_given = true;
    v.options.sensor.address = SENSOR;
    v.options.play.speed = 100.0;
    viewer_open(&v);
    s = viewer_wait(&v, is_in_state, FEED_ENDED);
    assert_int_equal(s.decoded.points, content.points);
    assert_int_equal(s.received.packets, content.packets);
    struct frame *frame = viewer_wait_frame(&v, LUM_EDGES_RISING, 0);
    assert_frame(frame, FRAMES, content.rising[FRAMES]);
    frame_release(frame);
    close_well(&v);
    assert_int_equal(unlink(path), 0);
}

static bool has_remarks(const struct feed_status *s, int64_t unused)
{
    (void)unused;
    return s->texts[FEED_REMARKS][0] != '\0';
}

static void copy_part(const char *to, long bytes)
{
    FILE *in = fopen(street, "rb");
    FILE *out = fopen(to, "wb");
    assert_non_null(in);
    assert_non_null(out);
    for (long i = 0; i < bytes; i++) {
        assert_true(fputc(fgetc(in), out) != EOF);
    }
    assert_int_equal(fclose(in), 0);
    assert_int_equal(fclose(out), 0);
}

static void a_capture_that_breaks_off_is_shown_as_far_as_it_goes(void **state)
{
    char path[64];
    struct viewer v;
    struct stat st;
    (void)state;
    (void)snprintf(path, sizeof path, "%s", in_directory("broken.pcap"));
    assert_int_equal(stat(street, &st), 0);
    copy_part(path, (long)st.st_size / 2);
    viewer_init(&v, path);
    v.options.play.speed = 100.0;
    viewer_open(&v);
    const struct feed_status s = viewer_wait(&v, is_in_state, FEED_ENDED);
    assert_in_range(s.frames, 3, 4);
    assert_non_null(strstr(s.texts[FEED_MESSAGE], "broken.pcap"));
    close_well(&v);
    assert_int_equal(unlink(path), 0);
}

/* A snap length cuts its longest packets. */
static void what_is_odd_about_a_capture_is_told(void **state)
{
    enum {
        SNAP = 1000,
        HEADERS = 24
    };
    char path[64];
    uint8_t head[16];
    uint8_t bytes[2048];
    struct viewer v;
    (void)state;
    (void)snprintf(path, sizeof path, "%s", in_directory("cut.pcap"));
    copy_part(path, HEADERS);
    FILE *in = fopen(street, "rb");
    FILE *out = fopen(path, "ab");
    assert_non_null(in);
    assert_non_null(out);
    assert_int_equal(fseek(in, HEADERS, SEEK_SET), 0);
    while (fread(head, sizeof head, 1, in) == 1) {
        const size_t len = head[8] + 256u * head[9];
        const size_t held = len < SNAP ? len : SNAP;
        assert_int_equal(fread(bytes, len, 1, in), 1);
        head[8] = (uint8_t)held;
        head[9] = (uint8_t)(held >> 8u);
        assert_int_equal(fwrite(head, sizeof head, 1, out), 1);
        assert_int_equal(fwrite(bytes, held, 1, out), 1);
    }
    assert_int_equal(fclose(in), 0);
    assert_int_equal(fclose(out), 0);
    viewer_init(&v, path);
    v.options.play.speed = 100.0;
    viewer_open(&v);
    const struct feed_status s = viewer_wait(&v, has_remarks, 0);
    assert_non_null(strstr(s.texts[FEED_REMARKS], "snap length of 1000 bytes"));
    close_well(&v);
    assert_int_equal(unlink(path), 0);
}

static void a_capture_without_frames_says_so(void **state)
{
    char path[64];
    struct viewer v;
    (void)state;
    (void)snprintf(path, sizeof path, "%s", in_directory("empty.pcap"));
    copy_part(path, 24);
    viewer_init(&v, path);
    viewer_open(&v);
    struct feed_status s = viewer_wait(&v, is_in_state, FEED_ENDED);
    assert_non_null(strstr(s.texts[FEED_MESSAGE], "no frame"));
    feed_play(v.feed, true);
    feed_step(v.feed, 1);
    close_well(&v);
    assert_int_equal(unlink(path), 0);
    viewer_init(&v, street);
    v.options.sensor.is_given = true;
    v.options.sensor.address = OTHER;
    viewer_open(&v);
    s = viewer_wait(&v, is_in_state, FEED_ENDED);
    assert_non_null(
        strstr(s.texts[FEED_MESSAGE], "no frame in it of the sensor"));
    close_well(&v);
}

static void a_capture_that_is_gone_fails_until_it_is_back(void **state)
{
    char path[64];
    char away[64];
    struct viewer v;
    (void)state;
    (void)snprintf(path, sizeof path, "%s", in_directory("here.pcap"));
    (void)snprintf(away, sizeof away, "%s", in_directory("away.pcap"));
    assert_int_equal(link(street, path), 0);
    viewer_init(&v, path);
    v.options.play.paused = true;
    viewer_open(&v);
    (void)viewer_wait(&v, has_range, 0);
    feed_seek(v.feed, 3);
    (void)viewer_wait(&v, shows_frame, 3);
    assert_int_equal(rename(path, away), 0);
    feed_seek(v.feed, 2);
    const struct feed_status s = viewer_wait(&v, is_in_state, FEED_FAILED);
    assert_non_null(strstr(s.texts[FEED_MESSAGE], "here.pcap"));
    assert_int_equal(s.frame, 3);
    assert_int_equal(rename(away, path), 0);
    feed_seek(v.feed, 2);
    (void)viewer_wait(&v, shows_frame, 2);
    (void)viewer_wait(&v, is_in_state, FEED_PAUSED);
    close_well(&v);
    assert_int_equal(unlink(path), 0);
}

static void expect_refusal(const char *source, const char *calibration,
                           const char *text)
{
    struct viewer v;
    lum_error error = {""};
    viewer_init(&v, source);
    v.options.calibration = calibration;
    viewer_open_badly(&v, &error);
    assert_non_null(strstr(error.text, text));
}

static void what_is_no_capture_is_refused(void **state)
{
    (void)state;
    expect_refusal(in_directory("missing.pcap"), NULL, "missing.pcap");
    expect_refusal(directory, NULL, "directory");
    expect_refusal("/etc/passwd", NULL, "not a capture");
    expect_refusal(street, in_directory("missing.yaml"), "missing.yaml");
}

/* Without threads, what can be read only once is. */
static bool is_refused(const char *pipe_path)
{
    if (!thread_exists()) {
        expect_refusal(pipe_path, NULL, "not a file");
        assert_int_equal(unlink(pipe_path), 0);
    }
    return !thread_exists();
}

/* A pipe with all of the capture in it, being filled by another process. */
static pid_t fill(const char *pipe_path)
{
    const pid_t child = fork();
    if (child == 0) {
        FILE *in = fopen(street, "rb");
        FILE *out = fopen(pipe_path, "wb");
        int c = 0;
        while (in != NULL && out != NULL && (c = fgetc(in)) != EOF &&
               fputc(c, out) != EOF) {
        }
        _exit(out != NULL && fclose(out) == 0 ? 0 : 1);
    }
    assert_true(child > 0);
    return child;
}

static void a_pipe_is_played_once(void **state)
{
    char path[64];
    struct viewer v;
    (void)state;
    (void)snprintf(path, sizeof path, "%s", in_directory("pipe"));
    assert_int_equal(mkfifo(path, 0600), 0);
    if (is_refused(path)) {
        return;
    }
    const pid_t child = fill(path);
    viewer_init(&v, path);
    v.options.play.paused = true;
    viewer_open(&v);
    (void)viewer_wait(&v, shows_frame, 1);
    feed_step(v.feed, 2);
    (void)viewer_wait(&v, shows_frame, 3);
    feed_step(v.feed, -1);
    feed_seek(v.feed, 1);
    feed_step(v.feed, 1);
    feed_speed(v.feed, 100.0);
    feed_play(v.feed, true);
    struct feed_status s = viewer_wait(&v, is_in_state, FEED_ENDED);
    assert_int_equal(s.frame, FRAMES);
    assert_int_equal(s.frames, FRAMES - 1);
    assert_false(s.has_range);
    feed_play(v.feed, true);
    feed_step(v.feed, -3);
    close_well(&v);
    int status = 1;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_int_equal(status, 0);
    assert_int_equal(unlink(path), 0);
}

static void a_pipe_in_which_nothing_comes_can_be_left(void **state)
{
    char path[64];
    struct viewer v;
    (void)state;
    (void)snprintf(path, sizeof path, "%s", in_directory("dry"));
    assert_int_equal(mkfifo(path, 0600), 0);
    if (is_refused(path)) {
        return;
    }
    viewer_init(&v, path);
    viewer_open(&v);
    close_well(&v);
    const int fd = open(path, O_RDWR);
    assert_true(fd >= 0);
    viewer_init(&v, path);
    viewer_open(&v);
    assert_int_equal(write(fd, "\xd4\xc3\xb2\xa1", 4), 4);
    (void)viewer_wait(&v, is_in_state, FEED_WAITING);
    close_well(&v);
    assert_int_equal(close(fd), 0);
    assert_int_equal(unlink(path), 0);
}

static void an_eyes_geometry_leads_back_to_its_angles(void **state)
{
    float mount[3];
    float rotation[9];
    struct viewer v;
    (void)state;
    open_paused(&v);
    struct frame *frame = viewer_wait_frame(&v, LUM_EDGES_RISING, 0);
    struct unpacked a = frame_arrays(frame);
    for (size_t i = 0; i < a.count; i += 97) {
        float e[3] = {0.0f, 0.0f, 0.0f};
        feed_geometry(v.feed, a.bits[i] & 1u, mount, rotation);
        for (unsigned row = 0; row < 3; row++) {
            for (unsigned column = 0; column < 3; column++) {
                e[column] += rotation[3u * row + column] *
                             ((float)a.xyz[i][row] - mount[row]);
            }
        }
        /* the manual's typical span */
        const float degree = 57.29578f;
        assert_true(fabsf(atan2f(e[1], e[0]) * degree) < 30.5f);
        assert_true(atan2f(e[2], hypotf(e[0], e[1])) * degree > -17.5f);
        assert_true(atan2f(e[2], hypotf(e[0], e[1])) * degree < 3.5f);
    }
    unpacked_free(&a);
    frame_release(frame);
    close_well(&v);
}

static void keys_that_are_set_reach_the_geometry(void **state)
{
    float mount[3];
    float rotation[9];
    struct viewer v;
    lum_error error = {""};
    (void)state;
    viewer_init(&v, street);
    assert_true(
        set_keys_add(&v.options.set, "eyes.green.mount.y_m=2.5", &error));
    viewer_open(&v);
    feed_geometry(v.feed, LUM_EYE_GREEN, mount, rotation);
    assert_true(mount[0] == 0.0f && mount[1] == 2.5f);
    feed_geometry(v.feed, LUM_EYE_BLUE, mount, rotation);
    assert_true(mount[1] == 0.0f);
    close_well(&v);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_frame_has_the_points_that_are_in_it),
        cmocka_unit_test(a_second_profile_follows_the_first),
        cmocka_unit_test(
            a_capture_plays_to_its_end_and_counts_what_lumdump_counts),
        cmocka_unit_test(
            what_was_under_way_when_a_stream_was_joined_is_no_loss),
        cmocka_unit_test(what_a_capture_lacks_is_marked),
        cmocka_unit_test(marks_are_of_more_frames_where_there_are_many),
        cmocka_unit_test(the_first_and_the_last_frame_become_known),
        cmocka_unit_test(play_at_the_end_begins_anew),
        cmocka_unit_test(a_pause_stands_until_play),
        cmocka_unit_test(steps_lead_forward_and_back_and_end_at_the_ends),
        cmocka_unit_test(steps_that_come_together_add_up),
        cmocka_unit_test(frames_at_once_end_at_the_one_that_is_shown),
        cmocka_unit_test(a_capture_that_plays_keeps_frames),
        cmocka_unit_test(a_step_pauses),
        cmocka_unit_test(a_jump_leads_to_the_nearest_frame),
        cmocka_unit_test(a_jump_before_the_ends_are_known_leads_there_too),
        cmocka_unit_test(
            a_jump_gives_the_same_frames_and_reads_nothing_before_them),
        cmocka_unit_test(a_jump_keeps_playing),
        cmocka_unit_test(what_is_passed_over_is_not_counted),
        cmocka_unit_test(a_loop_goes_round_until_it_is_ended),
        cmocka_unit_test(speed_changes_what_is_waited_for_now),
        cmocka_unit_test(nothing_plays_while_nobody_looks),
        cmocka_unit_test(
            a_view_that_is_wanted_in_a_pause_is_made_of_the_same_frame),
        cmocka_unit_test(
            a_view_that_is_wanted_at_the_end_is_made_and_the_end_stays),
        cmocka_unit_test(a_view_that_is_wanted_in_slow_motion_does_not_wait),
        cmocka_unit_test(smoothing_moves_points_and_loses_none),
        cmocka_unit_test(frames_that_are_kept_outlive_the_feed),
        cmocka_unit_test(a_feed_ends_whatever_it_is_at),
        cmocka_unit_test(orders_may_come_faster_than_frames),
        cmocka_unit_test(
            of_several_sensors_the_first_is_shown_and_the_others_named),
        cmocka_unit_test(a_capture_that_breaks_off_is_shown_as_far_as_it_goes),
        cmocka_unit_test(what_is_odd_about_a_capture_is_told),
        cmocka_unit_test(a_capture_without_frames_says_so),
        cmocka_unit_test(a_capture_that_is_gone_fails_until_it_is_back),
        cmocka_unit_test(what_is_no_capture_is_refused),
        cmocka_unit_test(a_pipe_is_played_once),
        cmocka_unit_test(a_pipe_in_which_nothing_comes_can_be_left),
        cmocka_unit_test(an_eyes_geometry_leads_back_to_its_angles),
        cmocka_unit_test(keys_that_are_set_reach_the_geometry),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
