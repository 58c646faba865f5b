#include "diagnosis.h"

#include "core/bytes.h"

#include <inttypes.h>
#include <stdbool.h>
#include <string.h>

static const char *const kind_names[LUM_PACKET_KINDS] = {
    [LUM_PACKET_DATA] = "data",
    [LUM_PACKET_HEARTBEAT] = "heartbeat",
    [LUM_PACKET_SET_IP] = "set IP",
    [LUM_PACKET_TIMESTAMP] = "timestamp",
    [LUM_PACKET_TLV] = "TLV",
    [LUM_PACKET_FOREIGN] = "foreign",
    [LUM_PACKET_UNKNOWN_TYPE] = "a type that is not known",
    [LUM_PACKET_MALFORMED] = "an impossible length or field",
    [LUM_PACKET_UNKNOWN_TAG] = "neither angles nor ranges",
};

static bool may_be_data(lum_packet_kind kind)
{
    return kind == LUM_PACKET_UNKNOWN_TYPE || kind == LUM_PACKET_MALFORMED ||
           kind == LUM_PACKET_UNKNOWN_TAG;
}

static struct packet_shape *find_shape(struct diagnosis *d, uint32_t type,
                                       size_t len, lum_packet_kind kind)
{
    size_t i = 0;
    while (i < d->shape_count &&
           !(d->shapes[i].type == type && d->shapes[i].kind == kind)) {
        i++;
    }
    if (i == d->shape_count && i < DIAGNOSIS_SHAPES_MAX) {
        d->shapes[i] = (struct packet_shape){type, len, len, 0, kind};
        d->shape_count++;
    }
    return i < DIAGNOSIS_SHAPES_MAX ? &d->shapes[i] : NULL;
}

static void note_shape(struct diagnosis *d, uint32_t type, size_t len,
                       lum_packet_kind kind)
{
    struct packet_shape *s = find_shape(d, type, len, kind);
    if (s == NULL) {
        d->more++;
        return;
    }
    s->count++;
    s->shortest = len < s->shortest ? len : s->shortest;
    s->longest = len > s->longest ? len : s->longest;
}

void diagnosis_note(struct diagnosis *d, const uint8_t *bytes, size_t len,
                    lum_packet_kind kind)
{
    const bool may_be = may_be_data(kind);
    note_shape(d, load_u32(bytes + 8), len, kind);
    /* the longest packet that may be data is the most useful */
    if ((may_be && !d->sample_may_be_data) ||
        (may_be == d->sample_may_be_data && len > d->sample_len)) {
        d->sample_may_be_data = may_be;
        d->sample_len = len;
        memcpy(d->sample, bytes, len < DIAGNOSIS_BYTES ? len : DIAGNOSIS_BYTES);
    }
}

static void print_hex(const struct diagnosis *d, FILE *out)
{
    const size_t n =
        d->sample_len < DIAGNOSIS_BYTES ? d->sample_len : DIAGNOSIS_BYTES;
    (void)fprintf(out, "One of them, %zu bytes%s:\n", d->sample_len,
                  n < d->sample_len ? ", the first of which are" : "");
    for (size_t i = 0; i < n; i++) {
        if (i % 16 == 0) {
            (void)fprintf(out, "  %4zu ", i);
        }
        (void)fprintf(out, " %02x", d->sample[i]);
        if (i % 16 == 15 || i + 1 == n) {
            (void)fputc('\n', out);
        }
    }
}

static bool has_type(const struct diagnosis *d, uint32_t type)
{
    for (size_t i = 0; i < d->shape_count; i++) {
        if (d->shapes[i].type == type) {
            return true;
        }
    }
    return false;
}

/* The commands that find the layout. */
static void print_infer_help(const char *source, const char *capture, FILE *out)
{
    (void)fputs("The layout of data packets is partly an assumption; a wire "
                "profile corrects it.\n"
                "To find it from a capture with ranges:\n",
                out);
    if (capture == NULL) {
        capture = "look.pcap";
        (void)fprintf(out, "  lumdump %s --laser --duration 3 -o %s\n", source,
                      capture);
    }
    (void)fprintf(out,
                  "  lumdump %s --infer -o profile.yaml\n"
                  "  lumdump %s --profile profile.yaml\n",
                  capture, capture);
}

static void print_profile_help(const struct diagnosis *d, FILE *out)
{
    if (has_type(d, 2) && has_type(d, 3)) {
        (void)fputs("Types 2 and 3 may be the tags of angles and ranges "
                    "themselves: try group: {tag: 8} first.\n",
                    out);
    }
    (void)fputs(
        "By hand: copy profile-default.yaml (installed in share/lumsdk), "
        "then:\n"
        "  data_packet_type   the type of most packets, if not 8\n"
        "  group              the offsets of tag (2 or 3), eye, line,\n"
        "                     num_samples (4 bytes each fill the packet),\n"
        "                     first_sample_index, timestamp, and samples\n"
        "  eye_values         the two values that stand where the eye is\n"
        "and run lumdump again with --profile FILE. docs/protocol.md, section "
        "8, has all keys.\n",
        out);
}

static void print_shape(const struct packet_shape *s, FILE *out)
{
    (void)fprintf(out, "  %8" PRIu64 " of type %" PRIu32 ", %zu", s->count,
                  s->type, s->shortest);
    if (s->longest > s->shortest) {
        (void)fprintf(out, " to %zu", s->longest);
    }
    (void)fprintf(out, " bytes (%s)\n", kind_names[s->kind]);
}

/* The most frequent first. */
static void sort_shapes(struct packet_shape *shapes, size_t n)
{
    for (size_t i = 1; i < n; i++) {
        const struct packet_shape s = shapes[i];
        size_t k = i;
        for (; k > 0 && shapes[k - 1u].count < s.count; k--) {
            shapes[k] = shapes[k - 1u];
        }
        shapes[k] = s;
    }
}

void diagnosis_print(const struct diagnosis *diagnosis, const char *source,
                     const char *capture, FILE *out)
{
    struct diagnosis d = *diagnosis;
    sort_shapes(d.shapes, d.shape_count);
    (void)fprintf(out,
                  "lumdump: %s: packets of a G2 came, but none of them is a "
                  "data packet:\n",
                  source);
    for (size_t i = 0; i < d.shape_count; i++) {
        print_shape(&d.shapes[i], out);
    }
    if (d.more > 0) {
        (void)fprintf(out, "  %8" PRIu64 " of further types\n", d.more);
    }
    print_hex(&d, out);
    if (d.sample_may_be_data) {
        print_infer_help(source, capture, out);
        print_profile_help(&d, out);
    } else {
        (void)fputs("All of these are of known kinds, so the layout is not the "
                    "problem: the sensor sent no data while\n"
                    "this was captured, or not past this interface. Data goes "
                    "to the sender of the last heartbeat,\n"
                    "and stops 3 s after it.\n",
                    out);
    }
}
