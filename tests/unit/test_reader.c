#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "drive.h"

#include "lum/base/time.h"
#include "lum/frame/reader.h"

#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#define FRAMES 4u
#define LINES  12u
#define POINTS (LINES * LUM_EYES * LUM_LINE_PIXELS) /* of a frame */

static char directory[] = "/tmp/lum-reader-XXXXXX";
static char drive[64];
static uint8_t *bytes; /* of that file */
static size_t byte_count;

static void add_line(lum_capture_writer *writer, unsigned eye, uint32_t line,
                     uint32_t clock)
{
    static struct drive_line packets;
    drive_pixels(&packets, eye, line, clock, 0, LUM_LINE_PIXELS);
    for (size_t i = 0; i < packets.count; i++) {
        const lum_datagram datagram = {.time_ns = INT64_C(1700000000000000000) +
                                                  INT64_C(1000) * clock,
                                       .payload = packets.bytes[i],
                                       .len = packets.len[i],
                                       .source = DRIVE_SENSOR,
                                       .destination = DRIVE_CLIENT,
                                       .source_port = 5517,
                                       .destination_port = 50000};
        assert_int_equal(lum_capture_writer_add(writer, &datagram, NULL), 0);
    }
}

static int make_drive(void **state)
{
    (void)state;
    lum_capture_writer *writer = NULL;
    assert_non_null(mkdtemp(directory));
    (void)snprintf(drive, sizeof drive, "%s/drive.pcap", directory);
    assert_int_equal(lum_capture_writer_open(drive, &writer, NULL), 0);
    for (uint32_t i = 0; i < FRAMES * LINES; i++) {
        add_line(writer, LUM_EYE_BLUE, i % LINES, 1000000u + 1000u * i);
        add_line(writer, LUM_EYE_GREEN, i % LINES, 1000000u + 1000u * i);
    }
    assert_int_equal(lum_capture_writer_close(writer, NULL), 0);
    FILE *file = fopen(drive, "rb");
    assert_non_null(file);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    byte_count = (size_t)ftell(file);
    rewind(file);
    bytes = malloc(byte_count);
    assert_non_null(bytes);
    assert_int_equal(fread(bytes, 1, byte_count, file), byte_count);
    return fclose(file);
}

static int remove_drive(void **state)
{
    (void)state;
    free(bytes);
    return remove(drive) == 0 && rmdir(directory) == 0 ? 0 : -1;
}

static lum_reader *open_reader(const lum_reader_options *options)
{
    lum_reader *reader = NULL;
    lum_error error = {""};
    if (lum_reader_open(options, &reader, &error) != 0) {
        fail_msg("%s", error.text);
    }
    return reader;
}

/* All frames, and how it ended. */
static int count_frames(lum_reader *reader, size_t *frames, uint64_t *points,
                        lum_error *error)
{
    const lum_frame *frame = NULL;
    int status = 0;
    *frames = 0;
    *points = 0;
    while ((status = lum_reader_next_frame(reader, &frame, error)) > 0) {
        ++*frames;
        *points += lum_frame_count(frame);
    }
    return status;
}

static void assert_whole(lum_reader *reader)
{
    size_t frames = 0;
    uint64_t points = 0;
    uint64_t done = 0;
    uint64_t total = 0;
    lum_error error = {""};
    assert_int_equal(count_frames(reader, &frames, &points, &error), 0);
    assert_int_equal(frames, FRAMES);
    assert_int_equal(points, FRAMES * POINTS);
    assert_int_equal(count_frames(reader, &frames, &points, &error), 0);
    assert_int_equal(frames, 0);
    lum_reader_progress(reader, &done, &total);
    assert_true(total == 0 || done == total);
    lum_reader_close(reader);
}

static void a_file_gives_all_its_frames_the_last_too(void **state)
{
    (void)state;
    const lum_reader_options options = {.struct_size = sizeof options,
                                        .path = drive};
    assert_whole(open_reader(&options));
}

static void memory_gives_the_same(void **state)
{
    (void)state;
    const lum_reader_options options = {
        .struct_size = sizeof options,
        .source = lum_source_from_memory("memory", bytes, byte_count)};
    assert_whole(open_reader(&options));
}

/* Functions of a caller, which gives few bytes at a time. */
struct pieces {
    size_t at;
    unsigned closed;
};

