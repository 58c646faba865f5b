/* Datagrams to lum_infer: lines in any layout that a profile can say, then
 * changed by the rest of the input, byte by byte of their headers and packet by
 * packet; or, if the first byte is odd, any bytes behind the magic. What is
 * found is a profile that is valid, and whose text loads as it. */
#include "lum/config/config.h"
#include "lum/group.h"
#include "lum/host/keys.h"
#include "lum/infer/infer.h"
#include "lum/packet.h"
#include "lum/wire.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define LINES_MIN   6u
#define LINES_MAX   12u
#define WORDS       60u
#define PACKETS_MAX (4u * 2u * LINES_MAX)
#define BYTES_MAX   1500u
#define STEPS_MAX   64u
#define BEGIN_NS    INT64_C(1700000000000000000)

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

/* What is left of the input; 0 behind its end. */
struct input {
    const uint8_t *at;
    size_t left;
};

struct packet {
    uint8_t bytes[BYTES_MAX];
    size_t len;
    int64_t time_ns;
    uint32_t sensor;
    lum_record_kind kind;
};

static struct packet packets[PACKETS_MAX];
static size_t count;

static void require(int fact)
{
    if (!fact) {
        abort();
    }
}

static unsigned take(struct input *in)
{
    if (in->left == 0) {
        return 0;
    }
    in->left--;
    return *in->at++;
}

/* --- Packets --- */

static lum_field take_field(struct input *in)
{
    const unsigned at = take(in);
    const unsigned shape = take(in);
    const unsigned low = take(in);
    const unsigned bits = take(in);
    return (lum_field){.at = (uint8_t)(8u + at % 57u),
                       .bytes = (uint8_t)(1u << shape % 4u),
                       .order = (uint8_t)(shape / 4u % 2u),
                       .low = (uint8_t)(low % 64u),
                       .bits = (uint8_t)(bits % 65u)};
}

/* Fields from the input, where they are a layout; else the usual one. */
static void take_layout(struct input *in, lum_layout *layout)
{
    lum_profile p;
    lum_profile_default(&p);
    const unsigned which = take(in);
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        if ((which >> f & 1u) != 0) {
            p.group[f] = take_field(in);
        }
    }
    if ((which & 0x40u) != 0) {
        const unsigned more = take(in);
        p.samples_at = (uint8_t)(12u + more % 53u);
        p.group[LUM_FIELD_NUM_SAMPLES].bytes = more > 200u ? 0 : 2;
        p.sample_order = (uint8_t)(take(in) % 2u);
        p.angle_order = (uint8_t)(take(in) % 2u);
        p.data_packet_type = take(in);
    }
    if (lum_layout_init(layout, &p, NULL, NULL) != LUM_OK) {
        lum_layout_default(layout);
    }
}

/* Values that do not fit a field leave the packet as it was begun. */
static struct packet *begin_packet(const lum_layout *layout,
                                   const lum_group *group, uint32_t time_us)
{
    struct packet *p = &packets[count];
    memset(p, 0, sizeof *p);
    if (lum_group_encode(layout, group, p->bytes, BYTES_MAX, &p->len) !=
        LUM_OK) {
        return NULL;
    }
    p->time_ns = BEGIN_NS + 1000 * (int64_t)time_us;
    p->sensor = 0x0a2a0025;
    p->kind = LUM_RECORD_DATAGRAM;
    count++;
    return p;
}

static void add_angles(const lum_layout *layout, lum_group group)
{
    group.tag = LUM_TAG_ANGLES;
    for (unsigned i = 0; i < 3; i++) {
        group.first_sample_index = 334u * i;
        group.num_samples = i == 2 ? 332u : 334u;
        struct packet *p =
            begin_packet(layout, &group, 1500u * group.line + 10u * i);
        for (uint32_t k = 0; p != NULL && k < group.num_samples; k++) {
            const int pixel = (int)(334u * i + k);
            const lum_angle angle = {(int16_t)(65 * pixel - 32000),
                                     (int16_t)(30000 - 400 * (int)group.line)};
            lum_angle_encode(layout, angle, p->bytes + p->len);
            p->len += LUM_SAMPLE_BYTES;
        }
    }
}

