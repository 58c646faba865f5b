/* A thread that takes what a sensor sent out of a ring, makes lines and points
 * of it and writes them. It may wait for its disk or its reader as long as it
 * takes: what keeps the session, and what fills other outputs, are other
 * threads. */
#ifndef LUMDUMP_WORKER_H
#define LUMDUMP_WORKER_H

#include "convert.h"

#include "../common/ring.h"
#include "lum/net/socket.h"

#include <stdbool.h>
#include <stdint.h>

struct worker;

/* What it has come to, for a look from outside. */
struct worker_view {
    uint64_t taken; /* datagrams, as of now; the rest as of the last tenth of a
                       second */
    uint64_t points;
    uint64_t lost_words; /* without lines that were under way when it began */
    uint64_t lost_lines; /* skipped, or without all angles; likewise */
    uint64_t refused;    /* datagrams that reassembly could not use */
    bool has_all;        /* that --frames asks for */
    bool has_ended;      /* its outputs are closed, and no file is lost that
                            worker_take_lost() has not given */
};

/* Where datagrams went from and to. */
struct worker_ends {
    lum_endpoint sensor;
    lum_endpoint client;
};

struct worker_setup {
    struct pass *pass; /* the worker's, its outputs among it, until it ended */
    struct ring *ring;
    struct worker_ends ends;
    bool only_records; /* it decodes nothing: the outputs are captures */
    bool opens;        /* the outputs, of which one may be waited for long */
};

/* 0, or -1 with the reason in error. */
int worker_start(const struct worker_setup *setup, struct worker **out,
                 lum_error *error);

/* dropped: how many datagrams its ring had no room for, which it tells. */
void worker_look(struct worker *worker, uint64_t dropped,
                 struct worker_view *out);

/* What became of a file while it was written, each one once. False: no more so
 * far. */
bool worker_take_lost(struct worker *worker, lum_error *out);

/* No more will come. Its outputs are finished once all that is in the ring has
 * been written, where keep is set or one of them has failed, which is aborted;
 * else all are. Does not wait. */
void worker_finish(struct worker *worker, bool keep);

/* Its outputs are given up: as soon as it moves again it ends. Does not wait.
 */
void worker_drop(struct worker *worker);

/* Wait for its end, free it. */
enum pass_result worker_join(struct worker *worker, lum_error *error);

#endif
