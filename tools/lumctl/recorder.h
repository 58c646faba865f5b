/* A recording of a sensor's packets, written by a thread of its own: whoever
 * keeps a laser on by heartbeats must not wait for a disk. */
#ifndef LUMCTL_RECORDER_H
#define LUMCTL_RECORDER_H

#include "../common/provenance.h"
#include "losses.h"

#include "lum/base/error.h"
#include "lum/net/socket.h"

#include <stdbool.h>
#include <stdint.h>

struct recorder;

struct recorder_options {
    const char *path; /* a pcapng file; no longer needed after, as the next */
    const struct provenance *about;
    const lum_layout *layout; /* must live on */
    lum_endpoint sensor;
    lum_endpoint host;
};

enum recorder_state {
    RECORDER_WRITES,
    RECORDER_BREAKS, /* a write has failed; it is to be closed */
    RECORDER_WHOLE,  /* it is on the disk under its name */
    RECORDER_FAILED  /* there is no file */
};

/* What stands in the file. */
struct recorder_counts {
    uint64_t packets;
    uint64_t dropped; /* and what does not: the disk was too slow */
    int64_t first_utc_ns;
    int64_t last_utc_ns;
    int64_t longest_gap_ns; /* without a packet: whole frames that are lost in
                               it are not among the losses */
    struct loss_counts losses;
};

/* Begins; the thread opens the file. It gets its name when it is whole; one of
 * that name is then replaced. NULL with the reason in error. */
struct recorder *recorder_new(const struct recorder_options *options,
                              lum_error *error);

/* Adds a datagram; it is seen with recorder_publish(). Does not wait. */
void recorder_put(struct recorder *recorder, const lum_received *datagram);
void recorder_publish(struct recorder *recorder);

/* No more will come: the thread ends the file. drop: it gets no name, unless
 * the thread is giving it just now. A second call may drop it after all. */
void recorder_close(struct recorder *recorder, bool drop);

/* error: of RECORDER_BREAKS and RECORDER_FAILED; empty: it was dropped. */
enum recorder_state recorder_look(struct recorder *recorder, lum_error *error);

/* After recorder_close(). counts: of RECORDER_WHOLE and RECORDER_FAILED; may be
 * NULL. Before that it hangs in a disk, and keeps its memory. NULL is allowed.
 */
void recorder_free(struct recorder *recorder, struct recorder_counts *counts);

/* After a drop: as recorder_free(), and what got its name all the same is
 * removed. */
void recorder_discard(struct recorder *recorder);

#endif
