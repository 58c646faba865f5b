#include "lum/capture/capture.h"
#include "fragments.h"
#include "pcap.h"
#include "unpack.h"

#include <stdlib.h>
#include <string.h>

struct lum_capture {
    lum_source *source;
    lum_pcap *reader;
    lum_fragments *fragments;
    lum_link_reader *link; /* of link_type; NULL: it is not supported */
    uint32_t link_type;    /* of the record before */
    uint64_t records;
    bool ended;
};

/* Whether there is a first byte; a directory gives its error here. */
static int check_start(lum_source *source, lum_error *error)
{
    if (lum_source_has(source, 1)) {
        return 0;
    }
    if (!source->has_failed) {
        return lum_error_set(error,
                             "%s: is empty; a pcap or pcapng file is expected",
                             source->name);
    }
    return lum_error_set(
        error, "%s: cannot be read: %s; a pcap or pcapng file is expected",
        source->name, source->error.text);
}

/* Both as it is and unpacked. */
static int start(lum_capture *c, lum_error *error)
{
    if (check_start(c->source, error) != 0 ||
        lum_unpack(&c->source, error) != 0) {
        return -1;
    }
    return check_start(c->source, error);
}

static bool is_supported(uint32_t link_type)
{
    return lum_link_find(link_type) != NULL;
}

static int begin(lum_capture *c, lum_error *error)
{
    lum_error reason = {""};
    const char *name = c->source->name;
    const int begun =
        lum_pcap_begin(c->reader, is_supported, &c->link_type, &reason);
    if (begun < 0) {
        return lum_error_set(
            error,
            "%s: not a capture (%s); a pcap or pcapng file is expected%s", name,
            reason.text, lum_unpack_hint(c->source));
    }
    c->link = lum_link_find(c->link_type);
    if (begun == 0) {
        return lum_error_set(
            error, "%s: link type %lu (%s) is not supported; supported are %s",
            name, (unsigned long)c->link_type, lum_link_name(c->link_type),
            lum_link_supported());
    }
    return 0;
}

int lum_capture_open_source(lum_source *source, lum_capture **out,
                            lum_error *error)
{
    lum_capture *c = calloc(1, sizeof *c);
    if (c == NULL) {
        (void)lum_error_set(error, "%s: not enough memory to read it",
                            source->name);
        lum_source_close(source);
        return -1;
    }
    c->source = source;
    int result = start(c, error);
    if (result == 0) {
        c->reader = lum_pcap_new(c->source);
        c->fragments = lum_fragments_new();
        result = c->reader == NULL || c->fragments == NULL
                     ? lum_error_set(error, "%s: not enough memory to read it",
                                     source->name)
                     : begin(c, error);
    }
    if (result != 0) {
        lum_capture_close(c);
        return -1;
    }
    *out = c;
    return 0;
}

int lum_capture_open(const char *path, lum_capture **out, lum_error *error)
{
    lum_source *source = NULL;
    return lum_source_open(path, &source, error) == 0
               ? lum_capture_open_source(source, out, error)
               : -1;
}

static int end(lum_capture *c, const char *reason, lum_record *out,
               lum_error *error)
{
    c->ended = true;
    out->dropped_fragments = lum_fragments_drop_all(c->fragments);
    if (reason == NULL) {
        return 0;
    }
    return lum_error_set(error, "%s: cannot be read on after record %llu: %s",
                         c->source->name, (unsigned long long)c->records,
                         reason);
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
    lum_pcap_record record;
    lum_error reason;
    memset(out, 0, sizeof *out);
    out->kind = LUM_RECORD_OTHER;
    if (capture->ended) {
        return 0;
    }
    const int got = lum_pcap_next(capture->reader, &record, &reason);
    if (got != 1) {
        return end(capture, got == 0 ? NULL : reason.text, out, error);
    }
    capture->records++;
    out->time_ns = record.time_ns;
    out->dropped_fragments =
        lum_fragments_expire(capture->fragments, out->time_ns);
    read_record(capture, &record, out);
    return 1;
}

void lum_capture_progress(const lum_capture *capture, uint64_t *done,
                          uint64_t *total)
{
    lum_source_progress(capture->source, done, total);
}

void lum_capture_close(lum_capture *capture)
{
    if (capture == NULL) {
        return;
    }
    lum_fragments_free(capture->fragments);
    lum_pcap_free(capture->reader);
    lum_source_close(capture->source);
    free(capture);
}
