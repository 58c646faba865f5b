#include "turn.h"

/* The upper half of a product, rounded down, and a sum. */
static LUM_ONE_COPY int32_t multiply(int32_t a, int32_t b, int32_t sum)
{
    return (int32_t)(((int64_t)a * b) >> 32) + sum;
}

/* Two turns are 2^33 units and 720e6 microdegrees: 6 less this / 2^32 units for
 * each of them. */
#define TURNS_PER_UDEG 149325896

uint32_t lum_turn_from_udeg(int32_t sum_udeg)
{
    return (uint32_t)sum_udeg * 6u -
           (uint32_t)multiply(sum_udeg, TURNS_PER_UDEG, 0);
}

/* Over an eighth of a turn to either side, y = -1..1, the sine is y P(y^2) and
 * the cosine 1 + y^2 Q(y^2), with least largest error: 1.3e-9 and 3.3e-8. Each
 * step multiplies by y^2 in 2^-30 and so takes 2 bits of fraction: from 2^-37
 * to 2^-31 and from 2^-36 to 2^-30. */
static LUM_ONE_COPY void compute(uint32_t angle, lum_fixed_turn *out)
{
    /* what the nearest quarter leaves fills a word when it is times 4 */
    const int32_t y = (int32_t)(angle << 2);
    const int32_t y2 = multiply(y, y, 0);
    int32_t s = multiply(-4930933, y2, 85551349);
    s = multiply(s, y2, -693597423);
    s = multiply(s, y2, 1686629690);
    s = multiply(s, y, 0);
    int32_t c = multiply(-21932519, y2, 272307758);
    c = multiply(c, y2, -1324673091);
    c = multiply(c, y2, INT32_C(1) << 30);
    angle += UINT32_C(1) << 29;
    if (angle >> 30 != 0) {
        const int32_t was = s;
        if ((angle & (UINT32_C(1) << 30)) != 0) {
            s = c;
            c = -was;
        }
        if ((angle & (UINT32_C(1) << 31)) != 0) {
            s = -s;
            c = -c;
        }
    }
    out->sine = s;
    out->cosine = c;
}

void lum_turn_compute(int32_t udeg, lum_fixed_turn *out)
{
    compute(lum_turn_from_udeg(2 * udeg), out);
}

/* The 2^-28 that multiply() makes of two numbers of 2^-30, as 2^-30. */
static int32_t quadruple(int32_t v)
{
    return (int32_t)((uint32_t)v * 4u);
}

/* Turn a vector from an axis to the next. */
static LUM_ONE_COPY void turn(int32_t *from, int32_t *to,
                              const lum_fixed_turn *t)
{
    const int32_t a = *from;
    const int32_t b = *to;
    *from = quadruple(multiply(a, t->cosine, 0) - multiply(b, t->sine, 0));
    *to = quadruple(multiply(a, t->sine, multiply(b, t->cosine, 0)));
}

/* What is left of a bit times any raw angle is below 2^30. */
static LUM_ONE_COPY void compute_axis(const lum_fixed_axis *axis, int32_t raw,
                                      lum_fixed_turn *out)
{
    compute(axis->center + (uint32_t)raw * axis->whole +
                (uint32_t)((raw * axis->part) >> 15),
            out);
}

void lum_turn_look(const lum_fixed_eye *eye, const lum_angle *angle,
                   int32_t out[3])
{
    lum_fixed_turn az;
    lum_fixed_turn el;
    compute_axis(&eye->azimuth, angle->azimuth, &az);
    compute_axis(&eye->elevation, angle->elevation, &el);
    int32_t x = quadruple(multiply(el.cosine, az.cosine, 0));
    int32_t y = quadruple(multiply(el.cosine, az.sine, 0));
    int32_t z = el.sine;
    if (eye->tilt != 0) {
        turn(&y, &z, &eye->roll);
        turn(&z, &x, &eye->pitch);
    }
    turn(&x, &y, &eye->yaw);
    out[0] = x;
    out[1] = y;
    out[2] = z;
}
