/** @file
 * A line of an eye, as the sensor would measure it: rays, returns, range words
 * and readings of the angles; and the exact points beside them.
 *
 * A sensor on a path, and all around it, moves while it scans; without one the
 * scene does not change during a frame. A line depends only on its seed, frame,
 * number and eye, not on the order of rendering. */
#ifndef LUM_SIM_RENDER_H
#define LUM_SIM_RENDER_H

#include "lum/calibration.h"
#include "lum/group.h"
#include "lum/points.h"
#include "lum/profile.h"
#include "lum/result.h"
#include "place.h"
#include "scan.h"
#include "scene.h"
#include "shape.h"
#include "sight.h"

#include <stddef.h>
#include <stdint.h>

/** Most returns of a pixel. */
#define LUM_RENDER_RETURNS_MAX 8u

/** Usual standard deviation of a range, metres. */
#define LUM_RENDER_NOISE_M 0.02f

/** Sensor clock at the beginning of the drive: some time after boot. */
#define LUM_RENDER_CLOCK_US INT64_C(5000000)

/** How a sensor runs among others. */
typedef struct lum_render_start {
    int64_t clock_us; /**< its clock when its first frame begins */
    int64_t late_us;  /**< this is so much after the beginning of the drive */
    double slow_ppm;  /**< its clock, and with it its frames, are slower by so
                           many millionths */
    uint32_t number;  /**< gives its noise and the errors of its encoders; 0:
                           those of a sensor alone */
} lum_render_start;

/** What to render. */
typedef struct lum_render_options {
    lum_calibration calibration; /**< checked */
    lum_layout layout;           /**< gives the scale of angles */
    lum_place_options place;     /**< what it looks at */
    uint64_t seed;               /**< of everything */
    uint32_t lines;              /**< of a frame, at least 1 */
    double rate_hz;              /**< frames a second, above 0 */
    lum_render_start start;      /**< usual: a sensor alone */
    unsigned returns_max;        /**< of a pixel, 1..LUM_RENDER_RETURNS_MAX */
    float noise_m[LUM_RENDER_RETURNS_MAX]; /**< standard deviation of the range
                                                of each return, metres */
    float gain;      /**< strength of all returns; 1 at full power */
    float threshold; /**< weakest return that is seen; 1 is usual */
    const int32_t *elevations_udeg[LUM_EYES]; /**< of each line, by ::lum_eye,
                                                   as lum_scan_aim(): kept, not
                                                   copied; NULL: the whole span
                                               */
} lum_render_options;

/** Most range words of a line. */
#define LUM_RENDER_WORDS_MAX (2u * LUM_RENDER_RETURNS_MAX * LUM_LINE_PIXELS)

/** A rendered line. */
typedef struct lum_sim_line {
    int64_t frame;      /**< from 1 */
    int64_t clock_us;   /**< sensor clock at its beginning */
    int64_t first_us;   /**< that of the first line of the drive */
    uint32_t number;    /**< within the frame */
    uint8_t eye;        /**< an ::lum_eye */
    size_t word_count;  /**< of words */
    size_t truth_count; /**< of truth */
    lum_angle angles[LUM_LINE_PIXELS];    /**< readings */
    uint32_t words[LUM_RENDER_WORDS_MAX]; /**< by pixel; for each return a
                                          rising word, then a falling one */
    lum_sample truth[LUM_RENDER_RETURNS_MAX *
                     LUM_LINE_PIXELS]; /**< the exact points of the rising
                                            words, in their order */
    lum_label labels[LUM_RENDER_RETURNS_MAX *
                     LUM_LINE_PIXELS]; /**< what each of these lies on */
} lum_sim_line;

/** lum_render_echoes() drops echoes below this strength, as a fraction of the
 * weakest return that is detected at the usual threshold. */
#define LUM_RENDER_FAINTEST 0.25f

