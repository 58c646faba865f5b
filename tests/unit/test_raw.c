#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drive.h"

#include "lum/frame/framer.h"
#include "lum/frame/packet_writer.h"
#include "lum/frame/raw.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINES       6u
#define FILE_NAME   "raw.pcap"
#define FRAMES_MAX  8u
#define RECORDS_MAX 256u
#define BEGIN_NS    INT64_C(1700000000000000000)
#define PERIOD_US   1500u

/* Records that a framer is pushed, and the frames it gives. */
struct run {
    lum_framer *framer;
    lum_frame *frames[FRAMES_MAX];
    size_t count;
    struct {
        uint8_t bytes[DRIVE_BYTES];
        size_t len;
        int64_t time_ns;
    } records[RECORDS_MAX];
    size_t record_count;
};

static struct run *run_new(bool keeps_raw)
{
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .keeps_raw = keeps_raw};
    struct run *r = calloc(1, sizeof *r);
    assert_non_null(r);
    assert_int_equal(lum_framer_new(&options, &r->framer, NULL), 0);
    return r;
}

static void run_free(struct run *r)
{
    while (r->count > 0) {
        lum_frame_release(r->frames[--r->count]);
    }
    lum_framer_free(r->framer);
    free(r);
}

static void take(struct run *r, lum_framer_event event)
{
    assert_int_equal(event, LUM_FRAMER_FRAME);
    assert_true(r->count < FRAMES_MAX);
    r->frames[r->count++] = lum_frame_keep(lum_framer_frame(r->framer, 0));
}

static void push(struct run *r, const lum_record *record)
{
    lum_framer_event event = LUM_FRAMER_NONE;
    while ((event = lum_framer_push(r->framer, record, NULL)) !=
           LUM_FRAMER_NONE) {
        take(r, event);
    }
}

static void send(struct run *r, const struct drive_line *line, size_t packet)
{
    const size_t i = r->record_count++;
    assert_true(i < RECORDS_MAX);
    r->records[i].time_ns = BEGIN_NS + (int64_t)i * 10000;
    r->records[i].len = line->len[packet];
    memcpy(r->records[i].bytes, line->bytes[packet], line->len[packet]);
    const lum_record record =
        drive_record(line, packet, DRIVE_SENSOR, r->records[i].time_ns);
    push(r, &record);
}

/* Two words a pixel, of which one has no range. */
static void make_line(struct drive_line *line, unsigned eye, uint32_t number,
                      uint32_t clock)
{
    static uint32_t words[2u * 500u];
    for (uint32_t i = 0; i < 500u; i++) {
        words[2u * i] = lum_word_make(drive_tof(eye, number, i), true, 2u * i);
        words[2u * i + 1u] = lum_word_make(-5, false, 2u * i);
    }
    drive_make(line, eye, number, clock, words, 1000);
}

/* Frames of both eyes, packet by packet in turn. */
static void send_frames(struct run *r, uint32_t frames)
{
    static struct drive_line both[LUM_EYES];
    for (uint32_t i = 0; i < frames * LINES; i++) {
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            make_line(&both[eye], eye, i % LINES * 20u,
                      1000000u + i * PERIOD_US);
        }
        for (size_t k = 0; k < both[0].count; k++) {
            send(r, &both[0], k);
            send(r, &both[1], k);
        }
    }
}

static void end(struct run *r)
{
    lum_framer_event event = LUM_FRAMER_NONE;
    while ((event = lum_framer_flush(r->framer)) != LUM_FRAMER_NONE) {
        take(r, event);
    }
}

static lum_frame_raw raw_of(const lum_frame *frame)
{
    lum_frame_raw raw = {.struct_size = sizeof raw};
    assert_int_equal(lum_frame_get_raw(frame, &raw), LUM_OK);
    return raw;
}

/* --- What a frame keeps --- */

