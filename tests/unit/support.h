/* What the tests of core and points share: packets made by the encoder, an
 * assembler with heap storage, and the lines it hands out, kept. */
#ifndef LUM_TEST_SUPPORT_H
#define LUM_TEST_SUPPORT_H

#include "lum/assembler.h"
#include "lum/group.h"
#include "lum/profile.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Bytes at the end of exactly as many: the sanitizer guards the next one. */
uint8_t *exact_copy(const void *bytes, size_t len);

/* A data packet as the encoder writes it: samples 4 bytes each. */
uint8_t *encode_packet(const lum_layout *layout, const lum_group *group,
                       const uint8_t *samples, size_t *len);

/* A line, or a complete frame, as it came out of an assembler. */
struct event {
    lum_result what; /* LUM_LINE_READY or LUM_FRAME_READY */
    int64_t frame;   /* of the line, or the one that is complete */
    lum_line line;   /* points into the copies below */
    uint32_t *words;
    lum_angle angles[LUM_LINE_PIXELS];
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
};

/* An assembler and all that came out of it. */
struct stream {
    lum_layout layout;
    lum_assembler_config config;
    lum_assembler assembler;
    lum_line_slot *slots;
    uint32_t *words;
    lum_reach *reach;
    struct event **events;
    size_t event_count;
    int64_t arrival; /* of the next packet; each gets one more */
    uint32_t clock;  /* of send_line() */
    uint32_t step;   /* from one send_line() to the next */
};

/* The defaults; tests may change config and layout before stream_begin(). */
struct stream *stream_new(void);
void stream_begin(struct stream *s);
/* stream_new() and stream_begin(). */
struct stream *stream_open(void);
void stream_free(struct stream *s);

/* Encode, decode, push until the packet is consumed. */
lum_result send_group(struct stream *s, const lum_group *group,
                      const uint8_t *samples);
/* Angles of n pixels: azimuth is 3 x pixel + line, elevation -pixel. */
lum_result send_angles(struct stream *s, unsigned eye, uint32_t line,
                       uint32_t clock, uint32_t first, uint32_t n);
lum_result send_words(struct stream *s, unsigned eye, uint32_t line,
                      uint32_t clock, uint32_t first, const uint32_t *words,
                      uint32_t n);
/* n rising words, one a pixel from pixel on, first_sample_index the same. */
lum_result send_pixels(struct stream *s, unsigned eye, uint32_t line,
                       uint32_t clock, uint32_t pixel, uint32_t n);
/* Two packets, so that the line's frame is decided; the stream's clock then
 * goes on by a step, 5000 us at first. */
void send_line(struct stream *s, unsigned eye, uint32_t line);
/* send_line() of line, line + 1 ... last. */
void send_lines(struct stream *s, unsigned eye, uint32_t line, uint32_t last);
/* Flush to the end. */
void stream_end(struct stream *s);

const lum_assembly_counters *counters(const struct stream *s);
size_t count_events(const struct stream *s, lum_result what);
/* The nth line handed out, from 0; fails the test when there are fewer. */
const lum_line *nth_line(const struct stream *s, size_t n);
/* The nth line of an eye and number, from 0. */
const lum_line *find_line(const struct stream *s, unsigned eye, uint32_t number,
                          size_t n);
int64_t frame_of(const struct stream *s, unsigned eye, uint32_t number,
                 size_t n);
/* The index of frame's completion among the events; -1 if it is not there. */
long frame_event(const struct stream *s, int64_t frame);
/* The numbers of all lines handed out, in order. */
void assert_lines(const struct stream *s, const uint32_t *numbers, size_t n);

#define ASSERT_LINES(stream, ...)                                              \
    assert_lines(stream, (const uint32_t[]){__VA_ARGS__},                      \
                 sizeof(const uint32_t[]){__VA_ARGS__} / sizeof(uint32_t))

/* Of a test program's table: what needs a file of the core that another one has
 * taken the place of is left out, and says so. */
#ifdef LUM_TEST_LAYOUT_FIXED
#define ANY_LAYOUT_TEST(test) LEFT_OUT(test, needs_any_layout)
#else
#define ANY_LAYOUT_TEST(test) cmocka_unit_test(test)
#endif
#ifdef LUM_TEST_FRAMES_NONE
#define FRAMES_TEST(test) LEFT_OUT(test, needs_frames)
#else
#define FRAMES_TEST(test) cmocka_unit_test(test)
#endif
#define LEFT_OUT(test, reason)                                                 \
    {                                                                          \
#test, 1 ? (reason) : (test), NULL, NULL, NULL                         \
    }

void needs_any_layout(void **state);
void needs_frames(void **state);

/* Reproducible numbers. */
uint32_t next_random(uint64_t *state);

#endif
