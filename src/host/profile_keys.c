/* The keys of a wire profile, and the messages for values that clash. */
#include "keys_internal.h"

#include <stdbool.h>
#include <string.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

/* The values in order; a group field has four. */
enum {
    AT,
    BYTES,
    ORDER,
    BITS,
    FIELD_VALUES
};
enum {
    VERSION = LUM_KEYS_VERSION,
    DATA_PACKET_TYPE,
    SET_IP_ORDER,
    ANGLE_ORDER,
    SAMPLE_ORDER,
    ANGLE_LSB,
    LINE_SPAN,
    CLOCK_UNIT,
    EYE,
    TLV = EYE + LUM_EYES,
    GROUP = TLV + LUM_TLV_USES,
    SAMPLES = GROUP + LUM_GROUP_FIELDS * FIELD_VALUES,
    VALUES
};

/* An offset that is none. */
#define NOWHERE (-1)

/* Bits that are not named. */
#define ALL_BITS (-1)

static const lum_key_word orders_of_ip[] = {{"network", LUM_SET_IP_NETWORK},
                                            {"little", LUM_SET_IP_LITTLE},
                                            {.text = NULL}};
static const lum_key_word orders_of_angles[] = {
    {"azimuth_elevation", LUM_AZIMUTH_ELEVATION},
    {"elevation_azimuth", LUM_ELEVATION_AZIMUTH},
    {.text = NULL}};
static const lum_key_word byte_orders[] = {
    {"little", LUM_ORDER_LITTLE}, {"big", LUM_ORDER_BIG}, {.text = NULL}};
static const lum_key_word all[] = {{"all", ALL_BITS}, {.text = NULL}};
static const lum_key_word span[] = {{"span", 0}, {.text = NULL}};
static const lum_key_word none[] = {{"none", NOWHERE}, {.text = NULL}};

static const lum_key_rule packet_type = {
    .min = 0,
    .max = 255,
    .whole = true,
    .allowed = "0 to 255, but not 5, 6 or 7 (set IP, timestamp, TLV)"};
static const lum_key_rule ip_order = {
    .words = orders_of_ip, .min = 0, .max = -1};
static const lum_key_rule angle_order = {
    .words = orders_of_angles, .min = 0, .max = -1};
static const lum_key_rule byte_order = {.words = byte_orders,
                                        .min = 0,
                                        .max = -1,
                                        .rare = true,
                                        .usual = LUM_ORDER_LITTLE};
static const lum_key_rule bit_pair = {
    .words = all,
    .min = 0,
    .max = 63,
    .pair = true,
    .rare = true,
    .usual = ALL_BITS,
    .allowed = "[LOW, HIGH], both included, 0 to 63"};
static const lum_key_rule clock_unit = {.min = 1,
                                        .max = LUM_CLOCK_UNIT_MAX_NS,
                                        .whole = true,
                                        .rare = true,
                                        .usual = 1000,
                                        .unit = "ns"};
static const lum_key_rule angle_lsb = {.words = span,
                                       .min = 1,
                                       .max = (int64_t)LUM_ANGLE_LSB_MAX_PDEG,
                                       .decimals = 12,
                                       .unit = "deg"};
static const lum_key_rule line_span = {
    .min = 0, .max = LUM_LINE_SPAN_MAX_US, .whole = true, .unit = "us"};
static const lum_key_rule eye_value = {
    .min = 0, .max = UINT32_MAX, .whole = true};
static const lum_key_rule tlv_number = {
    .min = 0, .max = UINT16_MAX, .whole = true};
static const lum_key_rule offset = {
    .min = 8, .max = 64, .whole = true, .allowed = "an offset from 8 to 64"};
static const lum_key_rule offset_or_none = {.words = none,
                                            .min = 8,
                                            .max = 64,
                                            .whole = true,
                                            .allowed =
                                                "an offset from 8 to 64"};
static const lum_key_rule bytes = {
    .min = 1, .max = 8, .whole = true, .allowed = "1, 2, 4 or 8"};