static void without_the_option_there_is_nothing_raw(void **state)
{
    struct run *r = run_new(false);
    lum_frame_raw raw = {.struct_size = sizeof raw};
    (void)state;
    send_frames(r, 1);
    end(r);
    assert_int_equal(lum_frame_get_raw(r->frames[0], &raw), LUM_E_VALUE);
    run_free(r);
}

static void a_frame_keeps_words_angles_and_packets_of_its_lines(void **state)
{
    struct run *r = run_new(true);
    (void)state;
    send_frames(r, 1);
    end(r);
    const lum_frame_raw raw = raw_of(r->frames[0]);
    const size_t packets = r->record_count / (2u * LINES);
    assert_int_equal(raw.line_count, 2u * LINES);
    assert_int_equal(raw.first_word[raw.line_count], 2u * LINES * 1000u);
    assert_int_equal(raw.packet_count, r->record_count);
    assert_int_equal(raw.lines_without_packets, 0);
    for (size_t i = 0; i < raw.line_count; i++) {
        lum_frame_line line = {.struct_size = sizeof line};
        assert_true(lum_frame_get_line(r->frames[0], i, &line));
        const uint32_t *words = raw.words + raw.first_word[i];
        assert_int_equal(raw.first_word[i], i * 1000u);
        assert_int_equal(lum_word_tof(words[2]),
                         drive_tof(line.eye, line.number, 1));
        assert_int_equal(raw.gives_point[i * 1000u + 2u], 1);
        assert_int_equal(raw.gives_point[i * 1000u + 3u], 0);
        assert_int_equal(raw.angles[i * LUM_LINE_PIXELS + 7u].azimuth,
                         60 * 7 - 30000);
        assert_int_equal(raw.angle_marks[i * LUM_PIXEL_MARK_WORDS], UINT32_MAX);
        for (size_t k = 0; k < packets; k++) {
            const lum_raw_packet *p = &raw.packets[i * packets + k];
            assert_int_equal(p->line, i);
            assert_int_equal(p->clock_raw, line.clock_us);
            assert_int_equal(p->arrival_ns,
                             BEGIN_NS + (int64_t)p->order * 10000);
        }
    }
    run_free(r);
}

static void packets_that_are_dropped_are_not_among_them(void **state)
{
    static struct drive_line line;
    struct run *r = run_new(true);
    (void)state;
    make_line(&line, LUM_EYE_BLUE, 3, 1000000);
    for (size_t k = 0; k < line.count; k++) {
        send(r, &line, k);
        send(r, &line, k);
    }
    end(r);
    const lum_frame_raw raw = raw_of(r->frames[0]);
    assert_int_equal(raw.packet_count, line.count);
    assert_int_equal(raw.packets[1].order, 1);
    assert_int_equal(raw.packets[1].arrival_ns, BEGIN_NS + 20000);
    run_free(r);
}

static void bad_words_are_counted_in_their_packet(void **state)
{
    static struct drive_line line;
    struct run *r = run_new(true);
    const uint32_t words[] = {lum_word_make(1000, true, 4), LUM_WORD_ZERO,
                              lum_word_make(2000, true, 9)};
    (void)state;
    drive_make(&line, LUM_EYE_GREEN, 3, 1000000, words, 3);
    for (size_t k = 0; k < line.count; k++) {
        send(r, &line, k);
    }
    end(r);
    const lum_frame_raw raw = raw_of(r->frames[0]);
    const lum_raw_packet *p = &raw.packets[raw.packet_count - 1u];
    assert_int_equal(raw.first_word[1], 2);
    assert_int_equal(p->num_samples, 3);
    assert_int_equal(p->bad_words, 1);
    assert_int_equal(p->first_pixel, 4);
    run_free(r);
}

/* --- Packets again --- */

static lum_packet_writer *open_writer(const lum_layout *layout)
{
    const lum_packet_writer_options options = {.struct_size = sizeof options,
                                               .layout = layout};
    lum_packet_writer *w = NULL;
    lum_error error = {""};
    if (lum_packet_writer_open(FILE_NAME, &options, &w, &error) != 0) {
        fail_msg("%s", error.text);
    }
    return w;
}

