/* A frame as lines: as they came, or as the rows of an organised cloud. */
#ifndef LUMDUMP_FRAME_LINES_H
#define LUMDUMP_FRAME_LINES_H

#include "pose_motion.h"

#include "lum/cloud/writer.h"
#include "lum/frame/frame.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The columns that a frame must have. */
#define FRAME_LINES_COLUMNS                                                    \
    (LUM_COLUMNS_ALL &                                                         \
     ~(LUM_COLUMN_BIT(LUM_COLUMN_LINE) | LUM_COLUMN_BIT(LUM_COLUMN_EYE) |      \
       LUM_COLUMN_BIT(LUM_COLUMN_STRONGEST)))

/* Those that messages need; lines of a frame that has no others have zeros
 * instead. */
#define FRAME_LINES_OF_MESSAGES                                                \
    (LUM_COLUMNS_XYZ | LUM_COLUMN_BIT(LUM_COLUMN_PULSE_WIDTH) |                \
     LUM_COLUMN_BIT(LUM_COLUMN_TIME) |                                         \
     LUM_COLUMN_BIT(LUM_COLUMN_RETURN_NUMBER))

/* A frame that was taken. */
struct taken_frame {
    const lum_frame *frame;
    int64_t number;
    bool is_whole; /* nothing is known to be missing in it */
    size_t points;
    size_t lines;
    uint64_t left_out; /* points in no row: their line number came twice or is
                          one that no sensor has */
};

struct frame_lines;

/* The timestamp of a line, in microseconds. */
typedef int64_t frame_lines_clock(const void *context,
                                  const lum_frame_line *line);

/* eyes: those that have rows, bit 1 << LUM_EYE_... context: for the clock.
 * Returns NULL without memory. */
struct frame_lines *frame_lines_new(unsigned eyes, frame_lines_clock *clock,
                                    const void *context);

void frame_lines_free(struct frame_lines *lines);

/* Take a frame, which must live as long as it is used here. wants_rows: also
 * arrange it in rows; the frames before give the smallest number of rows. -1
 * without memory. */
int frame_lines_take(struct frame_lines *lines, const lum_frame *frame,
                     bool wants_rows);

/* Points of the frame that was taken are here instead, until the next one is
 * taken: a number for each, NaN for those that are left out. */
void frame_lines_move(struct frame_lines *lines, const struct moved *moved);

/* What was taken last. */
const struct taken_frame *frame_lines_taken(const struct frame_lines *lines);

/* When it began, in ns since 1970: by the clock, or where there is none by
 * arrival. That is the time 0 of its points. */
int64_t frame_lines_begin_ns(const struct frame_lines *lines, bool by_arrival);

/* The same of any frame. */
int64_t frame_begin_ns(const lum_frame_times *times, bool by_arrival);

/* The i-th line, in the order in which they came. What out points to lives
 * until the next call. */
void frame_lines_get(struct frame_lines *lines, size_t i,
                     lum_line_samples *out);

/* The same before, without samples and a timestamp; false: points of it may be
 * left out. */
bool frame_lines_outline(const struct frame_lines *lines, size_t i,
                         lum_line_samples *out);

/* The number of rows, and one of them: a sample for each pixel, NaN if there is
 * no point. The rows of each eye are in the order of their line numbers, those
 * of the blue eye first. Both eyes have the same number of rows. */
uint32_t frame_lines_rows(const struct frame_lines *lines);
void frame_lines_get_row(struct frame_lines *lines, uint32_t row,
                         lum_line_samples *out);

#endif
