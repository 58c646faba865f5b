/* Code in C that reads data packets of one layout alone. */
#include "c_text.h"
#include "lum/version.h"

#include <inttypes.h>
#include <stdbool.h>

/* --- Fields --- */

/* Where a field's bits are read: the fewest bytes that have all of them. */
struct place {
    unsigned at;
    unsigned bytes; /* 1, 2, 4 or 8 */
    unsigned shift;
    unsigned bits;
    bool is_big;
};

static unsigned bits_of(const lum_field *field)
{
    return field->bits > 0 ? field->bits : 8u * field->bytes;
}

static bool is_wide(const lum_field *field)
{
    return bits_of(field) > 32u;
}

static struct place place_of(const lum_field *field)
{
    const unsigned end = (field->low + bits_of(field) + 7u) / 8u;
    unsigned lowest = field->low / 8u;
    unsigned bytes = 1;
    while (bytes < end - lowest) {
        bytes *= 2u;
    }
    if (lowest + bytes > field->bytes) {
        lowest = field->bytes - bytes;
    }
    const bool is_big = field->order == LUM_ORDER_BIG;
    const struct place place = {
        .at = field->at + (is_big ? field->bytes - lowest - bytes : lowest),
        .bytes = bytes,
        .shift = field->low - 8u * lowest,
        .bits = bits_of(field),
        .is_big = is_big,
    };
    return place;
}

static void put_load(struct source *out, const struct place *p)
{
    if (p->bytes == 1) {
        put(out, "b[%u]", p->at);
    } else {
        put(out, "load_%su%u(b + %u)", p->is_big ? "big_" : "", 8u * p->bytes,
            p->at);
    }
}

/* An expression of 64 bits, or one that 32 hold. */
static void put_value(struct source *out, const lum_field *field)
{
    const struct place p = place_of(field);
    if (p.bits > 32u) {
        put_load(out, &p);
    } else if (p.bytes == 8u) { /* then there is a shift */
        put(out, "(uint32_t)(");
        put_load(out, &p);
        put(out, " >> %u)", p.shift);
    } else {
        put(out, "%s", p.shift > 0 && p.bytes < 4u ? "(uint32_t)" : "");
        put_load(out, &p);
    }
    if (p.shift > 0 && (p.bits > 32u || p.bytes < 8u)) {
        put(out, " >> %u", p.shift);
    }
    if (p.shift + p.bits < 8u * p.bytes && p.bits != 32u) {
        put(out, " & 0x%" PRIx64 "u", UINT64_MAX >> (64u - p.bits));
    }
}

static void put_variable(struct source *out, const char *name,
                         const lum_field *field)
{
    put(out, "    const uint%u_t %s = ", is_wide(field) ? 64u : 32u, name);
    put_value(out, field);
    put(out, ";\n");
}

/* --- The layout --- */

static void put_head(struct source *out, const struct origin *o)
{
    put(out,
        "/* Packets of one layout alone, in place of layout_any.c: less "
        "code, and faster.\n"
        " * Made by lumtable " LUM_VERSION "; not to be changed by hand.\n");
    put_origin(out, "profile", o->profile);
    put_settings(out, o->set);
    put(out,
        " */\n"
        "#include \"layout.h\"\n"
        "\n"
        "#include \"bytes.h\"\n"
        "#include \"clock.h\"\n"
        "#include \"group.h\"\n"
        "\n"
        "#include <stddef.h>\n"
        "#include <string.h>\n"
        "\n"
        "#if LUM_LAYOUT_VERSION != %d\n"
        "#error \"made for another version of lumsdk: make it again with its "
        "lumtable\"\n"
        "#endif\n"
        "\n",
        LUM_LAYOUT_VERSION);
}

static void put_field(struct source *out, unsigned f, const lum_field *field)
{
    put(out, "        [LUM_FIELD_%s] = ", field_name(f));
    if (field->order == LUM_ORDER_LITTLE && field->bits == 0) {
        put(out, "{.at = %u, .bytes = %u},\n", field->at, field->bytes);
    } else {
        put(out, "{%u, %u, %s, %u, %u},\n", field->at, field->bytes,
            order_name(field->order), field->low, field->bits);
    }
}

