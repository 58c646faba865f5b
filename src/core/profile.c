#include "lum/profile.h"

#include "field.h"
#include "lum/wire.h"

#include <stdbool.h>

#define FIELD_AT_MIN 8u
#define FIELD_AT_MAX 64u

void lum_profile_default(lum_profile *out)
{
    *out = (lum_profile){
        .data_packet_type = 8,
        .group =
            {
                [LUM_FIELD_TAG] = {.at = 12, .bytes = 1},
                [LUM_FIELD_EYE] = {.at = 13, .bytes = 1},
                [LUM_FIELD_LINE] = {.at = 14, .bytes = 2},
                [LUM_FIELD_NUM_SAMPLES] = {.at = 16, .bytes = 2},
                [LUM_FIELD_FIRST_SAMPLE_INDEX] = {.at = 18, .bytes = 2},
                [LUM_FIELD_TIMESTAMP] = {.at = 20, .bytes = 4},
            },
        .samples_at = 24,
        .set_ip_order = LUM_SET_IP_NETWORK,
        .angle_order = LUM_AZIMUTH_ELEVATION,
        .sample_order = LUM_ORDER_LITTLE,
        .eye_values = {0, 1},
        .tlv = {1, 2, 3, 4},
        .angle_lsb_pdeg = 0,
        .line_span_us = 2000,
        .clock_unit_ns = 1000,
    };
}

void lum_layout_default(lum_layout *out)
{
    lum_profile_default(&out->profile);
}

/* A fault and the index it stands at, in one number. */
static unsigned fault_at(lum_profile_fault fault, unsigned index)
{
    return (unsigned)fault | index << 8;
}

static bool is_offset(unsigned at)
{
    return at >= FIELD_AT_MIN && at <= FIELD_AT_MAX;
}

static unsigned end_of(lum_field field)
{
    return (unsigned)field.at + field.bytes;
}

/* Whether a field's bits lie in its bytes. Without a number all do. */
static bool has_bits(lum_field field)
{
    return field.bits == 0
               ? field.low == 0
               : (unsigned)field.low + field.bits <= 8u * field.bytes;
}

static lum_profile_fault check_bytes(const lum_profile *p, unsigned f)
{
    const lum_field field = p->group[f];
    const unsigned bytes = field.bytes;
    if (bytes == 0 || bytes > 8 || (bytes & (bytes - 1u)) != 0) {
        return LUM_PROFILE_FIELD_WIDTH;
    }
    if (!is_offset(field.at)) {
        return LUM_PROFILE_FIELD_OFFSET;
    }
    if (field.at < LUM_HEADER_BYTES &&
        (f != LUM_FIELD_TAG || field.at != FIELD_AT_MIN)) {
        return LUM_PROFILE_FIELD_ON_TYPE;
    }
    if (field.order > LUM_ORDER_BIG) {
        return LUM_PROFILE_FIELD_ORDER;
    }
    return has_bits(field) ? LUM_PROFILE_FINE : LUM_PROFILE_FIELD_BITS;
}

/* Other bits of the same bytes are no overlap. */
static bool overlap(lum_field a, lum_field b)
{
    if (a.at >= end_of(b) || b.at >= end_of(a)) {
        return false;
    }
    return a.bits == 0 || b.bits == 0 || a.at != b.at || a.bytes != b.bytes ||
           a.order != b.order ||
           (a.low < b.low + b.bits && b.low < a.low + a.bits);
}

static bool may_be_nowhere(unsigned f)
{
    return f == LUM_FIELD_TIMESTAMP || f == LUM_FIELD_NUM_SAMPLES;
}

static lum_profile_fault check_field(const lum_profile *p, unsigned f)
{
    if (p->group[f].bytes == 0 && may_be_nowhere(f)) {
        return has_bits(p->group[f]) ? LUM_PROFILE_FINE
                                     : LUM_PROFILE_FIELD_BITS;
    }
    const lum_profile_fault fault = check_bytes(p, f);
    if (fault != LUM_PROFILE_FINE) {
        return fault;
    }
    for (unsigned other = 0; other < f; other++) {
        if (p->group[other].bytes > 0 &&
            overlap(p->group[f], p->group[other])) {
            return LUM_PROFILE_FIELDS_OVERLAP;
        }
    }
    return LUM_PROFILE_FINE;
}

