/** @file
 * The directions of a line's beams: the mirror's motion, the true angles of
 * each pixel, and the readings of the encoders.
 *
 * Line 0 is the uppermost. Azimuth moves back and forth, lines of even number
 * from left to right, and slows down towards both ends. Both eyes move in the
 * same way. */
#ifndef LUM_SIM_SCAN_H
#define LUM_SIM_SCAN_H

#include "lum/calibration.h"
#include "lum/group.h"
#include "lum/profile.h"
#include "lum/result.h"
#include "random.h"

#include <stdint.h>

/** Standard deviation of an encoder's reading, degrees. */
#define LUM_SCAN_NOISE_DEG 0.005

/** How one eye scans. Private: made by lum_scan_init(). */
typedef struct lum_scan_eye {
    float azimuth_deg[LUM_LINE_PIXELS]; /**< private: of an even line */
    float azimuth_sin[LUM_LINE_PIXELS]; /**< private */
    float azimuth_cos[LUM_LINE_PIXELS]; /**< private */
    float bend_deg[LUM_LINE_PIXELS];    /**< private: of every line */
    float bend_sin[LUM_LINE_PIXELS];    /**< private */
    float bend_cos[LUM_LINE_PIXELS];    /**< private */
    double azimuth_center;              /**< private: degrees */
    double azimuth_span;                /**< private: degrees */
    double elevation_center;            /**< private: degrees */
    double elevation_span;              /**< private: degrees */
    double azimuth_bits;                /**< private: of a degree */
    double elevation_bits;              /**< private: of a degree */
    float rotation[9];                  /**< private: eye to sensor */
    float mount[3];                     /**< private: metres */
    double wrong_deg[LUM_LINE_PIXELS];  /**< private: of an even line */
    double wrong_height;                /**< private: of a sine, degrees */
    double wrong_phase;                 /**< private: that of elevation */
    const int32_t *elevations_udeg;     /**< private: NULL: the whole span */
} lum_scan_eye;

/** How a sensor scans. */
typedef struct lum_scan {
    lum_scan_eye eye[LUM_EYES]; /**< private */
    uint32_t lines;             /**< of a frame */
} lum_scan;

/** A scanned line. */
typedef struct lum_scan_line {
    float azimuth[LUM_LINE_PIXELS];      /**< true, degrees, of the eye */
    float elevation[LUM_LINE_PIXELS];    /**< true, degrees, of the eye */
    float direction[LUM_LINE_PIXELS][3]; /**< unit, in the sensor's frame */
    lum_angle reading[LUM_LINE_PIXELS];  /**< as the packets have it */
} lum_scan_line;

/** Prepare a scan.
 * @param calibration checked.
 * @param lines       of a frame, at least 1.
 * @return LUM_OK; LUM_E_VALUE if the layout's angle_lsb cannot express the
 *         calibrated span in 16 bits. */
LUM_MUST_CHECK lum_result lum_scan_init(lum_scan *out,
                                        const lum_calibration *calibration,
                                        const lum_layout *layout,
                                        uint32_t lines);

/** Set the elevations of an eye's lines; after lum_scan_init() they cover the
 * whole span evenly.
 * @param elevations_udeg one for each line, the eye's own; those outside the
 *                        span are moved to its end. Kept, not copied. NULL: the
 *                        whole span. */
void lum_scan_aim(lum_scan *scan, unsigned eye, const int32_t *elevations_udeg);

/** Make the encoders wrong by a sine of one period over the span of each angle;
 * after lum_scan_init() they are right but for their noise.
 * @param height_deg height of the sine.
 * @param seed       gives the phases, of each eye and angle. */
void lum_scan_distort(lum_scan *scan, double height_deg, uint64_t seed);

/** Place of an eye in the frame of the sensor; metres. */
const float *lum_scan_mount(const lum_scan *scan, unsigned eye);

/** Scan a line.
 * @param line   below scan->lines.
 * @param random gives the encoders' noise. */
void lum_scan_compute(const lum_scan *scan, unsigned eye, uint32_t line,
                      lum_random *random, lum_scan_line *out);

#endif
