/* The raw part of frames, and of lines under way. */
#ifndef LUM_FRAME_RAW_INTERNAL_H
#define LUM_FRAME_RAW_INTERNAL_H

#include "lum/assembler.h"
#include "lum/frame/raw.h"
#include "lum/points.h"

#include "capture/demux_state.h"

/* --- Packets of lines under way: raw_watch.c --- */

/* Packets that one line was made of. */
typedef struct lum_raw_list {
    lum_raw_packet *packets; /* their line is not set */
    size_t count;
    size_t room;
    const uint16_t
        *places; /* as in lum_frame_raw, of the line; NULL: likewise */
} lum_raw_list;

typedef struct lum_raw_watch lum_raw_watch;

/* Watch what a demultiplexer accepts. NULL
 * without memory. It is freed after the last push. */
lum_raw_watch *lum_raw_watch_new(lum_demux *demux);

/* NULL is allowed. */
void lum_raw_watch_free(lum_raw_watch *watch);

/* Forget the lines under way. */
void lum_raw_watch_restart(lum_raw_watch *watch);

/* The packets of a line that a sensor's assembler has handed out, which
 * live until the next call; empty: not all of them are known. */
const lum_raw_list *lum_raw_watch_take(lum_raw_watch *watch, size_t sensor,
                                       const lum_line *line);

/* --- The raw part of a frame: raw.c --- */

typedef struct lum_raw_store lum_raw_store;

/* An empty one; NULL without memory. */
lum_raw_store *lum_raw_store_new(void);

/* NULL is allowed. */
void lum_raw_store_free(lum_raw_store *store);

/* Nothing is in it; its memory stays. */
void lum_raw_store_clear(lum_raw_store *store);

/* Make room for a line. False: there is no memory. */
bool lum_raw_store_reserve(lum_raw_store *store, const lum_line *line,
                           const lum_raw_list *packets);

/* Add the line that room was made for. */
void lum_raw_store_add(lum_raw_store *store, const lum_projector *projector,
                       const lum_line *line, const lum_raw_list *packets);

#endif
