/** @file
 * Lines to points, in float (docs/protocol.md, section 7).
 *
 * x forward, y left, z up, in metres, in the frame of the sensor or that of
 * lum_projector_place(). No heap and no I/O; all state belongs to the caller. A
 * projector, once made, is only read, so threads may share it. */
#ifndef LUM_POINTS_H
#define LUM_POINTS_H

#include "lum/assembler.h"
#include "lum/calibration.h"
#include "lum/point_losses.h"
#include "lum/pose.h"
#include "lum/profile.h"
#include "lum/result.h"
#include "lum/returns.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** How one eye's samples become geometry. Private: made by
 * lum_projector_init(). */
typedef struct lum_eye_projector {
    double azimuth_rad;       /**< private: radians of a bit */
    double elevation_rad;     /**< private */
    double azimuth_deg;       /**< private: degrees of a bit */
    double elevation_deg;     /**< private */
    double azimuth_center;    /**< private: degrees */
    double elevation_center;  /**< private: degrees */
    double range_lsb;         /**< private: metres of a bit */
    double range_offset;      /**< private: metres */
    float center_sin;         /**< private: of the elevation's centre */
    float center_cos;         /**< private */
    float rotation[9];        /**< private: eye to sensor, row by row */
    float mount[3];           /**< private: metres */
    int32_t min_tof;          /**< private */
    bool narrow;              /**< private: a polynomial reaches all angles */
    double exact_rotation[9]; /**< private: source of the floats */
    double exact_mount[3];    /**< private: likewise */
} lum_eye_projector;

/** How a sensor's samples become points. */
typedef struct lum_projector {
    lum_eye_projector eye[LUM_EYES]; /**< private */
    double tof_lsb_ns;               /**< private */
} lum_projector;

/** Make a projector.
 * @param out         caller-owned; written only on LUM_OK.
 * @param calibration checked here; not kept.
 * @param layout      has the scale of angles: that of the assembler whose lines
 *                    will be projected; not kept.
 * @return LUM_OK; LUM_E_VALUE as lum_calibration_check(). */
LUM_MUST_CHECK lum_result lum_projector_init(lum_projector *out,
                                             const lum_calibration *calibration,
                                             const lum_layout *layout);

/** Make a projector give points in another frame, such as the vehicle's: x y z,
 * the box of a selection and lum_directions_compute() are then in that frame.
 * Range, azimuth and elevation stay those of the eye.
 * @param pose where the projector's frame is in the new one; its quaternion has
 *             length 1. It is composed in double with the mounts of the eyes,
 *             so points are as exact as without it. A second call composes both
 *             poses. */
void lum_projector_place(lum_projector *projector, const lum_pose *pose);

/** A unit vector in the frame of the sensor, padded to 16 bytes. */
typedef struct lum_direction {
    float x;   /**< forward */
    float y;   /**< left */
    float z;   /**< up */
    float pad; /**< 0 */
} lum_direction;

/** Where the pixels of a line look.
 * @param line its raw angles are read, of unmarked pixels too.
 * @param out  LUM_LINE_PIXELS directions.
 * Within 1e-6 of the exact vector. */
void lum_directions_compute(const lum_projector *projector,
                            const lum_line *line, lum_direction *out);

/** A point and the word it came from. */
typedef struct lum_point {
    float x;       /**< metres, forward */
    float y;       /**< metres, left */
    float z;       /**< metres, up */
    uint32_t word; /**< the range word: time of flight, edge, pixel */
} lum_point;

/** All words of a line to points, in their order.
 * @param directions of this line.
 * @param out        room for line->word_count points, and all of that room may
 *                   be written.
 * @param losses     words without a point are added to it.
 * @return how many points were written. Linear. */
size_t lum_points_compute(const lum_projector *projector, const lum_line *line,
                          const lum_direction *directions, lum_point *out,
                          lum_point_losses *losses);

