/* Any bytes as a capture file, and as an MCAP file of any messages. */
#include "capture/mcap_messages.h"
#include "lum/capture/capture.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define SMALLEST_RECORD 12u   /* one of several joined ones */
#define LARGEST_RATIO   1032u /* of what was compressed; bzip2 has sums */
#define LARGEST_PAYLOAD 65507u

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static void require(int fact)
{
    if (!fact) {
        abort();
    }
}

static void check_record(const lum_record *r)
{
    static volatile uint8_t last;
    const int64_t limit_ns = INT64_C(1) << 62;
    require(r->kind >= LUM_RECORD_DATAGRAM && r->kind <= LUM_RECORD_JOINED);
    require(r->time_ns > -limit_ns && r->time_ns < limit_ns);
    require(r->len <= LARGEST_PAYLOAD);
    require(lum_record_is_datagram(r) || r->len == 0);
    for (size_t i = 0; i < r->len; i++) {
        last = r->payload[i];
    }
    (void)last;
}

static void check_comments(const lum_capture *capture)
{
    const size_t count = lum_capture_comment_count(capture, 0);
    require(count <= LUM_CAPTURE_COMMENTS_MAX);
    for (size_t i = 0; i < count; i++) {
        size_t len = 0;
        const char *text = lum_capture_comment(capture, 0, i, &len);
        require(len <= LUM_CAPTURE_COMMENT_BYTES_MAX);
        require(text[len] == '\0');
    }
    require(count == LUM_CAPTURE_COMMENTS_MAX ||
            lum_capture_comments_left_out(capture, 0) == 0);
}

static void check_damage(const lum_capture *capture)
{
    lum_error error = {""};
    lum_capture_source source = {.struct_size = sizeof source};
    const uint64_t damaged = lum_capture_damaged(capture, &error);
    require(lum_capture_get_source(capture, 0, &source) == LUM_OK);
    require(source.damaged == damaged);
    require((damaged != 0) == (error.text[0] != '\0'));
}

static void check_message(const lum_mcap_message *m, size_t topics)
{
    static volatile uint8_t last;
    require(m->index < topics && topics <= LUM_MCAP_CHANNELS_KEPT_MAX);
    require(strlen(m->topic->name) <= LUM_MCAP_NAME_MAX);
    require(strlen(m->topic->type) <= LUM_MCAP_NAME_MAX);
    require(strlen(m->topic->definition) <= LUM_MCAP_NAME_MAX);
    require(strlen(m->topic->encoding) <= LUM_MCAP_NAME_MAX);
    for (size_t i = 0; i < m->len; i++) {
        last = m->bytes[i];
    }
    (void)last;
}

static void read_messages(const uint8_t *data, size_t size)
{
    lum_error error = {""};
    lum_mcap_message m;
    size_t topics = 0;
    lum_mcap_event event = LUM_MCAP_ENDED;
    lum_source *source = lum_source_from_memory("fuzz", data, size);
    if (source == NULL) {
        return;
    }
    lum_mcap_messages *messages = lum_mcap_messages_new(source, &error);
    while (messages != NULL && (event = lum_mcap_messages_next(
                                    messages, &m, &error)) > LUM_MCAP_ENDED) {
        topics += event == LUM_MCAP_HAS_TOPIC ? 1u : 0u;
        check_message(&m, topics);
    }
    require(messages == NULL || event == LUM_MCAP_ENDED ||
            error.text[0] != '\0');
    lum_mcap_messages_free(messages);
    lum_source_close(source);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    read_messages(data, size);
    lum_capture *capture = NULL;
    lum_record record;
    lum_error error;
    uint64_t records = 0;
    uint64_t dropped = 0;
    uint64_t kept = 0;
    int result = 0;
    lum_source *source = lum_source_from_memory("fuzz", data, size);
    if (source == NULL ||
        lum_capture_open_source(source, &capture, &error) != 0) {
        return 0;
    }
    while ((result = lum_capture_next(capture, &record, &error)) == 1) {
        check_record(&record);
        records++;
        dropped += record.dropped_fragments;
        kept += record.kind == LUM_RECORD_FRAGMENT;
        require(records <= size * LARGEST_RATIO / SMALLEST_RECORD);
    }
    dropped += record.dropped_fragments;
    require(dropped <= kept);
    require(lum_capture_next(capture, &record, &error) == 0);
    require(record.dropped_fragments == 0);
    check_comments(capture);
    check_damage(capture);
    lum_capture_close(capture);
    return 0;
}
