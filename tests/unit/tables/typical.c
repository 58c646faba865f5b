/* Made by lumtable 0.1.0; not to be changed by hand.
 *   profile: built in
 *   calibration: built in
 */
/* clang-format off */
#include "lum/points_fixed.h"
#include "lum/profile.h"

#include <stdint.h>

#if LUM_LAYOUT_VERSION != 2 || LUM_FIXED_PROJECTOR_VERSION != 1
#error "made for another version of lumsdk: make it again with the lumtable of this one"
#endif

extern const lum_layout typical_layout;
extern const lum_fixed_projector typical_projector;

const lum_layout typical_layout = {
    .profile =
        {
            .data_packet_type = 8u,
            .group =
                {
                    [LUM_FIELD_TAG] = {.at = 12, .bytes = 1, .order = LUM_ORDER_LITTLE, .low = 0, .bits = 0},
                    [LUM_FIELD_EYE] = {.at = 13, .bytes = 1, .order = LUM_ORDER_LITTLE, .low = 0, .bits = 0},
                    [LUM_FIELD_LINE] = {.at = 14, .bytes = 2, .order = LUM_ORDER_LITTLE, .low = 0, .bits = 0},
                    [LUM_FIELD_NUM_SAMPLES] = {.at = 16, .bytes = 2, .order = LUM_ORDER_LITTLE, .low = 0, .bits = 0},
                    [LUM_FIELD_FIRST_SAMPLE_INDEX] = {.at = 18, .bytes = 2, .order = LUM_ORDER_LITTLE, .low = 0, .bits = 0},
                    [LUM_FIELD_TIMESTAMP] = {.at = 20, .bytes = 4, .order = LUM_ORDER_LITTLE, .low = 0, .bits = 0},
                },
            .samples_at = 24,
            .set_ip_order = LUM_SET_IP_NETWORK,
            .angle_order = LUM_AZIMUTH_ELEVATION,
            .sample_order = LUM_ORDER_LITTLE,
            .eye_values = {[LUM_EYE_BLUE] = UINT32_C(0), [LUM_EYE_GREEN] = UINT32_C(1)},
            .tlv = {[LUM_TLV_COMMAND] = 1u, [LUM_TLV_STATUS] = 2u, [LUM_TLV_DEBUG] = 3u, [LUM_TLV_YSCAN] = 4u},
            .angle_lsb_pdeg = UINT64_C(0),
            .line_span_us = UINT32_C(2000),
            .clock_unit_ns = UINT32_C(1000),
        },
};

const lum_fixed_projector typical_projector = {
    .eye =
        {
            [LUM_EYE_BLUE] = {
                .mount = {INT64_C(134217728), INT64_C(134217728), INT64_C(134217728)},
                .range_base = UINT64_C(136150463148),
                .range_lsb = UINT32_C(32715571),
                .first_tof = INT32_C(1),
                .azimuth = {.center = UINT32_C(0), .whole = UINT32_C(10922), .part = INT32_C(21846)},
                .elevation = {.center = UINT32_C(4211454044), .whole = UINT32_C(3640), .part = INT32_C(29128)},
                .axes =
                    {
                        {INT32_C(929887660), INT32_C(536870912), INT32_C(0)},
                        {INT32_C(-536870912), INT32_C(929887660), INT32_C(0)},
                        {INT32_C(0), INT32_C(0), INT32_C(1073741824)},
                    },
            },
            [LUM_EYE_GREEN] = {
                .mount = {INT64_C(134217728), INT64_C(134217728), INT64_C(134217728)},
                .range_base = UINT64_C(136150463148),
                .range_lsb = UINT32_C(32715571),
                .first_tof = INT32_C(1),
                .azimuth = {.center = UINT32_C(0), .whole = UINT32_C(10922), .part = INT32_C(21846)},
                .elevation = {.center = UINT32_C(4211454044), .whole = UINT32_C(3640), .part = INT32_C(29128)},
                .axes =
                    {
                        {INT32_C(929887660), INT32_C(-536870912), INT32_C(0)},
                        {INT32_C(536870912), INT32_C(929887660), INT32_C(0)},
                        {INT32_C(0), INT32_C(0), INT32_C(1073741824)},
                    },
            },
        },
};
