#include "lum/pose.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* The quaternion of first b, then a. */
static void multiply(const double a[4], const double b[4], double out[4])
{
    out[0] = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1];
    out[1] = a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0];
    out[2] = a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3];
    out[3] = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2];
}

/* Turn a vector: v + 2 q x (q x v + w v). */
static void rotate(const double q[4], const double v[3], double out[3])
{
    const double u[3] = {
        q[1] * v[2] - q[2] * v[1] + q[3] * v[0],
        q[2] * v[0] - q[0] * v[2] + q[3] * v[1],
        q[0] * v[1] - q[1] * v[0] + q[3] * v[2],
    };
    const double turned[3] = {
        v[0] + 2.0 * (q[1] * u[2] - q[2] * u[1]),
        v[1] + 2.0 * (q[2] * u[0] - q[0] * u[2]),
        v[2] + 2.0 * (q[0] * u[1] - q[1] * u[0]),
    };
    memcpy(out, turned, sizeof turned);
}

/* The length of the vector part: the sine of half the angle. */
static double half_sine(const double q[4])
{
    return sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2]);
}

lum_pose lum_pose_identity(void)
{
    const lum_pose identity = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 1.0}};
    return identity;
}

lum_pose lum_pose_of_angles(const double at[3], double roll_deg,
                            double pitch_deg, double yaw_deg)
{
    const double half_degree = 3.14159265358979323846 / 360.0;
    const double roll = roll_deg * half_degree;
    const double pitch = pitch_deg * half_degree;
    const double yaw = yaw_deg * half_degree;
    const double x[4] = {sin(roll), 0.0, 0.0, cos(roll)};
    const double y[4] = {0.0, sin(pitch), 0.0, cos(pitch)};
    const double z[4] = {0.0, 0.0, sin(yaw), cos(yaw)};
    lum_pose out = {.at = {at[0], at[1], at[2]}};
    double zy[4];
    multiply(z, y, zy);
    multiply(zy, x, out.turn);
    return out;
}

bool lum_pose_normalize(lum_pose *pose)
{
    const double *q = pose->turn;
    /* Beyond the sum, hypot() neither overflows nor vanishes. */
    const double length = hypot(hypot(q[0], q[1]), hypot(q[2], q[3]));
    const double sum = pose->at[0] - pose->at[0] + (pose->at[1] - pose->at[1]) +
                       (pose->at[2] - pose->at[2]);
    const bool has_length = length > 0.0 && length <= DBL_MAX;
    if (!has_length || sum != 0.0) {
        return false;
    }
    for (int i = 0; i < 4; i++) {
        pose->turn[i] /= length;
    }
    return true;
}

lum_pose lum_pose_compose(const lum_pose *outer, const lum_pose *inner)
{
    lum_pose out = {.at = {0.0}};
    lum_pose_apply(outer, inner->at, out.at);
    multiply(outer->turn, inner->turn, out.turn);
    return out;
}

lum_pose lum_pose_inverse(const lum_pose *pose)
{
    lum_pose out = {.turn = {-pose->turn[0], -pose->turn[1], -pose->turn[2],
                             pose->turn[3]}};
    const double back[3] = {-pose->at[0], -pose->at[1], -pose->at[2]};
    rotate(out.turn, back, out.at);
    return out;
}

/* How far along the screw `whole` its share is. The part of its path along the
 * axis grows evenly. The part across it is a chord of a circle: the chord of a
 * share of the angle is shorter by the sines of the half angles, and turned
 * back by half of the angle that is left. */
static lum_pose go_share(const lum_pose *whole, double share)
{
    const double *q = whole->turn;
    const double sine = half_sine(q);
    if (sine < 1e-9) { /* straight on */
        lum_pose out = *whole;
        for (int i = 0; i < 3; i++) {
            out.at[i] *= share;
            out.turn[i] *= share;
        }
        return out;
    }
    const double half = atan2(sine, q[3]);
    const double scale = sin(share * half) / sine;
    const double lean = 0.5 * (share - 1.0) * half;
    const double back = sin(lean) / sine;
    const double turn[4] = {q[0] * back, q[1] * back, q[2] * back, cos(lean)};
    const double along =
        (q[0] * whole->at[0] + q[1] * whole->at[1] + q[2] * whole->at[2]) /
        (sine * sine);
    lum_pose out;
    double across[3];
    for (int i = 0; i < 3; i++) {
        across[i] = whole->at[i] - along * q[i];
        out.turn[i] = q[i] * scale;
    }
    out.turn[3] = cos(share * half);
    rotate(turn, across, across);
    for (int i = 0; i < 3; i++) {
        out.at[i] = along * q[i] * share + across[i] * scale;
    }
    return out;
}

lum_pose lum_pose_between(const lum_pose *a, const lum_pose *b, double share)
{
    const lum_pose back = lum_pose_inverse(a);
    lum_pose whole = lum_pose_compose(&back, b);
    if (whole.turn[3] < 0.0) {
        for (int i = 0; i < 4; i++) {
            whole.turn[i] = -whole.turn[i];
        }
    }
    const lum_pose part = go_share(&whole, share);
    return lum_pose_compose(a, &part);
}

void lum_pose_matrix(const lum_pose *pose, double out[12])
{
    static const double axes[3][3] = {
        {1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    for (int column = 0; column < 3; column++) {
        double turned[3];
        rotate(pose->turn, axes[column], turned);
        for (int row = 0; row < 3; row++) {
            out[4 * row + column] = turned[row];
        }
        out[4 * column + 3] = pose->at[column];
    }
}

void lum_pose_apply(const lum_pose *pose, const double in[3], double out[3])
{
    double turned[3];
    rotate(pose->turn, in, turned);
    for (int i = 0; i < 3; i++) {
        out[i] = turned[i] + pose->at[i];
    }
}

double lum_pose_angle(const lum_pose *a, const lum_pose *b)
{
    const lum_pose back = lum_pose_inverse(a);
    double turn[4];
    multiply(back.turn, b->turn, turn);
    return 2.0 * atan2(half_sine(turn), fabs(turn[3]));
}
