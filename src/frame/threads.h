/* What frames need of threads: a lock, and threads that make the points of
 * lines beside the thread that assembles them.
 * Each line has its place in its frame before it is given, so it does not
 * matter who makes it when: the frame is the same, bit by bit. */
#ifndef LUM_FRAME_THREADS_H
#define LUM_FRAME_THREADS_H

#include "frame_internal.h"

#include "lum/smooth.h"

#include <stdbool.h>
#include <stddef.h>

/* For a few assignments at a time. */
typedef struct lum_lock lum_lock;

/* NULL without memory. */
lum_lock *lum_lock_new(void);

/* Nobody holds it. */
void lum_lock_free(lum_lock *lock);

void lum_lock_take(lum_lock *lock);
void lum_lock_leave(lum_lock *lock);

/* One thread uses them. */
typedef struct lum_line_threads lum_line_threads;

/* A line whose points are to be made. */
typedef struct lum_line_task {
    lum_column_line line;
    const lum_selection *selection;
    const lum_smooth *smooth; /* NULL: angles stay as they are */
    lum_frame_places places;
} lum_line_task;

/* threads: beside the caller's, which start when there is work for them.
 * words: most of a line.
 * *out: NULL if this system has no threads.
 * False: there is no memory. */
bool lum_line_threads_new(unsigned threads, size_t words,
                          lum_line_threads **out);

/* Nothing is under way. NULL is allowed. */
void lum_line_threads_free(lum_line_threads *threads);

/* Have the points of a line made; how many they are is known. The line is
 * copied, with its angles and words. The rest of the task, and the memory of
 * its places, are used until lum_line_threads_settle(). The caller makes
 * points, too, while the others are behind. Memory is bounded: 32 lines.
 * False: there is no memory for a copy, and nothing is under way of it. */
bool lum_line_threads_give(lum_line_threads *threads,
                           const lum_line_task *task);

/* Return when all that was given is made. NULL is allowed. */
void lum_line_threads_settle(lum_line_threads *threads);

#endif
