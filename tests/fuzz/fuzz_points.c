/* Any line under any calibration that passes its check. */
#include "lum/points.h"
#include "lum/points_fixed.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define HEAD_BYTES 64u
#define WORDS_MAX  2000u
#define RANGE_MAX  5e4f /* 525,000 bits of 1 ns, and 10 us, in metres */
#define BLOCK      37u  /* points that are projected at once */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

struct run {
    lum_calibration calibration;
    lum_layout layout;
    lum_projector projector;
    lum_selection selection;
    lum_line line;
    lum_angle angles[LUM_LINE_PIXELS];
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    uint32_t words[WORDS_MAX];
    lum_direction directions[LUM_LINE_PIXELS];
    lum_sample_workspace workspace;
    lum_return returns[WORDS_MAX];
    lum_point points[WORDS_MAX];
    lum_fixed_projector fixed;
    lum_fixed_point fixed_points[WORDS_MAX];
    lum_sample samples[WORDS_MAX];
};

static void require(int fact)
{
    if (!fact) {
        abort();
    }
}

static uint32_t read_u32(const uint8_t *b)
{
    return (uint32_t)b[0] | ((uint32_t)b[1] << 8) | ((uint32_t)b[2] << 16) |
           ((uint32_t)b[3] << 24);
}

static int32_t between(const uint8_t *b, int64_t min, int64_t max)
{
    return (int32_t)(min + (int64_t)(read_u32(b) % (uint64_t)(max - min + 1)));
}

static void calibrate(struct run *run, const uint8_t *b)
{
    lum_eye_calibration *e = &run->calibration.eye[b[0] & 1u];
    lum_calibration_default(&run->calibration);
    run->calibration.tof_lsb_fs = (uint32_t)between(b + 4, 1, 1000000);
    e->tof_offset_fs =
        (int64_t)(read_u32(b + 8) % 2000000001u) * 10 - INT64_C(10000000000);
    e->azimuth_center_udeg = between(b + 12, -180000000, 180000000);
    e->azimuth_width_udeg = between(b + 16, 1, 360000000);
    e->elevation_min_udeg = between(b + 20, -90000000, 89999999);
    e->elevation_max_udeg =
        between(b + 24, (int64_t)e->elevation_min_udeg + 1, 90000000);
    e->mount_um[0] = between(b + 28, -1000000000, 1000000000);
    e->mount_roll_udeg = between(b + 32, -360000000, 360000000);
    e->mount_pitch_udeg = between(b + 36, -360000000, 360000000);
    e->mount_yaw_udeg = between(b + 40, -360000000, 360000000);
    lum_layout_default(&run->layout);
    run->layout.profile.angle_lsb_pdeg =
        b[1] & 1u ? (uint64_t)read_u32(b + 44) * 100u : 0u;
    require(lum_projector_init(&run->projector, &run->calibration,
                               &run->layout) == LUM_OK);
    require(lum_fixed_projector_init(&run->fixed, &run->calibration,
                                     &run->layout) == LUM_OK);
}

static void select(struct run *run, const uint8_t *b)
{
    lum_selection_default(&run->selection);
    run->selection.edges = (lum_edges)(1u + b[2] % 3u);
    run->selection.returns = (lum_return_choice)(b[2] / 4u % 5u);
    run->selection.return_number = b[3];
    run->selection.has_range = (b[1] & 2u) != 0;
    memcpy(&run->selection.range_min, b + 48, sizeof(float));
    memcpy(&run->selection.range_max, b + 52, sizeof(float));
}

/* Words in order of pixels; every pixel whose bit the input clears lacks its
 * angles. */
static void make_line(struct run *run, const uint8_t *b, size_t size)
{
    uint32_t pixel = 0;
    uint32_t n = 0;
    for (; n < WORDS_MAX && size >= 4u; n++, b += 4, size -= 4u) {
        const uint32_t raw = read_u32(b);
        pixel += raw % 4u;
        if (pixel >= LUM_LINE_PIXELS) {
            break;
        }
        run->words[n] = (raw & 0xfffff400u) | pixel;
        run->angles[pixel].azimuth = (int16_t)((int32_t)(raw >> 16) - 32768);
        run->angles[pixel].elevation =
            (int16_t)((int32_t)(raw & 0xffffu) - 32768);
        if ((raw & 0x700u) != 0) {
            run->marks[pixel / 32u] |= UINT32_C(1) << (pixel % 32u);
        }
    }
    run->line.word_count = n;
}

