/* What a source holds, for people and for programs. */
#ifndef LUMDUMP_SUMMARY_H
#define LUMDUMP_SUMMARY_H

#include "output.h"

#include "lum/frame/framer.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

/* One output of a live run. */
struct live_output {
    const char *name;
    const char *end;   /* done, failed, stalled, no reader */
    const char *error; /* where it failed */
    bool is_recording;
    bool has_ended_early;
    uint64_t datagrams; /* that it took */
    uint64_t dropped;   /* that its buffer had no room for */
    double seconds;     /* from the first data to its end, if that was early */
};

/* Further counters of a live run. */
struct live_counts {
    uint64_t received;     /* datagrams of the sensor, while it was recorded */
    uint64_t kernel_drops; /* as lum_socket_drops() */
    bool kernel_drops_at_least; /* there may have been more */
    uint64_t ring_drops;        /* received, and lost to this summary */
    uint64_t recording_drops;   /* received, and lost to the recordings */
    struct live_output outputs[OUTPUTS_MAX];
    size_t output_count;
    uint64_t foreign_source;
    uint64_t heartbeats_sent;
    double silent_s;    /* at the end without data; 0: less than a second */
    double seconds;     /* from the first data to the end */
    double dark_s;      /* with data, and without the laser of --laser */
    const char *laser;  /* off, on, unknown, untouched */
    char darkness[320]; /* why there are no ranges; empty: not known */
};

struct summary {
    const char *source;
    const struct live_counts *live; /* NULL: a capture */
    const lum_framer *framer;
    const lum_capture *capture; /* NULL: live, or none could be opened */
    int64_t first_ns; /* capture times of the first and last of our packets */
    int64_t last_ns;
    uint64_t records; /* of the capture */
    bool has_time;
    bool has_frames; /* some were chosen */
    struct {
        uint32_t asked; /* --frames whole:N; 0: not */
        size_t sensor;
        uint64_t frames; /* that were chosen */
        uint64_t points; /* in them */
    } whole;
    bool truncated;
    struct left_out left_out[OUTPUTS_MAX]; /* of outputs that lack points */
    size_t left_out_count;
    struct drawn drawn[OUTPUTS_MAX]; /* of pictures */
    size_t drawn_count;
    struct retention_counts retention;
};

/* Parts of the capture that could not be read and were passed over; why: may be
 * NULL. */
uint64_t summary_damaged(const struct summary *summary, lum_error *why);

/* What was made of the lines of all sensors. */
lum_framer_counters summary_count(const struct summary *summary);

/* Counts of all sensors' clocks: readings, breaks, steps. */
lum_clock_fit_info summary_count_clocks(const struct summary *summary);

/* A sentence on what a picture shows. Returns out. */
const char *summary_drawn(const struct drawn *drawn, char *out, size_t room);

void summary_print_text(const struct summary *summary, FILE *out);
void summary_print_json(const struct summary *summary, FILE *out);

#endif
