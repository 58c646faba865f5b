/* One source or several to records: link types, fragments, joined datagrams. */
#include "lum/capture/capture.h"

#include "base/sized.h"
#include "capture_internal.h"
#include "fragments.h"
#include "joined.h"
#include "link.h"
#include "lum/capture/demux.h"
#include "lum/wire.h"
#include "merge.h"
#include "remarks.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct lum_capture {
    lum_merge *files;
    lum_fragments *fragments; /* of a datagram may be in two files */
    lum_link_reader *link;    /* of link_type; NULL: it is not supported */
    uint32_t link_type;       /* of the record before */
    const char *interface;    /* of the last record; NULL: it is not known */
    lum_record record;        /* the last one */
    lum_joined joined;        /* what of it was handed out */
    uint8_t *rest; /* its payload if it was read from a state; else NULL */
    lum_remarks remarks;
    char rest_interface[LUM_INTERFACE_BYTES]; /* and where that came from */
    bool ended;
};

/* Takes the files over. */
static int make_capture(lum_merge *files, lum_capture **out, lum_error *error)
{
    lum_capture *c = calloc(1, sizeof *c);
    lum_fragments *fragments = lum_fragments_new();
    if (c == NULL || fragments == NULL) {
        free(c);
        lum_fragments_free(fragments);
        lum_merge_close(files);
        return lum_error_set(error, "not enough memory to read a capture");
    }
    c->files = files;
    c->fragments = fragments;
    c->link = lum_link_find(c->link_type);
    *out = c;
    return 0;
}

int lum_capture_open_from(const lum_capture_from *from, lum_capture **out,
                          lum_error *error)
{
    lum_merge *files = NULL;
    const int opened =
        from->source != NULL
            ? lum_merge_one(from->source, from->go_on, &files, error)
            : lum_merge_open(from->paths, from->count, from->go_on, &files,
                             error);
    return opened == 0 ? make_capture(files, out, error) : -1;
}

int lum_capture_open_source(lum_source *source, lum_capture **out,
                            lum_error *error)
{
    const lum_capture_from from = {.source = source};
    return lum_capture_open_from(&from, out, error);
}

int lum_capture_open_several(const char *const *paths, size_t count,
                             lum_capture **out, lum_error *error)
{
    const lum_capture_from from = {.paths = paths, .count = count};
    return lum_capture_open_from(&from, out, error);
}

int lum_capture_open(const char *path, lum_capture **out, lum_error *error)
{
    return lum_capture_open_several(&path, 1, out, error);
}

static int end(lum_capture *c, int status, lum_record *out)
{
    c->ended = true;
    c->interface = NULL;
    out->dropped_fragments = lum_fragments_drop_all(c->fragments);
    return status;
}

/* Few captures have more than one. */
static lum_link_reader *link_of(lum_capture *c, uint32_t link_type)
{
    if (link_type != c->link_type) {
        c->link_type = link_type;
        c->link = lum_link_find(link_type);
    }
    return c->link;
}

static void read_record(lum_capture *c, const lum_pcap_record *from,
                        lum_record *out)
{
    lum_span packet;
    lum_fragment fragment;
    lum_link_reader *const link = link_of(c, from->link_type);
    if (link != NULL && link((lum_span){from->bytes, from->len}, &packet)) {
        lum_ipv4_read(packet, out, &fragment);
        if (out->kind == LUM_RECORD_FRAGMENT) {
            lum_fragments_add(c->fragments, &fragment, out);
        }
    }
}

int lum_capture_next(lum_capture *capture, lum_record *out, lum_error *error)
{
    lum_pcap_record packet;
    lum_record *const record = &capture->record;
    if (lum_joined_has_more(&capture->joined, record)) {
        (void)lum_joined_next(&capture->joined, record, out);
        return 1;
    }
    memset(out, 0, sizeof *out);
    out->kind = LUM_RECORD_OTHER;
    if (capture->ended) {
        return 0;
    }
    const int got = lum_merge_next(capture->files, &packet, error);
    if (got != 1) {
        return end(capture, got, out);
    }
    capture->interface = packet.name;
    *record = *out;
    record->time_ns = packet.time_ns;
    record->dropped_fragments =
        lum_fragments_expire(capture->fragments, packet.time_ns);
    read_record(capture, &packet, record);
    lum_remarks_take(&capture->remarks, &packet, record);
    capture->joined = (lum_joined){.each = 0};
    (void)lum_joined_next(&capture->joined, record, out);
    return 1;
}

const char *lum_capture_interface(const lum_capture *capture)
{
    return capture->interface;
}

void lum_capture_progress(const lum_capture *capture, uint64_t *done,
                          uint64_t *total)
{
    lum_merge_progress(capture->files, done, total);
}

bool lum_capture_can_seek(const lum_capture *capture)
{
    return lum_merge_can_seek(capture->files);
}

