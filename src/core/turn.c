#include "turn.h"

#include "product.h"

#include <string.h>

/* A sum of 720e6 microdegrees has a mean of one turn, 2^32 units: 6 less this /
 * 2^32 units for each of the sum. */
#define TURNS_PER_UDEG 149325896

uint32_t lum_turn_from_udeg(int32_t sum_udeg)
{
    return (uint32_t)sum_udeg * 6u -
           (uint32_t)high_product(sum_udeg, TURNS_PER_UDEG, 0);
}

/* An angle's sine and cosine, 2^-30. */
typedef struct turn {
    int32_t sine;
    int32_t cosine;
} turn;

/* Over an eighth of a turn to either side, y = -1..1, the sine is y P(y^2) and
 * the cosine 1 + y^2 Q(y^2), with least largest error: 1.3e-9 and 3.3e-8. Each
 * step multiplies by y^2 in 2^-30 and so takes 2 bits of fraction: from 2^-37
 * to 2^-31 and from 2^-36 to 2^-30. */
static inline void approximate(uint32_t angle, turn *out)
{
    /* what the nearest quarter leaves fills a word when it is times 4 */
    const int32_t y = (int32_t)(angle << 2);
    const int32_t y2 = high_product(y, y, 0);
    int32_t s = high_product(-4930933, y2, 85551349);
    s = high_product(s, y2, -693597423);
    s = high_product(s, y2, 1686629690);
    s = high_product(s, y, 0);
    int32_t c = high_product(-21932519, y2, 272307758);
    c = high_product(c, y2, -1324673091);
    out->sine = s;
    out->cosine = high_product(c, y2, INT32_C(1) << 30);
}

/* From the nearest quarter of a turn to the angle itself. */
static inline void turn_quarters(uint32_t angle, turn *t)
{
    const uint32_t quarters = angle + (UINT32_C(1) << 29);
    if (quarters >> 30 == 0) {
        return;
    }
    if ((quarters & (UINT32_C(1) << 30)) != 0) {
        const int32_t was = t->sine;
        t->sine = t->cosine;
        t->cosine = -was;
    }
    if ((quarters & (UINT32_C(1) << 31)) != 0) {
        t->sine = -t->sine;
        t->cosine = -t->cosine;
    }
}

static LUM_ONE_COPY void set_turn(turn *out, uint32_t angle)
{
    approximate(angle, out);
    turn_quarters(angle, out);
}

/* The 2^-28 that high_product() makes of two numbers of 2^-30, as 2^-30. */
static int32_t quadruple(int32_t v)
{
    return (int32_t)((uint32_t)v * 4u);
}

/* Turns the eye from an axis to the next. */
static void turn_axes(int32_t from[3], int32_t to[3], int32_t udeg)
{
    const uint32_t angle = lum_turn_from_udeg(2 * udeg);
    turn t;
    set_turn(&t, angle);
    for (unsigned i = 0; i < 3; i++) {
        const int32_t turned =
            high_product(from[i], t.cosine, 0) - high_product(to[i], t.sine, 0);
        const int32_t rest = high_product(to[i], t.cosine, 0);
        to[i] = quadruple(high_product(from[i], t.sine, rest));
        from[i] = quadruple(turned);
    }
}

void lum_turn_axes(const lum_eye_calibration *eye, int32_t out[3][3])
{
    memset(out, 0, 3 * sizeof out[0]);
    for (unsigned i = 0; i < 3; i++) {
        out[i][i] = INT32_C(1) << 30;
    }
    turn_axes(out[0], out[1], eye->azimuth_center_udeg);
    turn_axes(out[1], out[2], eye->mount_roll_udeg);
    turn_axes(out[2], out[0], eye->mount_pitch_udeg);
    turn_axes(out[0], out[1], eye->mount_yaw_udeg);
}

/* How far a vector of length 1 goes along another: both 2^-30, this 2^-28. */
static LUM_ONE_COPY int32_t project(const int32_t a[3], const int32_t b[3])
{
    return (int32_t)((product(a[0], b[0]) + product(a[1], b[1]) +
                      product(a[2], b[2])) >>
                     32);
}

/* What is left of a bit times any raw angle is below 2^30. */
static inline uint32_t angle_of(const lum_fixed_axis *axis, int32_t raw)
{
    return axis->center + (uint32_t)raw * axis->whole +
           (uint32_t)((raw * axis->part) >> 15);
}

void lum_turn_look(const lum_fixed_eye *eye, const lum_angle *angle,
                   int32_t out[3])
{
    turn az;
    turn el;
    const uint32_t a = angle_of(&eye->azimuth, angle->azimuth);
    const uint32_t e = angle_of(&eye->elevation, angle->elevation);
#if LUM_BY_PARTS
    set_turn(&az, a);
    set_turn(&el, e);
#else
    /* side by side: what both need is loaded once */
    approximate(a, &az);
    approximate(e, &el);
    turn_quarters(a, &az);
    turn_quarters(e, &el);
#endif
    const int32_t look[3] = {quadruple(high_product(el.cosine, az.cosine, 0)),
                             quadruple(high_product(el.cosine, az.sine, 0)),
                             el.sine};
    out[0] = project(eye->axes[0], look);
    out[1] = project(eye->axes[1], look);
    out[2] = project(eye->axes[2], look);
}
