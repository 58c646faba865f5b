/* Any bytes as a datagram, under layouts of many kinds. */
#include "lum/command.h"
#include "lum/host/command_text.h"
#include "lum/host/yscan.h"
#include "lum/laser.h"
#include "lum/packet.h"
#include "lum/wire.h"

#include "../layout/compare.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

DECLARE(fixed_);

#define PROFILE_BYTES 34u
#define YSCAN_LINES   64u

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void require(int fact)
{
    if (!fact) {
        abort();
    }
}

/* Anywhere between 8 and 71, so that some profiles are valid; seldom of an
 * order, or of bits, that there are not. */
static lum_field read_field(const uint8_t *place, const uint8_t *bits)
{
    static const uint8_t widths[] = {1, 2, 4, 8, 0, 3, 2, 4};
    static const uint8_t orders[] = {LUM_ORDER_LITTLE, LUM_ORDER_LITTLE,
                                     LUM_ORDER_LITTLE, LUM_ORDER_LITTLE,
                                     LUM_ORDER_BIG,    LUM_ORDER_BIG,
                                     LUM_ORDER_BIG,    LUM_ORDER_BIG + 1};
    const bool has_bits = (place[1] & 0x40u) != 0;
    return (lum_field){.at = (uint8_t)(8u + place[0] % 64u),
                       .bytes = widths[place[1] % 8u],
                       .order = orders[place[1] / 8u % 8u],
                       .low = has_bits ? bits[0] % 64u : 0,
                       .bits = has_bits ? (uint8_t)(bits[1] % 66u) : 0};
}

static uint32_t read_unit(uint8_t b)
{
    static const uint32_t units[] = {1000,       1,          100, 1000000,
                                     1000000000, 1000000001, 0,   40};
    return units[b % 8u];
}

static void read_profile(const uint8_t *b, lum_profile *p)
{
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        p->group[f] = read_field(b + 2u * f, b + 22 + 2u * f);
    }
    p->samples_at = (uint8_t)(16u + b[12] % 56u);
    p->data_packet_type = b[13];
    p->set_ip_order = b[14] % 3u;
    p->angle_order = b[15] % 3u;
    p->sample_order = b[15] / 3u % 3u;
    p->clock_unit_ns = read_unit(b[20]);
    p->eye_values[0] = b[16];
    p->eye_values[1] = (uint32_t)b[17] << (b[18] % 25u);
    p->tlv[0] = b[19];
    p->line_span_us = b[20];
    p->angle_lsb_pdeg = (uint64_t)b[21] << (b[18] % 40u);
}

/* The first byte chooses a layout; returns how many bytes that used. */
static size_t choose_layout(const uint8_t *data, size_t size, lum_layout *out)
{
    lum_profile p;
    lum_profile_fault fault = LUM_PROFILE_FINE;
    unsigned index = 0;
    size_t used = 1;
    lum_profile_default(&p);
    switch (size > 0 ? data[0] % 5u : 0u) {
    case 1:
        p.group[LUM_FIELD_TAG].at = 8;
        break;
    case 2:
        p.group[LUM_FIELD_TIMESTAMP] = (lum_field){.at = 0, .bytes = 0};
        p.angle_order = LUM_ELEVATION_AZIMUTH;
        break;
    case 3:
        p.data_packet_type = 3;
        p.set_ip_order = LUM_SET_IP_LITTLE;
        break;
    case 4:
        if (size > PROFILE_BYTES) {
            read_profile(data + 1, &p);
            used += PROFILE_BYTES;
        }
        break;
    default:
        break;
    }
    lum_layout_default(out);
    const lum_layout before = *out;
    const lum_result r = lum_layout_init(out, &p, &fault, &index);
    require((r == LUM_OK) == (fault == LUM_PROFILE_FINE));
    require(index <= LUM_GROUP_FIELDS);
    require(r == LUM_OK || memcmp(&before, out, sizeof before) == 0);
    return used < size ? used : size;
}

static void check_round_trip(const lum_layout *layout, const lum_group *g)
{
    uint8_t head[LUM_GROUP_HEAD_MAX];
    lum_group again;
    size_t len = 0;
    const size_t body = (size_t)LUM_SAMPLE_BYTES * g->num_samples;
    require(lum_group_encode(layout, g, head, sizeof head, &len) == LUM_OK);
    require(len == layout->profile.samples_at);
    uint8_t *packet = malloc(len + body);
    if (packet == NULL) {
        return;
    }
    memcpy(packet, head, len);
    memcpy(packet + len, g->samples, body);
    require(lum_packet_decode(layout, packet, len + body, &again) ==
            LUM_PACKET_DATA);
    require(again.samples == packet + len);
    require(again.line == g->line && again.num_samples == g->num_samples &&
            again.first_sample_index == g->first_sample_index &&
            again.clock_raw == g->clock_raw && again.eye == g->eye &&
            again.tag == g->tag && again.sample_order == g->sample_order);
    free(packet);
}

