/* All lanes of a live run, and their messages. */
#ifndef LUMDUMP_LANES_H
#define LUMDUMP_LANES_H

#include "lane.h"

struct lanes {
    struct lane *list[OUTPUTS_MAX + 1u]; /* the outputs' in their order, and the
                                            summary's */
    struct lane *summary;
    size_t count;    /* of the outputs */
    bool has_laser;  /* the run keeps one on */
    bool is_waiting; /* for an output at the end, and that was said */
};

/* Open the outputs of the run's options. 0, or -1 with the reason in error;
 * then lanes_free() is called too. */
int lanes_open(struct lanes *lanes, struct pass *run, lum_error *error);

/* 0, or -1 with the reason in error. After a signal it does not start, and
 * error is empty: opening a file may have stalled until then. */
int lanes_start(struct lanes *lanes, struct lane_ends ends, lum_error *error);

/* The receiving thread's: put an item into all; show what was put; wake all, so
 * that they look at the clock. None waits for anything. */
void lanes_put(struct lanes *lanes, const struct ring_item *item);
void lanes_publish(struct lanes *lanes);
void lanes_wake(struct lanes *lanes);

/* Check their states and report changes: outputs that ended, dropped datagrams,
 * outputs that stall, which are given up if there are others. False: there were
 * outputs, and none is left. */
bool lanes_watch(struct lanes *lanes, struct say *say, int64_t now_ns);

/* Datagrams that rings had no room for, of all lanes; how full the fullest ring
 * is, in percent. */
uint64_t lanes_dropped(const struct lanes *lanes);
unsigned lanes_level(const struct lanes *lanes);

/* No more will come: have what is in the rings written, and the files finished.
 * Does not wait. keep: see lane_finish(). */
void lanes_finish(struct lanes *lanes, bool keep);

/* After lanes_finish(): wait for that. Each output has its time. A file: while
 * it moves or its disk finishes it, and 30 s without that. A pipe: a minute,
 * and 3 s without moving. What takes longer is given up, and so is all that is
 * waited for when a signal comes; that is said. */
void lanes_end(struct lanes *lanes, struct say *say);

/* After lanes_end(): whether an output failed or was given up; whether all were
 * ended by their readers. */
bool lanes_have_failed(const struct lanes *lanes);
bool lanes_have_no_reader(const struct lanes *lanes);

/* After lanes_end(): what outputs lack and pictures show, into the summary of
 * the run. */
void lanes_note_left_out(const struct lanes *lanes, struct summary *summary);

/* False: a thread still waits for an output, so nothing that it uses may be
 * freed. */
bool lanes_free(struct lanes *lanes);

#endif
