/** @file
 * A line of an eye, as the sensor would measure it: rays, returns, range words
 * and readings of the angles; and the exact points beside them.
 *
 * The scene stands still during a frame. A line depends on its seed, frame,
 * number and eye alone, in whatever order lines are rendered. */
#ifndef LUM_SIM_RENDER_H
#define LUM_SIM_RENDER_H

#include "lum/calibration.h"
#include "lum/group.h"
#include "lum/points.h"
#include "lum/profile.h"
#include "lum/result.h"
#include "scan.h"
#include "scene.h"

#include <stddef.h>
#include <stdint.h>

/** Most returns of a pixel. */
#define LUM_RENDER_RETURNS_MAX 8u

/** Standard deviation of a range, metres. */
#define LUM_RENDER_NOISE_M 0.02f

/** Sensor clock at the beginning of the drive: some time after boot. */
#define LUM_RENDER_CLOCK_US INT64_C(5000000)

/** What to render. */
typedef struct lum_render_options {
    lum_calibration calibration; /**< checked */
    lum_layout layout;           /**< tells the scale of angles */
    uint64_t seed;               /**< of everything */
    uint32_t lines;              /**< of a frame, at least 1 */
    double rate_hz;              /**< frames a second, above 0 */
    unsigned returns_max;        /**< of a pixel, 1..LUM_RENDER_RETURNS_MAX */
    float gain;      /**< strength of all returns; 1 at full power */
    float threshold; /**< weakest return that is seen; 1 is usual */
} lum_render_options;

/** A rendered line. */
typedef struct lum_sim_line {
    int64_t frame;                     /**< from 1 */
    int64_t clock_us;                  /**< sensor clock at its beginning */
    uint32_t number;                   /**< within the frame */
    uint8_t eye;                       /**< an ::lum_eye */
    size_t word_count;                 /**< of words */
    size_t truth_count;                /**< of truth */
    lum_angle angles[LUM_LINE_PIXELS]; /**< readings */
    uint32_t words[2 * LUM_RENDER_RETURNS_MAX *
                   LUM_LINE_PIXELS]; /**< by pixel; for each return a rising
                                          word, then a falling one */
    lum_sample truth[LUM_RENDER_RETURNS_MAX *
                     LUM_LINE_PIXELS]; /**< the exact points of the rising
                                            words, in their order */
} lum_sim_line;

/** A renderer. Private but in size. */
typedef struct lum_render {
    lum_render_options options;  /**< private */
    lum_scan scan;               /**< private */
    lum_scene scenes[LUM_EYES];  /**< private */
    int64_t frame;               /**< private: that the scenes are set for */
    lum_scan_line line;          /**< private */
    double tof_per_m;            /**< private */
    double tof_offset[LUM_EYES]; /**< private */
    double tof_per_ns;           /**< private */
    unsigned scene_of[LUM_EYES]; /**< private */
} lum_render;

/** Usual options: default calibration and layout, 64 lines, 10 Hz, 4 returns,
 * full power. Cannot fail. */
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

/** Render a line. Fast when lines of one frame come after each other.
 * @param frame from 1.
 * @param line  below options.lines.
 * @param out   caller-owned; content undefined on failure.
 * @return LUM_OK; LUM_E_SPACE when there is no memory. */
LUM_MUST_CHECK lum_result lum_render_line(lum_render *render, int64_t frame,
                                          uint32_t line, unsigned eye,
                                          lum_sim_line *out);

#endif