static unsigned check_group(const lum_profile *p)
{
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        const lum_profile_fault fault = check_field(p, f);
        if (fault != LUM_PROFILE_FINE) {
            return fault_at(fault, f);
        }
    }
    if (!is_offset(p->samples_at)) {
        return fault_at(LUM_PROFILE_FIELD_OFFSET, LUM_GROUP_FIELDS);
    }
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        if (p->group[f].bytes > 0 && p->samples_at < end_of(p->group[f])) {
            return fault_at(LUM_PROFILE_SAMPLES_IN_HEADER, f);
        }
    }
    return LUM_PROFILE_FINE;
}

static unsigned check_eyes(const lum_profile *p)
{
    const unsigned bits = field_bits(&p->group[LUM_FIELD_EYE]);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        if (bits < 32 && p->eye_values[eye] >> bits != 0) {
            return fault_at(LUM_PROFILE_EYE_VALUE_WIDTH, eye);
        }
    }
    return p->eye_values[LUM_EYE_BLUE] == p->eye_values[LUM_EYE_GREEN]
               ? fault_at(LUM_PROFILE_EYE_VALUES_EQUAL, LUM_EYE_GREEN)
               : LUM_PROFILE_FINE;
}

static unsigned check_tlv(const lum_profile *p)
{
    for (unsigned i = 1; i < LUM_TLV_USES; i++) {
        for (unsigned j = 0; j < i; j++) {
            if (p->tlv[i] == p->tlv[j]) {
                return fault_at(LUM_PROFILE_TLV_EQUAL, i);
            }
        }
    }
    return LUM_PROFILE_FINE;
}

static unsigned check_scalars(const lum_profile *p)
{
    if (p->data_packet_type > 255u || (p->data_packet_type >= LUM_TYPE_SET_IP &&
                                       p->data_packet_type <= LUM_TYPE_TLV)) {
        return LUM_PROFILE_DATA_PACKET_TYPE;
    }
    if (p->set_ip_order > LUM_SET_IP_LITTLE) {
        return LUM_PROFILE_SET_IP_ORDER;
    }
    if (p->angle_order > LUM_ELEVATION_AZIMUTH) {
        return LUM_PROFILE_ANGLE_ORDER;
    }
    if (p->sample_order > LUM_ORDER_BIG) {
        return LUM_PROFILE_SAMPLE_ORDER;
    }
    if (p->clock_unit_ns - 1u >= LUM_CLOCK_UNIT_MAX_NS) {
        return LUM_PROFILE_CLOCK_UNIT;
    }
    if (p->angle_lsb_pdeg > LUM_ANGLE_LSB_MAX_PDEG) {
        return LUM_PROFILE_ANGLE_LSB;
    }
    return p->line_span_us > LUM_LINE_SPAN_MAX_US ? LUM_PROFILE_LINE_SPAN
                                                  : LUM_PROFILE_FINE;
}

static unsigned find_fault(const lum_profile *p)
{
    unsigned found = check_scalars(p);
    if (found == LUM_PROFILE_FINE) {
        found = check_group(p);
    }
    if (found == LUM_PROFILE_FINE) {
        found = check_eyes(p);
    }
    return found == LUM_PROFILE_FINE ? check_tlv(p) : found;
}

lum_result lum_layout_init(lum_layout *out, const lum_profile *profile,
                           lum_profile_fault *fault, unsigned *index)
{
    const unsigned found = find_fault(profile);
    if (found == LUM_PROFILE_FINE) {
        out->profile = *profile;
    }
    if (fault != NULL) {
        *fault = (lum_profile_fault)(found & 0xffu);
    }
    if (index != NULL) {
        *index = found >> 8;
    }
    return found == LUM_PROFILE_FINE ? LUM_OK : LUM_E_VALUE;
}