/** A surface that a beam met, and what it sends back at full power. */
typedef struct lum_echo {
    float range;    /**< as measured without noise, metres */
    float strength; /**< 1: the weakest that is seen at usual threshold */
    float noise;    /**< of the range, in standard deviations */
} lum_echo;

/** All that the detector of one eye could detect of a line, before power and
 * threshold are applied. */
typedef struct lum_echo_line {
    int64_t clock_us;                  /**< sensor clock at its beginning */
    size_t count;                      /**< of echoes */
    lum_angle angles[LUM_LINE_PIXELS]; /**< readings */
    uint8_t counts[LUM_LINE_PIXELS];   /**< echoes of each pixel */
    lum_echo echoes[LUM_SCENE_HITS_MAX * LUM_LINE_PIXELS]; /**< by pixel, near
                                                                to far */
} lum_echo_line;

/** A renderer. Private except its size; not to be moved. */
typedef struct lum_render {
    lum_render_options options;  /**< private */
    lum_scan scan;               /**< private */
    lum_sight sight;             /**< private */
    lum_scan_line line;          /**< private */
    double tof_per_m;            /**< private */
    double tof_offset[LUM_EYES]; /**< private */
    double tof_per_ns;           /**< private */
    uint64_t noise_seed;         /**< private */
    float recovery_m;            /**< private */
} lum_render;

/** Usual options: the drive along the street, default calibration and layout,
 * 64 lines, 10 Hz, 4 returns, full power. Cannot fail. */
void lum_render_options_default(lum_render_options *out);

/** Begin.
 * @param out     to be freed with lum_render_free() after LUM_OK.
 * @param options copied.
 * @return LUM_OK; LUM_E_VALUE as lum_scan_init(). */
LUM_MUST_CHECK lum_result lum_render_init(lum_render *out,
                                          const lum_render_options *options);

/** Free what a renderer holds. */
void lum_render_free(lum_render *render);

/** Sensor clock at the beginning of a line; microseconds.
 * @param frame from 1. */
int64_t lum_render_clock_us(const lum_render *render, int64_t frame,
                            uint32_t line);

/** When the sensor's clock shows this, since the beginning of the drive;
 * nanoseconds. */
int64_t lum_render_drive_ns(const lum_render *render, int64_t clock_ns);

/** Where the sensor's vehicle, or the sensor if it is on none, is in the frame
 * of the place when a line begins, as it is rendered; lum_pose_between() two
 * lines is where each pixel is cast from. */
lum_pose lum_render_pose(const lum_render *render, int64_t frame,
                         uint32_t line);

/** Render a line. Fast when lines of one frame come after each other.
 * @param frame from 1.
 * @param line  below options.lines.
 * @param out   caller-owned; content undefined on failure.
 * @return LUM_OK; LUM_E_SPACE when there is no memory. */
LUM_MUST_CHECK lum_result lum_render_line(lum_render *render, int64_t frame,
                                          uint32_t line, unsigned eye,
                                          lum_sim_line *out);

/** Render the part of a line that does not depend on power and threshold;
 * options.gain and options.threshold are ignored. Parameters and results as
 * lum_render_line(). */
LUM_MUST_CHECK lum_result lum_render_echoes(lum_render *render, int64_t frame,
                                            uint32_t line, unsigned eye,
                                            lum_echo_line *out);

/** The range words that a detector makes of echoes. With gain 1 and threshold 1
 * they are those of lum_render_line() at the same.
 * @param counts    echoes of each of the LUM_LINE_PIXELS pixels.
 * @param echoes    all of them, by pixel.
 * @param gain      strength of all returns; with 0 there are none.
 * @param threshold weakest return that is detected; 1 is usual. Echoes below
 *                  LUM_RENDER_FAINTEST are missing with any threshold.
 * @param words     room for two of each echo, and for LUM_RENDER_WORDS_MAX at
 *                  most.
 * @return how many words. */
size_t lum_render_words(const lum_render *render, unsigned eye,
                        const uint8_t *counts, const lum_echo *echoes,
                        float gain, float threshold, uint32_t *words);

#endif