static lum_raw_line line_of(const lum_frame *frame, const lum_frame_raw *raw,
                            size_t i)
{
    lum_frame_line line = {.struct_size = sizeof line};
    assert_true(lum_frame_get_line(frame, i, &line));
    const size_t packets = raw->packet_count / raw->line_count;
    return (lum_raw_line){
        .struct_size = sizeof(lum_raw_line),
        .clock_us = line.clock_us,
        .arrival_ns = line.arrival_ns,
        .angles = raw->angles + i * LUM_LINE_PIXELS,
        .angle_marks = raw->angle_marks + i * LUM_PIXEL_MARK_WORDS,
        .words = raw->words + raw->first_word[i],
        .word_count = (size_t)(raw->first_word[i + 1u] - raw->first_word[i]),
        .packets = raw->packets + i * packets,
        .packet_count = packets,
        .sensor = DRIVE_SENSOR,
        .number = line.number,
        .eye = line.eye,
        .places =
            raw->places != NULL ? raw->places + raw->first_word[i] : NULL};
}

static void write_frames(const struct run *r, lum_packet_writer *w)
{
    for (size_t f = 0; f < r->count; f++) {
        const lum_frame_raw raw = raw_of(r->frames[f]);
        for (size_t i = 0; i < raw.line_count; i++) {
            const lum_raw_line line = line_of(r->frames[f], &raw, i);
            assert_int_equal(lum_packet_writer_add(w, &line, NULL), 0);
        }
        assert_int_equal(lum_packet_writer_end_frame(w, NULL), 0);
    }
}

static void assert_written(const struct run *r)
{
    lum_capture *capture = NULL;
    lum_record record;
    assert_int_equal(lum_capture_open(FILE_NAME, &capture, NULL), 0);
    for (size_t i = 0; i < r->record_count; i++) {
        assert_int_equal(lum_capture_next(capture, &record, NULL), 1);
        assert_int_equal(record.time_ns, r->records[i].time_ns);
        assert_int_equal(record.source, DRIVE_SENSOR);
        assert_int_equal(record.len, r->records[i].len);
        assert_memory_equal(record.payload, r->records[i].bytes, record.len);
    }
    assert_int_equal(lum_capture_next(capture, &record, NULL), 0);
    lum_capture_close(capture);
}

static void frames_are_written_as_the_packets_they_came_in(void **state)
{
    struct run *r = run_new(true);
    lum_packet_writer *w = open_writer(NULL);
    lum_packet_writer_counters c = {.struct_size = sizeof c};
    (void)state;
    send_frames(r, 3);
    end(r);
    write_frames(r, w);
    assert_int_equal(lum_packet_writer_flush(w, NULL), 0);
    assert_int_equal(lum_packet_writer_count(w, &c), LUM_OK);
    assert_int_equal(c.packets, r->record_count);
    assert_int_equal(c.lines, 3u * 2u * LINES);
    assert_int_equal(c.lines_cut_anew + c.repeated + c.late + c.stray, 0);
    assert_int_equal(lum_packet_writer_close(w, NULL), 0);
    assert_written(r);
    run_free(r);
    (void)remove(FILE_NAME);
}

/* The bytes between fields are no part of any. */
static void what_the_profile_does_not_know_comes_again(void **state)
{
    lum_profile profile;
    lum_layout layout;
    static struct drive_line line;
    struct run *r = run_new(true);
    (void)state;
    lum_profile_default(&profile);
    profile.group[LUM_FIELD_TIMESTAMP] =
        (lum_field){20, 2, LUM_ORDER_LITTLE, 0, 0};
    assert_int_equal(lum_layout_init(&layout, &profile, NULL, NULL), LUM_OK);
    const lum_framer_options options = {
        .struct_size = sizeof options, .layout = &layout, .keeps_raw = true};
    lum_framer_free(r->framer);
    assert_int_equal(lum_framer_new(&options, &r->framer, NULL), 0);
    make_line(&line, LUM_EYE_BLUE, 3, 1000);
    for (size_t k = 0; k < line.count; k++) {
        line.bytes[k][22] = 0xa5;
        memset(line.bytes[k] + line.len[k], 0x5a, 8);
        line.len[k] += 8;
        send(r, &line, k);
    }
    end(r);
    lum_packet_writer *w = open_writer(&layout);
    write_frames(r, w);
    assert_int_equal(lum_packet_writer_close(w, NULL), 0);
    assert_written(r);
    run_free(r);
    (void)remove(FILE_NAME);
}