static int64_t read_piece(void *context, void *buffer, size_t room,
                          lum_error *error)
{
    (void)error;
    struct pieces *p = context;
    const size_t left = byte_count - p->at;
    size_t n = left < 777u ? left : 777u;
    n = n < room ? n : room;
    memcpy(buffer, bytes + p->at, n);
    p->at += n;
    return (int64_t)n;
}

static void close_pieces(void *context)
{
    ((struct pieces *)context)->closed++;
}

static void a_callers_function_gives_the_same(void **state)
{
    (void)state;
    struct pieces pieces = {0, 0};
    const lum_source_functions functions = {.struct_size = sizeof functions,
                                            .read = read_piece,
                                            .close = close_pieces,
                                            .context = &pieces};
    const lum_reader_options options = {
        .struct_size = sizeof options,
        .source = lum_source_from_functions("pieces", &functions, NULL)};
    assert_whole(open_reader(&options));
    assert_int_equal(pieces.closed, 1);
}

/* Records of a caller, as of a live sensor. */
struct live {
    struct drive_line line;
    size_t packet;
    uint32_t lines;
    bool fails;
    unsigned closed;
};

static int next_live(void *context, lum_record *out, lum_error *error)
{
    struct live *l = context;
    if (l->packet == l->line.count) {
        if (l->lines == FRAMES * LINES * LUM_EYES) {
            *out = (lum_record){.dropped_fragments = 3};
            return l->fails ? lum_error_set(error, "the sensor is gone") : 0;
        }
        drive_pixels(&l->line, l->lines % LUM_EYES, l->lines / LUM_EYES % LINES,
                     1000000u + 1000u * (l->lines / LUM_EYES), 0,
                     LUM_LINE_PIXELS);
        l->packet = 0;
        l->lines++;
    }
    *out = drive_record(&l->line, l->packet++, DRIVE_SENSOR, l->lines);
    return 1;
}

static void close_live(void *context)
{
    ((struct live *)context)->closed++;
}

static void records_of_a_caller_give_the_same(void **state)
{
    (void)state;
    struct live *live = calloc(1, sizeof *live);
    const lum_record_source source = {.struct_size = sizeof source,
                                      .next = next_live,
                                      .close = close_live,
                                      .context = live};
    const lum_reader_options options = {.struct_size = sizeof options,
                                        .records = &source};
    assert_non_null(live);
    assert_whole(open_reader(&options));
    assert_int_equal(live->closed, 1);
    free(live);
}

/* --- Asking the caller whether to go on --- */

/* Whom the reader asks. */
struct asked {
    unsigned calls;
    unsigned last; /* the call that says no; 0: none does */
    bool is_last;  /* the next one says no */
};

static bool answer(void *context)
{
    struct asked *a = context;
    a->calls++;
    return a->calls != a->last && !a->is_last;
}

static void assert_stopped(int status, const lum_error *error)
{
    assert_int_equal(status, -1);
    assert_string_equal(error->text, "stopped by the caller");
}

/* More time passes than between two questions. */
static void pass_time(void)
{
    const int64_t until_ns = lum_time_monotonic_ns() + 6000000;
    while (lum_time_monotonic_ns() < until_ns) {
        lum_time_sleep_until(until_ns);
    }
}

static int64_t read_slowly(void *context, void *buffer, size_t room,
                           lum_error *error)
{
    const struct pieces *p = context;
    if (p->at / 777u % 50u == 0) {
        pass_time();
    }
    return read_piece(context, buffer, room, error);
}

static int next_slowly(void *context, lum_record *out, lum_error *error)
{
    struct live *l = context;
    if (l->packet == l->line.count) {
        pass_time();
    }
    return next_live(context, out, error);
}

/* Frames come before the no, and none after it, not even the one under way. */
static void assert_stops_after_a_frame(lum_reader *reader, struct asked *asked)
{
    const lum_frame *frame = NULL;
    lum_error error = {""};
    assert_int_equal(lum_reader_next_frame(reader, &frame, &error), 1);
    assert_true(asked->calls > 1);
    asked->is_last = true;
    const unsigned calls = asked->calls;
    for (unsigned i = 0; i < 3; i++) {
        error.text[0] = '\0';
        assert_stopped(lum_reader_next_frame(reader, &frame, &error), &error);
    }
    assert_int_equal(asked->calls, calls + 1u);
    lum_reader_close(reader);
}

