#include "lum/profile.h"

#include "lum/wire.h"

#define FIELD_AT_MIN 8u
#define FIELD_AT_MAX 64u

void lum_profile_default(lum_profile *out)
{
    *out = (lum_profile){
        .data_packet_type = 8,
        .group =
            {
                [LUM_FIELD_TAG] = {12, 1},
                [LUM_FIELD_EYE] = {13, 1},
                [LUM_FIELD_LINE] = {14, 2},
                [LUM_FIELD_NUM_SAMPLES] = {16, 2},
                [LUM_FIELD_FIRST_SAMPLE_INDEX] = {18, 2},
                [LUM_FIELD_TIMESTAMP] = {20, 4},
            },
        .samples_at = 24,
        .set_ip_order = LUM_SET_IP_NETWORK,
        .angle_order = LUM_AZIMUTH_ELEVATION,
        .eye_values = {0, 1},
        .tlv = {1, 2, 3, 4},
        .angle_lsb_pdeg = 0,
        .line_span_us = 2000,
    };
}

void lum_layout_default(lum_layout *out)
{
    lum_profile_default(&out->profile);
}

static lum_profile_fault check_field(const lum_profile *p, unsigned f)
{
    const lum_field field = p->group[f];
    if (field.bytes == 0 && f == LUM_FIELD_TIMESTAMP) {
        return LUM_PROFILE_FINE;
    }
    if (field.bytes != 1 && field.bytes != 2 && field.bytes != 4) {
        return LUM_PROFILE_FIELD_WIDTH;
    }
    if (field.at < FIELD_AT_MIN || field.at > FIELD_AT_MAX) {
        return LUM_PROFILE_FIELD_OFFSET;
    }
    if (field.at < LUM_HEADER_BYTES &&
        !(f == LUM_FIELD_TAG && field.at == FIELD_AT_MIN)) {
        return LUM_PROFILE_FIELD_ON_TYPE;
    }
    for (unsigned other = 0; other < f; other++) {
        const lum_field o = p->group[other];
        if (field.at < o.at + o.bytes && o.at < field.at + field.bytes) {
            return LUM_PROFILE_FIELDS_OVERLAP;
        }
    }
    return LUM_PROFILE_FINE;
}

static lum_profile_fault check_samples(const lum_profile *p, unsigned *index)
{
    if (p->samples_at < FIELD_AT_MIN || p->samples_at > FIELD_AT_MAX) {
        *index = LUM_GROUP_FIELDS;
        return LUM_PROFILE_FIELD_OFFSET;
    }
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        const lum_field field = p->group[f];
        if (field.bytes > 0 && p->samples_at < field.at + field.bytes) {
            *index = f;
            return LUM_PROFILE_SAMPLES_IN_HEADER;
        }
    }
    return LUM_PROFILE_FINE;
}

static lum_profile_fault check_group(const lum_profile *p, unsigned *index)
{
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        const lum_profile_fault fault = check_field(p, f);
        if (fault != LUM_PROFILE_FINE) {
            *index = f;
            return fault;
        }
    }
    return check_samples(p, index);
}

static lum_profile_fault check_eyes(const lum_profile *p, unsigned *index)
{
    const unsigned bits = 8u * p->group[LUM_FIELD_EYE].bytes;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        if (bits < 32u && p->eye_values[eye] >> bits != 0) {
            *index = eye;
            return LUM_PROFILE_EYE_VALUE_WIDTH;
        }
    }
    *index = LUM_EYE_GREEN;
    return p->eye_values[LUM_EYE_BLUE] == p->eye_values[LUM_EYE_GREEN]
               ? LUM_PROFILE_EYE_VALUES_EQUAL
               : LUM_PROFILE_FINE;
}

static lum_profile_fault check_tlv(const lum_profile *p, unsigned *index)
{
    for (unsigned i = 0; i < LUM_TLV_USES; i++) {
        for (unsigned j = 0; j < i; j++) {
            if (p->tlv[i] == p->tlv[j]) {
                *index = i;
                return LUM_PROFILE_TLV_EQUAL;
            }
        }
    }
    return LUM_PROFILE_FINE;
}

static lum_profile_fault check_scalars(const lum_profile *p, unsigned *index)
{
    *index = 0;
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
    return p->angle_lsb_pdeg > LUM_ANGLE_LSB_MAX_PDEG ? LUM_PROFILE_ANGLE_LSB
                                                      : LUM_PROFILE_FINE;
}

static lum_profile_fault find_fault(const lum_profile *p, unsigned *index)
{
    static lum_profile_fault (*const checks[])(
        const lum_profile *, unsigned *) = {check_scalars, check_group,
                                            check_eyes, check_tlv};
    for (size_t i = 0; i < sizeof checks / sizeof checks[0]; i++) {
        const lum_profile_fault fault = checks[i](p, index);
        if (fault != LUM_PROFILE_FINE) {
            return fault;
        }
    }
    *index = 0;
    return LUM_PROFILE_FINE;
}

lum_result lum_layout_init(lum_layout *out, const lum_profile *profile,
                           lum_profile_fault *fault, unsigned *index)
{
    unsigned where = 0;
    const lum_profile_fault found = find_fault(profile, &where);
    if (fault != NULL) {
        *fault = found;
    }
    if (index != NULL) {
        *index = where;
    }
    if (found != LUM_PROFILE_FINE) {
        return LUM_E_VALUE;
    }
    out->profile = *profile;
    return LUM_OK;
}