static void add_ranges(const lum_layout *layout, lum_group group)
{
    group.tag = LUM_TAG_RANGES;
    group.first_sample_index = 0;
    group.num_samples = WORDS - group.line % 5u;
    struct packet *p = begin_packet(layout, &group, 1500u * group.line + 40u);
    for (uint32_t k = 0; p != NULL && k < group.num_samples; k++) {
        lum_group_word_encode(layout,
                              lum_word_make((int32_t)(3000u + k), true, 2u * k),
                              p->bytes + p->len);
        p->len += LUM_SAMPLE_BYTES;
    }
}

static void make_lines(struct input *in)
{
    lum_layout layout;
    take_layout(in, &layout);
    const uint32_t lines = LINES_MIN + take(in) % (LINES_MAX - LINES_MIN);
    const uint32_t ticks = take(in) * 50u;
    const unsigned eyes = take(in) % 4u == 0 ? 1 : 2;
    for (uint32_t line = 0; line < lines; line++) {
        for (unsigned eye = 0; eye < eyes; eye++) {
            const lum_group group = {.line = line,
                                     .eye = (uint8_t)eye,
                                     .clock_raw = 1000u + ticks * line};
            add_angles(&layout, group);
            add_ranges(&layout, group);
        }
    }
}

static void make_any(struct input *in)
{
    while (in->left > 0 && count < PACKETS_MAX) {
        static const uint8_t magic[] = {0xed, 0xfe, 0xf3, 0xa1,
                                        0xef, 0xbe, 0x34, 0x12};
        struct packet *p = &packets[count];
        memset(p, 0, sizeof *p);
        p->len = take(in) * 5u;
        memcpy(p->bytes, magic, sizeof magic);
        for (size_t i = sizeof magic; i < p->len; i++) {
            p->bytes[i] = (uint8_t)(i < 80 ? take(in) : 3u * i);
        }
        p->time_ns = (int64_t)count * 1000000;
        count++;
    }
}

/* --- Changes --- */

/* A byte of all headers: a constant, a counter, another byte, or noise. */
static void change_all(unsigned at, unsigned how, unsigned value)
{
    uint32_t noise = value + 1u;
    for (size_t i = 0; i < count; i++) {
        uint8_t *byte = &packets[i].bytes[8u + at % 64u];
        noise = noise * 1664525u + 1013904223u;
        switch (how % 4u) {
        case 0:
            *byte = (uint8_t)value;
            break;
        case 1:
            *byte = (uint8_t)(i >> value % 8u);
            break;
        case 2:
            *byte = packets[i].bytes[8u + value % 64u];
            break;
        default:
            *byte = (uint8_t)(noise >> 24);
            break;
        }
    }
}

static void change_one(struct packet *p, unsigned at, unsigned how,
                       unsigned value)
{
    switch (how % 6u) {
    case 0:
        p->bytes[8u + at % 64u] ^= (uint8_t)value;
        break;
    case 1:
        p->len = p->len * value / 256u;
        break;
    case 2:
        p->time_ns =
            BEGIN_NS + ((int64_t)value - 128) * (INT64_C(1) << at % 54u);
        break;
    case 3:
        p->sensor += value;
        break;
    case 4:
        p->kind = (lum_record_kind)(value % 4u);
        break;
    default:
        p->bytes[8u + (at * 256u + value) % (BYTES_MAX - 8u)] ^= 0x80;
        break;
    }
}

static void change(struct input *in)
{
    for (unsigned i = 0; i < STEPS_MAX && in->left > 0 && count > 0; i++) {
        const unsigned which = take(in);
        const unsigned at = take(in);
        const unsigned how = take(in);
        const unsigned value = take(in);
        if (which == 0) {
            change_all(at, how, value);
        } else {
            change_one(&packets[which % count], at, how, value);
        }
    }
}