/* Words of a line in order, and of one whose pixels stand in no order, also
 * across packets; each pixel has two in one packet. */
static void make_mixed(uint32_t *words, uint32_t line)
{
    for (uint32_t i = 0; i < 1000u; i++) {
        const uint32_t pixel = line == 0 ? i / 2u : i / 2u * 7u % 500u;
        words[i] = lum_word_make((int32_t)(1000u + i), i % 2u == 0, pixel);
    }
}

static void send_mixed(struct run *r)
{
    static uint32_t words[1000];
    static struct drive_line line;
    for (uint32_t i = 0; i < 3u; i++) {
        make_mixed(words, i % 2u);
        drive_make(&line, LUM_EYE_BLUE, i, 1000000u + i * PERIOD_US, words,
                   1000);
        for (size_t k = line.count; k > 0; k--) {
            send(r, &line, k - 1u);
        }
    }
    end(r);
}

static void words_in_no_order_have_their_places(void **state)
{
    struct run *r = run_new(true);
    (void)state;
    send_mixed(r);
    const lum_frame_raw raw = raw_of(r->frames[0]);
    assert_int_equal(raw.line_count, 3);
    assert_non_null(raw.places);
    for (size_t i = 0; i < 3; i++) {
        const lum_raw_line line = line_of(r->frames[0], &raw, i);
        for (size_t k = 0; k < line.word_count; k++) {
            const uint32_t sent = (uint32_t)lum_word_tof(line.words[k]) - 1000u;
            uint32_t before = 0;
            uint32_t p = 0;
            /* the last packet came first */
            while (line.packets[p].tag != LUM_TAG_RANGES ||
                   sent < line.packets[p].first_sample_index) {
                before += line.packets[p].tag == LUM_TAG_RANGES
                              ? line.packets[p].num_samples
                              : 0;
                p++;
            }
            assert_int_equal(line.places[k],
                             before + sent -
                                 line.packets[p].first_sample_index);
        }
    }
    run_free(r);
}

static void words_in_order_have_no_places(void **state)
{
    struct run *r = run_new(true);
    (void)state;
    send_frames(r, 1);
    end(r);
    assert_null(raw_of(r->frames[0]).places);
    run_free(r);
}

static void words_in_no_order_come_again_as_they_were(void **state)
{
    struct run *r = run_new(true);
    lum_packet_writer *w = open_writer(NULL);
    (void)state;
    send_mixed(r);
    write_frames(r, w);
    assert_int_equal(lum_packet_writer_close(w, NULL), 0);
    assert_written(r);
    run_free(r);
    (void)remove(FILE_NAME);
}

/* A bad word is one of another value. */
static void bad_words_stay_at_their_place(void **state)
{
    static struct drive_line line;
    struct run *r = run_new(true);
    const uint32_t words[] = {LUM_WORD_ZERO, lum_word_make(1000, true, 4),
                              LUM_WORD_ZERO, lum_word_make(2000, true, 9)};
    (void)state;
    drive_make(&line, LUM_EYE_GREEN, 3, 1000000, words, 4);
    for (size_t k = 0; k < line.count; k++) {
        send(r, &line, k);
    }
    end(r);
    lum_packet_writer *w = open_writer(NULL);
    write_frames(r, w);
    assert_int_equal(lum_packet_writer_close(w, NULL), 0);
    assert_written(r);
    run_free(r);
    (void)remove(FILE_NAME);
}

