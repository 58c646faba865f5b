#include "lum/config/config.h"
#include "lum/wire.h"
#include "yaml.h"

#include <stdbool.h>
#include <stdio.h>

#define COUNT(array) (sizeof(array) / sizeof(array)[0])

/* The values of a file in order; a group field has two, its offset and its
 * width. */
enum {
    AT,
    BYTES,
    FIELD_VALUES
};
enum {
    VERSION,
    DATA_PACKET_TYPE,
    SET_IP_ORDER,
    ANGLE_ORDER,
    ANGLE_LSB,
    LINE_SPAN,
    EYE,
    TLV = EYE + LUM_EYES,
    GROUP = TLV + LUM_TLV_USES,
    SAMPLES = GROUP + LUM_GROUP_FIELDS * FIELD_VALUES,
    VALUES
};

#define KEY_BYTES 48 /* of the longest path */

/* An offset that is none. */
#define NOWHERE (-1)

static const lum_yaml_word orders_of_ip[] = {
    {"network", LUM_SET_IP_NETWORK}, {"little", LUM_SET_IP_LITTLE}, {NULL, 0}};
static const lum_yaml_word orders_of_angles[] = {
    {"azimuth_elevation", LUM_AZIMUTH_ELEVATION},
    {"elevation_azimuth", LUM_ELEVATION_AZIMUTH},
    {NULL, 0}};
static const lum_yaml_word span[] = {{"span", 0}, {NULL, 0}};
static const lum_yaml_word none[] = {{"none", NOWHERE}, {NULL, 0}};

static const lum_yaml_rule version = {
    .min = 1, .max = 1, .whole = true, .allowed = "1"};
static const lum_yaml_rule packet_type = {
    .min = 0,
    .max = 255,
    .whole = true,
    .allowed = "0 to 255, but not 5, 6 or 7 (set IP, timestamp, TLV)"};
static const lum_yaml_rule ip_order = {
    .words = orders_of_ip, .min = 0, .max = -1};
static const lum_yaml_rule angle_order = {
    .words = orders_of_angles, .min = 0, .max = -1};
static const lum_yaml_rule angle_lsb = {.words = span,
                                        .min = 1,
                                        .max = (int64_t)LUM_ANGLE_LSB_MAX_PDEG,
                                        .decimals = 12,
                                        .unit = " deg"};
static const lum_yaml_rule line_span = {
    .min = 0, .max = LUM_LINE_SPAN_MAX_US, .whole = true, .unit = " us"};
static const lum_yaml_rule eye_value = {
    .min = 0, .max = UINT32_MAX, .whole = true, .unit = ""};
static const lum_yaml_rule tlv_number = {
    .min = 0, .max = UINT16_MAX, .whole = true, .unit = ""};
static const lum_yaml_rule offset = {
    .min = 8, .max = 64, .whole = true, .allowed = "an offset from 8 to 64"};
static const lum_yaml_rule offset_or_none = {.words = none,
                                             .min = 8,
                                             .max = 64,
                                             .whole = true,
                                             .allowed =
                                                 "an offset from 8 to 64"};
static const lum_yaml_rule bytes = {
    .min = 1, .max = 4, .whole = true, .allowed = "1, 2 or 4"};

static const lum_yaml_key field_keys[] = {
    {"at", AT, &offset, NULL},
    {"bytes", BYTES, &bytes, NULL},
};
static const lum_yaml_table field = {field_keys, COUNT(field_keys)};

/* By lum_group_field, then the samples. */
#define FIELD(f) (GROUP + FIELD_VALUES * (f))
static const lum_yaml_key group_keys[] = {
    {"tag", FIELD(LUM_FIELD_TAG), &offset, &field},
    {"eye", FIELD(LUM_FIELD_EYE), &offset, &field},
    {"line", FIELD(LUM_FIELD_LINE), &offset, &field},
    {"num_samples", FIELD(LUM_FIELD_NUM_SAMPLES), &offset, &field},
    {"first_sample_index", FIELD(LUM_FIELD_FIRST_SAMPLE_INDEX), &offset,
     &field},
    {"timestamp", FIELD(LUM_FIELD_TIMESTAMP), &offset_or_none, &field},
    {"samples", SAMPLES, &offset, NULL},
};
static const lum_yaml_table group = {group_keys, COUNT(group_keys)};

/* By lum_eye. */
static const lum_yaml_key eye_keys[] = {
    {"blue", EYE + LUM_EYE_BLUE, &eye_value, NULL},
    {"green", EYE + LUM_EYE_GREEN, &eye_value, NULL},
};
static const lum_yaml_table eye_values = {eye_keys, COUNT(eye_keys)};

/* By lum_tlv_use. */
static const lum_yaml_key tlv_keys[] = {
    {"command", TLV + LUM_TLV_COMMAND, &tlv_number, NULL},
    {"status", TLV + LUM_TLV_STATUS, &tlv_number, NULL},
    {"debug", TLV + LUM_TLV_DEBUG, &tlv_number, NULL},
    {"yscan", TLV + LUM_TLV_YSCAN, &tlv_number, NULL},
};
static const lum_yaml_table tlv = {tlv_keys, COUNT(tlv_keys)};

