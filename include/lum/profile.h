/** @file
 * The wire profile: every assumption about the layout of packets, as data.
 *
 * The maker's manual is silent on parts of the protocol (docs/protocol.md,
 * section 8). What this SDK assumes there is a field of ::lum_profile, so if
 * your sensor differs, you correct a value and not the code. */
#ifndef LUM_PROFILE_H
#define LUM_PROFILE_H

#include "lum/result.h"

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Number of pixels in a line of one eye. */
#define LUM_LINE_PIXELS 1000u

/** The two eyes. Blue sits on the left and looks right. */
enum lum_eye {
    LUM_EYE_BLUE = 0,  /**< left side of the sensor, right half of the view */
    LUM_EYE_GREEN = 1, /**< right side of the sensor, left half of the view */
    LUM_EYES = 2       /**< how many there are */
};

/** Order of the bytes of a number. */
enum lum_byte_order {
    LUM_ORDER_LITTLE, /**< the lowest byte first */
    LUM_ORDER_BIG     /**< the highest byte first */
};

/** Where an unsigned field is in a data packet. Members that an initialiser
 * leaves out are 0: {12, 2} has all bits of two bytes, the lower byte first. */
typedef struct lum_field {
    uint8_t at;    /**< offset from the packet's first byte, 8..64 */
    uint8_t bytes; /**< width: 1, 2, 4 or 8; 0: no such field, allowed for
                        timestamp and num_samples */
    uint8_t order; /**< a ::lum_byte_order */
    uint8_t low;   /**< the lowest of its bits, 0..63; 0 is the lowest bit of
                        the number in these bytes */
    uint8_t bits;  /**< how many; 0: all, and low is 0 */
} lum_field;

/** The fields of a data packet, in the order of lum_profile.group. */
enum lum_group_field {
    LUM_FIELD_TAG,                /**< 2 angles, 3 ranges */
    LUM_FIELD_EYE,                /**< one of lum_profile.eye_values */
    LUM_FIELD_LINE,               /**< line number within the frame */
    LUM_FIELD_NUM_SAMPLES,        /**< samples in this packet; without this
                                       field, all that the datagram has */
    LUM_FIELD_FIRST_SAMPLE_INDEX, /**< first pixel, or first word */
    LUM_FIELD_TIMESTAMP,          /**< sensor clock, in ticks */
    LUM_GROUP_FIELDS              /**< how many there are */
};

/** Byte order of the address in a set IP packet. */
enum lum_set_ip_order {
    LUM_SET_IP_NETWORK, /**< a.b.c.d */
    LUM_SET_IP_LITTLE   /**< d.c.b.a */
};

/** Order of the two values of an angle sample. */
enum lum_angle_order {
    LUM_AZIMUTH_ELEVATION, /**< azimuth first */
    LUM_ELEVATION_AZIMUTH  /**< elevation first */
};

/** TLV type numbers this SDK gives a meaning. */
enum lum_tlv_use {
    LUM_TLV_COMMAND, /**< ASCII command text, client to sensor */
    LUM_TLV_STATUS,  /**< u16 laser status */
    LUM_TLV_DEBUG,   /**< ASCII text, sensor to client */
    LUM_TLV_YSCAN,   /**< i16 elevation of each line */
    LUM_TLV_USES     /**< how many there are */
};

/** One wire profile. Plain data: fill it by hand, with
 * lum_profile_default(), or from YAML with lum/config/config.h. */
typedef struct lum_profile {
    uint32_t data_packet_type;         /**< 0..255, not 5, 6 or 7 */
    lum_field group[LUM_GROUP_FIELDS]; /**< indexed by ::lum_group_field */
    uint8_t samples_at;                /**< offset of the first sample */
    uint8_t set_ip_order;              /**< an ::lum_set_ip_order */
    uint8_t angle_order;               /**< an ::lum_angle_order */
    uint8_t sample_order;              /**< a ::lum_byte_order, of the angles
                                            and words */
    uint32_t eye_values[LUM_EYES];     /**< on the wire, by ::lum_eye */
    uint16_t tlv[LUM_TLV_USES];        /**< type numbers by ::lum_tlv_use */
    uint64_t angle_lsb_pdeg; /**< 1e-12 degree a bit; 0: full scale is half
                                  the calibrated span */
    uint32_t line_span_us;   /**< longest a line lasts on the sensor clock */
    uint32_t clock_unit_ns;  /**< length of a tick of the sensor clock in data
                                  packets, 1..::LUM_CLOCK_UNIT_MAX_NS */
} lum_profile;