/* No place is kept of lines with more bad words than anyone sends. */
static void bad_words_without_end_take_no_memory(void **state)
{
    static uint32_t words[300];
    static struct drive_line line;
    struct run *r = run_new(true);
    (void)state;
    for (uint32_t i = 0; i < 300u; i++) {
        words[i] = LUM_WORD_ZERO;
    }
    drive_make(&line, LUM_EYE_GREEN, 3, 1000000, words, 300);
    for (size_t k = 0; k + 1u < line.count; k++) {
        send(r, &line, k);
    }
    for (uint32_t n = 0; n <= LUM_RAW_PLACES_MAX; n += 300u) {
        r->record_count = RECORDS_MAX - 1u;
        send(r, &line, line.count - 1u);
    }
    words[7] = lum_word_make(1000, true, 4);
    drive_make(&line, LUM_EYE_GREEN, 3, 1000000, words, 300);
    r->record_count = RECORDS_MAX - 1u;
    send(r, &line, line.count - 1u);
    end(r);
    const lum_frame_raw raw = raw_of(r->frames[0]);
    assert_int_equal(raw.first_word[1], 1);
    assert_int_equal(raw.lines_without_packets, 0);
    assert_null(raw.places);
    run_free(r);
}

/* By pixel instead: a place that is none, one that is there twice, words of a
 * pixel in another order, a pixel in two packets. */
static void places_that_do_not_fit_are_not_used(void **state)
{
    static uint16_t places[4][1000];
    static struct drive_line packets;
    struct run *r = run_new(true);
    (void)state;
    make_line(&packets, LUM_EYE_BLUE, 3, 1000000);
    for (size_t k = 0; k < packets.count; k++) {
        send(r, &packets, k);
    }
    end(r);
    const lum_frame_raw raw = raw_of(r->frames[0]);
    lum_raw_line line = line_of(r->frames[0], &raw, 0);
    for (uint16_t k = 0; k < 1000u; k++) {
        places[0][k] = k == 500u ? 1000u : k;
        places[1][k] = k == 500u ? 499u : k;
        places[2][k] = k ^ 1u;
        places[3][k] = (uint16_t)(k % 2u * 500u + k / 2u);
    }
    for (size_t i = 0; i < 4; i++) {
        lum_packet_writer *w = open_writer(NULL);
        line.places = places[i];
        assert_int_equal(lum_packet_writer_add(w, &line, NULL), 0);
        assert_int_equal(lum_packet_writer_close(w, NULL), 0);
        assert_written(r);
    }
    run_free(r);
    (void)remove(FILE_NAME);
}

static void a_jump_of_the_clock_is_written_twice(void **state)
{
    static struct drive_line line;
    struct run *r = run_new(true);
    lum_packet_writer_counters c = {.struct_size = sizeof c};
    (void)state;
    for (uint32_t i = 0; i < 2; i++) {
        make_line(&line, LUM_EYE_BLUE, 3, 1000000u + i * 900000000u);
        send(r, &line, 0); /* after the jump it is taken for a stray */
        for (size_t k = 0; k < line.count; k++) {
            send(r, &line, k);
        }
    }
    end(r);
    lum_packet_writer *w = open_writer(NULL);
    write_frames(r, w);
    assert_int_equal(lum_packet_writer_flush(w, NULL), 0);
    assert_int_equal(lum_packet_writer_count(w, &c), LUM_OK);
    assert_int_equal(c.repeated, 1);
    assert_int_equal(c.packets, 2u * line.count + 1u);
    assert_int_equal(c.stray, 0);
    lum_packet_writer_abort(w);
    run_free(r);
}

