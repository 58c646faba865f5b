#include "calls.h"

void call_word(uint32_t word, uint8_t *out)
{
    out[0] = (uint8_t)word;
    out[1] = (uint8_t)(word >> 8);
    out[2] = (uint8_t)(word >> 16);
    out[3] = (uint8_t)(word >> 24);
}

void call_samples(const uint8_t *b, uint32_t n, uint8_t *samples)
{
    uint32_t pixel = (uint32_t)(b[3] | (b[4] << 8)) % 1100u;
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t word = ((uint32_t)b[5] * 7919u * (i + 1u)) << 12 |
                              ((b[6] >> (i % 8u)) & 1u ? LUM_WORD_RISING : 0u) |
                              (b[7] % 29u == i ? (uint32_t)LUM_WORD_ZERO : 0u) |
                              (pixel & LUM_WORD_PIXEL);
        call_word(word, samples + (size_t)LUM_SAMPLE_BYTES * i);
        pixel += b[6] % 3u;
        pixel ^= b[7] % 31u == i ? 5u : 0u;
    }
}

void call_layout(uint8_t b, uint8_t angle_order, lum_layout *out)
{
    static const uint8_t bytes[] = {4, 4, 2, 1, 0, 8, 4, 8};
    static const uint32_t units[] = {1000, 1000, 1, 1000000};
    lum_layout_default(out);
    lum_field *clock = &out->profile.group[LUM_FIELD_TIMESTAMP];
    clock->bytes = bytes[b % 8u];
    clock->bits = b % 8u == 7 ? 41 : 0;
    out->profile.clock_unit_ns = units[b / 8u % 4u];
    out->profile.angle_order = angle_order;
}

void call_built_in(lum_layout *layout)
{
    const uint32_t span_us = layout->profile.line_span_us;
    lum_layout_default(layout);
    layout->profile.line_span_us = span_us;
}

uint32_t call_step(uint8_t b)
{
    static const uint32_t steps[] = {
        0,    0,     0,      100,    500,     1999,     2000, 2001,
        5000, 99999, 100000, 100001, 1000000, 1u << 31, 50,   10};
    const uint32_t step = steps[b % 16u];
    return b & 0x80u ? 0u - step : step;
}

void call_packet(const uint8_t *b, bool is_large, uint8_t *samples,
                 lum_group *g)
{
    const uint32_t small = 1u + (b[0] >> 2) % 32u;
    const uint32_t n = is_large && (b[0] & 0x80u) != 0
                           ? SAMPLES_MAX - 4u * (small - 1u)
                           : small;
    const uint32_t first = (uint32_t)(b[3] | (b[4] << 8));
    *g = (lum_group){.samples = samples,
                     .line = b[1] == 255 ? 0xffffffffu : b[1] % 80u,
                     .num_samples = n,
                     .first_sample_index = first,
                     .eye = b[0] & 1u,
                     .tag = b[0] & 2u ? LUM_TAG_ANGLES : LUM_TAG_RANGES};
    if (g->tag == LUM_TAG_ANGLES) {
        g->first_sample_index = first % (LUM_LINE_PIXELS + 1u - n);
    }
    call_samples(b, n, samples);
}

void call_spoil(lum_group *g, unsigned which)
{
    switch (which % 4u) {
    case 0:
        g->eye = (uint8_t)(LUM_EYES + which / 4u);
        break;
    case 1:
        g->tag = (uint8_t)(LUM_TAG_RANGES + 1u + which / 4u);
        break;
    case 2:
        g->num_samples = 0;
        break;
    default:
        g->tag = LUM_TAG_ANGLES;
        g->first_sample_index = LUM_LINE_PIXELS - g->num_samples + 1u + which;
        break;
    }
}