static const lum_yaml_key root_keys[] = {
    {"version", VERSION, &version, NULL},
    {"data_packet_type", DATA_PACKET_TYPE, &packet_type, NULL},
    {"set_ip_order", SET_IP_ORDER, &ip_order, NULL},
    {"group", 0, NULL, &group},
    {"eye_values", 0, NULL, &eye_values},
    {"angle_order", ANGLE_ORDER, &angle_order, NULL},
    {"angle_lsb_deg", ANGLE_LSB, &angle_lsb, NULL},
    {"tlv", 0, NULL, &tlv},
    {"line_span_us", LINE_SPAN, &line_span, NULL},
};
static const lum_yaml_table root = {root_keys, COUNT(root_keys)};

static void put(lum_yaml_value *v, const lum_profile *p)
{
    v[DATA_PACKET_TYPE].number = p->data_packet_type;
    v[SET_IP_ORDER].number = p->set_ip_order;
    v[ANGLE_ORDER].number = p->angle_order;
    v[ANGLE_LSB].number = (int64_t)p->angle_lsb_pdeg;
    v[LINE_SPAN].number = p->line_span_us;
    for (unsigned i = 0; i < LUM_EYES; i++) {
        v[EYE + i].number = p->eye_values[i];
    }
    for (unsigned i = 0; i < LUM_TLV_USES; i++) {
        v[TLV + i].number = p->tlv[i];
    }
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        v[FIELD(f) + AT].number = p->group[f].at;
        v[FIELD(f) + BYTES].number = p->group[f].bytes;
    }
    v[SAMPLES].number = p->samples_at;
}

static lum_field take_field(const lum_yaml_value *v)
{
    const lum_field nowhere = {0, 0};
    const lum_field there = {(uint8_t)v[AT].number, (uint8_t)v[BYTES].number};
    return v[AT].number == NOWHERE ? nowhere : there;
}

static void take(const lum_yaml_value *v, lum_profile *p)
{
    p->data_packet_type = (uint32_t)v[DATA_PACKET_TYPE].number;
    p->set_ip_order = (uint8_t)v[SET_IP_ORDER].number;
    p->angle_order = (uint8_t)v[ANGLE_ORDER].number;
    p->angle_lsb_pdeg = (uint64_t)v[ANGLE_LSB].number;
    p->line_span_us = (uint32_t)v[LINE_SPAN].number;
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
    const lum_yaml_source *source;
    const lum_yaml_value *values;
    const lum_profile *profile;
    lum_error *error;
    unsigned index; /* of the culprit, as lum_layout_init() gives it */
} refusal;

typedef struct culprit {
    char key[KEY_BYTES];
    unsigned line; /* 0: its value is the default */
} culprit;

static culprit culprit_of(const refusal *r, const char *parent,
                          const lum_yaml_key *key)
{
    const lum_yaml_value *v = &r->values[key->index];
    culprit c;
    (void)snprintf(c.key, sizeof c.key, "%s.%s", parent, key->name);
    c.line = v->line;
    if (key->table != NULL && v[BYTES].line > c.line) {
        c.line = v[BYTES].line;
    }
    return c;
}

static culprit field_culprit(const refusal *r, unsigned f)
{
    return culprit_of(r, "group", &group_keys[f]);
}

#define REFUSE(r, culprit, ...)                                                \
    lum_yaml_fail((r)->error, (r)->source->name, (culprit)->line,              \
                  (culprit)->key, __VA_ARGS__)

static const char *defaulted(const culprit *c)
{
    return c->line == 0 ? " (the default)" : "";
}

static int refuse_type(const refusal *r)
{
    return lum_yaml_fail(
        r->error, r->source->name, r->values[DATA_PACKET_TYPE].line,
        "data_packet_type", "%u is the type of other packets; allowed: %s",
        (unsigned)r->profile->data_packet_type, packet_type.allowed);
}

static int refuse_width(const refusal *r)
{
    const lum_yaml_value *v = &r->values[FIELD(r->index) + BYTES];
    char key[KEY_BYTES];
    (void)snprintf(key, sizeof key, "group.%s.bytes",
                   group_keys[r->index].name);
    return lum_yaml_fail(r->error, r->source->name, v->line, key,
                         "no field has %u bytes; allowed: %s",
                         (unsigned)v->number, bytes.allowed);
}

static int refuse_on_type(const refusal *r)
{
    const culprit c = field_culprit(r, r->index);
    return REFUSE(r, &c,
                  "%u lies on the packet type (bytes 8 to 11); allowed: 12 to "
                  "64, or 8 for group.tag alone",
                  (unsigned)r->profile->group[r->index].at);
}

static unsigned last_byte(lum_field f)
{
    return f.at + (unsigned)f.bytes - 1u;
}

/* The first field before the given one that shares bytes with it. */
static unsigned overlapped(const lum_profile *p, unsigned f)
{
    unsigned other = 0;
    while (other + 1 < f && (p->group[other].bytes == 0 ||
                             p->group[other].at > last_byte(p->group[f]) ||
                             last_byte(p->group[other]) < p->group[f].at)) {
        other++;
    }
    return other;
}