/* Clocks and arrivals of the lines that a reader gets. */
static void assert_read(const lum_layout *layout, const lum_raw_line *lines,
                        size_t n)
{
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .layout = layout};
    lum_capture *capture = NULL;
    lum_record record;
    struct run *r = run_new(false);
    size_t at = 0;
    lum_framer_free(r->framer);
    assert_int_equal(lum_framer_new(&options, &r->framer, NULL), 0);
    assert_int_equal(lum_capture_open(FILE_NAME, &capture, NULL), 0);
    while (lum_capture_next(capture, &record, NULL) == 1) {
        push(r, &record);
    }
    lum_capture_close(capture);
    end(r);
    for (size_t f = 0; f < r->count; f++) {
        for (size_t i = 0; i < lum_frame_line_count(r->frames[f]); i++) {
            lum_frame_line line = {.struct_size = sizeof line};
            assert_true(lum_frame_get_line(r->frames[f], i, &line));
            assert_true(at < n);
            assert_int_equal(line.number, lines[at].number);
            assert_true(line.clock_us == lines[at].clock_us);
            assert_true(line.arrival_ns == lines[at].arrival_ns);
            at++;
        }
    }
    assert_int_equal(at, n);
    run_free(r);
    (void)remove(FILE_NAME);
}

static void a_line_that_is_moved_takes_its_packets_along(void **state)
{
    struct run *r = run_new(true);
    lum_raw_line lines[2u * LINES];
    lum_packet_writer_counters c = {.struct_size = sizeof c};
    (void)state;
    send_frames(r, 1);
    end(r);
    const lum_frame_raw raw = raw_of(r->frames[0]);
    lum_packet_writer *w = open_writer(NULL);
    for (size_t i = 0; i < raw.line_count; i++) {
        lines[i] = line_of(r->frames[0], &raw, i);
        lines[i].clock_us += 700;
        lines[i].arrival_ns += 5000000;
        lines[i].number += 2;
        assert_int_equal(lum_packet_writer_add(w, &lines[i], NULL), 0);
    }
    assert_int_equal(lum_packet_writer_flush(w, NULL), 0);
    assert_int_equal(lum_packet_writer_count(w, &c), LUM_OK);
    assert_int_equal(c.lines_cut_anew, 0);
    assert_int_equal(lum_packet_writer_close(w, NULL), 0);
    assert_read(NULL, lines, raw.line_count);
    run_free(r);
}

static void a_jump_that_readers_take_for_another_is_counted(void **state)
{
    struct run *r = run_new(true);
    lum_packet_writer *w = open_writer(NULL);
    lum_packet_writer_counters c = {.struct_size = sizeof c};
    (void)state;
    send_frames(r, 2);
    end(r);
    for (size_t f = 0; f < 2; f++) {
        const lum_frame_raw raw = raw_of(r->frames[f]);
        for (size_t i = 0; i < raw.line_count; i++) {
            lum_raw_line line = line_of(r->frames[f], &raw, i);
            line.clock_us += (int64_t)f << 31;
            assert_int_equal(lum_packet_writer_add(w, &line, NULL), 0);
        }
        assert_int_equal(lum_packet_writer_end_frame(w, NULL), 0);
    }
    assert_int_equal(lum_packet_writer_flush(w, NULL), 0);
    assert_int_equal(lum_packet_writer_count(w, &c), LUM_OK);
    assert_int_equal(c.clock_jumps, 1);
    lum_packet_writer_abort(w);
    run_free(r);
}

/* --- Lines that are made up --- */

static const lum_angle no_angles[LUM_LINE_PIXELS];

static void make_marks(uint32_t marks[LUM_PIXEL_MARK_WORDS])
{
    memset(marks, 0, LUM_PIXEL_MARK_WORDS * sizeof *marks);
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
        marks[p / 32u] |= UINT32_C(1) << p % 32u;
    }
}

