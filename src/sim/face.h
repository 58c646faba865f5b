/** @file
 * A flat face of a wall, a floor or a box: a rectangle, seen from both sides.
 *
 * Real walls are not flat, and a sensor measures walls of different paint at
 * slightly different ranges: a face can have waves and a bias. */
#ifndef LUM_SIM_FACE_H
#define LUM_SIM_FACE_H

#include <stdbool.h>
#include <stdint.h>

/** Waves of a face. */
#define LUM_FACE_WAVES 6

/** Shortest and longest wave, metres. */
#define LUM_FACE_WAVE_MIN_M 0.8f
#define LUM_FACE_WAVE_MAX_M 4.0f

/** One wave: height_m sin(a along_per_m + b up_per_m + phase) at a along the
 * face and b up. */
typedef struct lum_face_wave {
    float along_per_m; /**< radians */
    float up_per_m;    /**< radians */
    float phase;       /**< radians */
} lum_face_wave;

/** A face; where it stands is told by who has it. */
typedef struct lum_face {
    float along[3];  /**< unit vector of one side */
    float up[3];     /**< unit vector of the other side */
    float normal[3]; /**< unit vector, along x up */
    float half[2];   /**< of its sides along and up, metres */
    float height_m;  /**< of each wave; 0: it is flat */
    float bias_m;    /**< on top of each range that is measured to it */
    lum_face_wave waves[LUM_FACE_WAVES]; /**< where height_m is not 0 */
} lum_face;

/** Give a face waves and a bias by chance.
 * @param seed   with number it gives the same ones again.
 * @param rms_m  root mean square of the waves, at least 0.
 * @param bias_m standard deviation of the bias, at least 0. */
void lum_face_roughen(lum_face *face, uint64_t seed, unsigned number,
                      double rms_m, double bias_m);

/** How far the surface stands out along the normal; metres.
 * @param a along, from the middle.
 * @param b up, from the middle. */
float lum_face_height(const lum_face *face, float a, float b);

/** Where a beam from the origin hits the face.
 * @param middle of the face.
 * @param d      unit vector.
 * @param range  metres; written only if the result is true.
 * @param cosine of the angle of incidence, 0..1; as range. */
bool lum_face_cast(const lum_face *face, const float middle[3],
                   const float d[3], float *range, float *cosine);

#endif