static void check_samples(const lum_layout *layout, const lum_group *g)
{
    for (uint32_t i = 0; i < g->num_samples; i++) {
        uint8_t bytes[LUM_SAMPLE_BYTES];
        const uint8_t *at = g->samples + (size_t)LUM_SAMPLE_BYTES * i;
        if (g->tag == LUM_TAG_ANGLES) {
            lum_angle_encode(layout, lum_group_angle(layout, g, i), bytes);
        } else {
            lum_group_word_encode(layout, lum_group_word(g, i), bytes);
        }
        require(memcmp(bytes, at, sizeof bytes) == 0);
    }
}

static void check_data(const lum_layout *layout, const uint8_t *data,
                       size_t size)
{
    lum_group g;
    memset(&g, 0x5a, sizeof g);
    const lum_group before = g;
    const lum_packet_kind kind = lum_packet_decode(layout, data, size, &g);
    require(kind < LUM_PACKET_KINDS);
    if (kind != LUM_PACKET_DATA) {
        require(memcmp(&before, &g, sizeof g) == 0);
        return;
    }
    const size_t head = layout->profile.samples_at;
    require(g.samples == data + head && g.num_samples >= 1);
    require(g.num_samples <= (size - head) / LUM_SAMPLE_BYTES);
    require(g.eye < LUM_EYES);
    require(g.tag == LUM_TAG_ANGLES || g.tag == LUM_TAG_RANGES);
    require(g.sample_order == layout->profile.sample_order);
    require(layout->profile.group[LUM_FIELD_NUM_SAMPLES].bytes > 0 ||
            g.num_samples == (size - head) / LUM_SAMPLE_BYTES);
    require(g.tag == LUM_TAG_RANGES ||
            (uint64_t)g.first_sample_index + g.num_samples <= LUM_LINE_PIXELS);
    check_samples(layout, &g);
    check_round_trip(layout, &g);
}

static bool groups_agree(const lum_group *a, const lum_group *b)
{
    return a->samples == b->samples && a->clock_raw == b->clock_raw &&
           a->line == b->line && a->num_samples == b->num_samples &&
           a->first_sample_index == b->first_sample_index && a->eye == b->eye &&
           a->tag == b->tag && a->sample_order == b->sample_order;
}

static bool samples_agree(const lum_layout *layout, const lum_group *g)
{
    static lum_angle any[LUM_LINE_PIXELS];
    static lum_angle fixed[LUM_LINE_PIXELS];
    for (uint32_t i = 0; i < g->num_samples; i++) {
        if (lum_group_word(g, i) != fixed_group_word(g, i)) {
            return false;
        }
    }
    if (g->tag != LUM_TAG_ANGLES) {
        return true;
    }
    lum_layout_copy_angles(any, g, layout->profile.angle_order);
    fixed_layout_copy_angles(fixed, g, layout->profile.angle_order);
    return memcmp(any, fixed, g->num_samples * sizeof *any) == 0;
}

/* The clock before it is any number that the packet's bytes make. */
static bool clocks_agree(const lum_layout *layout, const lum_group *g)
{
    lum_clock any = {0};
    lum_clock fixed = {0};
    uint64_t ticks = 0;
    uint64_t fixed_ticks = 0;
    const uint64_t before =
        (g->clock_raw ^ lum_group_word(g, 0)) * UINT64_C(0x9e3779b97f4a7c15);
    lum_clock_init(&any, &layout->profile);
    fixed_clock_init(&fixed, &layout->profile);
    for (unsigned turn = 0; turn < 2; turn++) {
        if (lum_clock_follow(&any, g, &ticks) !=
                fixed_clock_follow(&fixed, g, &fixed_ticks) ||
            ticks != fixed_ticks) {
            return false;
        }
        clock_take(&any, &before);
        clock_take(&fixed, &before);
    }
    return any.lowest == fixed.lowest;
}

/* A packet of the built-in layout, by layout_any.c and by layout_fixed.c: the
 * result, each member, each word and angle, and the clock. */
