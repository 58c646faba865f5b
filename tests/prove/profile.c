/* Any profile, with any bytes: no alarm, and a profile that lum_layout_init()
 * accepts has its values in range and its fields before its samples. group.c
 * and the assembler's driver begin there. */
#include "lum/profile.h"
#include "unknown.h"

static lum_profile profile;

static void check_any(void)
{
    lum_profile_fault fault;
    unsigned index;
    lum_layout layout;
    any_bytes(&profile, sizeof profile);
    if (lum_layout_init(&layout, &profile, &fault, &index) == LUM_OK) {
        const lum_profile *p = &layout.profile;
        //@ assert fault == LUM_PROFILE_FINE && index == 0;
        //@ assert p->data_packet_type <= 255;
        //@ assert p->set_ip_order <= LUM_SET_IP_LITTLE;
        //@ assert p->angle_order <= LUM_ELEVATION_AZIMUTH;
        //@ assert p->angle_lsb_pdeg <= LUM_ANGLE_LSB_MAX_PDEG;
        //@ assert p->sample_order <= LUM_ORDER_BIG;
        //@ assert 1 <= p->clock_unit_ns <= LUM_CLOCK_UNIT_MAX_NS;
        //@ assert 8 <= p->samples_at <= 64;
    } else {
        //@ assert index <= LUM_GROUP_FIELDS;
    }
}

/* Field f at one place and of one width, of any bits in any order; all other
 * fields, and where samples begin, are any. */
static void check_field_of(uint32_t f, uint8_t at, uint8_t bytes)
{
    lum_layout layout;
    profile.group[f].at = at;
    profile.group[f].bytes = bytes;
    if (lum_layout_init(&layout, &profile, NULL, NULL) == LUM_OK) {
        const lum_field *field = &layout.profile.group[f];
        //@ assert field->low <= 63 && field->bits <= 8 * bytes;
        if (bytes == 0) {
            //@ assert f == LUM_FIELD_TIMESTAMP || f == LUM_FIELD_NUM_SAMPLES;
        } else {
            //@ assert at >= 8 && bytes \in {1, 2, 4, 8};
            //@ assert at + bytes <= layout.profile.samples_at;
            //@ assert field->order <= LUM_ORDER_BIG;
        }
    }
}

static void check_fields(uint32_t f, uint32_t bytes)
{
    const uint32_t at = any_u32(0, 255);
    any_bytes(profile.group, sizeof profile.group);
    any_bytes(&profile.samples_at, sizeof profile.samples_at);
    if (bytes > 8 || bytes == 0 || at < 8 || at > 64) {
        check_field_of(f, (uint8_t)at, (uint8_t)bytes);
    } else {
        //@ split at;
        check_field_of(f, (uint8_t)at, (uint8_t)bytes);
    }
}

void main(void)
{
    check_any();
    lum_profile_default(&profile);
    const uint32_t f = any_u32(0, LUM_GROUP_FIELDS - 1);
    const uint32_t bytes = any_u32(0, 255);
    //@ split f;
    if (bytes <= 8) {
        //@ split bytes;
        check_fields(f, bytes);
    } else {
        check_fields(f, bytes);
    }
}
