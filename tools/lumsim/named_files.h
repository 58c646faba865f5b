/* The files that options name: what is read of them, and that none is two
 * things. */
#ifndef LUMSIM_NAMED_FILES_H
#define LUMSIM_NAMED_FILES_H

#include "lum/base/error.h"
#include "options.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Whether the named files can be used as intended; prints the error. */
bool files_check(const struct options *o);

/* Read calibration and profile into o->render; complains. */
bool files_load(struct options *o);

/* Where the profile is from, for messages. */
const char *layout_source(const struct options *o);

/* Take a profile's layout into o->render. False: packets cannot be made of it;
 * complains. */
bool layout_take(struct options *o, const lum_profile *profile);

/* Write the capture of the options. Returns the exit status. */
int offline_run(const struct options *o);

/* The data packets of one sensor of a capture, as they were recorded. */
struct recording;

struct recorded {
    int64_t time_ns;      /* of capture */
    const uint8_t *bytes; /* live until the next one is read */
    size_t len;
};

/* What a first look at it shows. */
struct recording_facts {
    uint64_t packets;
    size_t longest; /* bytes */
    int64_t first_ns;
    int64_t last_ns;
    bool is_cut_off;  /* it cannot be read to its end */
    lum_error damage; /* what of it was passed over, as a message; or "" */
};

/* Look through a capture and open it. path: kept. 0, or -1 with the reason in
 * error. */
int recording_open(const char *path, const lum_layout *layout,
                   const struct replayed_sensor *sensor, struct recording **out,
                   struct recording_facts *facts, lum_error *error);

/* As lum_capture_remark(), until recording_rewind(). */
bool recording_remark(const struct recording *recording, size_t i,
                      lum_error *out);

/* 1 with a packet; 0 at the end, or where it cannot be read any further; -1
 * with the reason in error if it is not open. */
int recording_next(struct recording *recording, struct recorded *out,
                   lum_error *error);

/* Start again. 0, or -1 with the reason in error. */
int recording_rewind(struct recording *recording, lum_error *error);

/* NULL is allowed. */
void recording_close(struct recording *recording);

#endif
