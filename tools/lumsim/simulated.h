/* A sensor of a capture, line by line: its packets, and what is true of it. */
#ifndef LUMSIM_SIMULATED_H
#define LUMSIM_SIMULATED_H

#include "base/outfile.h"
#include "lum/base/error.h"
#include "options.h"
#include "sim/fault.h"
#include "sim/packets.h"
#include "sim/render.h"
#include "truth.h"

#include <stddef.h>
#include <stdint.h>

/* All times are of a clock that is right, and shows what the sensor's does when
 * the drive begins if there is one alone. Too large for a stack; not to be
 * moved. */
struct simulated {
    const struct options *options;
    lum_render render;
    lum_sim_line line; /* the last that was rendered */
    lum_packet_batch batches[LUM_EYES];
    lum_sim_packet *order[LUM_EYES * LUM_PACKETS_LINE_MAX]; /* of that line */
    size_t count;                                           /* of these */
    size_t next;                  /* the first that has not left */
    struct truth *truth;          /* NULL: not requested */
    lum_outfile true_calibration; /* likewise; a fd of -1 */
    struct labels *labels;        /* likewise */
    int64_t frame;                /* of the next line */
    uint32_t number;              /* likewise */
    size_t interface;             /* of the capture */
    uint64_t packets;             /* in the capture */
    uint64_t points;
    uint64_t faults[LUM_FAULT_KINDS];
};

/* Begin. The options are kept. simulated_free() also after a failure. 0; 1 if
 * the profile does not reach the ends of the span; then nothing is said. */
int simulated_init(struct simulated *out, const struct options *o);

/* Begin what is written of it beside the capture. 0, or -1 with the reason in
 * error. */
int simulated_open(struct simulated *s, lum_error *error);

/* Render the next line and make its packets. 0, or -1 with the reason in
 * error. */
int simulated_render(struct simulated *s, unsigned sender, lum_error *error);

/* Of the sensor's clock, ns. */
int64_t simulated_time_ns(const struct simulated *s, int64_t clock_ns);

/* The capture's clock at a time. */
int64_t simulated_utc(const struct options *o, int64_t time_ns);

/* Finish what is written of it. 0, or -1 with the reason in error; then
 * simulated_abort() removes the rest. */
int simulated_close(struct simulated *s, lum_error *error);

/* Remove what is not finished. */
void simulated_abort(struct simulated *s);

void simulated_free(struct simulated *s);

#endif
