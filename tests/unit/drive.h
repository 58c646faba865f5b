/* What the tests of frames share: records of a sensor's lines, made by hand. */
#ifndef LUM_TEST_DRIVE_H
#define LUM_TEST_DRIVE_H

#include "lum/capture/capture.h"
#include "lum/profile.h"

#include <stddef.h>
#include <stdint.h>

#define DRIVE_SENSOR  0x0a2a0025u /* 10.42.0.37 */
#define DRIVE_CLIENT  0x0a2a0001u
#define DRIVE_PACKETS 64u /* most of a line */
#define DRIVE_BYTES   1472u

/* The datagrams of one line. */
struct drive_line {
    size_t count;
    size_t len[DRIVE_PACKETS];
    uint8_t bytes[DRIVE_PACKETS][DRIVE_BYTES];
};

/* The layout of lines that are made next, which lives until then; NULL: the
 * default. */
void drive_use(const lum_layout *layout);

/* All angles and these words, in their order.
 * Pixel p of line l looks to azimuth 60 p - 30000, elevation 300 l - 9000. */
void drive_make(struct drive_line *out, unsigned eye, uint32_t line,
                uint32_t clock, const uint32_t *words, uint32_t count);

/* A line with one rising word a pixel from `first` on, each as far away as
 * drive_tof() says. */
void drive_pixels(struct drive_line *out, unsigned eye, uint32_t line,
                  uint32_t clock, uint32_t first, uint32_t count);

int32_t drive_tof(unsigned eye, uint32_t line, uint32_t pixel);

/* A packet of a line as a record. */
lum_record drive_record(const struct drive_line *line, size_t packet,
                        uint32_t sensor, int64_t time_ns);

#endif