static void finish_line(struct run *run, const uint8_t *b)
{
    if ((b[1] & 4u) != 0) {
        memset(run->marks, 0xff, sizeof run->marks);
    }
    for (uint32_t pixel = 0; pixel < LUM_LINE_PIXELS; pixel++) {
        run->line.angle_count =
            (uint16_t)(run->line.angle_count +
                       ((run->marks[pixel / 32u] >> (pixel % 32u)) & 1u));
    }
    run->line.angles = run->angles;
    run->line.angle_marks = run->marks;
    run->line.words = run->words;
    run->line.eye = b[0] & 1u;
    run->workspace.returns = run->returns;
}

static void check_points(struct run *run)
{
    lum_point_losses losses = {0, 0};
    lum_point_losses counted = {0, 0};
    uint64_t rising = 0;
    uint64_t falling = 0;
    lum_directions_compute(&run->projector, &run->line, run->directions);
    const size_t n = lum_points_compute(&run->projector, &run->line,
                                        run->directions, run->points, &losses);
    lum_points_count(&run->projector, &run->line, &rising, &falling, &counted);
    require(n + losses.no_angle + losses.no_range == run->line.word_count);
    require(rising + falling == n);
    require(counted.no_angle == losses.no_angle);
    require(counted.no_range == losses.no_range);
    for (size_t i = 0; i < n; i++) {
        const lum_point *p = &run->points[i];
        require(isfinite(p->x) && isfinite(p->y) && isfinite(p->z));
    }
}

/* Both are within their bounds of section 7: float within 1e-6 and a few 2^-24
 * of the range, and 2^-24 of a mount of up to 1 km; integers within 0.3 mm. */
static void require_near(const struct run *run, const lum_fixed_point *p,
                         const lum_point *q)
{
    const float *m = run->projector.eye[run->line.eye].mount;
    const double unit = 1e-3 / LUM_FIXED_PER_MM;
    const double dx = p->x * unit - (double)q->x;
    const double dy = p->y * unit - (double)q->y;
    const double dz = p->z * unit - (double)q->z;
    const double range =
        hypot(hypot((double)q->x - (double)m[0], (double)q->y - (double)m[1]),
              (double)q->z - (double)m[2]);
    require(p->word == q->word);
    require(range > 250.0 || dx * dx + dy * dy + dz * dz < 1e-6);
}

/* Block by block what float makes at once. */
static void check_fixed(struct run *run)
{
    lum_point_losses losses = {0, 0};
    lum_point_losses counted = {0, 0};
    size_t n = 0;
    const size_t count = lum_points_compute(
        &run->projector, &run->line, run->directions, run->points, &counted);
    for (uint32_t at = 0; at < run->line.word_count; at += BLOCK) {
        n += lum_points_fixed_compute(&run->fixed, &run->line, at, BLOCK,
                                      run->fixed_points + n, &losses);
    }
    require(n == count);
    require(counted.no_angle == losses.no_angle);
    require(counted.no_range == losses.no_range);
    for (size_t i = 0; i < n; i++) {
        require_near(run, &run->fixed_points[i], &run->points[i]);
    }
}

static void check_samples(struct run *run)
{
    lum_point_losses losses = {0, 0};
    const size_t n =
        lum_samples_compute(&run->projector, &run->line, &run->selection,
                            &run->workspace, run->samples, &losses);
    require(n + losses.no_angle + losses.no_range <= run->line.word_count);
    for (size_t i = 0; i < n; i++) {
        const lum_sample *p = &run->samples[i];
        const unsigned edge = p->edge ? LUM_EDGES_RISING : LUM_EDGES_FALLING;
        require(isfinite(p->x) && isfinite(p->y) && isfinite(p->z));
        require(isfinite(p->azimuth) && isfinite(p->elevation));
        require(p->range >= 0.0f && p->range <= RANGE_MAX * 4.0f);
        require(p->pulse_width >= 0.0f && isfinite(p->pulse_width));
        require(p->return_number >= 1 &&
                p->return_number <= p->number_of_returns);
        require(((unsigned)run->selection.edges & edge) != 0);
        require(!run->selection.has_range ||
                (p->range >= run->selection.range_min &&
                 p->range <= run->selection.range_max));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < HEAD_BYTES) {
        return 0;
    }
    struct run *run = calloc(1, sizeof *run);
    if (run == NULL) {
        return 0;
    }
    calibrate(run, data);
    select(run, data);
    make_line(run, data + HEAD_BYTES, size - HEAD_BYTES);
    finish_line(run, data);
    check_points(run);
    check_fixed(run);
    check_samples(run);
    free(run);
    return 0;
}
