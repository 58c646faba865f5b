#include "render.h"

#include <math.h>
#include <string.h>

/* Metres of range for each nanosecond that light takes there and back. */
#define M_PER_NS 0.15f

/* Two pulses closer than this become one: the detector has to recover. More
 * than twice the largest noise, so that edges keep their order. */
#define RECOVERY_M          0.15f
#define RECOVERY_DEVIATIONS 7.0f

/* A white wall at 1 m, head on, returns this much at full power. */
#define STRENGTH 1000.0f

/* The weakest return that is detected at the usual threshold. */
#define WEAKEST 0.0015f

/* Pulse widths of the faintest return and, never reached, of the brightest. */
#define WIDTH_MIN_NS  2.0f
#define WIDTH_SPAN_NS 10.0f

/* Numbers of a line's random streams. */
#define LINE_STREAM 2u

/* Stream number for the noise of echoes that are not detected at usual power
 * and threshold, so that all else of the line stays the same. */
#define FAINT_STREAM 3u

/* Seeds of further sensors. */
#define SENSOR_STREAM 7u

typedef struct pulse {
    float range;
    float width_ns;
    size_t echo;    /* that it begins with */
    bool is_joined; /* others ended in it */
} pulse;

/* --- Making and freeing --- */

void lum_render_options_default(lum_render_options *out)
{
    memset(out, 0, sizeof *out);
    lum_calibration_default(&out->calibration);
    lum_layout_default(&out->layout);
    out->lines = 64;
    out->rate_hz = 10.0;
    out->start.clock_us = LUM_RENDER_CLOCK_US;
    out->returns_max = 4;
    out->gain = 1.0f;
    out->threshold = 1.0f;
    for (unsigned i = 0; i < LUM_RENDER_RETURNS_MAX; i++) {
        out->noise_m[i] = LUM_RENDER_NOISE_M;
    }
}

static float recovery_of(const lum_render_options *options)
{
    float recovery = RECOVERY_M;
    for (unsigned i = 0; i < LUM_RENDER_RETURNS_MAX; i++) {
        const float needed = RECOVERY_DEVIATIONS * options->noise_m[i];
        recovery = needed > recovery ? needed : recovery;
    }
    return recovery;
}

static uint64_t own_seed(uint64_t seed, uint32_t number)
{
    lum_random random;
    lum_random_init(&random, seed, ((uint64_t)number << 8) | SENSOR_STREAM);
    return number == 0 ? seed : lum_random_next(&random);
}

lum_result lum_render_init(lum_render *out, const lum_render_options *options)
{
    const lum_calibration *c = &options->calibration;
    const double lsb_s = (double)c->tof_lsb_fs * 1e-15;
    memset(out, 0, sizeof *out);
    out->options = *options;
    if (lum_scan_init(&out->scan, c, &options->layout, options->lines) !=
        LUM_OK) {
        return LUM_E_VALUE;
    }
    for (unsigned i = 0; i < LUM_EYES; i++) {
        out->tof_offset[i] =
            (double)c->eye[i].tof_offset_fs / (double)c->tof_lsb_fs;
    }
    for (unsigned i = 0; i < LUM_EYES; i++) {
        lum_scan_aim(&out->scan, i, options->elevations_udeg[i]);
    }
    out->tof_per_m = 2.0 / (double)c->speed_of_light / lsb_s;
    out->tof_per_ns = 1e-9 / lsb_s;
    out->recovery_m = recovery_of(options);
    const lum_render_start *start = &options->start;
    lum_sight_init(&out->sight, &options->place, options->seed, &out->scan,
                   options->rate_hz / (1.0 + start->slow_ppm * 1e-6),
                   (double)start->late_us * 1e-6);
    const lum_place *place = lum_sight_place(&out->sight);
    out->noise_seed = own_seed(lum_place_noise_seed(place), start->number);
    lum_scan_distort(&out->scan, lum_place_encoder_deg(place),
                     own_seed(options->seed, start->number));
    return LUM_OK;
}

void lum_render_free(lum_render *render)
{
    lum_sight_free(&render->sight);
}

int64_t lum_render_clock_us(const lum_render *render, int64_t frame,
                            uint32_t line)
{
    const double lines =
        (double)(frame - 1) * (double)render->options.lines + (double)line;
    const double period_us =
        1e6 / render->options.rate_hz / (double)render->options.lines;
    return render->options.start.clock_us + (int64_t)(lines * period_us);
}

int64_t lum_render_drive_ns(const lum_render *render, int64_t clock_ns)
{
    const lum_render_start *start = &render->options.start;
    const int64_t since_ns = clock_ns - start->clock_us * 1000;
    return start->late_us * 1000 + since_ns +
           (int64_t)((double)since_ns * start->slow_ppm * 1e-6);
}

/* Since the beginning of the drive. */
static double time_of(const lum_render *r, int64_t frame, uint32_t line)
{
    const lum_render_start *start = &r->options.start;
    const int64_t us = lum_render_clock_us(r, frame, line) - start->clock_us;
    return (double)start->late_us * 1e-6 +
           (double)us * 1e-6 * (1.0 + start->slow_ppm * 1e-6);
}

