/* A layout and a fixed projector as constants in C. */
#include "c_text.h"
#include "lum/version.h"

#include <inttypes.h>

/* A field that is new has to be written too. Where 64 bits are aligned as 32,
 * structs are shorter. */
typedef char all_of_a_field[sizeof(lum_field) == 5 ? 1 : -1];
typedef char all_of_a_profile
    [sizeof(lum_profile) == 72 || sizeof(lum_profile) == 68 ? 1 : -1];
typedef char all_of_an_eye
    [sizeof(lum_fixed_eye) == 104 || sizeof(lum_fixed_eye) == 100 ? 1 : -1];

static void put_head(struct source *out, const struct origin *o)
{
    put(out,
        "/* Made by lumtable " LUM_VERSION "; not to be changed by hand.\n");
    put_origin(out, "profile", o->profile);
    put_origin(out, "calibration", o->calibration);
    put_settings(out, o->set);
    put(out,
        " */\n"
        "/* clang-format off */\n"
        "#include \"lum/points_fixed.h\"\n"
        "#include \"lum/profile.h\"\n"
        "\n"
        "#include <stdint.h>\n"
        "\n"
        "#if LUM_LAYOUT_VERSION != %d || LUM_FIXED_PROJECTOR_VERSION != %d\n"
        "#error \"made for another version of lumsdk: make it again with the "
        "lumtable of this one\"\n"
        "#endif\n"
        "\n"
        "extern const lum_layout %s_layout;\n"
        "extern const lum_fixed_projector %s_projector;\n"
        "\n",
        LUM_LAYOUT_VERSION, LUM_FIXED_PROJECTOR_VERSION, o->name, o->name);
}

static void put_fields(struct source *out, const lum_field *group)
{
    put(out, "            .group =\n                {\n");
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        put(out,
            "                    [LUM_FIELD_%s] = {.at = %u, .bytes = %u, "
            ".order = %s, .low = %u, .bits = %u},\n",
            field_name(f), group[f].at, group[f].bytes,
            order_name(group[f].order), group[f].low, group[f].bits);
    }
    put(out, "                },\n");
}

static void put_layout(struct source *out, const char *name,
                       const lum_profile *p)
{
    put(out,
        "const lum_layout %s_layout = {\n"
        "    .profile =\n"
        "        {\n"
        "            .data_packet_type = %" PRIu32 "u,\n",
        name, p->data_packet_type);
    put_fields(out, p->group);
    put(out,
        "            .samples_at = %u,\n"
        "            .set_ip_order = %s,\n"
        "            .angle_order = %s,\n"
        "            .sample_order = %s,\n",
        p->samples_at,
        p->set_ip_order == LUM_SET_IP_NETWORK ? "LUM_SET_IP_NETWORK"
                                              : "LUM_SET_IP_LITTLE",
        angle_order_name(p->angle_order), order_name(p->sample_order));
    put(out,
        "            .eye_values = {[LUM_EYE_BLUE] = UINT32_C(%" PRIu32
        "), [LUM_EYE_GREEN] = UINT32_C(%" PRIu32 ")},\n",
        p->eye_values[LUM_EYE_BLUE], p->eye_values[LUM_EYE_GREEN]);
    put(out,
        "            .tlv = {[LUM_TLV_COMMAND] = %uu, [LUM_TLV_STATUS] = %uu, "
        "[LUM_TLV_DEBUG] = %uu, [LUM_TLV_YSCAN] = %uu},\n",
        p->tlv[LUM_TLV_COMMAND], p->tlv[LUM_TLV_STATUS], p->tlv[LUM_TLV_DEBUG],
        p->tlv[LUM_TLV_YSCAN]);
    put(out,
        "            .angle_lsb_pdeg = UINT64_C(%" PRIu64 "),\n"
        "            .line_span_us = UINT32_C(%" PRIu32 "),\n"
        "            .clock_unit_ns = UINT32_C(%" PRIu32 "),\n"
        "        },\n"
        "};\n"
        "\n",
        p->angle_lsb_pdeg, p->line_span_us, p->clock_unit_ns);
}

static void put_axis(struct source *out, const char *name,
                     const lum_fixed_axis *axis)
{
    put(out,
        "                .%s = {.center = UINT32_C(%" PRIu32
        "), .whole = UINT32_C(%" PRIu32 "), .part = INT32_C(%" PRId32 ")},\n",
        name, axis->center, axis->whole, axis->part);
}

static void put_eye(struct source *out, const char *name,
                    const lum_fixed_eye *e)
{
    put(out,
        "            [LUM_EYE_%s] = {\n"
        "                .mount = {INT64_C(%" PRId64 "), INT64_C(%" PRId64
        "), INT64_C(%" PRId64 ")},\n",
        name, e->mount[0], e->mount[1], e->mount[2]);
    put(out,
        "                .range_base = UINT64_C(%" PRIu64 "),\n"
        "                .range_lsb = UINT32_C(%" PRIu32 "),\n"
        "                .first_tof = INT32_C(%" PRId32 "),\n",
        e->range_base, e->range_lsb, e->first_tof);
    put_axis(out, "azimuth", &e->azimuth);
    put_axis(out, "elevation", &e->elevation);
    put(out, "                .axes =\n                    {\n");
    for (unsigned i = 0; i < 3; i++) {
        put(out,
            "                        {INT32_C(%" PRId32 "), INT32_C(%" PRId32
            "), INT32_C(%" PRId32 ")},\n",
            e->axes[i][0], e->axes[i][1], e->axes[i][2]);
    }
    put(out, "                    },\n            },\n");
}

void tables_write(struct source *out, const struct origin *origin,
                  const lum_layout *layout,
                  const lum_fixed_projector *projector)
{
    put_head(out, origin);
    put_layout(out, origin->name, &layout->profile);
    put(out,
        "const lum_fixed_projector %s_projector = {\n"
        "    .eye =\n"
        "        {\n",
        origin->name);
    put_eye(out, "BLUE", &projector->eye[LUM_EYE_BLUE]);
    put_eye(out, "GREEN", &projector->eye[LUM_EYE_GREEN]);
    put(out, "        },\n};\n");
}
