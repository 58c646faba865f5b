/* A frame as lines: as they came, or as the rows of an organised cloud. */
#ifndef LUMDUMP_FRAME_LINES_H
#define LUMDUMP_FRAME_LINES_H

#include "lum/cloud/writer.h"
#include "lum/frame/frame.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The columns that a frame has to have. */
#define FRAME_LINES_COLUMNS                                                    \
    (LUM_COLUMNS_ALL &                                                         \
     ~(LUM_COLUMN_BIT(LUM_COLUMN_LINE) | LUM_COLUMN_BIT(LUM_COLUMN_EYE) |      \
       LUM_COLUMN_BIT(LUM_COLUMN_STRONGEST)))

struct frame_lines;

/* What the timestamp of a line is, in microseconds. */
typedef int64_t frame_lines_clock(const void *context,
                                  const lum_frame_line *line);

/* eyes: those that have rows, bit 1 << LUM_EYE_... context: for the clock. NULL
 * without memory. */
struct frame_lines *frame_lines_new(unsigned eyes, frame_lines_clock *clock,
                                    const void *context);

void frame_lines_free(struct frame_lines *lines);

/* Take a frame, which has to live as long as it is asked about.
 * wants_rows: and lay it out in rows; the frames before tell how many there are
 * at least. -1 without memory. */
int frame_lines_take(struct frame_lines *lines, const lum_frame *frame,
                     bool wants_rows);

int64_t frame_lines_number(const struct frame_lines *lines);

/* How many lines it has, and the i-th, in the order in which they came. What
 * out points to lives until the next call. */
size_t frame_lines_count(const struct frame_lines *lines);
void frame_lines_get(struct frame_lines *lines, size_t i,
                     lum_line_samples *out);

/* How many rows it has, and one of them: a sample for each pixel, NaN where
 * there is no point. The lines of each eye stand by their numbers, those of the
 * blue eye first, and both eyes have as many. */
uint32_t frame_lines_rows(const struct frame_lines *lines);
void frame_lines_get_row(struct frame_lines *lines, uint32_t row,
                         lum_line_samples *out);

/* Points that are in no row: of a line number that came twice, or that no
 * sensor has. */
uint64_t frame_lines_left_out(const struct frame_lines *lines);

#endif