#define FIELD(f) (GROUP + FIELD_VALUES * (f))

/* An offset alone leaves the width as it is. */
#define GROUP_FIELD(name, field, rule)                                         \
    {"group." name, FIELD(field) + AT, rule},                                  \
        {"group." name ".at", FIELD(field) + AT, &offset},                     \
        {"group." name ".bytes", FIELD(field) + BYTES, &bytes},                \
        {"group." name ".order", FIELD(field) + ORDER, &byte_order},           \
    {                                                                          \
        "group." name ".bits", FIELD(field) + BITS, &bit_pair                  \
    }

static const lum_key_entry entries[] = {
    {"version", VERSION, &lum_key_version},
    {"data_packet_type", DATA_PACKET_TYPE, &packet_type},
    {"set_ip_order", SET_IP_ORDER, &ip_order},
    GROUP_FIELD("tag", LUM_FIELD_TAG, &offset),
    GROUP_FIELD("eye", LUM_FIELD_EYE, &offset),
    GROUP_FIELD("line", LUM_FIELD_LINE, &offset),
    GROUP_FIELD("num_samples", LUM_FIELD_NUM_SAMPLES, &offset_or_none),
    GROUP_FIELD("first_sample_index", LUM_FIELD_FIRST_SAMPLE_INDEX, &offset),
    GROUP_FIELD("timestamp", LUM_FIELD_TIMESTAMP, &offset_or_none),
    {"group.timestamp.unit_ns", CLOCK_UNIT, &clock_unit},
    {"group.samples", SAMPLES, &offset},
    {"eye_values.blue", EYE + LUM_EYE_BLUE, &eye_value},
    {"eye_values.green", EYE + LUM_EYE_GREEN, &eye_value},
    {"angle_order", ANGLE_ORDER, &angle_order},
    {"sample_order", SAMPLE_ORDER, &byte_order},
    {"angle_lsb_deg", ANGLE_LSB, &angle_lsb},
    {"tlv.command", TLV + LUM_TLV_COMMAND, &tlv_number},
    {"tlv.status", TLV + LUM_TLV_STATUS, &tlv_number},
    {"tlv.debug", TLV + LUM_TLV_DEBUG, &tlv_number},
    {"tlv.yscan", TLV + LUM_TLV_YSCAN, &tlv_number},
    {"line_span_us", LINE_SPAN, &line_span},
};
const lum_key_table lum_profile_keys = {entries, COUNT(entries)};

/* Each value has a key, and the offset of a field two. Else this does not
 * compile. */
typedef char every_value_has_its_key
    [COUNT(entries) == VALUES + (size_t)LUM_GROUP_FIELDS ? 1 : -1];

/* The shortest key of a value, for messages; each has one. */
static const char *path_of(unsigned index)
{
    size_t i = 0;
    while (entries[i].index != index) {
        i++;
    }
    return entries[i].path;
}

/* --- Values of a profile, and back --- */

static void put_field(lum_key_value *v, const lum_field *field)
{
    v[AT].number = field->at;
    v[BYTES].number = field->bytes;
    v[ORDER].number = field->order;
    v[BITS].number = field->bits == 0
                         ? ALL_BITS
                         : LUM_KEY_PAIR((int64_t)field->low,
                                        (int64_t)field->low + field->bits - 1);
}