static void a_caller_can_stop_a_reading(void **state)
{
    (void)state;
    struct asked asked = {0};
    struct pieces pieces = {0, 0};
    const lum_source_functions functions = {.struct_size = sizeof functions,
                                            .read = read_slowly,
                                            .close = close_pieces,
                                            .context = &pieces};
    const lum_reader_options options = {
        .struct_size = sizeof options,
        .source = lum_source_from_functions("slow", &functions, NULL),
        .go_on = answer,
        .go_on_context = &asked};
    assert_stops_after_a_frame(open_reader(&options), &asked);
    assert_int_equal(pieces.closed, 1);
}

static void a_caller_can_stop_the_reading_of_records(void **state)
{
    (void)state;
    struct asked asked = {0};
    struct live *live = calloc(1, sizeof *live);
    const lum_record_source source = {.struct_size = sizeof source,
                                      .next = next_slowly,
                                      .close = close_live,
                                      .context = live};
    const lum_reader_options options = {.struct_size = sizeof options,
                                        .records = &source,
                                        .go_on = answer,
                                        .go_on_context = &asked};
    assert_non_null(live);
    assert_stops_after_a_frame(open_reader(&options), &asked);
    assert_int_equal(live->closed, 1);
    free(live);
}

static void a_caller_can_stop_an_opening(void **state)
{
    (void)state;
    struct asked asked = {.last = 1};
    struct live live = {.closed = 0};
    struct pieces pieces = {0, 0};
    lum_reader *reader = NULL;
    lum_error error = {""};
    const lum_record_source source = {.struct_size = sizeof source,
                                      .next = next_live,
                                      .close = close_live,
                                      .context = &live};
    const lum_source_functions functions = {.struct_size = sizeof functions,
                                            .read = read_piece,
                                            .close = close_pieces,
                                            .context = &pieces};
    lum_reader_options options = {.struct_size = sizeof options,
                                  .path = drive,
                                  .go_on = answer,
                                  .go_on_context = &asked};
    assert_stopped(lum_reader_open(&options, &reader, &error), &error);
    options.path = NULL;
    options.records = &source;
    asked.calls = 0;
    assert_stopped(lum_reader_open(&options, &reader, &error), &error);
    assert_int_equal(live.closed, 1);
    options.records = NULL;
    options.source = lum_source_from_functions("pieces", &functions, NULL);
    asked.calls = 0;
    assert_stopped(lum_reader_open(&options, &reader, &error), &error);
    assert_int_equal(pieces.closed, 1);
    assert_null(reader);
}

/* A pipe that nobody writes to. */
static void a_caller_can_stop_a_wait(void **state)
{
    (void)state;
    struct asked asked = {.last = 3};
    char path[32];
    int ends[2];
    lum_reader *reader = NULL;
    lum_error error = {""};
    assert_int_equal(pipe(ends), 0);
    (void)snprintf(path, sizeof path, "/dev/fd/%d", ends[0]);
    const lum_reader_options options = {.struct_size = sizeof options,
                                        .path = path,
                                        .go_on = answer,
                                        .go_on_context = &asked};
    (void)alarm(600); /* in place of waiting for ever */
    assert_stopped(lum_reader_open(&options, &reader, &error), &error);
    (void)alarm(0);
    assert_int_equal(asked.calls, 3);
    (void)close(ends[0]);
    (void)close(ends[1]);
}

static void whoever_says_yes_changes_nothing(void **state)
{
    (void)state;
    struct asked asked = {0};
    const lum_reader_options options = {.struct_size = sizeof options,
                                        .path = drive,
                                        .go_on = answer,
                                        .go_on_context = &asked};
    assert_whole(open_reader(&options));
    assert_true(asked.calls > 0);
}

/* --- More of records --- */

/* One record, and an end that leaves it as it is. */
static int next_only(void *context, lum_record *out, lum_error *error)
{
    (void)error;
    bool *is_given = context;
    if (*is_given) {
        return 0;
    }
    *is_given = true;
    *out = (lum_record){.kind = LUM_RECORD_FRAGMENT, .dropped_fragments = 3};
    return 1;
}

static void fragments_are_counted_once(void **state)
{
    (void)state;
    bool is_given = false;
    const lum_record_source source = {
        .struct_size = sizeof source, .next = next_only, .context = &is_given};
    const lum_reader_options options = {.struct_size = sizeof options,
                                        .records = &source};
    const lum_frame *frame = NULL;
    lum_demux_counters total = {.struct_size = sizeof total};
    lum_reader *reader = open_reader(&options);
    assert_int_equal(lum_reader_next_frame(reader, &frame, NULL), 0);
    lum_demux_total(lum_framer_demux(lum_reader_framer(reader)), &total);
    assert_int_equal(total.other, 3);
    lum_reader_close(reader);
}

