#include "input.h"

#include "link.h"
#include "unpack.h"

#include <stdlib.h>

/* Records of a link type that is not read which are looked at. */
#define LOOKS_MAX 1000u

/* Whether there is a first byte; a directory gives its error here. 1: there is
 * none. */
static int check_start(lum_source *source, lum_error *error)
{
    if (lum_source_has(source, 1)) {
        return 0;
    }
    if (!source->has_failed) {
        (void)lum_error_set(
            error, "%s: is empty; a pcap, pcapng, MCAP or bag file is expected",
            source->name);
        return 1;
    }
    return lum_error_set(
        error,
        "%s: cannot be read: %s; a pcap, pcapng, MCAP or bag file is expected",
        source->name, source->error.text);
}

/* Both as it is and unpacked. */
static int start(lum_input *in, lum_error *error)
{
    const int result = check_start(in->source, error);
    if (result != 0) {
        return result;
    }
    return lum_unpack(&in->source, error) == 0 ? check_start(in->source, error)
                                               : -1;
}

static bool is_supported(uint32_t link_type)
{
    return lum_link_find(link_type) != NULL;
}

static int refuse_link(const lum_input *in, lum_error *error)
{
    char fix[LUM_LINK_FIX_BYTES] = "";
    if (in->hidden_at != 0) {
        (void)lum_link_fix(in->hidden_link, in->hidden_at, fix);
    }
    return lum_error_set(
        error, "%s: link type %lu (%s) is not supported; supported are %s%s%s",
        in->source->name, (unsigned long)in->link_type,
        lum_link_name(in->link_type), lum_link_supported(),
        in->hidden_at != 0 ? "; packets of a G2 are in it: " : "", fix);
}

static void look_inside(lum_input *in, const lum_pcap_record *record)
{
    if (in->hidden_at == 0 && in->records < LOOKS_MAX) {
        in->hidden_link = record->link_type;
        in->hidden_at = lum_link_find_hidden(
            record->link_type, (lum_span){record->bytes, record->len});
    }
}

/* A pcap file has no other interface; its packets may tell how to read it. */
static int refuse_all(lum_input *in, lum_error *error)
{
    lum_pcap_record record;
    while (in->hidden_at == 0 && in->records < LOOKS_MAX &&
           lum_pcap_next(in->reader, &record, NULL) == 1) {
        look_inside(in, &record);
        in->records++;
    }
    return refuse_link(in, error);
}

static void take_option(void *context, lum_pcap_place place, unsigned code,
                        const uint8_t *value, size_t len)
{
    if (place == LUM_PCAP_SECTION && code == LUM_PCAP_COMMENT) {
        lum_comments_add(context, value, len);
    }
}

static int begin(lum_input *in, lum_comments *comments, lum_error *error)
{
    lum_error reason = {""};
    char hint[LUM_UNPACK_HINT_BYTES];
    lum_comments_rewind(comments);
    lum_pcap_take_options(in->reader, take_option, comments);
    const int begun =
        lum_pcap_begin(in->reader, is_supported, &in->link_type, &reason);
    if (begun < 0 && lum_pcap_ends_early(in->reader)) {
        (void)lum_error_set(
            error, "%s: not a capture: it ends within its headers (%s)",
            in->source->name, reason.text);
        return 1;
    }
    if (begun < 0 && lum_pcap_is_spoilt(in->reader)) {
        return lum_error_set(error, "%s: %s", in->source->name, reason.text);
    }
    if (begun < 0) {
        return lum_error_set(error,
                             "%s: not a capture (%s); a pcap, pcapng, MCAP or "
                             "bag file is expected%s",
                             in->source->name, reason.text,
                             lum_source_offset(in->source) == 0
                                 ? lum_unpack_hint(in->source, hint)
                                 : "");
    }
    return begun > 0 ? 0 : refuse_all(in, error);
}

static int refuse_for_memory(const lum_source *source, lum_error *error)
{
    return lum_error_set(error, "%s: not enough memory to read it",
                         source->name);
}

int lum_input_open(lum_source *source, lum_comments *comments, lum_input **out,
                   lum_error *error)
{
    lum_input *in = calloc(1, sizeof *in);
    if (in == NULL) {
        (void)refuse_for_memory(source, error);
        lum_source_close(source);
        return -1;
    }
    in->source = source;
    int result = start(in, error);
    if (result == 0) {
        in->reader = lum_pcap_new(in->source);
        result = in->reader != NULL ? begin(in, comments, error)
                                    : refuse_for_memory(in->source, error);
    }
    if (result != 0) {
        lum_input_close(in);
        return result;
    }
    *out = in;
    return 0;
}

void lum_input_close(lum_input *input)
{
    if (input != NULL) {
        lum_pcap_free(input->reader);
        lum_source_close(input->source);
        free(input);
    }
}

static bool has_link(const lum_input *in)
{
    return in->reader->has_wanted;
}

static bool is_all_damaged(const lum_input *in)
{
    return in->records == 0 && lum_pcap_is_spoilt(in->reader);
}

int lum_input_next(lum_input *input, lum_pcap_record *out, lum_error *error)
{
    lum_error reason;
    reason.text[0] = '\0';
    const int got = lum_pcap_next(input->reader, out, &reason);
    if (got == 0 && !has_link(input)) {
        return refuse_link(input, error);
    }
    if (got > 0 && !has_link(input)) {
        look_inside(input, out);
    }
    if (got <= 0 && is_all_damaged(input)) {
        (void)lum_pcap_fail_damaged(input->reader, &reason);
        return lum_error_set(error, "%s: %s", input->source->name, reason.text);
    }
    if (got >= 0) {
        input->records += (uint64_t)got;
        return got;
    }
    return lum_error_set(error, "%s: cannot be read beyond record %llu: %s",
                         input->source->name,
                         (unsigned long long)input->records, reason.text);
}

int lum_input_pack(lum_input *input, lum_pack *pack, lum_error *error)
{
    lum_error reason = {""};
    uint64_t offset = lum_source_offset(input->source);
    (void)lum_error_set(error, "%s", "");
    lum_pack_u64(pack, &offset);
    lum_pack_u64(pack, &input->records);
    if (!lum_pcap_pack(input->reader, pack)) {
        return -1;
    }
    if (lum_pack_is_reading(pack) &&
        lum_source_seek(input->source, offset, &reason) != 0) {
        return lum_error_set(error, "%s: cannot be read from byte %llu: %s",
                             input->source->name, (unsigned long long)offset,
                             reason.text);
    }
    return 0;
}

bool lum_input_is_unread(const lum_input *input)
{
    return !has_link(input) || is_all_damaged(input);
}