lum_pose lum_render_pose(const lum_render *render, int64_t frame, uint32_t line)
{
    const lum_place *place = lum_sight_place(&render->sight);
    return lum_place_vehicle_pose(place, lum_place_moves(place)
                                             ? time_of(render, frame, line)
                                             : (double)(frame - 1) /
                                                   render->options.rate_hz);
}

/* --- Echoes of a beam --- */

static float width_of(float strength)
{
    const float root = sqrtf(strength);
    return WIDTH_MIN_NS + WIDTH_SPAN_NS * root / (root + 0.6f);
}

/* One more return: added to the pulse before it if both touch, otherwise a new
 * pulse if there is room. */
static size_t add_pulse(const lum_render *r, pulse *pulses, size_t count,
                        pulse next)
{
    if (count > 0) {
        pulse *last = &pulses[count - 1];
        const float end = last->range + last->width_ns * M_PER_NS;
        if (next.range < end + r->recovery_m) {
            const float joint =
                (next.range - last->range) / M_PER_NS + next.width_ns;
            last->width_ns = joint > last->width_ns ? joint : last->width_ns;
            last->is_joined = true;
            return count;
        }
    }
    if (count < r->options.returns_max) {
        pulses[count++] = next;
    }
    return count;
}

/* What the surfaces along a beam send back at full power, without noise. */
static void weigh(const lum_hit *hits, size_t n, lum_random *random,
                  lum_echo *out)
{
    float left = STRENGTH;
    for (size_t i = 0; i < n; i++) {
        const lum_hit *hit = &hits[i];
        const float speckle = 0.7f + 0.6f * lum_random_unit(random);
        const float strength = left * hit->cover * hit->reflectivity *
                               hit->cosine * speckle /
                               (hit->range * hit->range);
        left *= 1.0f - hit->cover;
        out[i] =
            (lum_echo){.range = hit->range + hit->bias, .strength = strength};
    }
}

/* --- Echoes to words --- */

/* What the detector makes of the echoes of a pixel. */
static size_t detect(const lum_render *r, const lum_echo *echoes, size_t n,
                     float gain, float threshold, pulse *pulses)
{
    const float weakest = WEAKEST * threshold;
    size_t count = 0;
    for (size_t i = 0; i < n; i++) {
        const float strength = gain * echoes[i].strength;
        if (strength >= weakest) {
            const pulse next = {echoes[i].range, width_of(strength), i, false};
            count = add_pulse(r, pulses, count, next);
        }
    }
    return count;
}

/* To the nearest integer; x above -2^20, as a cast rounds down above 0. */
static int32_t round_tof(double x)
{
    return (int32_t)(x + 1048576.5) - 1048576;
}

/* Both edges of a return; false when a word cannot hold them. */
static bool make_words(const lum_render *r, unsigned eye, const pulse *p,
                       float noise, uint32_t pixel, uint32_t out[2])
{
    const double rise =
        ((double)p->range + (double)noise) * r->tof_per_m - r->tof_offset[eye];
    const double width = (double)p->width_ns * r->tof_per_ns;
    if (rise < LUM_TOF_MIN || rise + width > LUM_TOF_MAX - 1) {
        return false;
    }
    const int32_t rising = round_tof(rise);
    const int32_t falling = rising + round_tof(width);
    out[0] = lum_word_make(rising, true, pixel);
    out[1] =
        lum_word_make(falling > rising ? falling : rising + 1, false, pixel);
    return true;
}

static void add_truth(const lum_render *r, const pulse *p, const lum_hit *hit,
                      uint32_t pixel, lum_sim_line *out)
{
    const float range = hit->range;
    const float *d = r->line.direction[pixel];
    const float *mount = lum_scan_mount(&r->scan, out->eye);
    out->labels[out->truth_count] =
        (lum_label){.object = hit->object,
                    .thing = hit->thing,
                    .is_mixed = p->is_joined || hit->is_rim};
    lum_sample *s = &out->truth[out->truth_count++];
    memset(s, 0, sizeof *s);
    s->x = d[0] * range + mount[0];
    s->y = d[1] * range + mount[1];
    s->z = d[2] * range + mount[2];
    s->range = range;
    s->azimuth = r->line.azimuth[pixel];
    s->elevation = r->line.elevation[pixel];
    s->pulse_width = p->width_ns;
    s->pixel = (uint16_t)pixel;
    s->edge = 1;
}

static void number_returns(lum_sample *samples, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        samples[i].return_number = (uint16_t)(i + 1);
        samples[i].number_of_returns = (uint16_t)n;
    }
}

/* --- Pixels and lines --- */