static int refuse_overlap(const refusal *r)
{
    unsigned named = r->index;
    unsigned other = overlapped(r->profile, named);
    if (field_culprit(r, named).line == 0) {
        named = other;
        other = r->index;
    }
    const culprit c = field_culprit(r, named);
    const culprit o = field_culprit(r, other);
    const lum_field *g = r->profile->group;
    return REFUSE(r, &c,
                  "bytes %u to %u overlap %s, %u to %u%s; fields must not "
                  "share bytes",
                  g[named].at, last_byte(g[named]), o.key, g[other].at,
                  last_byte(g[other]), defaulted(&o));
}

static int refuse_samples(const refusal *r)
{
    const culprit s = culprit_of(r, "group", &group_keys[LUM_GROUP_FIELDS]);
    const culprit f = field_culprit(r, r->index);
    const unsigned last = last_byte(r->profile->group[r->index]);
    const unsigned at = r->profile->samples_at;
    return s.line != 0
               ? REFUSE(r, &s,
                        "%u is not behind %s, which ends with byte %u%s; "
                        "samples come behind every field",
                        at, f.key, last, defaulted(&f))
               : REFUSE(r, &f,
                        "ends with byte %u, but %s is %u (the default); "
                        "samples come behind every field",
                        last, s.key, at);
}

static int refuse_eye_width(const refusal *r)
{
    const unsigned width = r->profile->group[LUM_FIELD_EYE].bytes;
    const culprit f = field_culprit(r, LUM_FIELD_EYE);
    const culprit c = culprit_of(r, "eye_values", &eye_keys[r->index]);
    return REFUSE(r, &c,
                  "%lu does not fit %s, %u byte%s wide; allowed: 0 to %u",
                  (unsigned long)r->profile->eye_values[r->index], f.key, width,
                  width == 1 ? "" : "s", (1u << (8u * width)) - 1u);
}

/* Two of a table's keys that bear one value. */
static int refuse_equal(const refusal *r, const char *parent,
                        const lum_yaml_key *a, const lum_yaml_key *b)
{
    culprit c = culprit_of(r, parent, a);
    culprit o = culprit_of(r, parent, b);
    if (c.line == 0) {
        const culprit swapped = c;
        c = o;
        o = swapped;
    }
    return REFUSE(r, &c, "%lu is the value of %s%s; they must differ",
                  (unsigned long)r->values[a->index].number, o.key,
                  defaulted(&o));
}

static int refuse_eyes(const refusal *r)
{
    return refuse_equal(r, "eye_values", &eye_keys[LUM_EYE_GREEN],
                        &eye_keys[LUM_EYE_BLUE]);
}

static int refuse_tlv(const refusal *r)
{
    unsigned other = 0;
    while (other + 1 < r->index &&
           r->profile->tlv[other] != r->profile->tlv[r->index]) {
        other++;
    }
    return refuse_equal(r, "tlv", &tlv_keys[r->index], &tlv_keys[other]);
}

/* Faults without an entry are refused by the rules already. */
static int refuse(const refusal *r, lum_profile_fault fault)
{
    static int (*const by_fault[])(const refusal *) = {
        [LUM_PROFILE_DATA_PACKET_TYPE] = refuse_type,
        [LUM_PROFILE_FIELD_WIDTH] = refuse_width,
        [LUM_PROFILE_FIELD_ON_TYPE] = refuse_on_type,
        [LUM_PROFILE_FIELDS_OVERLAP] = refuse_overlap,
        [LUM_PROFILE_SAMPLES_IN_HEADER] = refuse_samples,
        [LUM_PROFILE_EYE_VALUES_EQUAL] = refuse_eyes,
        [LUM_PROFILE_EYE_VALUE_WIDTH] = refuse_eye_width,
        [LUM_PROFILE_TLV_EQUAL] = refuse_tlv,
    };
    if ((size_t)fault < COUNT(by_fault) && by_fault[fault] != NULL) {
        return by_fault[fault](r);
    }
    return lum_yaml_fail(r->error, r->source->name, 0, NULL,
                         "refused: fault %d of the profile", (int)fault);
}

int lum_profile_parse(const char *text, size_t len, const char *name,
                      lum_profile *out, lum_error *error)
{
    const lum_yaml_source source = {text, len, name};
    lum_yaml_value values[VALUES] = {{0, 0}};
    lum_profile p;
    lum_layout layout;
    lum_profile_fault fault = LUM_PROFILE_FINE;
    refusal r = {&source, values, &p, error, 0};
    lum_profile_default(&p);
    put(values, &p);
    if (lum_yaml_read(&source, &root, values, error) != 0) {
        return -1;
    }
    if (values[VERSION].line == 0) {
        return lum_yaml_fail(error, name, 1, "version",
                             "missing; a profile needs 'version: 1'");
    }
    take(values, &p);
    if (lum_layout_init(&layout, &p, &fault, &r.index) != LUM_OK) {
        return refuse(&r, fault);
    }
    *out = p;
    return 0;
}