void lum_keys_of_profile(lum_keys *out, const lum_profile *start)
{
    lum_profile usual;
    const lum_profile *p = start != NULL ? start : &usual;
    lum_key_value *v = out->values;
    lum_profile_default(&usual);
    memset(out, 0, sizeof *out);
    out->kind = LUM_KEYS_PROFILE;
    out->is_default = start == NULL;
    v[VERSION].number = 1;
    v[DATA_PACKET_TYPE].number = p->data_packet_type;
    v[SET_IP_ORDER].number = p->set_ip_order;
    v[ANGLE_ORDER].number = p->angle_order;
    v[ANGLE_LSB].number = (int64_t)p->angle_lsb_pdeg;
    v[LINE_SPAN].number = p->line_span_us;
    v[SAMPLE_ORDER].number = p->sample_order;
    for (unsigned i = 0; i < LUM_EYES; i++) {
        v[EYE + i].number = p->eye_values[i];
    }
    for (unsigned i = 0; i < LUM_TLV_USES; i++) {
        v[TLV + i].number = p->tlv[i];
    }
    /* An offset that is set later needs a width. */
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        const bool is_nowhere = p->group[f].bytes == 0;
        put_field(v + FIELD(f), is_nowhere ? &usual.group[f] : &p->group[f]);
        if (is_nowhere) {
            v[FIELD(f) + AT].number = NOWHERE;
        }
    }
    v[CLOCK_UNIT].number = p->group[LUM_FIELD_TIMESTAMP].bytes == 0
                               ? usual.clock_unit_ns
                               : p->clock_unit_ns;
    v[SAMPLES].number = p->samples_at;
}

static lum_field take_field(const lum_key_value *v)
{
    const lum_field nowhere = {.bytes = 0};
    lum_field there = {.at = (uint8_t)v[AT].number,
                       .bytes = (uint8_t)v[BYTES].number,
                       .order = (uint8_t)v[ORDER].number};
    if (v[BITS].number != ALL_BITS) {
        const int64_t low = LUM_KEY_PAIR_LOW(v[BITS].number);
        const int64_t high = LUM_KEY_PAIR_HIGH(v[BITS].number);
        there.low = (uint8_t)low;
        there.bits = (uint8_t)(high - low + 1);
    }
    return v[AT].number == NOWHERE ? nowhere : there;
}

static void take(const lum_key_value *v, lum_profile *p)
{
    memset(p, 0, sizeof *p);
    p->data_packet_type = (uint32_t)v[DATA_PACKET_TYPE].number;
    p->set_ip_order = (uint8_t)v[SET_IP_ORDER].number;
    p->angle_order = (uint8_t)v[ANGLE_ORDER].number;
    p->angle_lsb_pdeg = (uint64_t)v[ANGLE_LSB].number;
    p->line_span_us = (uint32_t)v[LINE_SPAN].number;
    p->clock_unit_ns = (uint32_t)v[CLOCK_UNIT].number;
    p->sample_order = (uint8_t)v[SAMPLE_ORDER].number;
    for (unsigned i = 0; i < LUM_EYES; i++) {
        p->eye_values[i] = (uint32_t)v[EYE + i].number;
    }
    for (unsigned i = 0; i < LUM_TLV_USES; i++) {
        p->tlv[i] = (uint16_t)v[TLV + i].number;
    }
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        p->group[f] = take_field(v + FIELD(f));
    }
    p->samples_at = (uint8_t)v[SAMPLES].number;
}

/* A profile that the core refuses, and what to say about it. */
typedef struct refusal {
    const lum_keys *keys;
    const lum_profile *profile;
    unsigned index; /* of the culprit, as lum_layout_init() gives it */
} refusal;

/* A value that may be to blame. */
typedef struct culprit {
    const char *path;
    uint32_t place; /* 0: it was not set */
} culprit;

/* --- Messages: which key is blamed --- */

static uint32_t place_of(const refusal *r, unsigned index)
{
    return r->keys->values[index].place;
}

/* Of a field's values, the one that was set last. */
static culprit field_culprit(const refusal *r, unsigned f)
{
    culprit c = {path_of(FIELD(f) + AT), 0};
    for (unsigned i = 0; i < FIELD_VALUES; i++) {
        const uint32_t place = place_of(r, FIELD(f) + i);
        c.place = place > c.place ? place : c.place;
    }
    return c;
}

static const char *origin(const refusal *r, const culprit *c)
{
    return lum_keys_origin(r->keys, c->place);
}

static lum_key_text begin(lum_key_refusal *why, const culprit *c)
{
    return lum_key_refuse(why, c->path, c->place);
}