static void render_pixel(const lum_render *r, uint32_t pixel,
                         const lum_hit *hits, size_t n, lum_random *random,
                         lum_sim_line *out)
{
    lum_echo echoes[LUM_SCENE_HITS_MAX];
    pulse pulses[LUM_RENDER_RETURNS_MAX];
    weigh(hits, n, random, echoes);
    const size_t count =
        detect(r, echoes, n, r->options.gain, r->options.threshold, pulses);
    const size_t first = out->truth_count;
    for (size_t i = 0; i < count; i++) {
        const float noise = r->options.noise_m[i] * lum_random_normal(random);
        if (make_words(r, out->eye, &pulses[i], noise, pixel,
                       &out->words[out->word_count])) {
            out->word_count += 2;
            add_truth(r, &pulses[i], &hits[pulses[i].echo], pixel, out);
        }
    }
    number_returns(&out->truth[first], out->truth_count - first);
}

static void init_random(const lum_render *r, int64_t frame, uint32_t line,
                        unsigned eye, unsigned stream, lum_random *out)
{
    lum_random_init(out, r->noise_seed,
                    ((uint64_t)frame << 24) | ((uint64_t)line << 8) |
                        (eye << 4) | stream);
}

lum_result lum_render_line(lum_render *render, int64_t frame, uint32_t line,
                           unsigned eye, lum_sim_line *out)
{
    lum_random random;
    const lum_sight_line *seen = NULL;
    init_random(render, frame, line, eye, LINE_STREAM, &random);
    lum_scan_compute(&render->scan, eye, line, &random, &render->line);
    if (lum_sight_look(&render->sight, frame, line, eye,
                       time_of(render, frame, line), &render->line,
                       &seen) != LUM_OK) {
        return LUM_E_SPACE;
    }
    out->frame = frame;
    out->clock_us = lum_render_clock_us(render, frame, line);
    out->first_us = render->options.start.clock_us;
    out->number = line;
    out->eye = (uint8_t)eye;
    out->word_count = 0;
    out->truth_count = 0;
    memcpy(out->angles, render->line.reading, sizeof out->angles);
    const lum_hit *hits = seen->hits;
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
        render_pixel(render, p, hits, seen->counts[p], &random, out);
        hits += seen->counts[p];
    }
    return LUM_OK;
}

/* --- Lines kept as echoes, made words later --- */

/* The noise of pulses that are detected at usual power and threshold is drawn
 * as for a rendered line; the other echoes use another stream. */
static void add_noise(const lum_render *r, lum_random *random,
                      lum_random *faint, lum_echo *echoes, size_t n)
{
    pulse pulses[LUM_RENDER_RETURNS_MAX];
    const size_t count = detect(r, echoes, n, 1.0f, 1.0f, pulses);
    size_t next = 0;
    for (size_t i = 0; i < n; i++) {
        const bool is_seen = next < count && pulses[next].echo == i;
        echoes[i].noise = lum_random_normal(is_seen ? random : faint);
        next += is_seen;
    }
}

static void keep_echoes(const lum_echo *echoes, size_t n, uint32_t pixel,
                        lum_echo_line *out)
{
    const size_t first = out->count;
    for (size_t i = 0; i < n; i++) {
        if (echoes[i].strength >= LUM_RENDER_FAINTEST * WEAKEST) {
            out->echoes[out->count++] = echoes[i];
        }
    }
    out->counts[pixel] = (uint8_t)(out->count - first);
}

lum_result lum_render_echoes(lum_render *render, int64_t frame, uint32_t line,
                             unsigned eye, lum_echo_line *out)
{
    lum_random random;
    lum_random faint;
    const lum_sight_line *seen = NULL;
    init_random(render, frame, line, eye, LINE_STREAM, &random);
    init_random(render, frame, line, eye, FAINT_STREAM, &faint);
    lum_scan_compute(&render->scan, eye, line, &random, &render->line);
    if (lum_sight_look(&render->sight, frame, line, eye,
                       time_of(render, frame, line), &render->line,
                       &seen) != LUM_OK) {
        return LUM_E_SPACE;
    }
    out->clock_us = lum_render_clock_us(render, frame, line);
    out->count = 0;
    memcpy(out->angles, render->line.reading, sizeof out->angles);
    const lum_hit *hits = seen->hits;
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
        lum_echo echoes[LUM_SCENE_HITS_MAX];
        const size_t n = seen->counts[p];
        weigh(hits, n, &random, echoes);
        hits += n;
        add_noise(render, &random, &faint, echoes, n);
        keep_echoes(echoes, n, p, out);
    }
    return LUM_OK;
}

size_t lum_render_words(const lum_render *render, unsigned eye,
                        const uint8_t *counts, const lum_echo *echoes,
                        float gain, float threshold, uint32_t *words)
{
    size_t n = 0;
    if (!(gain > 0.0f)) {
        return 0;
    }
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
        pulse pulses[LUM_RENDER_RETURNS_MAX];
        const size_t count =
            detect(render, echoes, counts[p], gain, threshold, pulses);
        for (size_t i = 0; i < count; i++) {
            const float noise =
                render->options.noise_m[i] * echoes[pulses[i].echo].noise;
            n += make_words(render, eye, &pulses[i], noise, p, &words[n]) ? 2u
                                                                          : 0u;
        }
        echoes += counts[p];
    }
    return n;
}
