#include "scan.h"

#include "rotation.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

/* The mirror swings a little less than the span, so that no reading's noise
 * leaves it. */
#define SWING 0.995

/* The part of a sine that a sweep is: at 60 degrees to either side the mirror
 * is half as fast as in the middle. */
#define SWEEP_DEG 55.0

/* How far a line bends, in line pitches. */
#define BEND 0.2

/* Stream of random numbers. */
#define STREAM_ENCODER 5u

static double degrees_of(int32_t udeg)
{
    return (double)udeg * 1e-6;
}

static void make_rotation(const lum_eye_calibration *c, float out[9])
{
    lum_rotation_make(degrees_of(c->mount_roll_udeg),
                      degrees_of(c->mount_pitch_udeg),
                      degrees_of(c->mount_yaw_udeg), out);
}

static void make_sweep(lum_scan_eye *e, double half_width)
{
    const double end = sin(lum_radians(SWEEP_DEG));
    for (unsigned p = 0; p < LUM_LINE_PIXELS; p++) {
        const double u = 1.0 - (2.0 * p + 1.0) / LUM_LINE_PIXELS;
        const double swing = sin(lum_radians(SWEEP_DEG) * u) / end;
        const double az = e->azimuth_center + SWING * half_width * swing;
        e->azimuth_deg[p] = (float)az;
        e->azimuth_sin[p] = (float)sin(lum_radians(az));
        e->azimuth_cos[p] = (float)cos(lum_radians(az));
    }
}

static void make_bend(lum_scan_eye *e, double pitch)
{
    for (unsigned p = 0; p < LUM_LINE_PIXELS; p++) {
        const double u = (2.0 * p + 1.0) / LUM_LINE_PIXELS - 1.0;
        const double bend = BEND * pitch * (u - u * u * u);
        e->bend_deg[p] = (float)bend;
        e->bend_sin[p] = (float)sin(lum_radians(bend));
        e->bend_cos[p] = (float)cos(lum_radians(bend));
    }
}

static lum_result eye_init(lum_scan_eye *e, const lum_eye_calibration *c,
                           const lum_layout *layout, uint32_t lines)
{
    const double half_az = degrees_of(c->azimuth_width_udeg) / 2.0;
    const double low = degrees_of(c->elevation_min_udeg);
    const double high = degrees_of(c->elevation_max_udeg);
    const double half_el = (high - low) / 2.0;
    const double lsb = (double)layout->profile.angle_lsb_pdeg * 1e-12;
    e->elevations_udeg = NULL;
    e->wrong_height = 0.0;
    memset(e->wrong_deg, 0, sizeof e->wrong_deg);
    e->azimuth_center = degrees_of(c->azimuth_center_udeg);
    e->azimuth_span = 2.0 * half_az;
    e->elevation_center = (low + high) / 2.0;
    e->elevation_span = high - low;
    e->azimuth_bits = lsb > 0.0 ? 1.0 / lsb : 32768.0 / half_az;
    e->elevation_bits = lsb > 0.0 ? 1.0 / lsb : 32768.0 / half_el;
    if (half_az * e->azimuth_bits > 32768.5 ||
        half_el * e->elevation_bits > 32768.5) {
        return LUM_E_VALUE;
    }
    for (int i = 0; i < 3; i++) {
        e->mount[i] = (float)((double)c->mount_um[i] * 1e-6);
    }
    make_rotation(c, e->rotation);
    make_sweep(e, half_az);
    make_bend(e, e->elevation_span / lines);
    return LUM_OK;
}

lum_result lum_scan_init(lum_scan *out, const lum_calibration *calibration,
                         const lum_layout *layout, uint32_t lines)
{
    out->lines = lines;
    for (unsigned i = 0; i < LUM_EYES; i++) {
        if (eye_init(&out->eye[i], &calibration->eye[i], layout, lines) !=
            LUM_OK) {
            return LUM_E_VALUE;
        }
    }
    return LUM_OK;
}