static void what_was_read_stands_before_the_error(void **state)
{
    (void)state;
    struct live *live = calloc(1, sizeof *live);
    const lum_record_source source = {.struct_size = sizeof source,
                                      .next = next_live,
                                      .close = close_live,
                                      .context = live};
    const lum_reader_options options = {.struct_size = sizeof options,
                                        .records = &source};
    lum_demux_counters total = {.struct_size = sizeof total};
    lum_error error = {""};
    size_t frames = 0;
    uint64_t points = 0;
    assert_non_null(live);
    live->fails = true;
    lum_reader *reader = open_reader(&options);
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(count_frames(reader, &frames, &points, &error), -1);
        assert_string_equal(error.text, "the sensor is gone");
        assert_int_equal(frames, i == 0 ? FRAMES : 0);
    }
    lum_demux_total(lum_framer_demux(lum_reader_framer(reader)), &total);
    assert_int_equal(total.other, 3);
    lum_reader_close(reader);
    free(live);
}

/* Cut anywhere: frames never are more than the whole ones, and the reading
 * ends. */
static void a_capture_that_breaks_off_gives_what_there_is(void **state)
{
    (void)state;
    for (size_t len = 24; len < byte_count; len += byte_count / 23u) {
        const lum_reader_options options = {
            .struct_size = sizeof options,
            .source = lum_source_from_memory("cut", bytes, len)};
        lum_error error = {""};
        size_t frames = 0;
        uint64_t points = 0;
        lum_reader *reader = open_reader(&options);
        const int status = count_frames(reader, &frames, &points, &error);
        const uint64_t expected = (uint64_t)FRAMES * POINTS * len / byte_count;
        assert_int_equal(status < 0, error.text[0] != '\0');
        assert_true(points <= FRAMES * POINTS);
        assert_true(points + 4u * LUM_LINE_PIXELS >= expected);
        lum_reader_close(reader);
    }
}

static void events_come_as_they_are_asked_for(void **state)
{
    (void)state;
    const lum_framer_options framer = {.struct_size = sizeof framer,
                                       .wants = LUM_WANT_LINES |
                                                LUM_WANT_FRAME_ENDS};
    const lum_reader_options options = {
        .struct_size = sizeof options, .path = drive, .framer = &framer};
    lum_reader *reader = open_reader(&options);
    lum_framer_event event = LUM_FRAMER_NONE;
    const lum_sample *samples = NULL;
    unsigned lines = 0;
    unsigned ends = 0;
    uint64_t points = 0;
    while (lum_reader_next(reader, &event, NULL) > 0) {
        switch (event) {
        case LUM_FRAMER_LINE:
            lines++;
            points +=
                lum_framer_line_samples(lum_reader_framer(reader), 0, &samples);
            assert_int_equal(
                lum_framer_line_samples(lum_reader_framer(reader), 1, &samples),
                0);
            break;
        case LUM_FRAMER_FRAME_END:
            ends++;
            break;
        case LUM_FRAMER_FRAME:
        case LUM_FRAMER_NONE:
        case LUM_FRAMER_FAILED:
            fail_msg("event %d", (int)event);
            break;
        }
    }
    assert_int_equal(lines, FRAMES * LINES * LUM_EYES);
    assert_int_equal(ends, FRAMES);
    assert_int_equal(points, FRAMES * POINTS);
    lum_reader_close(reader);
}

static void assert_refused(const lum_reader_options *options, const char *part)
{
    lum_reader *reader = (lum_reader *)(uintptr_t)1;
    lum_error error = {""};
    assert_int_equal(lum_reader_open(options, &reader, &error), -1);
    assert_null(reader);
    if (strstr(error.text, part) == NULL) {
        fail_msg("'%s' is not in: %s", part, error.text);
    }
}

static size_t put_file(char *path, size_t room, const char *name, size_t from,
                       size_t to)
{
    (void)snprintf(path, room, "%s/%s", directory, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, 24, file), 24);
    assert_int_equal(fwrite(bytes + from, 1, to - from, file), to - from);
    assert_int_equal(fclose(file), 0);
    return to;
}