static void put_profile(struct source *out, const lum_profile *p)
{
    put(out,
        "#define SAMPLES_AT %uu\n"
        "#define BLUE       %" PRIu32 "u\n"
        "#define GREEN      %" PRIu32 "u\n"
        "#define UNIT_NS    %" PRIu32 "u\n"
        "\n"
        "/* As they stand in a lum_profile. */\n"
        "static const struct fields {\n"
        "    lum_field group[LUM_GROUP_FIELDS];\n"
        "    uint8_t samples_at;\n"
        "} own = {\n"
        "    {\n",
        p->samples_at, p->eye_values[LUM_EYE_BLUE],
        p->eye_values[LUM_EYE_GREEN], p->clock_unit_ns);
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        put_field(out, f, &p->group[f]);
    }
    put(out,
        "    },\n"
        "    SAMPLES_AT,\n"
        "};\n"
        "\n"
        "bool lum_layout_is_read(const lum_layout *layout)\n"
        "{\n"
        "    const lum_profile *p = &layout->profile;\n"
        "    return p->sample_order == %s &&\n"
        "           p->angle_order == %s &&\n"
        "           p->eye_values[LUM_EYE_BLUE] == BLUE &&\n"
        "           p->eye_values[LUM_EYE_GREEN] == GREEN &&\n"
        "           p->clock_unit_ns == UNIT_NS &&\n"
        "           memcmp((const uint8_t *)p + offsetof(lum_profile, group), "
        "&own,\n"
        "                  sizeof own) == 0;\n"
        "}\n"
        "\n",
        order_name(p->sample_order), angle_order_name(p->angle_order));
}

/* --- lum_group_decode() --- */

/* Of two numbers that follow each other, the eye is the distance from BLUE. */
static const char *eye_of(const lum_profile *p)
{
    const uint32_t blue = p->eye_values[LUM_EYE_BLUE];
    const uint32_t green = p->eye_values[LUM_EYE_GREEN];
    if (green == blue + 1u && blue < UINT32_MAX) {
        return blue == 0 ? "eye" : "eye - BLUE";
    }
    return blue == green + 1u && green < UINT32_MAX ? "BLUE - eye" : NULL;
}

/* What is wrong with the number of samples or the eye, where anything can be.
 */
static void put_check(struct source *out, const lum_profile *p)
{
    const bool has_room = bits_of(&p->group[LUM_FIELD_NUM_SAMPLES]) > 1u;
    const char *eye = eye_of(p);
    const bool has_eye = bits_of(&p->group[LUM_FIELD_EYE]) > 1u;
    if (!has_room && !has_eye) {
        return;
    }
    put(out, "    if (%s%s", has_room ? "n > room" : "",
        has_room && has_eye ? " || " : "");
    if (has_eye && eye != NULL) {
        put(out, "%s > 1u", eye);
    } else if (has_eye) {
        put(out, has_room ? "(%s)" : "%s", "eye != BLUE && eye != GREEN");
    }
    put(out, ") {\n        return LUM_E_MALFORMED;\n    }\n");
}

/* There is no line, and no first sample, above 32 bits. */
static void put_check_excess(struct source *out, const lum_field *group)
{
    const bool line = is_wide(&group[LUM_FIELD_LINE]);
    const bool first = is_wide(&group[LUM_FIELD_FIRST_SAMPLE_INDEX]);
    if (line || first) {
        put(out,
            "    if (%s%s%s) {\n"
            "        return LUM_E_MALFORMED;\n"
            "    }\n",
            line ? "line > UINT32_MAX" : "", line && first ? " || " : "",
            first ? "first > UINT32_MAX" : "");
    }
}

static const char *cast(const lum_field *field)
{
    return is_wide(field) ? "(uint32_t)" : "";
}