/* Adds a number between two strings. */
static void add(lum_key_text *text, const char *before, int64_t number,
                const char *behind)
{
    lum_key_text_add(text, before);
    lum_key_text_add_number(text, number, 0);
    lum_key_text_add(text, behind);
}

/* --- Messages: one for each fault of a profile --- */

static void refuse_type(const refusal *r, lum_key_refusal *why)
{
    lum_key_text text =
        lum_key_refuse(why, "data_packet_type", place_of(r, DATA_PACKET_TYPE));
    add(&text, "", r->profile->data_packet_type,
        " is the type of other packets; allowed: ");
    lum_key_text_add(&text, packet_type.allowed);
}

static void refuse_width(const refusal *r, lum_key_refusal *why)
{
    const unsigned index = FIELD(r->index) + BYTES;
    lum_key_text text = lum_key_refuse(why, path_of(index), place_of(r, index));
    add(&text, "no field has ", r->profile->group[r->index].bytes,
        " bytes; allowed: ");
    lum_key_text_add(&text, bytes.allowed);
}

static void refuse_bits(const refusal *r, lum_key_refusal *why)
{
    const lum_field field = r->profile->group[r->index];
    const unsigned width = FIELD(r->index) + BYTES;
    culprit c = {path_of(FIELD(r->index) + BITS),
                 place_of(r, FIELD(r->index) + BITS)};
    c.place = place_of(r, width) > c.place ? place_of(r, width) : c.place;
    lum_key_text text = begin(why, &c);
    add(&text, "bit ", (int64_t)field.low + field.bits - 1, " is not one of ");
    lum_key_text_add(&text, path_of(width));
    add(&text, ", ", field.bytes, "; allowed: 0 to ");
    lum_key_text_add_number(&text, 8 * (int64_t)field.bytes - 1, 0);
}

/* Whether a tag that stands on the packet type has its byte as the lowest. */
static bool is_type(lum_field tag)
{
    return tag.low == 0 && tag.bits != 1 &&
           (tag.bytes == 1 || tag.order == LUM_ORDER_LITTLE);
}

static void refuse_tag(const refusal *r, lum_key_refusal *why)
{
    const culprit c = field_culprit(r, LUM_FIELD_TAG);
    lum_key_text text = begin(why, &c);
    lum_key_text_add(&text, "at 8 it is the packet type; allowed: 1 byte, or "
                            "order little, with all bits or 2 and more from "
                            "bit 0 on");
}

static void refuse_on_type(const refusal *r, lum_key_refusal *why)
{
    const culprit c = field_culprit(r, r->index);
    lum_key_text text = begin(why, &c);
    add(&text, "", r->profile->group[r->index].at,
        " lies on the packet type (bytes 8 to 11); allowed: 12 to 64, or 8 for "
        "group.tag alone");
}

static unsigned last_byte(lum_field f)
{
    return f.at + (unsigned)f.bytes - 1u;
}

static bool has_all_bits(lum_field f)
{
    return f.bits == 0;
}

static bool share_bytes(lum_field a, lum_field b)
{
    return b.bytes > 0 && b.at <= last_byte(a) && last_byte(b) >= a.at;
}

/* Two fields that name different bits of the same bytes. */
static bool are_apart(lum_field a, lum_field b)
{
    return !has_all_bits(a) && !has_all_bits(b) && a.at == b.at &&
           a.bytes == b.bytes && a.order == b.order &&
           (a.low >= b.low + b.bits || b.low >= a.low + a.bits);
}

/* The first field that overlaps the given one. */
static unsigned overlapped(const lum_profile *p, unsigned f)
{
    unsigned other = 0;
    while (!share_bytes(p->group[f], p->group[other]) ||
           are_apart(p->group[f], p->group[other])) {
        other++;
    }
    return other;
}

/* Why two fields may not share these bytes. */
static const char *reason(lum_field a, lum_field b)
{
    if (has_all_bits(a) && has_all_bits(b)) {
        return "; fields must not share bytes, unless both name bits";
    }
    if (has_all_bits(a) || has_all_bits(b)) {
        return "; fields that share bytes must both name bits";
    }
    if (a.at != b.at || a.bytes != b.bytes || a.order != b.order) {
        return "; fields that share bytes must have the same at, bytes and "
               "order";
    }
    return "; fields must not share a bit";
}