void lum_scan_aim(lum_scan *scan, unsigned eye, const int32_t *elevations_udeg)
{
    scan->eye[eye].elevations_udeg = elevations_udeg;
}

static double draw_phase(lum_random *random)
{
    return lum_radians(360.0 * (double)lum_random_unit(random));
}

void lum_scan_distort(lum_scan *scan, double height_deg, uint64_t seed)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        lum_scan_eye *e = &scan->eye[eye];
        lum_random random;
        lum_random_init(&random, seed, (eye << 8) | STREAM_ENCODER);
        const double phase = draw_phase(&random);
        e->wrong_height = height_deg;
        e->wrong_phase = draw_phase(&random);
        for (unsigned p = 0; p < LUM_LINE_PIXELS; p++) {
            const double turn =
                ((double)e->azimuth_deg[p] - e->azimuth_center) /
                e->azimuth_span;
            e->wrong_deg[p] =
                height_deg * sin(lum_radians(360.0 * turn) + phase);
        }
    }
}

static double elevation_wrong_deg(const lum_scan_eye *e, double elevation)
{
    const double turn = (elevation - e->elevation_center) / e->elevation_span;
    return e->wrong_height <= 0.0
               ? 0.0
               : e->wrong_height *
                     sin(lum_radians(360.0 * turn) + e->wrong_phase);
}

const float *lum_scan_mount(const lum_scan *scan, unsigned eye)
{
    return scan->eye[eye].mount;
}

/* Where a line lies, in the middle between its bends. */
static double elevation_of(const lum_scan_eye *e, uint32_t line, uint32_t lines)
{
    if (e->elevations_udeg == NULL) {
        const double pitch = e->elevation_span / lines;
        return e->elevation_center + e->elevation_span / 2.0 -
               pitch * ((double)line + 0.5);
    }
    const double swing = SWING * e->elevation_span / 2.0;
    const double up =
        degrees_of(e->elevations_udeg[line]) - e->elevation_center;
    return e->elevation_center + fmax(-swing, fmin(swing, up));
}

static int16_t read_encoder(double degrees, double bits, lum_random *random)
{
    const double noise = LUM_SCAN_NOISE_DEG * (double)lum_random_normal(random);
    const double raw = (degrees + noise) * bits;
    if (raw <= -32768.0) {
        return INT16_MIN;
    }
    /* Above 0, where a cast rounds down. */
    return (int16_t)(raw >= 32767.0 ? INT16_MAX
                                    : (int32_t)(raw + 32768.5) - 32768);
}

void lum_scan_compute(const lum_scan *scan, unsigned eye, uint32_t line,
                      lum_random *random, lum_scan_line *out)
{
    const lum_scan_eye *e = &scan->eye[eye];
    const double line_el = elevation_of(e, line, scan->lines);
    const double line_wrong = elevation_wrong_deg(e, line_el);
    const float sine = (float)sin(lum_radians(line_el));
    const float cosine = (float)cos(lum_radians(line_el));
    for (unsigned p = 0; p < LUM_LINE_PIXELS; p++) {
        const unsigned at = (line & 1u) ? LUM_LINE_PIXELS - 1 - p : p;
        const float s = sine * e->bend_cos[p] + cosine * e->bend_sin[p];
        const float c = cosine * e->bend_cos[p] - sine * e->bend_sin[p];
        const float v[3] = {c * e->azimuth_cos[at], c * e->azimuth_sin[at], s};
        const double elevation = line_el + (double)e->bend_deg[p];
        lum_rotation_turn(e->rotation, v, out->direction[p]);
        out->azimuth[p] = e->azimuth_deg[at];
        out->elevation[p] = (float)elevation;
        out->reading[p].azimuth = read_encoder(
            (double)e->azimuth_deg[at] - e->azimuth_center + e->wrong_deg[at],
            e->azimuth_bits, random);
        out->reading[p].elevation =
            read_encoder(elevation - e->elevation_center + line_wrong,
                         e->elevation_bits, random);
    }
}