static void put_variables(struct source *out, const lum_field *group)
{
    const lum_field *n = &group[LUM_FIELD_NUM_SAMPLES];
    if (n->bytes == 0 || bits_of(n) > 1u) {
        put(out, "%s(uint32_t)((len - SAMPLES_AT) / LUM_SAMPLE_BYTES);\n",
            n->bytes == 0 ? "    const uint32_t n = "
                          : "    const uint32_t room = ");
    }
    put_variable(out, "tag", &group[LUM_FIELD_TAG]);
    put_variable(out, "eye", &group[LUM_FIELD_EYE]);
    if (n->bytes > 0) {
        put_variable(out, "n", n);
    }
    put_variable(out, "first", &group[LUM_FIELD_FIRST_SAMPLE_INDEX]);
    if (is_wide(&group[LUM_FIELD_LINE])) {
        put_variable(out, "line", &group[LUM_FIELD_LINE]);
    }
}

static void put_results(struct source *out, const lum_profile *p)
{
    const lum_field *group = p->group;
    const char *eye = eye_of(p);
    put(out, "    out->samples = b + SAMPLES_AT;\n    out->clock_raw = ");
    if (group[LUM_FIELD_TIMESTAMP].bytes > 0) {
        put_value(out, &group[LUM_FIELD_TIMESTAMP]);
    } else {
        put(out, "0");
    }
    put(out, ";\n    out->line = ");
    if (is_wide(&group[LUM_FIELD_LINE])) {
        put(out, "(uint32_t)line");
    } else {
        put_value(out, &group[LUM_FIELD_LINE]);
    }
    put(out,
        ";\n"
        "    out->num_samples = %sn;\n"
        "    out->first_sample_index = %sfirst;\n"
        "    out->eye = ",
        cast(&group[LUM_FIELD_NUM_SAMPLES]),
        cast(&group[LUM_FIELD_FIRST_SAMPLE_INDEX]));
    if (eye == NULL) {
        put(out, "eye == BLUE ? LUM_EYE_BLUE : LUM_EYE_GREEN");
    } else {
        put(out,
            p->eye_values[LUM_EYE_BLUE] == 0 ? "(uint8_t)%s" : "(uint8_t)(%s)",
            eye);
    }
    put(out,
        ";\n"
        "    out->tag = (uint8_t)tag;\n"
        "    out->sample_order = %s;\n"
        "    return LUM_OK;\n"
        "}\n"
        "\n",
        order_name(p->sample_order));
}

static void put_decode(struct source *out, const lum_profile *p)
{
    const lum_field *group = p->group;
    const bool is_tag_wide = is_wide(&group[LUM_FIELD_TAG]);
    put(out, "lum_result lum_group_decode(const lum_layout *layout, const void "
             "*bytes,\n"
             "                            size_t len, lum_group *out)\n"
             "{\n"
             "    const uint8_t *b = bytes;\n"
             "    (void)layout;\n"
             "    if (len < SAMPLES_AT + LUM_SAMPLE_BYTES) {\n"
             "        return LUM_E_MALFORMED;\n"
             "    }\n");
    put_variables(out, group);
    put_check_excess(out, group);
    put_check(out, p);
    if (is_tag_wide) {
        put(out, "    const uint32_t known = tag > UINT32_MAX ? 0 : "
                 "(uint32_t)tag;\n");
    }
    put(out,
        "    const lum_result r = lum_group_check(%s, %sn, %sfirst);\n"
        "    if (r != LUM_OK) {\n"
        "        return r;\n"
        "    }\n",
        is_tag_wide ? "known" : "tag", cast(&group[LUM_FIELD_NUM_SAMPLES]),
        cast(&group[LUM_FIELD_FIRST_SAMPLE_INDEX]));
    put_results(out, p);
}

/* --- The clock --- */

/* How often 1000 is halved to it; 0: never. */
static unsigned halvings(uint32_t unit_ns)
{
    unsigned n = 3u;
    while (n > 0 && unit_ns != 1000u >> n) {
        n--;
    }
    return n;
}

/* Of 1000 ns a tick, of a multiple, and of a half, a quarter or an eighth there
 * is nothing to divide. */
