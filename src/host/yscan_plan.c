#include "lum/host/yscan_plan.h"

#include "normal.h"

#include <stdbool.h>

/* Half away from zero; by is above 0. */
static int64_t divide_rounded(int64_t value, int64_t by)
{
    return value < 0 ? -((-value + by / 2) / by) : (value + by / 2) / by;
}

static int32_t saturated(int64_t value)
{
    if (value < INT32_MIN || value > INT32_MAX) {
        return value < 0 ? INT32_MIN : INT32_MAX;
    }
    return (int32_t)value;
}

static bool is_count(size_t n)
{
    return n >= 1 && n <= LUM_YSCAN_LINES_MAX;
}

static void spread(int32_t min_udeg, int32_t max_udeg, int32_t *out_udeg,
                   size_t n)
{
    const int64_t lines = (int64_t)n;
    const int64_t sum = (int64_t)min_udeg + max_udeg;
    const int64_t span = (int64_t)max_udeg - min_udeg;
    for (int64_t i = 0; i < lines; i++) {
        out_udeg[i] = (int32_t)divide_rounded(
            sum * lines + (lines - 1 - 2 * i) * span, 2 * lines);
    }
}

lum_result lum_yscan_uniform(int32_t min_udeg, int32_t max_udeg,
                             int32_t *out_udeg, size_t n)
{
    if (min_udeg >= max_udeg || !is_count(n)) {
        return LUM_E_VALUE;
    }
    spread(min_udeg, max_udeg, out_udeg, n);
    return LUM_OK;
}

/* Makes equal lines differ by a microdegree where there is room, and never lets
 * a line rise above the one before it. */
static void part_lines(int32_t min, int32_t max, int32_t *out, size_t n)
{
    const int32_t step = (int64_t)max - min >= (int64_t)n ? 1 : 0;
    int64_t most = max;
    int64_t least = min;
    for (size_t i = 0; i < n; i++) {
        out[i] = out[i] < most ? out[i] : saturated(most);
        most = (int64_t)out[i] - step;
    }
    for (size_t i = n; i > 0; i--) {
        out[i - 1] = out[i - 1] > least ? out[i - 1] : saturated(least);
        least = (int64_t)out[i - 1] + step;
    }
}

#define SIGMA_MIN_UDEG 10000
#define SIGMA_MAX_UDEG 90000000

static int64_t cumulative_at(int32_t udeg, int32_t center, int32_t sigma)
{
    const int64_t distance = (int64_t)udeg - center;
    return lum_normal_cumulative(distance * LUM_NORMAL_ONE / sigma);
}

lum_result lum_yscan_gaussian(int32_t min_udeg, int32_t max_udeg,
                              int32_t center_udeg, int32_t sigma_udeg,
                              int32_t *out_udeg, size_t n)
{
    if (min_udeg >= max_udeg || center_udeg < min_udeg ||
        center_udeg > max_udeg || sigma_udeg < SIGMA_MIN_UDEG ||
        sigma_udeg > SIGMA_MAX_UDEG || !is_count(n)) {
        return LUM_E_VALUE;
    }
    const int64_t lines = (int64_t)n;
    const int64_t low = cumulative_at(min_udeg, center_udeg, sigma_udeg);
    const int64_t high = cumulative_at(max_udeg, center_udeg, sigma_udeg);
    for (int64_t i = 0; i < lines; i++) {
        const int64_t u = divide_rounded((high + low) * lines +
                                             (lines - 1 - 2 * i) * (high - low),
                                         2 * lines);
        const int64_t from_center =
            divide_rounded(lum_normal_quantile(u) * sigma_udeg, LUM_NORMAL_ONE);
        out_udeg[i] = (int32_t)(center_udeg + from_center);
    }
    part_lines(min_udeg, max_udeg, out_udeg, n);
    return LUM_OK;
}

#define WEIGHT_MAX 1000000u

static bool are_regions(const lum_yscan_region *regions, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const lum_yscan_region *r = &regions[i];
        if (r->min_udeg >= r->max_udeg || r->weight < 1 ||
            r->weight > WEIGHT_MAX ||
            (i > 0 && r->max_udeg > regions[i - 1].min_udeg)) {
            return false;
        }
    }
    return true;
}

/* Number of the line after each region's last. The end of a region is rounded
 * and not its length, so that the shares add up. */
static void share_lines(const lum_yscan_region *regions, size_t count, size_t n,
                        size_t ends[LUM_YSCAN_REGIONS_MAX])
{
    uint64_t all = 0;
    uint64_t sum = 0;
    size_t least = 0;
    for (size_t i = 0; i < count; i++) {
        all += regions[i].weight;
    }
    for (size_t i = 0; i < count; i++) {
        const size_t most = n - (count - 1 - i);
        sum += regions[i].weight;
        ends[i] = (size_t)((2 * sum * n + all) / (2 * all));
        least++;
        ends[i] = ends[i] < least ? least : ends[i];
        ends[i] = ends[i] > most ? most : ends[i];
        least = ends[i];
    }
}