/* --- What is found --- */

static void require_text(const char *text, size_t room)
{
    const size_t len = strlen(text);
    require(len < room);
    for (size_t i = 0; i < len; i++) {
        require(text[i] >= 0x20 && text[i] < 0x7f);
    }
}

static void require_loads(const lum_infer_result *r)
{
    char text[LUM_INFER_YAML_BYTES];
    char wanted[LUM_KEYS_WRITE_BYTES];
    char got[LUM_KEYS_WRITE_BYTES];
    lum_profile loaded;
    lum_keys keys;
    const size_t len = lum_infer_write_yaml(r, text, sizeof text);
    require(len > 0 && len < sizeof text && len == strlen(text));
    require(lum_profile_parse(text, len, "found", &loaded, NULL) == 0);
    lum_keys_of_profile(&keys, &r->profile);
    (void)lum_keys_write(&keys, wanted, sizeof wanted);
    lum_keys_of_profile(&keys, &loaded);
    (void)lum_keys_write(&keys, got, sizeof got);
    require(strcmp(wanted, got) == 0);
}

static void require_profile(const lum_infer_result *r)
{
    lum_layout layout;
    require(r->verdict == LUM_INFER_FOUND || r->verdict == LUM_INFER_UNSURE);
    require(lum_layout_init(&layout, &r->profile, NULL, NULL) == LUM_OK);
    require(!r->has_second ||
            lum_layout_init(&layout, &r->second, NULL, NULL) == LUM_OK);
    require(r->fit <= r->counts.packets && r->fit * 2 >= r->counts.packets);
    require(r->margin >= 0.0 && r->margin <= 100.0);
    require(r->verdict == LUM_INFER_UNSURE ||
            r->margin >= LUM_INFER_MARGIN_SURE);
    require(r->finding_count == LUM_INFER_KEYS);
    for (size_t i = 0; i < r->finding_count; i++) {
        const lum_infer_finding *f = &r->findings[i];
        require(f->key == (lum_infer_key)i);
        require_text(f->value, sizeof f->value);
        require_text(f->evidence, sizeof f->evidence);
        require_text(f->equal, sizeof f->equal);
        require_text(f->look, sizeof f->look);
    }
    require_loads(r);
}

static void require_result(lum_infer *infer)
{
    static lum_infer_result r;
    memset(&r, 0, sizeof r);
    r.struct_size = sizeof r;
    const int solved = lum_infer_solve(infer, &r, NULL);
    require(solved == 0 || solved == 1);
    require(r.has_profile == (solved == 0));
    require(r.text[0] != '\0');
    require_text(r.text, sizeof r.text);
    if (solved == 0) {
        require_profile(&r);
    } else {
        require(r.verdict == LUM_INFER_TOO_LITTLE ||
                r.verdict == LUM_INFER_NOTHING_FITS);
        require(!r.has_second && r.finding_count == 0);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const lum_infer_options options = {.struct_size = sizeof options};
    struct input in = {data, size};
    lum_infer *infer = NULL;
    count = 0;
    if (take(&in) % 2u == 0) {
        make_lines(&in);
        change(&in);
    } else {
        make_any(&in);
    }
    if (lum_infer_create(&options, &infer, NULL) != 0) {
        abort();
    }
    for (size_t i = 0; i < count; i++) {
        const struct packet *p = &packets[i];
        const lum_record record = {.time_ns = p->time_ns,
                                   .payload = p->bytes,
                                   .len = p->len,
                                   .source = p->sensor,
                                   .destination = 0x0a2a0001,
                                   .source_port = LUM_PORT,
                                   .destination_port = 50000,
                                   .kind = p->kind};
        require(lum_infer_push(infer, &record, NULL) == 1);
    }
    require_result(infer);
    lum_infer_free(infer);
    return 0;
}
