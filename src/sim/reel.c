#include "reel.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* A line of one eye. All its pointers lie in one block of memory, that of
 * echoes. */
struct strip {
    lum_echo *echoes;
    uint8_t *counts; /* of the echoes of each pixel */
    uint8_t *bytes;  /* of the packets: of angles, then room for all that the
                        echoes can fill */
    float gain;      /* that the range packets were made with */
    float threshold;
    uint16_t packets;     /* as they are now */
    uint16_t angles;      /* packets of angles among them */
    uint16_t angle_bytes; /* of these */
    uint16_t len[LUM_PACKETS_LINE_MAX];
};

struct lum_reel {
    lum_render render; /* without a scene once all is rendered */
    lum_layout layout;
    unsigned frames;
    uint32_t lines;
    lum_sim_line line;      /* that packets are made of */
    lum_packet_batch batch; /* where they are made */
    struct strip *strips;   /* by frame, line, eye */
};

static struct strip *strip_of(const lum_reel *reel, unsigned frame,
                              uint32_t line, unsigned eye)
{
    return &reel->strips[((size_t)frame * reel->lines + line) * LUM_EYES + eye];
}

static size_t count_strips(const lum_reel *reel)
{
    return (size_t)reel->frames * reel->lines * LUM_EYES;
}

/* Bytes of the range packets that this many echoes can fill: every packet
 * except the last is full, up to less than one pixel's words. */
static size_t range_room(const lum_layout *layout, const lum_echo_line *line,
                         unsigned returns_max)
{
    const size_t full =
        (LUM_PACKET_BYTES_MAX - layout->profile.samples_at) / LUM_SAMPLE_BYTES;
    size_t words = 0;
    for (unsigned p = 0; p < LUM_LINE_PIXELS; p++) {
        const unsigned n = line->counts[p];
        words += 2u * (n < returns_max ? n : returns_max);
    }
    const size_t packets = words / (full - 2u * returns_max + 1u) + 1u;
    return words * LUM_SAMPLE_BYTES + packets * layout->profile.samples_at;
}

/* Append the batch's packets to those of a strip. */
static void keep_packets(const lum_packet_batch *batch, struct strip *strip,
                         size_t at)
{
    for (size_t i = 0; i < batch->count; i++) {
        const lum_sim_packet *p = &batch->packets[i];
        memcpy(strip->bytes + at, p->bytes, p->len);
        strip->len[strip->packets++] = (uint16_t)p->len;
        at += p->len;
    }
}

static size_t count_bytes(const lum_packet_batch *batch)
{
    size_t n = 0;
    for (size_t i = 0; i < batch->count; i++) {
        n += batch->packets[i].len;
    }
    return n;
}

/* reel->line holds the line's angles. */
static lum_result make_strip(lum_reel *reel, const lum_echo_line *from,
                             struct strip *out)
{
    const size_t echo_bytes = from->count * sizeof from->echoes[0];
    reel->batch.count = 0;
    const lum_result result =
        lum_packets_add_angles(&reel->layout, &reel->line, &reel->batch);
    if (result != LUM_OK) {
        return result;
    }
    const size_t angle_bytes = count_bytes(&reel->batch);
    const size_t ranges =
        range_room(&reel->layout, from, reel->render.options.returns_max);
    out->echoes =
        malloc(echo_bytes + sizeof from->counts + angle_bytes + ranges);
    if (out->echoes == NULL) {
        return LUM_E_SPACE;
    }
    out->counts = (uint8_t *)out->echoes + echo_bytes;
    out->bytes = out->counts + sizeof from->counts;
    memcpy(out->echoes, from->echoes, echo_bytes);
    memcpy(out->counts, from->counts, sizeof from->counts);
    keep_packets(&reel->batch, out, 0);
    out->angles = out->packets;
    out->angle_bytes = (uint16_t)angle_bytes;
    return LUM_OK;
}

static lum_result render_strip(lum_reel *reel, unsigned frame, uint32_t line,
                               unsigned eye, lum_echo_line *work)
{
    const lum_result result =
        lum_render_echoes(&reel->render, (int64_t)frame + 1, line, eye, work);
    if (result != LUM_OK) {
        return result;
    }
    reel->line.number = line;
    reel->line.eye = (uint8_t)eye;
    memcpy(reel->line.angles, work->angles, sizeof work->angles);
    return make_strip(reel, work, strip_of(reel, frame, line, eye));
}