/** What is wrong with a profile. */
typedef enum lum_profile_fault {
    LUM_PROFILE_FINE,              /**< nothing */
    LUM_PROFILE_DATA_PACKET_TYPE,  /**< above 255, or 5, 6 or 7 */
    LUM_PROFILE_FIELD_OFFSET,      /**< an offset outside 8..64 */
    LUM_PROFILE_FIELD_WIDTH,       /**< a width other than 1, 2, 4 or 8 */
    LUM_PROFILE_FIELD_ON_TYPE,     /**< a field other than a tag at 8 on the
                                        packet type's bytes 8..11 */
    LUM_PROFILE_FIELDS_OVERLAP,    /**< two fields share a byte, and are not
                                        separate bits of the same bytes */
    LUM_PROFILE_SAMPLES_IN_HEADER, /**< samples begin before a field ends */
    LUM_PROFILE_SET_IP_ORDER,      /**< not an ::lum_set_ip_order */
    LUM_PROFILE_ANGLE_ORDER,       /**< not an ::lum_angle_order */
    LUM_PROFILE_EYE_VALUES_EQUAL,  /**< both eyes have the same value */
    LUM_PROFILE_EYE_VALUE_WIDTH,   /**< a value its field cannot hold */
    LUM_PROFILE_TLV_EQUAL,         /**< two uses have the same number */
    LUM_PROFILE_ANGLE_LSB,         /**< above ::LUM_ANGLE_LSB_MAX_PDEG */
    LUM_PROFILE_LINE_SPAN,         /**< above ::LUM_LINE_SPAN_MAX_US */
    LUM_PROFILE_FIELD_ORDER,       /**< not a ::lum_byte_order */
    LUM_PROFILE_FIELD_BITS,        /**< bits that its bytes do not have */
    LUM_PROFILE_SAMPLE_ORDER,      /**< not a ::lum_byte_order */
    LUM_PROFILE_CLOCK_UNIT         /**< 0, or above ::LUM_CLOCK_UNIT_MAX_NS */
} lum_profile_fault;

/** Largest angle_lsb_pdeg: 1 degree a bit. */
#define LUM_ANGLE_LSB_MAX_PDEG UINT64_C(1000000000000)

/** Largest line_span_us: 1000 s. */
#define LUM_LINE_SPAN_MAX_US UINT32_C(1000000000)

/** Largest clock_unit_ns: 1 s. */
#define LUM_CLOCK_UNIT_MAX_NS UINT32_C(1000000000)

/** Raised when a ::lum_layout that was made elsewhere (by lumtable) would
 * differ from what lum_layout_init() makes of the same profile, or code that
 * lumtable made would no longer read packets by it. */
#define LUM_LAYOUT_VERSION 2

/** A profile that has been checked: what decoders and encoders take. Private:
 * only lum_layout_init() sets it; any number of threads may read it. */
typedef struct lum_layout {
    lum_profile profile; /**< the checked profile; do not write */
} lum_layout;

/** The built-in profile (docs/protocol.md, section 8).
 * @param out caller-owned, overwritten. Cannot fail. */
void lum_profile_default(lum_profile *out);

/** Check a profile and make a layout of it.
 * @param out     caller-owned; written only on LUM_OK.
 * @param profile not kept.
 * @param fault   may be NULL; gets what is wrong, or LUM_PROFILE_FINE.
 * @param index   may be NULL; gets the ::lum_group_field (LUM_GROUP_FIELDS: the
 *                samples), ::lum_eye or ::lum_tlv_use concerned, 0 if the fault
 *                has none.
 * @return LUM_OK, or LUM_E_VALUE with the first fault found.
 * Constant time, reentrant. */
LUM_MUST_CHECK lum_result lum_layout_init(lum_layout *out,
                                          const lum_profile *profile,
                                          lum_profile_fault *fault,
                                          unsigned *index);

/** The layout of the built-in profile. Cannot fail.
 * @param out caller-owned, overwritten. */
void lum_layout_default(lum_layout *out);

#ifdef __cplusplus
}
#endif

#endif