/* The end of the record that holds half of the bytes. */
static size_t find_half(void)
{
    size_t at = 24;
    while (at < byte_count / 2u) {
        const uint8_t *const len = bytes + at + 8; /* little-endian */
        at += 16u + ((size_t)len[0] | (size_t)len[1] << 8 |
                     (size_t)len[2] << 16 | (size_t)len[3] << 24);
    }
    return at;
}

static void several_paths_are_one_source(void **state)
{
    (void)state;
    char first[64];
    char second[64];
    const size_t half = find_half();
    (void)put_file(first, sizeof first, "1.pcap", 24, half);
    (void)put_file(second, sizeof second, "2.pcap", half, byte_count);
    const char *const paths[] = {second, first};
    const lum_reader_options options = {
        .struct_size = sizeof options, .paths = paths, .path_count = 2};
    assert_whole(open_reader(&options));
    assert_int_equal(remove(first), 0);
    assert_refused(&options, "1.pcap");
    assert_int_equal(remove(second), 0);
}

static void a_reader_wants_one_source_and_closes_what_it_was_given(void **state)
{
    (void)state;
    struct live live = {.closed = 0};
    const lum_record_source source = {.struct_size = sizeof source,
                                      .next = next_live,
                                      .close = close_live,
                                      .context = &live};
    lum_framer_options framer = {.struct_size = 0};
    lum_reader_options o = {.struct_size = 0};
    assert_refused(&o, "struct_size of the reader's options is not set; set it "
                       "to sizeof(lum_reader_options)");
    o.struct_size = sizeof o;
    assert_refused(&o, "one source");
    o.path = drive;
    o.records = &source;
    o.source = lum_source_from_memory("memory", bytes, byte_count);
    assert_refused(&o, "one source");
    assert_int_equal(live.closed, 1);
    o.path = NULL;
    o.source = NULL;
    o.framer = &framer;
    assert_refused(&o, "struct_size");
    assert_int_equal(live.closed, 2);
    o.framer = NULL;
    o.records = NULL;
    o.path = "/nonexistent/drive.pcap";
    assert_refused(&o, "/nonexistent/drive.pcap");
}

/* Frames of one reader are read and released by another thread. */
struct reading {
    pthread_t thread;
    size_t frames;
    uint64_t points;
    lum_frame *kept[FRAMES];
};

static void *read_all(void *argument)
{
    struct reading *reading = argument;
    const lum_reader_options options = {.struct_size = sizeof options,
                                        .path = drive};
    lum_reader *reader = NULL;
    const lum_frame *frame = NULL;
    if (lum_reader_open(&options, &reader, NULL) != 0) {
        return NULL;
    }
    while (lum_reader_next_frame(reader, &frame, NULL) > 0 &&
           reading->frames < FRAMES) {
        reading->kept[reading->frames++] = lum_frame_keep(frame);
        reading->points += lum_frame_count(frame);
        lum_frame_release(lum_frame_keep(frame));
    }
    lum_reader_close(reader);
    return NULL;
}

static void *release_all(void *argument)
{
    struct reading *reading = argument;
    for (size_t i = 0; i < reading->frames; i++) {
        const float *x = lum_frame_floats(reading->kept[i], LUM_COLUMN_X);
        reading->points += x[POINTS - 1u] > 0.0f ? 0u : 1u;
        lum_frame_release(reading->kept[i]);
    }
    return NULL;
}

static void two_threads_read_two_readers_and_share_frames(void **state)
{
    (void)state;
    struct reading readings[2] = {{.frames = 0}, {.frames = 0}};
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(
            pthread_create(&readings[i].thread, NULL, read_all, &readings[i]),
            0);
    }
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(pthread_join(readings[i].thread, NULL), 0);
        assert_int_equal(readings[i].points, FRAMES * POINTS);
    }
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(pthread_create(&readings[i].thread, NULL, release_all,
                                        &readings[i]),
                         0);
    }
    for (unsigned i = 0; i < 2; i++) {
        assert_int_equal(pthread_join(readings[i].thread, NULL), 0);
        assert_int_equal(readings[i].points, FRAMES * POINTS);
    }
}

/* A stream of large frames, made as it is read: 640 lines of both eyes, 1016
 * points each. */
#define BIG_LINES  640u
#define BIG_WORDS  1016u
#define BIG_FRAMES 5u

