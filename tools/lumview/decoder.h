/* Records to pictures: reassembly, and the points of each view that is wanted
 * while a frame comes in. One thread's at a time. */
#ifndef LUMVIEW_DECODER_H
#define LUMVIEW_DECODER_H

#include "stage.h"
#include "view_picture.h"

#include "lum/capture/capture.h"
#include "lum/capture/demux.h"
#include "lum/host/rig.h"

#include <stdbool.h>
#include <stdint.h>

struct decoder;

struct decoder_options {
    const lum_layout *layout;
    const lum_projector *projector;
    const lum_layout *second_layout; /* of a profile beside it; or NULL */
    const lum_projector *second_projector;
    const lum_rig_member *members; /* the sensors of a rig; then no second
                                      layout */
    size_t member_count;           /* 0: no rig */
    const lum_rig *rig; /* their names; NULL: one alone is shown, as without */
    struct sensor_choice sensor;
    bool makes_no_points; /* frames have none, whatever is wanted */
    struct stage *stage;  /* has the views that are wanted */
};

enum decoded {
    DECODED_ALL,   /* the record was taken */
    DECODED_FRAME, /* a frame is complete: push the same record again */
    DECODED_FAILED /* there was no memory */
};

/* To be freed by decoder_free(); NULL without memory. */
struct decoder *decoder_new(const struct decoder_options *options);
void decoder_free(struct decoder *decoder);

/* Frames before this one are skipped: not made, reported or counted. Of a rig
 * frames are pictures of all sensors, by numbers of their own from 1 on. */
void decoder_skip_to(struct decoder *decoder, int64_t frame);

/* As lum_framer_set_interface(). */
void decoder_set_interface(struct decoder *decoder, const char *name);

/* What the other has learned of the sensors' clocks is known from the first
 * line on. Called before any push. False: there was no memory. */
bool decoder_learn(struct decoder *decoder, const struct decoder *from);

enum decoded decoder_push(struct decoder *decoder, const lum_record *record);

/* The end of the source: as decoder_push(), until it returns DECODED_ALL. */
enum decoded decoder_flush(struct decoder *decoder);

/* The frame of DECODED_FRAME; to be shown or dropped before the next push. */
struct picture *decoder_picture(struct decoder *decoder);

/* What alone makes its frames, to go elsewhere in a capture before any push;
 * NULL: there are several. */
lum_framer *decoder_framer(struct decoder *decoder);

/* Whether what it takes has to be read from its start, as records that were
 * passed over would have said whose it is. */
bool decoder_is_lost(const struct decoder *decoder);

/* The first and the last frame so far, those that were passed over too. False:
 * none yet. */
bool decoder_range(const struct decoder *decoder, int64_t *first,
                   int64_t *last);

void decoder_count(const struct decoder *decoder, struct totals *out);

/* Tell the stage what does not fit the layout, and how to find the right one in
 * captures or, where they are NULL, with a sensor, "udp://ADDRESS". What has
 * been told stays. */
void decoder_tell_doubt(const struct decoder *decoder,
                        const struct sources *captures, const char *sensor);

/* Frames of a rig that were left out as gather_put() says; sensor gets the name
 * of the latest. */
uint64_t decoder_late(const struct decoder *decoder, const char **sensor);

/* What counts what it takes. */
const lum_demux *decoder_demux(const struct decoder *decoder);

/* Sensors that are not shown, where there is no rig, as text: "" or
 * "10.42.0.38, 10.42.0.39". Returns out. shown gets the one that is, "" before
 * it was heard. */
const char *decoder_others(const struct decoder *decoder,
                           char shown[LUM_SENSOR_NAME_BYTES], char *out,
                           size_t room);

#endif
