/* Frames while they are made, and the memory that they share. */
#ifndef LUM_FRAME_INTERNAL_H
#define LUM_FRAME_INTERNAL_H

#include "lum/frame/clock_fit.h"
#include "lum/frame/frame.h"

#include "points/columns.h"
#include "raw_internal.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Whether a frame's number is before another one; they go round 32 bits. */
static inline bool lum_frame_is_before(int64_t a, int64_t b)
{
    return (int32_t)((uint32_t)a - (uint32_t)b) < 0;
}

/* Of a number of a column. */
size_t lum_column_bytes(lum_column column);

/* Memory of frames that are no longer needed, for later ones. Any thread. */
typedef struct lum_frame_pool lum_frame_pool;

/* points_max: of a frame. spare_max: frames whose memory is kept. keeps_raw:
 * frames have a raw part. NULL without memory. */
lum_frame_pool *lum_frame_pool_new(size_t points_max, unsigned spare_max,
                                   bool keeps_raw);

/* No new frame can begin; existing ones stay valid. NULL is allowed. */
void lum_frame_pool_free(lum_frame_pool *pool);

/* An array that begins at a multiple of 64 bytes. */
typedef struct lum_column_array {
    void *block; /* what was allocated */
    void *at;
    size_t room; /* numbers */
} lum_column_array;

/* The arrays of a frame, which pass from one to another. */
typedef struct lum_frame_store {
    lum_column_array columns[LUM_COLUMN_COUNT];
    void *xyz; /* the block of x, y and z, which have no own; NULL: the frame
                  lacks one of them */
    lum_frame_line *rows;
    int64_t *scratch; /* as many as rows have room */
    size_t row_room;
} lum_frame_store;

struct lum_frame {
    lum_frame *self; /* for callers that may only count references */
    lum_frame_pool *pool;
    lum_frame *next;     /* of the spare ones */
    lum_frame *into;     /* claimed for lum_frame_relocate(); NULL: none */
    size_t usual;        /* points that it is likely to have; 0: not known */
    unsigned references; /* guarded by the pool's lock */
    size_t points_max;
    lum_columns mask;
    size_t count; /* points */
    size_t row_count;
    uint32_t rows_before[LUM_EYES]; /* by whole lines, of the frame before */
    lum_frame_store store;
    bool is_placed; /* x y z are in the frame that this pose is in */
    lum_pose pose;
    lum_raw_store *raw; /* NULL: it has none */
    lum_frame_info info;
};

/* An empty frame, which is likely to have so many points; 0: not known. NULL
 * without memory. */
lum_frame *lum_frame_begin(lum_frame_pool *pool, lum_columns mask,
                           size_t usual);

/* Make room for one more line. False: there is no memory. */
bool lum_frame_reserve_row(lum_frame *frame);

/* Whether there is room for this many more points where the others are. If not,
 * or if the frame has claimed better memory, call lum_frame_relocate() next,
 * while nobody reads or writes the points. */
bool lum_frame_claim_room(lum_frame *frame, size_t points);

/* Move the points where there is room for this many more. False: there is no
 * memory; some columns may have moved, and all have the same points. */
bool lum_frame_relocate(lum_frame *frame, size_t points);

/* Where the points of a line are written; NULL: not requested. */
typedef struct lum_frame_places {
    lum_column_places columns;
    uint32_t *line;
    float *time;
    uint8_t *eye;
} lum_frame_places;

/* Points of a line, for a frame. */
typedef struct lum_frame_part {
    lum_column_line line; /* smoothed, if it is to be */
    const lum_selection *selection;
    lum_column_work *work;
    lum_point_losses losses; /* of the line */
} lum_frame_part;

/* Working memory for lines of at most so many words. False: there is no memory;
 * what there is of it is to be released, too. */
bool lum_column_work_allocate(lum_column_work *work, size_t words);

void lum_column_work_release(lum_column_work *work);

/* Add a line's points; room for them was reserved. */
void lum_frame_add(lum_frame *frame, const lum_frame_part *part);

/* The same in steps, for points that another thread makes: their places; the
 * points; and that there are n of them, which is known before. n is at most
 * lum_frame_points_left(). */
size_t lum_frame_points_left(const lum_frame *frame);
lum_frame_places lum_frame_next_places(const lum_frame *frame);
size_t lum_frame_make_points(const lum_frame_part *part,
                             const lum_frame_places *places);
void lum_frame_add_made(lum_frame *frame, const lum_frame_part *part, size_t n);

/* What only who makes the frame knows. */
typedef struct lum_frame_end {
    bool has_clock;               /* else lines are timed by arrival */
    const lum_clock_fit *clock;   /* NULL: there is none */
    uint32_t lines_max[LUM_EYES]; /* lines of the frame before */
    uint64_t lines_late;
    bool has_pause;
    uint64_t lines_in_pauses;
} lum_frame_end;

/* Complete a frame: compute times and what is missing. After that nothing is
 * added, and others may read it. */
void lum_frame_seal(lum_frame *frame, const lum_frame_end *end);

/* A number of a column that it has. */
float lum_frame_number(const lum_frame *frame, lum_column column, size_t i);

/* Number of lines of an eye, from its whole lines: their highest number plus
 * one, at most LUM_FRAME_LINES_MAX. A damaged packet can have any number, so a
 * higher one is not believed. */
uint32_t lum_frame_whole_rows(const lum_frame *frame, unsigned eye);

#endif
