/* Made by lumtable 0.1.0; not to be changed by hand.
 *   profile: odd.profile.yaml
 *   calibration: odd.calibration.yaml
 */
/* clang-format off */
#include "lum/points_fixed.h"
#include "lum/profile.h"

#include <stdint.h>

#if LUM_LAYOUT_VERSION != 2 || LUM_FIXED_PROJECTOR_VERSION != 1
#error "made for another version of lumsdk: make it again with the lumtable of this one"
#endif

extern const lum_layout odd_layout;
extern const lum_fixed_projector odd_projector;

const lum_layout odd_layout = {
    .profile =
        {
            .data_packet_type = 200u,
            .group =
                {
                    [LUM_FIELD_TAG] = {.at = 60, .bytes = 1, .order = LUM_ORDER_BIG, .low = 2, .bits = 5},
                    [LUM_FIELD_EYE] = {.at = 30, .bytes = 4, .order = LUM_ORDER_LITTLE, .low = 0, .bits = 0},
                    [LUM_FIELD_LINE] = {.at = 16, .bytes = 4, .order = LUM_ORDER_BIG, .low = 1, .bits = 30},
                    [LUM_FIELD_NUM_SAMPLES] = {.at = 40, .bytes = 1, .order = LUM_ORDER_LITTLE, .low = 0, .bits = 0},
                    [LUM_FIELD_FIRST_SAMPLE_INDEX] = {.at = 44, .bytes = 4, .order = LUM_ORDER_LITTLE, .low = 0, .bits = 0},
                    [LUM_FIELD_TIMESTAMP] = {.at = 50, .bytes = 8, .order = LUM_ORDER_BIG, .low = 3, .bits = 59},
                },
            .samples_at = 63,
            .set_ip_order = LUM_SET_IP_LITTLE,
            .angle_order = LUM_ELEVATION_AZIMUTH,
            .sample_order = LUM_ORDER_BIG,
            .eye_values = {[LUM_EYE_BLUE] = UINT32_C(4294967295), [LUM_EYE_GREEN] = UINT32_C(7)},
            .tlv = {[LUM_TLV_COMMAND] = 65535u, [LUM_TLV_STATUS] = 20u, [LUM_TLV_DEBUG] = 300u, [LUM_TLV_YSCAN] = 4000u},
            .angle_lsb_pdeg = UINT64_C(1234567891),
            .line_span_us = UINT32_C(1000000000),
            .clock_unit_ns = UINT32_C(999),
        },
};

const lum_fixed_projector odd_projector = {
    .eye =
        {
            [LUM_EYE_BLUE] = {
                .mount = {INT64_C(-4294967115782272), INT64_C(4294967384217728), INT64_C(-530105259088)},
                .range_base = UINT64_C(317594730446156416),
                .range_lsb = UINT32_C(31045717),
                .first_tof = INT32_C(524288),
                .azimuth = {.center = UINT32_C(0), .whole = UINT32_C(14728), .part = INT32_C(31740)},
                .elevation = {.center = UINT32_C(3834153097), .whole = UINT32_C(14728), .part = INT32_C(31740)},
                .axes =
                    {
                        {INT32_C(-761791404), INT32_C(347434796), INT32_C(-672223472)},
                        {INT32_C(52098508), INT32_C(-927525800), INT32_C(-538426512)},
                        {INT32_C(-754904700), INT32_C(-414615984), INT32_C(641197272)},
                    },
            },
            [LUM_EYE_GREEN] = {
                .mount = {INT64_C(2147617842728), INT64_C(-1073607594772), INT64_C(4294967379922760)},
                .range_base = UINT64_C(53321810231),
                .range_lsb = UINT32_C(31045717),
                .first_tof = INT32_C(-5),
                .azimuth = {.center = UINT32_C(0), .whole = UINT32_C(14728), .part = INT32_C(31740)},
                .elevation = {.center = UINT32_C(25352238), .whole = UINT32_C(14728), .part = INT32_C(31740)},
                .axes =
                    {
                        {INT32_C(-41836892), INT32_C(-225731672), INT32_C(-1048912036)},
                        {INT32_C(-191149036), INT32_C(-1031347936), INT32_C(229575932)},
                        {INT32_C(-1055761944), INT32_C(195673904), INT32_C(0)},
                    },
            },
        },
};
