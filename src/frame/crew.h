/* Threads that make the points of lines beside the thread that assembles them.
 * Each line has its place in its frame before it is given, so it does not
 * matter who makes it when: the frame is the same, bit by bit. */
#ifndef LUM_FRAME_CREW_H
#define LUM_FRAME_CREW_H

#include "frame_internal.h"

#include "lum/smooth.h"

#include <stdbool.h>
#include <stddef.h>

/* One thread uses a crew, which has threads of its own. */
typedef struct lum_crew lum_crew;

/* A line whose points are to be made. */
typedef struct lum_crew_task {
    lum_column_line line;
    const lum_selection *selection;
    const lum_smooth *smooth; /* NULL: angles stay as they are */
    lum_frame_places places;
} lum_crew_task;

/* threads: beside the caller's, which start when there is work for them.
 * words: most of a line.
 * *out: NULL if this system has no threads.
 * False: there is no memory. */
bool lum_crew_new(unsigned threads, size_t words, lum_crew **out);

/* Nothing is under way. NULL is allowed. */
void lum_crew_free(lum_crew *crew);

/* Have the points of a line made; how many they are is known. The line is
 * copied, with its angles and words. The rest of the task, and the memory of
 * its places, are used until lum_crew_settle(). The caller makes points, too,
 * while the others are behind. Memory is bounded: 32 lines.
 * False: there is no memory for a copy, and nothing is under way of it. */
bool lum_crew_give(lum_crew *crew, const lum_crew_task *task);

/* Return when all that was given is made. NULL is allowed. */
void lum_crew_settle(lum_crew *crew);

/* --- Working memory of a thread: column_work.c --- */

/* words: most of a line. False: there is no memory; what there is of it is to
 * be released, too. */
bool lum_column_work_allocate(lum_column_work *work, size_t words);

void lum_column_work_release(lum_column_work *work);

#endif
