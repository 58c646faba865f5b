/* The sensors of --rig: how the packets of each become points, what outputs say
 * of it, and which outputs are of which sensor. */
#ifndef LUMDUMP_RIG_RUN_H
#define LUMDUMP_RIG_RUN_H

#include "../common/geometry.h"
#include "../common/provenance.h"
#include "options.h"

#include "lum/capture/capture.h"
#include "lum/cloud/writer.h"
#include "lum/config/rig.h"
#include "lum/frame/framer.h"

/* Name of the column with a sensor's place in the rig's file. */
#define RIG_COLUMN "sensor"

/* One sensor. */
struct rig_sensor {
    const lum_rig_sensor *of;
    size_t place; /* in the rig's file, from 0 */
    struct geometry geometry;
    lum_layout layout;
    lum_projector projector; /* as its points are wanted */
    lum_pose pose;           /* on the vehicle */
    char topic[LUM_RIG_NAME_BYTES + 16u];
    char line[LUM_RIG_PATH_BYTES * 2u + 400u]; /* of it, for headers */
    struct provenance points;                  /* of outputs of it alone */
    struct provenance packets;
    const void *column;                 /* its place, as often as wanted */
    uint8_t places[LUM_LINE_WORDS_MAX]; /* that */
};

struct rig {
    const char *path;
    lum_rig_files files;
    bool is_one;    /* --sensor or a live source chose it */
    bool is_live;   /* then no other sends data */
    bool is_placed; /* points come in the vehicle's frame */
    size_t count;   /* sensors that are read: the first of these */
    struct rig_sensor sensors[LUM_RIG_SENSORS_MAX]; /* all of its file */
    lum_rig_member members[LUM_RIG_SENSORS_MAX];    /* not used if live */
    lum_mcap_sensor messages[LUM_RIG_SENSORS_MAX];
    char *names[OUTPUTS_MAX]; /* of outputs, made of %s */
};

/* Read the rig that the options name, choose the sensor of --sensor, and make
 * an output for each sensor of those with %s in their name. *out: NULL if no
 * rig is named; then %s is refused. 0, or -1 with the reason in error. */
int rig_open(struct options *options, struct rig **out, lum_error *error);

/* NULL is allowed. */
void rig_free(struct rig *rig);

/* Outputs with points of several sensors have UTC, unless --time is given:
 * their clocks differ. */
void rig_choose_time(struct options *options);

/* Refuse what does not go with it. 0, or -1 with the reason in error. */
int rig_check(const struct options *options, lum_error *error);

/* Make layouts, projectors, members and what outputs say. run: of the points,
 * and of the packets. 0, or -1 with the reason in error. */
int rig_prepare(struct rig *rig, const struct options *options,
                const struct provenance_run *points,
                const struct provenance_run *packets, lum_error *error);

/* Which of those that are read a record of this interface is of, which the
 * demux was given last. -1: none. */
int rig_member(const struct rig *rig, const lum_demux *demux,
               const lum_record *record, const char *interface);

/* Which of those that are read the i-th sensor of the framer is; -1: none. */
int rig_member_of(const struct rig *rig, const lum_framer *framer, size_t i);

/* Whether the i-th output has the column RIG_COLUMN. */
bool rig_has_column(const struct options *options, size_t i);

#endif
