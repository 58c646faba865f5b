/** @file
 * What the beams of a line meet in a place, at the start of a frame, or where
 * the sensor has a path each at its own time. In a still place each line is
 * looked at once, and kept. */
#ifndef LUM_SIM_SIGHT_H
#define LUM_SIM_SIGHT_H

#include "lum/group.h"
#include "lum/result.h"
#include "place.h"
#include "scan.h"
#include "scene.h"

#include <stdint.h>

/** What the beams of a line meet. */
typedef struct lum_sight_line {
    uint8_t counts[LUM_LINE_PIXELS]; /**< hits of each pixel */
    lum_hit *hits;                   /**< by pixel, near to far */
} lum_sight_line;

/** The sight of both eyes. Private except its size; not to be moved. */
typedef struct lum_sight {
    lum_place place;                /**< private */
    lum_scene scenes[LUM_EYES];     /**< private */
    unsigned scene_of[LUM_EYES];    /**< private */
    float mounts[LUM_EYES][3];      /**< private */
    uint32_t lines;                 /**< private */
    double rate_hz;                 /**< private */
    double begin_s;                 /**< private: of the first frame */
    int64_t frame;                  /**< private: that the scenes are set for */
    lum_section section;            /**< private: of the first scene, if the
                                         place moves */
    int64_t section_number;         /**< private: from 1 */
    double fastest;                 /**< private: m/s */
    double half_view;               /**< private: azimuths that are scanned,
                                         radians; 0: not known yet */
    lum_sight_line work;            /**< private */
    lum_sight_line *kept[LUM_EYES]; /**< private: all lines of a still place;
                                         hits NULL: not seen yet */
} lum_sight;

/** Begin.
 * @param out     to be freed with lum_sight_free().
 * @param scan    gives the places of the eyes and the number of lines.
 * @param rate_hz frames a second, above 0.
 * @param begin_s when the first frame begins, since that of the drive. */
void lum_sight_init(lum_sight *out, const lum_place_options *options,
                    uint64_t seed, const lum_scan *scan, double rate_hz,
                    double begin_s);

/** Free what it holds. */
void lum_sight_free(lum_sight *sight);

/** The place that it looks at. */
const lum_place *lum_sight_place(const lum_sight *sight);

/** Look along a line. Fast when lines of one frame come after each other.
 * @param frame from 1.
 * @param time_s when the line begins, since the beginning of the drive; of a
 *               place that moves.
 * @param scan  the line, as lum_scan_compute() makes it for this number and
 *              eye.
 * @param out   lives until the next call.
 * @return LUM_OK; LUM_E_SPACE when there is no memory. */
LUM_MUST_CHECK lum_result lum_sight_look(lum_sight *sight, int64_t frame,
                                         uint32_t line, unsigned eye,
                                         double time_s,
                                         const lum_scan_line *scan,
                                         const lum_sight_line **out);

#endif