static void refuse_overlap(const refusal *r, lum_key_refusal *why)
{
    unsigned named = r->index;
    unsigned other = overlapped(r->profile, named);
    if (field_culprit(r, named).place == 0) {
        named = other;
        other = r->index;
    }
    const culprit c = field_culprit(r, named);
    const culprit o = field_culprit(r, other);
    const lum_field *g = r->profile->group;
    lum_key_text text = begin(why, &c);
    add(&text, "bytes ", g[named].at, " to ");
    add(&text, "", last_byte(g[named]), " overlap ");
    lum_key_text_add(&text, o.path);
    add(&text, ", ", g[other].at, " to ");
    add(&text, "", last_byte(g[other]), origin(r, &o));
    lum_key_text_add(&text, reason(g[named], g[other]));
}

static void refuse_samples(const refusal *r, lum_key_refusal *why)
{
    static const char rule[] = "; samples come after all fields";
    const culprit s = {path_of(SAMPLES), place_of(r, SAMPLES)};
    const culprit f = field_culprit(r, r->index);
    const unsigned last = last_byte(r->profile->group[r->index]);
    const unsigned at = r->profile->samples_at;
    if (s.place != 0) {
        lum_key_text text = begin(why, &s);
        add(&text, "", at, " is not behind ");
        lum_key_text_add(&text, f.path);
        add(&text, ", which ends with byte ", last, origin(r, &f));
        lum_key_text_add(&text, rule);
        return;
    }
    lum_key_text text = begin(why, &f);
    add(&text, "ends with byte ", last, ", but ");
    lum_key_text_add(&text, s.path);
    add(&text, " is ", at, origin(r, &s));
    lum_key_text_add(&text, rule);
}

static void refuse_eye_width(const refusal *r, lum_key_refusal *why)
{
    const lum_field field = r->profile->group[LUM_FIELD_EYE];
    const unsigned width = has_all_bits(field) ? field.bytes : field.bits;
    const unsigned bits = has_all_bits(field) ? 8u * field.bytes : field.bits;
    const culprit f = field_culprit(r, LUM_FIELD_EYE);
    const culprit c = {path_of(EYE + r->index), place_of(r, EYE + r->index)};
    lum_key_text text = begin(why, &c);
    add(&text, "", r->profile->eye_values[r->index], " does not fit ");
    lum_key_text_add(&text, f.path);
    add(&text, ", ", width, has_all_bits(field) ? " byte" : " bit");
    lum_key_text_add(&text, width == 1 ? "" : "s");
    add(&text, " wide; allowed: 0 to ", (INT64_C(1) << bits) - 1, "");
}

/* Two values that must differ; the message names the first if it was set. */
static void refuse_equal(const refusal *r, culprit c, culprit o, int64_t number,
                         lum_key_refusal *why)
{
    if (c.place == 0) {
        const culprit swapped = c;
        c = o;
        o = swapped;
    }
    lum_key_text text = begin(why, &c);
    add(&text, "", number, " is the value of ");
    lum_key_text_add(&text, o.path);
    lum_key_text_add(&text, origin(r, &o));
    lum_key_text_add(&text, "; they must differ");
}

static void refuse_eyes(const refusal *r, lum_key_refusal *why)
{
    const culprit green = {path_of(EYE + LUM_EYE_GREEN),
                           place_of(r, EYE + LUM_EYE_GREEN)};
    const culprit blue = {path_of(EYE + LUM_EYE_BLUE),
                          place_of(r, EYE + LUM_EYE_BLUE)};
    refuse_equal(r, green, blue, r->profile->eye_values[LUM_EYE_GREEN], why);
}