static bool layouts_agree(const uint8_t *data, size_t len)
{
    lum_layout layout;
    lum_group any = {0};
    lum_group fixed = {0};
    lum_layout_default(&layout);
    if (!fixed_layout_is_read(&layout) ||
        lum_group_decode(&layout, data, len, &any) !=
            fixed_group_decode(&layout, data, len, &fixed) ||
        !groups_agree(&any, &fixed)) {
        return false;
    }
    return any.num_samples == 0 ||
           (samples_agree(&layout, &any) && clocks_agree(&layout, &any));
}

static void check_set_ip(const lum_layout *layout, const uint8_t *data,
                         size_t size)
{
    uint32_t address = 0x5a5a5a5a;
    uint8_t again[LUM_SET_IP_BYTES];
    if (lum_set_ip_decode(layout, data, size, &address) != LUM_OK) {
        require(address == 0x5a5a5a5a);
    } else if (lum_set_ip_encode(again, layout, address) == LUM_OK) {
        require(memcmp(again, data, sizeof again) == 0);
    }
}

static void check_timestamp(const uint8_t *data, size_t size)
{
    lum_timestamp t = {0x5a, 0x5a};
    uint8_t again[LUM_TIMESTAMP_BYTES];
    if (lum_timestamp_decode(data, size, &t) != LUM_OK) {
        require(t.sequence == 0x5a && t.clock_us == 0x5a);
        return;
    }
    lum_timestamp_encode(again, &t);
    require(memcmp(again, data, sizeof again) == 0);
}

/* A text of commands: each that is read is one that can be written. */
static void check_commands(const uint8_t *data, size_t size)
{
    const char *text = (const char *)data;
    size_t left = size;
    lum_command command = {LUM_COMMAND_POWER, 4711};
    while (left > 0) {
        char out[LUM_COMMAND_TEXT_BYTES];
        size_t len = 0;
        const char *before = text;
        const size_t had = left;
        if (lum_command_parse(&text, &left, &command) != LUM_OK) {
            require(text == before && left == had);
            return;
        }
        require(left < had && text == before + (had - left));
        require(lum_command_format(&command, out, &len) == LUM_OK);
        require(len <= had - left && memcmp(out, before, len) == 0);
    }
}

static void check_yscan(const lum_tlv *tlv)
{
    int16_t lines[YSCAN_LINES] = {0};
    uint8_t out[LUM_TLV_PACKET_BYTES + LUM_TLV_HEAD_BYTES + 2u * YSCAN_LINES];
    lum_tlv_writer writer;
    size_t n = 4711;
    if (lum_yscan_decode(tlv, lines, YSCAN_LINES, &n) != LUM_OK) {
        require(n == 4711);
        return;
    }
    require(2u * n == tlv->length);
    require(lum_tlv_begin(&writer, out, sizeof out, 0) == LUM_OK);
    require(lum_yscan_add(&writer, tlv->type, lines, n) == LUM_OK);
    require(memcmp(out + LUM_TLV_PACKET_BYTES + LUM_TLV_HEAD_BYTES, tlv->value,
                   tlv->length) == 0);
}

static void check_tlv(const lum_tlv *tlv, const uint8_t *data, size_t size)
{
    uint16_t status = 0x5a5a;
    require(tlv->value >= data && tlv->value <= data + size);
    require(tlv->length <= (size_t)(data + size - tlv->value));
    require((lum_tlv_u16(tlv, &status) == LUM_OK) == (tlv->length >= 2));
    check_yscan(tlv);
    check_commands(tlv->value, tlv->length);
}

static void check_tlvs(const uint8_t *data, size_t size)
{
    lum_tlv_reader reader = {NULL, 0};
    lum_tlv tlv = {0, 0, NULL};
    uint32_t sequence = 0x5a;
    if (lum_tlv_open(data, size, &sequence, &reader) != LUM_OK) {
        require(sequence == 0x5a && reader.next == NULL);
        return;
    }
    size_t items = 0;
    lum_result r = LUM_OK;
    while ((r = lum_tlv_next(&reader, &tlv)) == LUM_OK) {
        require(++items <= size / LUM_TLV_HEAD_BYTES);
        check_tlv(&tlv, data, size);
    }
    require(r == LUM_END || r == LUM_E_MALFORMED);
    require(lum_tlv_next(&reader, &tlv) == LUM_END);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    lum_layout layout;
    uint8_t type = 0x5a;
    const size_t used = choose_layout(data, size, &layout);
    data += used;
    size -= used;
    if (lum_header_decode(data, size, &type) != LUM_OK) {
        require(type == 0x5a);
    }
    check_data(&layout, data, size);
    require(layouts_agree(data, size));
    check_set_ip(&layout, data, size);
    check_timestamp(data, size);
    check_tlvs(data, size);
    check_commands(data, size);
    return 0;
}
