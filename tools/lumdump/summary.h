/* What came from a source, in numbers. It only reads what it points to; of one
 * thread at a time. */
#ifndef LUMDUMP_SUMMARY_H
#define LUMDUMP_SUMMARY_H

#include "output.h"

#include "lum/frame/framer.h"
#include "lum/frame/move.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

struct rig;

/* Packets of a sensor that a rig does not name, by where they came from. */
struct rig_other {
    uint32_t address;
    char interface[LUM_INTERFACE_BYTES];
    uint64_t packets;
};

struct rig_others {
    struct rig_other list[LUM_DEMUX_SENSORS_MAX];
    size_t count; /* of more of them nothing is known */
};

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

/* Capture times of the first and the last of our packets. */
struct summary_span {
    bool is_known; /* there was one */
    int64_t first_ns;
    int64_t last_ns;
};

/* What outputs have to say at their end. */
struct summary_outputs {
    struct left_out left_out[OUTPUTS_MAX]; /* of those that lack points */
    size_t left_out_count;
    struct drawn drawn[OUTPUTS_MAX]; /* of pictures */
    size_t drawn_count;
    struct retention_counts retention;
};

/* Points that became voxels; size 0: none did. */
struct voxel_counts {
    double size;           /* metres */
    uint64_t points;       /* in voxels */
    uint64_t voxels;       /* written */
    uint64_t without_pose; /* points left out; they are also in moved */
    uint64_t not_finite;   /* likewise */
    uint64_t out_of_range; /* likewise */
    uint64_t spooled;      /* bytes that the map had on the disk */
};

struct summary {
    const char *source;
    const struct live_counts *live; /* NULL: a capture */
    const lum_framer *framer;
    const lum_capture *capture; /* NULL: live, or none could be opened */
    const struct rig *rig;      /* NULL: there is none */
    struct rig_others others;   /* what came of sensors that it does not name */
    const lum_move_counts *moved; /* by poses; NULL: there are none */
    const double *origin;         /* of the moved points, metres */
    struct summary_span span;
    uint64_t records; /* of the capture */
    bool has_frames;  /* some were chosen */
    struct {
        uint32_t asked; /* --frames whole:N; 0: not */
        size_t sensor;
        uint64_t frames; /* that were chosen */
        uint64_t points; /* in them */
    } whole;
    bool truncated;
    struct summary_outputs outputs;
    struct voxel_counts voxels;
};

/* Which part of a report a counter is in. */
enum summary_group {
    SUMMARY_PACKETS,
    SUMMARY_CONTENT,
    SUMMARY_LOSSES,
    SUMMARY_UNDER_WAY /* not lost: cut by the stream's begin or end */
};

/* A counter, as reports show it. */
struct summary_row {
    enum summary_group group;
    const char *key;     /* its name in JSON */
    const char *meaning; /* the same in words */
    const char *of; /* the key of the loss that it is a part of; NULL: none */
    uint64_t value;
};

/* With room for what a report adds. */
struct summary_rows {
    struct summary_row list[48];
    size_t count;
};

/* All counters, in the order of the reports. */
void summary_list(const lum_demux_counters *packets,
                  const lum_framer_counters *frames, struct summary_rows *out);

/* What was made of the lines of all sensors, and of one. */
lum_framer_counters summary_count(const struct summary *summary);
lum_framer_counters summary_count_sensor(const struct summary *summary,
                                         size_t sensor);

/* Packets of all sensors. */
lum_demux_counters summary_count_packets(const struct summary *summary);

/* Counts of all sensors' clocks: readings, breaks, steps. */
lum_clock_fit_info summary_count_clocks(const struct summary *summary);

/* The clock of one. False: there is none, or no line yet. */
bool summary_find_clock(const struct summary *summary, size_t sensor,
                        lum_clock_fit_info *out);

/* Parts of the capture that could not be read and were passed over; why: may be
 * NULL. */
uint64_t summary_damaged(const struct summary *summary, lum_error *why);

/* From the first packet to the last; 0: there is none. */
double summary_seconds(const struct summary *summary);

/* Print it as text for people, or as JSON. */
void summary_text_print(const struct summary *summary, FILE *out);
void summary_json_print(const struct summary *summary, FILE *out);

/* A sentence on what a picture shows. Returns out. */
const char *summary_text_drawn(const struct drawn *drawn, char *out,
                               size_t room);

#endif
