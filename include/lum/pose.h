/** @file
 * Poses: where a moving frame is in a fixed one, such as the sensor in the
 * world.
 *
 * No heap and no I/O; functions on the caller's structs, from any thread. A
 * quaternion has length 1: lum_pose_normalize() ensures that, and the other
 * functions keep it up to rounding. */
#ifndef LUM_POSE_H
#define LUM_POSE_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Where a moving frame is in a fixed one. */
typedef struct lum_pose {
    double at[3];   /**< metres: the moving frame's origin in the fixed one */
    double turn[4]; /**< unit quaternion x, y, z, w: turns directions of the
                         moving frame into the fixed one */
} lum_pose;

/** The pose of a frame in itself. */
lum_pose lum_pose_identity(void);

/** The pose Rz(yaw) Ry(pitch) Rx(roll), then + at, as for an eye's mount.
 * @param at metres: x, y, z. Angles in degrees, all finite. */
lum_pose lum_pose_of_angles(const double at[3], double roll_deg,
                            double pitch_deg, double yaw_deg);

/** Scale the quaternion to length 1.
 * @return false if a number is not finite or the quaternion is 0; then the pose
 *         is untouched. */
bool lum_pose_normalize(lum_pose *pose);

/** Two poses, one after the other: `outer` is where the frame B is in the frame
 * A, `inner` where C is in B. Returns where C is in A. */
lum_pose lum_pose_compose(const lum_pose *outer, const lum_pose *inner);

/** Where the fixed frame is in the moving one. */
lum_pose lum_pose_inverse(const lum_pose *pose);

/** A pose on the path from a to b, along the screw that joins them, with
 * constant velocity and turn rate: a exp(share log(a^-1 b)), the shorter way
 * round.
 * @param share 0: a, 1: b; the path goes on below 0 and above 1. */
lum_pose lum_pose_between(const lum_pose *a, const lum_pose *b, double share);

/** A pose as a matrix, 3 rows of 4: [R | t], for points as columns. */
void lum_pose_matrix(const lum_pose *pose, double out[12]);

/** A point of the moving frame in the fixed one; out may be in. */
void lum_pose_apply(const lum_pose *pose, const double in[3], double out[3]);

/** The angle of the turn from a to b, 0..pi radians. */
double lum_pose_angle(const lum_pose *a, const lum_pose *b);

#ifdef __cplusplus
}
#endif

#endif