static int next_big(void *context, lum_record *out, lum_error *error)
{
    struct live *l = context;
    uint32_t words[BIG_WORDS];
    (void)error;
    if (l->packet == l->line.count) {
        if (l->lines == BIG_FRAMES * BIG_LINES * LUM_EYES) {
            return 0;
        }
        for (uint32_t i = 0; i < BIG_WORDS; i++) {
            const uint32_t pixel = i < 32u ? i / 2u : i - 16u;
            words[i] = lum_word_make((int32_t)(2000u + i), true, pixel);
        }
        drive_make(&l->line, l->lines % LUM_EYES,
                   l->lines / LUM_EYES % BIG_LINES,
                   1000000u + 150u * (l->lines / LUM_EYES), words, BIG_WORDS);
        l->packet = 0;
        l->lines++;
    }
    *out = drive_record(&l->line, l->packet++, DRIVE_SENSOR, l->lines);
    return 1;
}

/* Peak memory of this process in MB after reading frames of 1.3 million
 * points, all columns. */
static unsigned read_big(void)
{
    static struct live live;
    const lum_record_source source = {
        .struct_size = sizeof source, .next = next_big, .context = &live};
    struct rusage usage;
    lum_view view;
    lum_error error = {""};
    size_t frames = 0;
    uint64_t points = 0;
    lum_view_default(&view);
    view.columns = LUM_COLUMNS_ALL;
    const lum_framer_options framer = {
        .struct_size = sizeof framer, .views = &view, .view_count = 1};
    const lum_reader_options options = {
        .struct_size = sizeof options, .records = &source, .framer = &framer};
    lum_reader *reader = open_reader(&options);
    assert_int_equal(count_frames(reader, &frames, &points, &error), 0);
    lum_reader_close(reader);
    assert_int_equal(frames, BIG_FRAMES);
    assert_int_equal(points, BIG_FRAMES * BIG_LINES * LUM_EYES * BIG_WORDS);
    assert_int_equal(getrusage(RUSAGE_SELF, &usage), 0);
    return (unsigned)(usage.ru_maxrss / 1024);
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define HAS_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define HAS_SANITIZER
#endif
#endif

/* Valgrind loads libraries of its own into what it runs, and its memory counts
 * as the program's. */
static bool under_valgrind(void)
{
    const char *preload = getenv("LD_PRELOAD");
    return preload != NULL && strstr(preload, "vgpreload") != NULL;
}

static void a_frame_of_1300000_points_of_all_columns_fits_80_mb(void **state)
{
    (void)state;
#if defined(__linux__) && !defined(HAS_SANITIZER)
    int status = 0;
    if (under_valgrind()) {
        assert_true(read_big() > 0);
        return;
    }
    const pid_t child = fork(); /* whose peak is its own */
    assert_true(child >= 0);
    if (child == 0) {
        const unsigned mb = read_big();
        (void)fprintf(stderr, "peak of 1.3 million points: %u MB\n", mb);
        _exit(mb <= 80u ? 0 : 1);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 0);
#else
    (void)under_valgrind;
    assert_true(read_big() > 0); /* a sanitizer takes memory of its own */
#endif
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_of_1300000_points_of_all_columns_fits_80_mb),
        cmocka_unit_test(a_file_gives_all_its_frames_the_last_too),
        cmocka_unit_test(memory_gives_the_same),
        cmocka_unit_test(a_callers_function_gives_the_same),
        cmocka_unit_test(records_of_a_caller_give_the_same),
        cmocka_unit_test(a_caller_can_stop_a_reading),
        cmocka_unit_test(a_caller_can_stop_the_reading_of_records),
        cmocka_unit_test(a_caller_can_stop_an_opening),
        cmocka_unit_test(a_caller_can_stop_a_wait),
        cmocka_unit_test(whoever_says_yes_changes_nothing),
        cmocka_unit_test(fragments_are_counted_once),
        cmocka_unit_test(what_was_read_stands_before_the_error),
        cmocka_unit_test(a_capture_that_breaks_off_gives_what_there_is),
        cmocka_unit_test(events_come_as_they_are_asked_for),
        cmocka_unit_test(
            a_reader_wants_one_source_and_closes_what_it_was_given),
        cmocka_unit_test(several_paths_are_one_source),
        cmocka_unit_test(two_threads_read_two_readers_and_share_frames),
    };
    return cmocka_run_group_tests(tests, make_drive, remove_drive);
}
