#include "lum/smooth.h"

#include <stdbool.h>
#include <string.h>

/* Values of two neighbours in the family of polynomials that are orthogonal
 * over the pixels of a window. */
struct basis {
    double now[LUM_SMOOTH_WINDOW_MAX];
    double before[LUM_SMOOTH_WINDOW_MAX];
    double norm; /* of `before`; 0 at the start */
};

static double multiply(const double *a, const double *b, uint32_t n)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

/* The next higher polynomial: x times this one, minus its projection on the one
 * before. x is 0 in the window's middle and half an integer or a whole one. */
static void raise_order(struct basis *b, uint32_t n, double norm)
{
    const double share = b->norm > 0.0 ? norm / b->norm : 0.0;
    for (uint32_t i = 0; i < n; i++) {
        const double x = (double)i - (double)(n - 1u) * 0.5;
        const double next = x * b->now[i] - share * b->before[i];
        b->before[i] = b->now[i];
        b->now[i] = next;
    }
    b->norm = norm;
}

/* The polynomial of least squares through n readings, order below n, at each of
 * them. */
static void fit(const double *in, uint32_t n, uint32_t order, double *out)
{
    struct basis b = {.norm = 0.0};
    for (uint32_t i = 0; i < n; i++) {
        b.now[i] = 1.0;
        out[i] = 0.0;
    }
    for (uint32_t k = 0;; k++) {
        const double norm = multiply(b.now, b.now, n);
        const double part = multiply(b.now, in, n) / norm;
        for (uint32_t i = 0; i < n; i++) {
            out[i] += part * b.now[i];
        }
        if (k == order) {
            return;
        }
        raise_order(&b, n, norm);
    }
}

lum_result lum_smooth_init(lum_smooth *out, uint32_t window, uint32_t order)
{
    double one[LUM_SMOOTH_WINDOW_MAX] = {0.0};
    double weights[LUM_SMOOTH_WINDOW_MAX];
    if (window % 2u == 0 || window > LUM_SMOOTH_WINDOW_MAX ||
        order > LUM_SMOOTH_ORDER_MAX || order >= window) {
        return LUM_E_VALUE;
    }
    /* The weights are symmetric: a reading gives its neighbours what it gets
     * from them. */
    const uint32_t half = window / 2u;
    one[half] = 1.0;
    fit(one, window, order, weights);
    *out = (lum_smooth){.window = (uint8_t)window, .order = (uint8_t)order};
    for (uint32_t i = 0; i <= half; i++) {
        out->weights[i] = (float)weights[half + i];
    }
    return LUM_OK;
}

/* Pixels that are computed at once: short loops of one length, of which the
 * compiler makes vector code. */
#define BLOCK 32u

/* n sums, at most BLOCK; reaches half a window to either side. */
static inline void weigh(const lum_smooth *s, const float *in, uint32_t n,
                         float *out)
{
    float sums[BLOCK] = {0.0f};
    for (uint32_t i = 0; i < n; i++) {
        sums[i] = s->weights[0] * in[i];
    }
    for (uint32_t k = 1; k <= s->window / 2u; k++) {
        for (uint32_t i = 0; i < n; i++) {
            sums[i] += s->weights[k] * ((in - k)[i] + (in + k)[i]);
        }
    }
    memcpy(out, sums, n * sizeof *out);
}

static void smooth_middle(const lum_smooth *s, const float *in, uint32_t n,
                          float *out)
{
    uint32_t i = 0;
    for (; n - i >= BLOCK; i += BLOCK) {
        weigh(s, in + i, BLOCK, out + i);
    }
    weigh(s, in + i, n - i, out + i);
}

/* Fit a polynomial to n readings; keep it for those from first to end. */
static void smooth_window(const float *in, uint32_t n, uint32_t order,
                          uint32_t first, uint32_t end, float *out)
{
    double readings[LUM_SMOOTH_WINDOW_MAX];
    double fitted[LUM_SMOOTH_WINDOW_MAX];
    for (uint32_t i = 0; i < n; i++) {
        readings[i] = (double)in[i];
    }
    fit(readings, n, order, fitted);
    for (uint32_t i = first; i < end; i++) {
        out[i] = (float)fitted[i];
    }
}

/* Angles of one axis, and what becomes of them. */
struct track {
    float in[LUM_LINE_PIXELS];
    float out[LUM_LINE_PIXELS];
};

static void smooth_run(const lum_smooth *s, struct track *t, uint32_t n)
{
    const uint32_t window = s->window;
    const uint32_t half = window / 2u;
    if (n <= s->order + 1u) {
        memcpy(t->out, t->in, n * sizeof t->out[0]);
    } else if (n < window) {
        smooth_window(t->in, n, s->order, 0, n, t->out);
    } else {
        const uint32_t last = n - window;
        smooth_window(t->in, window, s->order, 0, half, t->out);
        smooth_middle(s, t->in + half, last + 1u, t->out + half);
        smooth_window(t->in + last, window, s->order, half + 1u, window,
                      t->out + last);
    }
}

static int16_t to_raw(float value)
{
    const float rounded = value + (value < 0.0f ? -0.5f : 0.5f);
    if (rounded >= 32767.0f) {
        return INT16_MAX;
    }
    return rounded <= -32768.0f ? INT16_MIN : (int16_t)rounded;
}

static void smooth_azimuth(const lum_smooth *s, lum_angle *angles, uint32_t n)
{
    struct track t = {{0.0f}, {0.0f}};
    for (uint32_t i = 0; i < n; i++) {
        t.in[i] = (float)angles[i].azimuth;
    }
    smooth_run(s, &t, n);
    for (uint32_t i = 0; i < n; i++) {
        angles[i].azimuth = to_raw(t.out[i]);
    }
}

static void smooth_elevation(const lum_smooth *s, lum_angle *angles, uint32_t n)
{
    struct track t = {{0.0f}, {0.0f}};
    for (uint32_t i = 0; i < n; i++) {
        t.in[i] = (float)angles[i].elevation;
    }
    smooth_run(s, &t, n);
    for (uint32_t i = 0; i < n; i++) {
        angles[i].elevation = to_raw(t.out[i]);
    }
}

/* The first pixel from `pixel` on that has angles, or has none. */
static uint32_t find(const lum_line *line, uint32_t pixel, bool has_angles)
{
    while (pixel < LUM_LINE_PIXELS &&
           lum_line_has_angles(line, pixel) != has_angles) {
        pixel++;
    }
    return pixel;
}

void lum_smooth_line(const lum_smooth *smooth, const lum_line *line,
                     lum_angle out[LUM_LINE_PIXELS])
{
    memmove(out, line->angles, LUM_LINE_PIXELS * sizeof *out);
    uint32_t end = 0;
    for (;;) {
        const uint32_t begin = find(line, end, true);
        if (begin == LUM_LINE_PIXELS) {
            return;
        }
        end = find(line, begin, false);
        smooth_azimuth(smooth, out + begin, end - begin);
        smooth_elevation(smooth, out + begin, end - begin);
    }
}
