/* The Y-scan table: from the options to the packet. */
#ifndef LUMCTL_YSCAN_TABLE_H
#define LUMCTL_YSCAN_TABLE_H

#include "../ctl.h"

#include "lum/calibration.h"
#include "lum/host/yscan_plan.h"

/* Lines of the two line modes; the protocol cannot ask which is on. */
#define YSCAN_LINES     640u
#define YSCAN_LINES_FEW 64u

/* A table and its source. */
struct yscan_table {
    size_t count;
    int32_t udeg[YSCAN_LINES]; /* as asked for */
    int16_t raw[YSCAN_LINES];  /* for both eyes */
    int32_t off_udeg;          /* how far a line is from udeg in an eye whose
                                  calibration differs from the other's */
};

/* Room for "640 lines from 2.98 down to -16.98 degrees". */
#define YSCAN_TEXT_BYTES 64

/* What the calibration is made from: the file and what is set on top of it, as
 * on a command line behind --calibration; without a file it begins with --set.
 * NULL: the default. */
const char *yscan_name_calibration(const struct ctl *ctl,
                                   char out[MEMORY_FROM_BYTES]);

/* The calibration of --calibration, or the default. Complains. */
enum exit_status yscan_load_calibration(const struct ctl *ctl,
                                        lum_calibration *out);

/* Fills count, udeg from a shape. Complains. */
enum exit_status yscan_fill(const lum_yscan_shape *shape,
                            const lum_calibration *calibration, size_t lines,
                            struct yscan_table *out);

/* Fills raw from udeg. Complains if a line lies outside an eye's span, or the
 * lines turn. */
enum exit_status yscan_encode(const struct ctl *ctl,
                              const lum_calibration *calibration,
                              struct yscan_table *table);

/* A note if a uniform scan of this many degrees around the horizon exceeds what
 * an eye sees. */
void yscan_note_view(const struct ctl *ctl, const lum_calibration *calibration,
                     unsigned fov_deg);

/* A note if the table is a compromise between two eyes. */
void yscan_note_eyes(const struct ctl *ctl, const struct yscan_table *table);

/* Draws a table on standard error, unless --quiet. */
void yscan_show(const struct ctl *ctl, const lum_calibration *calibration,
                const struct yscan_table *table);

/* A table for people. Returns out. */
const char *yscan_describe(const struct yscan_table *table,
                           char out[YSCAN_TEXT_BYTES]);

/* Whether an answer's debug texts speak of the table: the sensor refused it. */
bool yscan_is_refused(const char *debug);

#endif
