/** @file
 * Where a sensor that moves is at a time.
 *
 * A course is made of straight lines and arcs; one that closes is driven round
 * and round, and comes back to exactly where it began. */
#ifndef LUM_SIM_PATH_H
#define LUM_SIM_PATH_H

#include "lum/pose.h"

#include <stdbool.h>
#include <stddef.h>

/** Which way it takes. */
typedef enum lum_path_kind {
    LUM_PATH_NONE,        /**< as a place has it without one */
    LUM_PATH_STRAIGHT,    /**< along x */
    LUM_PATH_CIRCLE,      /**< round; in a town round the block, to the right */
    LUM_PATH_EIGHT,       /**< to the left, then to the right */
    LUM_PATH_STOP_AND_GO, /**< straight, or in a town round the block: it stops
                               every ::LUM_PATH_CYCLE_S */
    LUM_PATH_POSES        /**< along given ones */
} lum_path_kind;

/** Of stop-and-go: it gains speed, keeps it, loses it and stands, a quarter of
 * this time each. */
#define LUM_PATH_CYCLE_S 12.0

/** One piece of a course. */
typedef struct lum_path_piece {
    double length_m;
    double radius_m; /**< above 0 to the left, below 0 to the right, 0:
                          straight */
} lum_path_piece;

/** A course. Static data. */
typedef struct lum_course {
    double at[3];                 /**< where it begins, along x */
    const lum_path_piece *pieces; /**< it closes with the last one; none: it is
                                       straight, without end */
    size_t count;
} lum_course;

/** A path. */
typedef struct lum_path {
    lum_path_kind kind;
    double velocity_m_s;   /**< but for given poses: largest one, above 0 */
    lum_course course;     /**< likewise; set by who knows the place */
    const lum_pose *poses; /**< given ones: kept, not copied */
    const double *times_s; /**< of each; they rise; kept, not copied */
    size_t count;          /**< of these, at least 1 */
} lum_path;

/** How long one round of a course is, metres; 0: it has no end. */
double lum_course_length(const lum_course *course);

/** Where what follows the path is. Before and after given poses it is at the
 * first and at the last.
 * @param time_s since the beginning of the drive. */
lum_pose lum_path_at(const lum_path *path, double time_s);

/** No part of it is faster; m/s.
 * @param lever_m how far what moves is from what follows the path. */
double lum_path_fastest(const lum_path *path, double lever_m);

#endif