static void put_us(struct source *out, uint32_t unit_ns)
{
    const uint32_t us = unit_ns / 1000u;
    const unsigned shift = halvings(unit_ns);
    if (unit_ns == 1000u) {
        put(out, "    return signed64(*ticks);\n");
    } else if (unit_ns % 1000u == 0) {
        put(out,
            "    const uint32_t high = (uint32_t)(*ticks >> 32) * %" PRIu32
            "u;\n"
            "    const uint32_t low = (uint32_t)*ticks;\n"
            "    return signed64(((uint64_t)high << 32) + "
            "product_unsigned(low, %" PRIu32 "u));\n",
            us, us);
    } else if (shift > 0) {
        put(out,
            "    /* Ticks below 0 are below 2^64 as much, and lifted "
            "meanwhile. */\n"
            "    const uint64_t lift = UINT64_C(1000) << 52;\n"
            "    return signed64(((*ticks + lift) >> %u) - (lift >> %u));\n",
            shift, shift);
    } else {
        put(out, "    return lum_clock_us(*ticks, UNIT_NS);\n");
    }
}

/* How far a packet's clock is beyond the lowest that it can be. */
static void put_ticks(struct source *out, unsigned bits, uint64_t mask)
{
    put(out, "    const uint64_t lowest = clock->lowest;\n");
    if (bits > 32u) {
        put(out, "    const uint64_t ahead = group->clock_raw - lowest;\n");
    } else {
        put(out, "    const uint32_t ahead = (uint32_t)group->clock_raw - "
                 "(uint32_t)lowest;\n");
    }
    if (bits == 32u) {
        put(out, "    *ticks = lowest + ahead;\n");
    } else {
        put(out, "    *ticks = lowest + (ahead & 0x%" PRIx64 "u);\n", mask);
    }
}

static void put_clock(struct source *out, const lum_profile *p)
{
    const unsigned all = bits_of(&p->group[LUM_FIELD_TIMESTAMP]);
    const unsigned bits = all < 64u ? all : 63u;
    const uint64_t mask = bits > 0 ? UINT64_MAX >> (64u - bits) : 0;
    put(out, "void lum_clock_init(lum_clock *clock, const lum_profile "
             "*profile)\n"
             "{\n"
             "    (void)profile;\n");
    if (bits > 0) {
        put(out, "    clock->half = 0x%" PRIx64 "u;\n", mask ^ mask >> 1);
    } else {
        put(out, "    (void)clock;\n");
    }
    put(out, "}\n"
             "\n"
             "int64_t lum_clock_follow(const lum_clock *clock, const lum_group "
             "*group,\n"
             "                         uint64_t *ticks)\n"
             "{\n");
    if (bits > 0) {
        put_ticks(out, bits, mask);
        put_us(out, p->clock_unit_ns);
    } else {
        put(out, "    (void)clock;\n"
                 "    (void)group;\n"
                 "    *ticks = 0;\n"
                 "    return 0;\n");
    }
    put(out, "}\n\n");
}

/* --- All of it --- */

static void put_samples(struct source *out, const lum_profile *p)
{
    const char *big = p->sample_order == LUM_ORDER_BIG ? "big_" : "";
    const unsigned swap = p->angle_order == LUM_ELEVATION_AZIMUTH ? 1u : 0u;
    put(out,
        "void lum_layout_copy_angles(lum_angle *to, const lum_group *group,\n"
        "                            uint8_t angle_order)\n"
        "{\n"
        "    uint16_t *restrict numbers = (uint16_t *)to;\n"
        "    const uint8_t *restrict from = group->samples;\n"
        "    const uint16_t *const end = numbers + (size_t)2 * "
        "group->num_samples;\n"
        "    (void)angle_order;\n"
        "    for (; numbers != end; numbers += 2) {\n"
        "        numbers[%u] = load_%su16(from);\n"
        "        numbers[%u] = load_%su16(from + 2);\n"
        "        from += LUM_SAMPLE_BYTES;\n"
        "    }\n"
        "}\n"
        "\n"
        "uint32_t lum_group_word(const lum_group *group, uint32_t i)\n"
        "{\n"
        "    return load_%su32(group->samples + (size_t)LUM_SAMPLE_BYTES * "
        "i);\n"
        "}\n",
        swap, big, swap ^ 1u, big, big);
}

void layout_write(struct source *out, const struct origin *origin,
                  const lum_layout *layout)
{
    const lum_profile *p = &layout->profile;
    put_head(out, origin);
    put_profile(out, p);
    put_decode(out, p);
    put_clock(out, p);
    put_samples(out, p);
}
