#include "lum/points_fixed.h"

#include "check.h"
#include "counter.h"
#include "product.h"
#include "turn.h"

#include <stddef.h>

/* 2^-47 turns in a picodegree, times 2^32: 2^79 / 360e12. */
#define TURNS_PER_PDEG UINT32_C(1679063638)

static void set_axis(lum_fixed_axis *out, int32_t sum_udeg, int32_t width_udeg,
                     const uint64_t *lsb_pdeg)
{
    /* 2^-47 turns a bit; half the width is 2^15 bits */
    uint64_t lsb = lum_turn_from_udeg(width_udeg);
    if (*lsb_pdeg != 0) {
        lsb = product_unsigned((uint32_t)(*lsb_pdeg >> 32), TURNS_PER_PDEG) +
              (product_unsigned((uint32_t)*lsb_pdeg, TURNS_PER_PDEG) >> 32);
    }
    out->center = lum_turn_from_udeg(sum_udeg);
    out->whole = (uint32_t)(lsb >> 15);
    out->part = (int32_t)(lsb & 0x7fffu);
}

/* A micrometre is 0.016 units, times 2^30; 1 km is below 2^54. Of that the
 * mount keeps 2^-28 units, as directions have them. */
#define MOUNT_PER_UM INT32_C(17179869)
#define MOUNT_HALF   (INT32_C(1) << 29)

/* Light goes out and back: a femtosecond at 1 m/s is 8e-12 units of range;
 * times 2^68. */
#define RANGE_PER_FS UINT32_C(2361183241)
#define RANGE_HALF   (UINT32_C(1) << 31)

static void set_range(lum_fixed_eye *out, const lum_calibration *c,
                      unsigned eye)
{
    /* 2^-40 units a femtosecond: up to 2.8e9, so below 2^32 */
    const uint32_t scale =
        (uint32_t)(product_unsigned(c->speed_of_light, RANGE_PER_FS) >> 28);
    const int32_t lsb_fs = (int32_t)c->tof_lsb_fs;
    out->first_tof = lum_calibration_min_tof(c, eye);
    /* of the first time of flight, in 8 femtoseconds: above 0, and below 2^31;
     * nothing uses it where none is long enough */
    const uint32_t base = (uint32_t)((c->eye[eye].tof_offset_fs +
                                      product(out->first_tof, lsb_fs)) >>
                                     3);
    out->range_lsb =
        (uint32_t)(product_unsigned((uint32_t)lsb_fs, scale) >> 20);
    out->range_base = product_unsigned(base, scale >> 5) + RANGE_HALF;
}

lum_result lum_fixed_projector_init(lum_fixed_projector *out,
                                    const lum_calibration *calibration,
                                    const lum_layout *layout)
{
    const lum_result r = lum_calibration_check(calibration, NULL, NULL);
    if (r != LUM_OK) {
        return r;
    }
    for (unsigned i = 0; i < LUM_EYES; i++) {
        const lum_eye_calibration *e = &calibration->eye[i];
        const uint64_t *lsb = &layout->profile.angle_lsb_pdeg;
        lum_fixed_eye *eye = &out->eye[i];
        set_axis(&eye->azimuth, 0, e->azimuth_width_udeg, lsb);
        set_axis(&eye->elevation, e->elevation_min_udeg + e->elevation_max_udeg,
                 e->elevation_max_udeg - e->elevation_min_udeg, lsb);
        lum_turn_axes(e, eye->axes);
        for (unsigned k = 0; k < 3; k++) {
            eye->mount[k] =
                (product(e->mount_um[k], MOUNT_PER_UM) + MOUNT_HALF) >> 2;
        }
        set_range(eye, calibration, i);
    }
    return LUM_OK;
}

/* Below 2^31 x 2^28 + 2^52 before the shift. */
static LUM_ONE_COPY int32_t place(const int64_t *mount, int32_t range,
                                  int32_t direction)
{
    return (int32_t)((*mount + product(range, direction)) >> 28);
}

static inline void put_point(const lum_fixed_eye *eye,
                             const int32_t direction[3], uint32_t bits,
                             lum_fixed_point *out)
{
    /* bits are below 2^20, a bit below 2^32, the range below 1.33e9 */
    const int32_t range =
        (int32_t)((eye->range_base +
                   product_unsigned(bits << 12, eye->range_lsb)) >>
                  32);
    out->x = place(&eye->mount[0], range, direction[0]);
    out->y = place(&eye->mount[1], range, direction[1]);
    out->z = place(&eye->mount[2], range, direction[2]);
}

size_t lum_points_fixed_compute(const lum_fixed_projector *projector,
                                const lum_line *line, uint32_t first,
                                uint32_t count, lum_fixed_point *out,
                                lum_point_losses *losses)
{
    const lum_fixed_eye *eye = projector->eye;
    if (line->eye != LUM_EYE_BLUE) {
        eye++;
    }
    if (first > line->word_count) {
        first = line->word_count;
    }
    if (count > line->word_count - first) {
        count = line->word_count - first;
    }
    const uint32_t *words = line->words + first;
    const uint32_t *const end = words + count;
    const lum_fixed_point *const begin = out;
    int32_t direction[3];
    uint32_t at = UINT32_MAX; /* no pixel */
    for (; words != end; words++) {
        const uint32_t word = *words;
        const uint32_t pixel = lum_word_pixel(word);
        LUM_CHECK(pixel < LUM_LINE_PIXELS);
        if (pixel != at) {
            if (!lum_line_has_angles(line, pixel)) {
                lum_counter_add(&losses->no_angle, 1);
                continue;
            }
            at = pixel;
            lum_turn_look(eye, &line->angles[pixel], direction);
        }
        const int32_t bits = ((int32_t)word >> 12) - eye->first_tof;
        if (bits < 0) {
            lum_counter_add(&losses->no_range, 1);
            continue;
        }
        out->word = word;
        put_point(eye, direction, (uint32_t)bits, out);
        out++;
    }
    return (size_t)(out - begin);
}