lum_result lum_yscan_regions(const lum_yscan_region *regions, size_t count,
                             int32_t *out_udeg, size_t n)
{
    size_t ends[LUM_YSCAN_REGIONS_MAX];
    if (!is_count(n) || count < 1 || count > LUM_YSCAN_REGIONS_MAX ||
        count > n || !are_regions(regions, count)) {
        return LUM_E_VALUE;
    }
    share_lines(regions, count, n, ends);
    for (size_t i = 0, from = 0; i < count; from = ends[i], i++) {
        spread(regions[i].min_udeg, regions[i].max_udeg, out_udeg + from,
               ends[i] - from);
    }
    return LUM_OK;
}

lum_result lum_yscan_make(const lum_yscan_shape *shape, int32_t span_min_udeg,
                          int32_t span_max_udeg, int32_t *out_udeg, size_t n)
{
    const int32_t min =
        shape->min_udeg == INT32_MIN ? span_min_udeg : shape->min_udeg;
    const int32_t max =
        shape->max_udeg == INT32_MAX ? span_max_udeg : shape->max_udeg;
    switch (shape->kind) {
    case LUM_YSCAN_UNIFORM:
        return lum_yscan_uniform(min, max, out_udeg, n);
    case LUM_YSCAN_GAUSSIAN:
        return lum_yscan_gaussian(min, max, shape->center_udeg,
                                  shape->sigma_udeg, out_udeg, n);
    case LUM_YSCAN_REGIONS:
        return lum_yscan_regions(shape->regions, shape->region_count, out_udeg,
                                 n);
    default:
        return LUM_E_VALUE;
    }
}

/* What twice a distance in microdegrees is in raw, as a fraction. */
typedef struct raw_scale {
    int64_t times;
    int64_t by;
} raw_scale;

static raw_scale scale_of(const lum_eye_calibration *eye,
                          const lum_layout *layout)
{
    const int64_t span =
        (int64_t)eye->elevation_max_udeg - eye->elevation_min_udeg;
    const int64_t lsb_pdeg = (int64_t)layout->profile.angle_lsb_pdeg;
    return lsb_pdeg == 0 ? (raw_scale){32768, span}
                         : (raw_scale){500000, lsb_pdeg};
}

static int64_t twice_middle(const lum_eye_calibration *eye)
{
    return (int64_t)eye->elevation_min_udeg + eye->elevation_max_udeg;
}

int32_t lum_yscan_elevation(const lum_eye_calibration *eye,
                            const lum_layout *layout, int16_t raw)
{
    const raw_scale scale = scale_of(eye, layout);
    return saturated(divide_rounded(
        raw * scale.by + twice_middle(eye) * scale.times, 2 * scale.times));
}

static int64_t raw_of(const lum_eye_calibration *eye, raw_scale scale,
                      int32_t udeg)
{
    return divide_rounded((2 * (int64_t)udeg - twice_middle(eye)) * scale.times,
                          scale.by);
}

/* Whether the whole span falls on raw values, except its end, which may be off
 * by one. */
static bool is_raw(int64_t raw, bool is_fraction_of_span)
{
    return raw >= INT16_MIN && raw <= INT16_MAX + (is_fraction_of_span ? 1 : 0);
}

/* Index of the first elevation at fault, n where none is. */
static size_t find_fault(const lum_eye_calibration *eye,
                         const lum_layout *layout, const int32_t *udeg,
                         size_t n)
{
    const raw_scale scale = scale_of(eye, layout);
    const bool of_span = layout->profile.angle_lsb_pdeg == 0;
    bool falls = false;
    bool rises = false;
    for (size_t i = 0; i < n; i++) {
        falls = falls || (i > 0 && udeg[i] < udeg[i - 1]);
        rises = rises || (i > 0 && udeg[i] > udeg[i - 1]);
        if ((falls && rises) || udeg[i] < eye->elevation_min_udeg ||
            udeg[i] > eye->elevation_max_udeg ||
            !is_raw(raw_of(eye, scale, udeg[i]), of_span)) {
            return i;
        }
    }
    return n;
}

lum_result lum_yscan_encode(const lum_eye_calibration *eye,
                            const lum_layout *layout, const int32_t *udeg,
                            size_t n, int16_t *out, size_t *at)
{
    const raw_scale scale = scale_of(eye, layout);
    const size_t fault = find_fault(eye, layout, udeg, n);
    if (fault < n) {
        if (at != NULL) {
            *at = fault;
        }
        return LUM_E_VALUE;
    }
    for (size_t i = 0; i < n; i++) {
        const int64_t raw = raw_of(eye, scale, udeg[i]);
        out[i] = (int16_t)(raw > INT16_MAX ? INT16_MAX : raw);
    }
    return LUM_OK;
}