static void assert_cuts(const uint32_t *counts, size_t n)
{
    lum_capture *capture = NULL;
    lum_record record;
    lum_layout layout;
    lum_group group;
    lum_layout_default(&layout);
    assert_int_equal(lum_capture_open(FILE_NAME, &capture, NULL), 0);
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(lum_capture_next(capture, &record, NULL), 1);
        assert_int_equal(
            lum_group_decode(&layout, record.payload, record.len, &group),
            LUM_OK);
        assert_int_equal(group.num_samples, counts[i]);
        assert_int_equal(group.clock_raw, 5000000);
    }
    assert_int_equal(lum_capture_next(capture, &record, NULL), 0);
    lum_capture_close(capture);
}

static void a_line_without_packets_is_cut_as_the_sensor_does_it(void **state)
{
    static uint32_t words[500];
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    const uint32_t cuts[] = {334, 334, 332, 360, 140};
    (void)state;
    make_marks(marks);
    for (uint32_t i = 0; i < 500; i++) {
        words[i] = lum_word_make(1000, true, i / 3u);
    }
    const lum_raw_line line = {.struct_size = sizeof line,
                               .clock_us = 5000000,
                               .arrival_ns = BEGIN_NS,
                               .angles = no_angles,
                               .angle_marks = marks,
                               .words = words,
                               .word_count = 500,
                               .sensor = DRIVE_SENSOR,
                               .number = 4};
    lum_packet_writer *w = open_writer(NULL);
    assert_int_equal(lum_packet_writer_add(w, &line, NULL), 0);
    assert_int_equal(lum_packet_writer_close(w, NULL), 0);
    assert_cuts(cuts, sizeof cuts / sizeof cuts[0]);
    (void)remove(FILE_NAME);
}

static void made_up_clocks_are_those_that_are_read(const lum_layout *layout,
                                                   const int64_t *clocks,
                                                   size_t n)
{
    lum_raw_line lines[8];
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    lum_packet_writer_counters c = {.struct_size = sizeof c};
    lum_packet_writer *w = open_writer(layout);
    make_marks(marks);
    for (size_t i = 0; i < n; i++) {
        lines[i] = (lum_raw_line){.struct_size = sizeof lines[i],
                                  .clock_us = clocks[i],
                                  .arrival_ns = BEGIN_NS + (int64_t)i * 1000000,
                                  .angles = no_angles,
                                  .angle_marks = marks,
                                  .sensor = DRIVE_SENSOR,
                                  .number = (uint32_t)i};
        assert_int_equal(lum_packet_writer_add(w, &lines[i], NULL), 0);
    }
    assert_int_equal(lum_packet_writer_flush(w, NULL), 0);
    assert_int_equal(lum_packet_writer_count(w, &c), LUM_OK);
    assert_int_equal(c.stray + c.late + c.clock_jumps, 0);
    assert_int_equal(lum_packet_writer_close(w, NULL), 0);
    assert_read(layout, lines, n);
}

static void a_tick_is_the_one_that_is_read_as_the_clock(void **state)
{
    const int64_t clocks[] = {1, 3001, 6003, 9004};
    lum_profile profile;
    lum_layout layout;
    (void)state;
    lum_profile_default(&profile);
    profile.clock_unit_ns = 1500; /* 1 us is the first tick, of 1.5 us */
    assert_int_equal(lum_layout_init(&layout, &profile, NULL, NULL), LUM_OK);
    made_up_clocks_are_those_that_are_read(&layout, clocks, 4);
}

static void packets_that_no_longer_fit_are_not_used(void **state)
{
    struct run *r = run_new(true);
    lum_packet_writer *w = open_writer(NULL);
    lum_packet_writer_counters c = {.struct_size = sizeof c};
    (void)state;
    send_frames(r, 1);
    end(r);
    const lum_frame_raw raw = raw_of(r->frames[0]);
    lum_raw_line line = line_of(r->frames[0], &raw, 0);
    line.word_count -= 1u;
    assert_int_equal(lum_packet_writer_add(w, &line, NULL), 0);
    assert_int_equal(lum_packet_writer_flush(w, NULL), 0);
    assert_int_equal(lum_packet_writer_count(w, &c), LUM_OK);
    assert_int_equal(c.lines_cut_anew, 1);
    assert_int_equal(c.packets, 3u + 3u);
    lum_packet_writer_abort(w);
    run_free(r);
}

