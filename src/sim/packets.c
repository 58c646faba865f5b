#include "packets.h"

#include "core/cuts.h"
#include "core/field.h"
#include "lum/clock.h"

#include <stdbool.h>

static uint64_t largest(unsigned field, uint32_t lines)
{
    switch ((enum lum_group_field)field) {
    case LUM_FIELD_TAG:
        return LUM_TAG_RANGES;
    case LUM_FIELD_LINE:
        return lines - 1u;
    case LUM_FIELD_NUM_SAMPLES:
        return LUM_PACKET_BYTES_MAX / LUM_SAMPLE_BYTES;
    case LUM_FIELD_FIRST_SAMPLE_INDEX:
        return 2u * LUM_RENDER_RETURNS_MAX * LUM_LINE_PIXELS;
    case LUM_FIELD_EYE:
    case LUM_FIELD_TIMESTAMP:
    case LUM_GROUP_FIELDS:
    default:
        return 0;
    }
}

unsigned lum_packets_bits(unsigned field, uint32_t lines)
{
    unsigned bits = 0;
    for (uint64_t most = largest(field, lines); most > 0; most >>= 1) {
        bits++;
    }
    return bits;
}

unsigned lum_packets_narrow(const lum_layout *layout, uint32_t lines)
{
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        const unsigned bits = field_bits(&layout->profile.group[f]);
        if (bits > 0 && bits < lum_packets_bits(f, lines)) {
            return f;
        }
    }
    return LUM_GROUP_FIELDS;
}

lum_result lum_packets_check(const lum_layout *layout, uint32_t lines)
{
    return lum_packets_narrow(layout, lines) == LUM_GROUP_FIELDS ? LUM_OK
                                                                 : LUM_E_VALUE;
}

static uint64_t ticks_of(const lum_layout *layout, int64_t clock_us)
{
    return (uint64_t)clock_us * 1000u / layout->profile.clock_unit_ns;
}

int64_t lum_packets_clock_us(const lum_layout *layout, const lum_sim_line *line)
{
    const unsigned bits =
        field_bits(&layout->profile.group[LUM_FIELD_TIMESTAMP]);
    if (bits == 0) {
        return 0;
    }
    const uint64_t first = ticks_of(layout, line->first_us);
    const uint64_t since = ticks_of(layout, line->clock_us) - first;
    const uint64_t mask = bits < 64 ? (UINT64_C(1) << bits) - 1u : UINT64_MAX;
    return lum_clock_us((first & mask) + since, layout->profile.clock_unit_ns);
}

static lum_sim_packet *begin(const lum_layout *layout, const lum_sim_line *line,
                             const lum_group *group, lum_packet_batch *out)
{
    if (out->count == LUM_PACKETS_LINE_MAX) {
        return NULL;
    }
    lum_sim_packet *p = &out->packets[out->count];
    if (lum_group_encode(layout, group, p->bytes, sizeof p->bytes, &p->len) !=
        LUM_OK) {
        return NULL;
    }
    p->time_ns = line->clock_us * 1000;
    p->sender = 0;
    out->count++;
    return p;
}

static lum_group group_of(const lum_layout *layout, const lum_sim_line *line,
                          uint8_t tag, uint32_t first, uint32_t n)
{
    const lum_group group = {.line = line->number,
                             .num_samples = n,
                             .first_sample_index = first,
                             .clock_raw = ticks_of(layout, line->clock_us),
                             .eye = line->eye,
                             .tag = tag};
    return group;
}

lum_result lum_packets_add_angles(const lum_layout *layout,
                                  const lum_sim_line *line,
                                  lum_packet_batch *out)
{
    uint32_t first = 0;
    for (size_t i = 0; i < LINE_CUTS; i++) {
        const uint32_t n = line_cuts[i];
        const lum_group group =
            group_of(layout, line, LUM_TAG_ANGLES, first, n);
        lum_sim_packet *p = begin(layout, line, &group, out);
        if (p == NULL) {
            return LUM_E_VALUE;
        }
        for (uint32_t k = 0; k < n; k++) {
            lum_angle_encode(layout, line->angles[first + k],
                             p->bytes + p->len);
            p->len += LUM_SAMPLE_BYTES;
        }
        first += n;
    }
    return LUM_OK;
}

lum_result lum_packets_add_ranges(const lum_layout *layout,
                                  const lum_sim_line *line,
                                  lum_packet_batch *out)
{
    const size_t room =
        (LUM_PACKET_BYTES_MAX - layout->profile.samples_at) / LUM_SAMPLE_BYTES;
    for (size_t first = 0; first < line->word_count;) {
        const size_t end =
            cut_words(line->words, line->word_count, first, room);
        const lum_group group =
            group_of(layout, line, LUM_TAG_RANGES, (uint32_t)first,
                     (uint32_t)(end - first));
        lum_sim_packet *p =
            end - first <= room ? begin(layout, line, &group, out) : NULL;
        if (p == NULL) {
            return LUM_E_VALUE;
        }
        for (; first < end; first++) {
            lum_group_word_encode(layout, line->words[first],
                                  p->bytes + p->len);
            p->len += LUM_SAMPLE_BYTES;
        }
    }
    return LUM_OK;
}

lum_result lum_packets_build(const lum_layout *layout, const lum_sim_line *line,
                             lum_packet_batch *out)
{
    out->count = 0;
    const lum_result result = lum_packets_add_angles(layout, line, out);
    return result != LUM_OK ? result
                            : lum_packets_add_ranges(layout, line, out);
}

/* Other fields may have the other bits of its bytes. */
void lum_packets_set_clock(const lum_layout *layout, int64_t clock_us,
                           uint8_t *packet)
{
    const lum_field field = layout->profile.group[LUM_FIELD_TIMESTAMP];
    const uint64_t ticks = ticks_of(layout, clock_us);
    for (unsigned i = 0; i < field_bits(&field); i++) {
        const unsigned bit = field.low + i;
        const unsigned place = field.order == LUM_ORDER_LITTLE
                                   ? bit / 8u
                                   : field.bytes - 1u - bit / 8u;
        uint8_t *to = &packet[field.at + place];
        const unsigned set = (unsigned)(ticks >> i) & 1u;
        *to = (uint8_t)((*to & ~(1u << bit % 8u)) | set << bit % 8u);
    }
}

size_t lum_packets_spread(lum_packet_batch batches[LUM_EYES], double line_ns,
                          lum_sim_packet **order)
{
    const size_t total = batches[0].count + batches[1].count;
    size_t n = 0;
    for (size_t i = 0; n < total; i++) {
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            if (i < batches[eye].count) {
                order[n++] = &batches[eye].packets[i];
            }
        }
    }
    for (size_t i = 0; i < total; i++) {
        order[i]->time_ns +=
            (int64_t)(line_ns * (double)(i + 1) / (double)total);
    }
    return total;
}