/* The datagrams of a record that were not handed out yet, as a record. */
static lum_record rest_of(const lum_capture *c)
{
    lum_record rest = c->record;
    rest.kind = LUM_RECORD_JOINED;
    rest.dropped_fragments = 0;
    rest.len = 0;
    if (lum_joined_has_more(&c->joined, &c->record)) {
        rest.payload += c->joined.at;
        rest.len = c->record.len - c->joined.at;
    }
    return rest;
}

/* bytes: its payload, taken over. */
static void take_rest(lum_capture *c, const lum_record *rest, uint8_t *bytes,
                      uint32_t len, uint32_t each)
{
    free(c->rest);
    c->rest = bytes;
    c->record = *rest;
    c->record.payload = bytes;
    c->record.len = len;
    c->joined.each = each;
}

static void pack_interface(lum_capture *c, lum_pack *pack)
{
    if (!lum_pack_is_reading(pack) && c->interface != c->rest_interface) {
        (void)snprintf(c->rest_interface, sizeof c->rest_interface, "%s",
                       c->interface != NULL ? c->interface : "");
    }
    lum_pack_text(pack, c->rest_interface, sizeof c->rest_interface);
    if (lum_pack_is_reading(pack)) {
        c->interface = c->rest_interface[0] != '\0' ? c->rest_interface : NULL;
    }
}

static bool pack_rest(lum_capture *c, lum_pack *pack)
{
    static const lum_joined none = {.each = 0};
    const bool is_reading = lum_pack_is_reading(pack);
    lum_record rest = rest_of(c);
    uint32_t len = (uint32_t)rest.len;
    uint32_t each = (uint32_t)c->joined.each;
    lum_pack_u32(pack, &len);
    c->joined = is_reading ? none : c->joined;
    if (len == 0 || !lum_pack_check(pack, len <= LUM_IPV4_BYTES_MAX)) {
        return !pack->has_failed;
    }
    uint8_t *bytes = malloc(len);
    if (bytes == NULL) {
        pack->has_failed = true;
        return false;
    }
    if (!is_reading) {
        memcpy(bytes, rest.payload, len);
    }
    lum_pack_u32(pack, &each);
    lum_pack_i64(pack, &rest.time_ns);
    lum_pack_u32(pack, &rest.source);
    lum_pack_u32(pack, &rest.destination);
    lum_pack_u16(pack, &rest.source_port);
    lum_pack_u16(pack, &rest.destination_port);
    lum_pack_bytes(pack, bytes, len);
    pack_interface(c, pack);
    if (is_reading && !pack->has_failed) {
        take_rest(c, &rest, bytes, len, each);
    } else {
        free(bytes);
    }
    return !pack->has_failed;
}

int lum_capture_pack(lum_capture *capture, lum_pack *pack, lum_error *error)
{
    if (lum_merge_pack(capture->files, pack, error) != 0) {
        return -1;
    }
    if (lum_pack_is_reading(pack)) {
        capture->ended = false;
        capture->interface = NULL;
    }
    return lum_fragments_pack(capture->fragments, pack) &&
                   pack_rest(capture, pack)
               ? 0
               : -1;
}

size_t lum_capture_source_count(const lum_capture *capture)
{
    return lum_merge_count(capture->files);
}

lum_result lum_capture_get_source(const lum_capture *capture, size_t i,
                                  lum_capture_source *out)
{
    lum_capture_source source;
    lum_merge_get(capture->files, i, &source);
    return lum_sized_fill(out, &source, sizeof source) ? LUM_OK : LUM_E_VALUE;
}

uint64_t lum_capture_damaged(const lum_capture *capture, lum_error *error)
{
    return lum_merge_damaged(capture->files, error);
}

size_t lum_capture_comment_count(const lum_capture *capture, size_t source)
{
    return lum_merge_comments(capture->files, source)->count;
}

const char *lum_capture_comment(const lum_capture *capture, size_t source,
                                size_t i, size_t *len)
{
    const lum_comment *comment =
        &lum_merge_comments(capture->files, source)->list[i];
    *len = comment->len;
    return comment->text;
}

uint64_t lum_capture_comments_left_out(const lum_capture *capture,
                                       size_t source)
{
    return lum_merge_comments(capture->files, source)->left_out;
}

bool lum_capture_remark(const lum_capture *capture, const lum_demux *demux,
                        uint16_t port, size_t i, lum_error *out)
{
    return lum_remarks_get(capture != NULL ? &capture->remarks : NULL, demux,
                           port, i, out);
}

void lum_capture_close(lum_capture *capture)
{
    if (capture == NULL) {
        return;
    }
    lum_fragments_free(capture->fragments);
    lum_merge_close(capture->files);
    free(capture->rest);
    free(capture);
}
