/* Section 7 of docs/protocol.md in double, for one eye of one calibration:
 * sines and cosines of all raw angles are computed once. */
#ifndef LUM_TESTS_FIXED_REFERENCE_H
#define LUM_TESTS_FIXED_REFERENCE_H

#include "lum/calibration.h"
#include "lum/profile.h"

#include <stdbool.h>
#include <stdint.h>

#define RAW_VALUES 65536u

/* Of one raw angle. */
typedef struct wave {
    double sine;
    double cosine;
} wave;

typedef struct reference {
    wave azimuth[RAW_VALUES];   /* by raw + 32768 */
    wave elevation[RAW_VALUES]; /* likewise */
    double rotation[9];         /* row by row */
    double mount_mm[3];
    int64_t lsb_fs;
    int64_t offset_fs;
    double mm_per_fs;
} reference;

void reference_init(reference *out, const lum_calibration *calibration,
                    unsigned eye, uint64_t angle_lsb_pdeg);

/* Whether a time of flight gives a point, exactly. */
bool reference_has_range(const reference *r, int32_t tof);

/* From the eye, before the mount. */
double reference_range_mm(const reference *r, int32_t tof);

/* The smallest and the largest time of flight whose range is above zero and at
 * most this; false where there are none. */
bool reference_reach(const reference *r, double range_mm, int32_t *nearest,
                     int32_t *farthest);

void reference_point_mm(const reference *r, int32_t tof, int32_t azimuth,
                        int32_t elevation, double out[3]);

#endif