static void refuse_tlv(const refusal *r, lum_key_refusal *why)
{
    unsigned other = 0;
    while (r->profile->tlv[other] != r->profile->tlv[r->index]) {
        other++;
    }
    const culprit c = {path_of(TLV + r->index), place_of(r, TLV + r->index)};
    const culprit o = {path_of(TLV + other), place_of(r, TLV + other)};
    refuse_equal(r, c, o, r->profile->tlv[r->index], why);
}

/* --- The check --- */

/* Faults without an entry are refused by the rules already. */
static void refuse(const refusal *r, lum_profile_fault fault,
                   lum_key_refusal *why)
{
    static void (*const by_fault[])(const refusal *, lum_key_refusal *) = {
        [LUM_PROFILE_DATA_PACKET_TYPE] = refuse_type,
        [LUM_PROFILE_FIELD_WIDTH] = refuse_width,
        [LUM_PROFILE_FIELD_BITS] = refuse_bits,
        [LUM_PROFILE_FIELD_ON_TYPE] = refuse_on_type,
        [LUM_PROFILE_FIELDS_OVERLAP] = refuse_overlap,
        [LUM_PROFILE_SAMPLES_IN_HEADER] = refuse_samples,
        [LUM_PROFILE_EYE_VALUES_EQUAL] = refuse_eyes,
        [LUM_PROFILE_EYE_VALUE_WIDTH] = refuse_eye_width,
        [LUM_PROFILE_TLV_EQUAL] = refuse_tlv,
    };
    if ((size_t)fault < COUNT(by_fault) && by_fault[fault] != NULL) {
        by_fault[fault](r, why);
        return;
    }
    lum_key_text text = lum_key_refuse(why, "", 0);
    add(&text, "refused: fault ", fault, " of the profile");
}

/* The first value that was set of what is none; VALUES: there is none. */
static unsigned find_idle(const lum_key_value *v)
{
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        if (v[FIELD(f) + AT].number != NOWHERE) {
            continue;
        }
        for (unsigned i = BYTES; i < FIELD_VALUES; i++) {
            if (v[FIELD(f) + i].place != 0) {
                return FIELD(f) + i;
            }
        }
        if (f == LUM_FIELD_TIMESTAMP && v[CLOCK_UNIT].place != 0) {
            return CLOCK_UNIT;
        }
    }
    return VALUES;
}

static void refuse_idle(const lum_keys *keys, unsigned index,
                        lum_key_refusal *why)
{
    const lum_key_value *v = keys->values;
    const unsigned f = index == CLOCK_UNIT ? (unsigned)LUM_FIELD_TIMESTAMP
                                           : (index - GROUP) / FIELD_VALUES;
    lum_key_text text = lum_key_refuse(why, path_of(index), v[index].place);
    lum_key_text_add(&text, path_of(FIELD(f) + AT));
    lum_key_text_add(&text, " is none");
    lum_key_text_add(&text, lum_keys_origin(keys, v[FIELD(f) + AT].place));
    lum_key_text_add(&text, "; give it an offset too, or leave this out");
}

lum_result lum_keys_profile(const lum_keys *keys, lum_profile *out,
                            lum_key_refusal *why)
{
    lum_profile p;
    lum_layout layout;
    lum_profile_fault fault = LUM_PROFILE_FINE;
    refusal r = {keys, &p, 0};
    if (keys->kind != LUM_KEYS_PROFILE) {
        lum_key_text text = lum_key_refuse(why, "", 0);
        lum_key_text_add(&text, "these are keys of a calibration");
        return LUM_E_TYPE;
    }
    const unsigned idle = find_idle(keys->values);
    if (idle != VALUES) {
        refuse_idle(keys, idle, why);
        return LUM_E_VALUE;
    }
    take(keys->values, &p);
    if (lum_layout_init(&layout, &p, &fault, &r.index) != LUM_OK) {
        refuse(&r, fault, why);
        return LUM_E_VALUE;
    }
    if (p.group[LUM_FIELD_TAG].at == 8 && !is_type(p.group[LUM_FIELD_TAG])) {
        refuse_tag(&r, why);
        return LUM_E_VALUE;
    }
    *out = p;
    return LUM_OK;
}