static void assert_refused(lum_packet_writer *w, const lum_raw_line *line,
                           const char *why)
{
    lum_error error = {""};
    assert_int_equal(lum_packet_writer_add(w, line, &error), -1);
    if (strstr(error.text, why) == NULL) {
        fail_msg("'%s' is not in: %s", why, error.text);
    }
}

static void what_a_packet_cannot_hold_is_refused(void **state)
{
    const uint32_t back[] = {lum_word_make(1, true, 9),
                             lum_word_make(1, true, 8)};
    const uint32_t bad = LUM_WORD_ZERO;
    const lum_raw_line fine = {.struct_size = sizeof fine, .clock_us = 1000000};
    lum_packet_writer *w = open_writer(NULL);
    lum_raw_line line = fine;
    (void)state;
    line.eye = 2;
    assert_refused(w, &line, "eye is 2; use 0 for blue or 1 for green");
    line = fine;
    line.words = back;
    line.word_count = 2;
    assert_refused(w, &line, "pixel 8 follows pixel 9");
    line.words = &bad;
    line.word_count = 1;
    assert_refused(w, &line, "word 0 is 0x00000800");
    line.words = back;
    line.number = 70000;
    assert_refused(w, &line,
                   "line number is 70000; the profile's field of 16 bits "
                   "holds at most 65535");
    line = fine;
    line.arrival_ns = -1;
    assert_refused(w, &line, "arrival is -1 ns; use 0 or more");
    assert_int_equal(lum_packet_writer_add(w, &fine, NULL), 0);
    line = fine;
    line.clock_us += INT64_C(1) << 31;
    assert_refused(w, &line,
                   "is 2147483648 us from that of the line before it; the "
                   "profile's clock of 32 bits needs less than 2147483648");
    line.clock_us = INT64_MIN;
    assert_refused(w, &line, "is 9223372036855775808 us from that");
    lum_packet_writer_abort(w);
}

static void a_file_that_is_not_finished_is_not_there(void **state)
{
    lum_capture *capture = NULL;
    (void)state;
    (void)remove(FILE_NAME);
    lum_packet_writer_abort(open_writer(NULL));
    assert_int_equal(lum_capture_open(FILE_NAME, &capture, NULL), -1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_the_option_there_is_nothing_raw),
        cmocka_unit_test(a_frame_keeps_words_angles_and_packets_of_its_lines),
        cmocka_unit_test(packets_that_are_dropped_are_not_among_them),
        cmocka_unit_test(bad_words_are_counted_in_their_packet),
        cmocka_unit_test(frames_are_written_as_the_packets_they_came_in),
        cmocka_unit_test(what_the_profile_does_not_know_comes_again),
        cmocka_unit_test(words_in_no_order_have_their_places),
        cmocka_unit_test(words_in_order_have_no_places),
        cmocka_unit_test(words_in_no_order_come_again_as_they_were),
        cmocka_unit_test(bad_words_stay_at_their_place),
        cmocka_unit_test(bad_words_without_end_take_no_memory),
        cmocka_unit_test(places_that_do_not_fit_are_not_used),
        cmocka_unit_test(a_jump_of_the_clock_is_written_twice),
        cmocka_unit_test(a_line_that_is_moved_takes_its_packets_along),
        cmocka_unit_test(a_line_without_packets_is_cut_as_the_sensor_does_it),
        cmocka_unit_test(a_jump_that_readers_take_for_another_is_counted),
        cmocka_unit_test(a_tick_is_the_one_that_is_read_as_the_clock),
        cmocka_unit_test(packets_that_no_longer_fit_are_not_used),
        cmocka_unit_test(what_a_packet_cannot_hold_is_refused),
        cmocka_unit_test(a_file_that_is_not_finished_is_not_there),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