static lum_result render_frame(lum_reel *reel, unsigned frame,
                               lum_reel_stop stop, lum_echo_line *work)
{
    for (uint32_t line = 0; line < reel->lines; line++) {
        if (stop.ask != NULL && stop.ask(stop.context)) {
            return LUM_END;
        }
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            const lum_result result =
                render_strip(reel, frame, line, eye, work);
            if (result != LUM_OK) {
                return result;
            }
        }
    }
    return LUM_OK;
}

static lum_result render_all(lum_reel *reel, lum_reel_stop stop)
{
    lum_result result = LUM_OK;
    lum_echo_line *work = malloc(sizeof *work);
    if (work == NULL) {
        return LUM_E_SPACE;
    }
    for (unsigned i = 0; i < reel->frames && result == LUM_OK; i++) {
        result = render_frame(reel, i, stop, work);
    }
    free(work);
    /* Words need only its scales. */
    lum_render_free(&reel->render);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        lum_scan_aim(&reel->render.scan, eye, NULL);
        reel->render.options.elevations_udeg[eye] = NULL;
    }
    return result;
}

static lum_result begin(lum_reel *reel, const lum_render_options *options,
                        unsigned frames)
{
    reel->layout = options->layout;
    reel->frames = frames;
    reel->lines = options->lines;
    if (frames > SIZE_MAX / LUM_EYES / sizeof *reel->strips / options->lines) {
        return LUM_E_SPACE;
    }
    reel->strips = calloc(count_strips(reel), sizeof *reel->strips);
    if (reel->strips == NULL) {
        return LUM_E_SPACE;
    }
    return lum_render_init(&reel->render, options);
}

lum_result lum_reel_new(const lum_render_options *options, unsigned frames,
                        lum_reel_stop stop, lum_reel **out)
{
    if (frames == 0 ||
        lum_packets_check(&options->layout, options->lines) != LUM_OK) {
        return LUM_E_VALUE;
    }
    lum_reel *reel = calloc(1, sizeof *reel);
    if (reel == NULL) {
        return LUM_E_SPACE;
    }
    lum_result result = begin(reel, options, frames);
    if (result == LUM_OK) {
        result = render_all(reel, stop);
    }
    if (result != LUM_OK) {
        lum_reel_free(reel);
        return result;
    }
    *out = reel;
    return LUM_OK;
}

void lum_reel_free(lum_reel *reel)
{
    if (reel == NULL) {
        return;
    }
    const size_t n = reel->strips != NULL ? count_strips(reel) : 0;
    for (size_t i = 0; i < n; i++) {
        free(reel->strips[i].echoes);
    }
    free(reel->strips);
    free(reel);
}

unsigned lum_reel_frames(const lum_reel *reel)
{
    return reel->frames;
}

uint32_t lum_reel_lines(const lum_reel *reel)
{
    return reel->lines;
}

/* The range packets of a strip, made again if power or threshold changed. */
static void thin(lum_reel *reel, uint32_t line, unsigned eye, float gain,
                 float threshold, struct strip *strip)
{
    if (strip->gain == gain && strip->threshold == threshold) {
        return;
    }
    strip->gain = gain;
    strip->threshold = threshold;
    strip->packets = strip->angles;
    reel->line.number = line;
    reel->line.eye = (uint8_t)eye;
    reel->line.word_count =
        lum_render_words(&reel->render, eye, strip->counts, strip->echoes, gain,
                         threshold, reel->line.words);
    reel->batch.count = 0;
    if (lum_packets_add_ranges(&reel->layout, &reel->line, &reel->batch) ==
        LUM_OK) {
        keep_packets(&reel->batch, strip, strip->angle_bytes);
    }
}

size_t lum_reel_line(lum_reel *reel, unsigned frame, uint32_t line,
                     const lum_reel_settings *settings, int64_t clock_us,
                     lum_reel_packet *out)
{
    struct strip *strips = strip_of(reel, frame, line, 0);
    uint8_t *next[LUM_EYES];
    size_t n = 0;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        thin(reel, line, eye, settings->gain, settings->threshold[eye],
             &strips[eye]);
        next[eye] = strips[eye].bytes;
    }
    const size_t total = (size_t)strips[0].packets + strips[1].packets;
    for (size_t i = 0; n < total; i++) {
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            if (i < strips[eye].packets) {
                const size_t len = strips[eye].len[i];
                lum_packets_set_clock(&reel->layout, clock_us, next[eye]);
                out[n++] = (lum_reel_packet){next[eye], len};
                next[eye] += len;
            }
        }
    }
    return n;
}