/** Which code makes directions and points on this processor.
 * @return "avx512", "avx2", "sse2", "neon" or "plain" (C): the widest vectors
 *         that the processor has, or those that LUM_CPU in the environment
 *         named when this library was first used. All of them give the same
 *         bits. Constant; safe from any thread. */
const char *lum_points_vectors(void);

/** Count the words of a line that give a point and those that give none,
 * without projecting them.
 * @param rising  gets those of rising edges that give a point.
 * @param falling gets those of falling edges that give a point.
 * @param losses  words without a point are added to it. Linear. */
void lum_points_count(const lum_projector *projector, const lum_line *line,
                      uint64_t *rising, uint64_t *falling,
                      lum_point_losses *losses);

/** Mark the words of a line that give a point.
 * @param out a byte for each word of the line: 1 if its pixel has angles and
 *            its range is above 0, else 0. Linear. */
void lum_points_mark(const lum_projector *projector, const lum_line *line,
                     uint8_t *out);

/** A point with all its values. Frame, eye, line number and timestamp are those
 * of its line. */
typedef struct lum_sample {
    float x;                    /**< metres, forward */
    float y;                    /**< metres, left */
    float z;                    /**< metres, up */
    float range;                /**< metres from the eye, before the mount */
    float azimuth;              /**< degrees, of the eye, before the mount */
    float elevation;            /**< degrees, of the eye, before the mount */
    float pulse_width;          /**< nanoseconds; 0 where unknown */
    uint16_t pixel;             /**< 0..999 */
    uint16_t return_number;     /**< from 1 */
    uint16_t number_of_returns; /**< of the pixel and edge */
    uint8_t edge;               /**< 1 rising, 0 falling */
    uint8_t pad;                /**< 0 */
} lum_sample;

/** Which edges are requested. */
typedef enum lum_edges {
    LUM_EDGES_RISING = 1,  /**< only rising */
    LUM_EDGES_FALLING = 2, /**< only falling */
    LUM_EDGES_BOTH = 3     /**< both */
} lum_edges;

/** Which returns of a pixel and edge are requested, among all of them, before
 * limits of range and box apply. */
typedef enum lum_return_choice {
    LUM_RETURNS_ALL,       /**< every one */
    LUM_RETURNS_FIRST,     /**< the first */
    LUM_RETURNS_LAST,      /**< the last */
    LUM_RETURNS_STRONGEST, /**< the widest pulse, the first among equals */
    LUM_RETURNS_NUMBER     /**< the one with return_number */
} lum_return_choice;

/** What is requested of a line. */
typedef struct lum_selection {
    lum_edges edges;           /**< edges */
    lum_return_choice returns; /**< returns */
    uint16_t return_number;    /**< with LUM_RETURNS_NUMBER, from 1 */
    bool has_range;            /**< whether range limits apply */
    bool has_box;              /**< whether the box applies */
    float range_min;           /**< metres, included */
    float range_max;           /**< metres, included */
    float box_min[3];          /**< metres: x, y, z, included */
    float box_max[3];          /**< metres: x, y, z, included */
} lum_selection;

/** Working memory of lum_samples_compute(); content is private. */
typedef struct lum_sample_workspace {
    lum_direction directions[LUM_LINE_PIXELS]; /**< private */
    lum_return *returns; /**< caller's: as many as a line can have words */
} lum_sample_workspace;

/** All rising returns, no limits. Cannot fail. */
void lum_selection_default(lum_selection *out);

/** A line to samples, those that a selection requests, in the order of words.
 * @param workspace caller-owned; its returns hold line->word_count entries.
 * @param out       room for line->word_count samples.
 * @param losses    words without a point are added, of all edges and returns,
 *                  selected or not; NULL: they are not counted, which is
 *                  faster.
 * @return how many samples were written. Linear. */
size_t lum_samples_compute(const lum_projector *projector, const lum_line *line,
                           const lum_selection *selection,
                           lum_sample_workspace *workspace, lum_sample *out,
                           lum_point_losses *losses);

#ifdef __cplusplus
}
#endif

#endif
