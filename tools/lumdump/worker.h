/* The thread that makes lines and points of what a sensor sent and writes them.
 * It may wait for a disk or for a reader as long as it takes: what keeps the
 * session is another thread, and they share a ring. */
#ifndef LUMDUMP_WORKER_H
#define LUMDUMP_WORKER_H

#include "convert.h"

#include "../common/ring.h"
#include "lum/net/cancel.h"
#include "lum/net/socket.h"

#include <stdbool.h>
#include <stdint.h>

struct worker;

/* What it has come to, for a look from outside. */
struct worker_view {
    uint64_t points;
    uint64_t lost_words;
    uint64_t lost_lines; /* skipped, or without all angles */
    uint64_t refused;    /* datagrams that reassembly could not use */
    size_t notes;        /* that outputs gave; see worker_note() */
    bool has_ended;
};

/* Where datagrams went from and to. */
struct worker_ends {
    lum_endpoint sensor;
    lum_endpoint client;
};

/* Begin. The worker uses the pass, its outputs among it, until worker_end().
 * cancel is raised when it ends of itself, because an output has failed or its
 * reader has left. 0, or -1 with the reason in error. */
int worker_start(struct pass *pass, struct ring *ring, struct worker_ends ends,
                 lum_cancel *cancel, struct worker **out, lum_error *error);

/* As of the last tenth of a second. */
void worker_look(struct worker *worker, struct worker_view *out);

/* One of the notes that the last look counted. */
const char *worker_note(const struct worker *worker, size_t i);

/* No more will come: wait until all that is in the ring has been written, free
 * the worker. Its outputs are finished, where keep is set or one of them has
 * failed, which is aborted; else all are. left_out: see outputs_left_out(). */
enum pass_result worker_end(struct worker *worker, bool keep,
                            uint64_t *left_out, lum_error *error);

#endif
