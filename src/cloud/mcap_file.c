#include "mcap_file.h"

#include "le.h"

#include <errno.h>

enum {
    OP_HEADER = 0x01,
    OP_FOOTER = 0x02,
    OP_SCHEMA = 0x03,
    OP_CHANNEL = 0x04,
    OP_MESSAGE = 0x05,
    OP_CHUNK = 0x06,
    OP_MESSAGE_INDEX = 0x07,
    OP_CHUNK_INDEX = 0x08,
    OP_ATTACHMENT = 0x09,
    OP_ATTACHMENT_INDEX = 0x0a,
    OP_STATISTICS = 0x0b,
    OP_METADATA = 0x0c,
    OP_METADATA_INDEX = 0x0d,
    OP_SUMMARY_OFFSET = 0x0e,
    OP_DATA_END = 0x0f
};

#define MAGIC       "\x89MCAP0\r\n"
#define MAGIC_BYTES 8u

#define RECORD_HEAD  9u  /* opcode, length */
#define MESSAGE_HEAD 31u /* that, channel, sequence, both times */
#define SUM_BYTES    4u
#define SUM_AT       (RECORD_HEAD + 24u) /* in a chunk */
#define FOOTER_BYTES 20u

static const uint8_t group_ops[LUM_MCAP_GROUPS] = {
    [LUM_MCAP_SCHEMAS] = OP_SCHEMA,
    [LUM_MCAP_CHANNELS] = OP_CHANNEL,
    [LUM_MCAP_STATISTICS] = OP_STATISTICS,
    [LUM_MCAP_CHUNKS] = OP_CHUNK_INDEX,
    [LUM_MCAP_ATTACHMENTS] = OP_ATTACHMENT_INDEX,
    [LUM_MCAP_METADATA] = OP_METADATA_INDEX};

/* --- Records --- */

static int out_of_memory(const lum_mcap_file *file, lum_error *error)
{
    errno = ENOMEM;
    return lum_error_set(error, "%s: no memory for a chunk of its messages",
                         lum_sink_name(file->sink));
}

static int put(lum_mcap_file *file, const lum_bytes *bytes, lum_error *error)
{
    return bytes->failed
               ? out_of_memory(file, error)
               : lum_sink_write(file->sink, bytes->at, bytes->len, error);
}

/* At the end of some bytes; returns where it begins. */
static size_t begin_record(lum_bytes *bytes, uint8_t op)
{
    const size_t at = bytes->len;
    lum_bytes_put_u8(bytes, op);
    lum_bytes_put_u64(bytes, 0);
    return at;
}

static void end_record(lum_bytes *bytes, size_t at)
{
    if (!bytes->failed) {
        (void)lum_put_le64(bytes->at + at + 1, bytes->len - at - RECORD_HEAD);
    }
}

/* The one record in the making. */
static lum_bytes *begin_own(lum_mcap_file *file, uint8_t op)
{
    file->record.len = 0;
    (void)begin_record(&file->record, op);
    return &file->record;
}

static int put_own(lum_mcap_file *file, lum_error *error)
{
    end_record(&file->record, 0);
    return put(file, &file->record, error);
}

/* Times before 1970 are none. */
static uint64_t time_of(int64_t ns)
{
    return ns > 0 ? (uint64_t)ns : 0u;
}

/* A record that stands in the summary too. */
static int put_twice(lum_mcap_file *file, lum_mcap_group group,
                     lum_error *error)
{
    end_record(&file->record, 0);
    lum_bytes_put(&file->groups[group], file->record.at, file->record.len);
    file->counts[group]++;
    return put(file, &file->record, error);
}

/* --- The beginning --- */

int lum_mcap_begin(lum_mcap_file *out, lum_sink *sink, const char *library,
                   bool compresses, lum_error *error)
{
    out->sink = sink;
    out->chunk_max = 1;
    lum_crc32_init(&out->crc);
    if (compresses) {
        out->packer = lum_mcap_packer_new(&out->crc);
        if (out->packer == NULL) {
            return out_of_memory(out, error);
        }
    }
    lum_bytes *r = begin_own(out, OP_HEADER);
    lum_bytes_put_text(r, "ros2");
    lum_bytes_put_text(r, library);
    return lum_sink_write(sink, MAGIC, MAGIC_BYTES, error) == 0
               ? put_own(out, error)
               : -1;
}

void lum_mcap_set_threads(lum_mcap_file *file, unsigned threads)
{
    if (file->packer != NULL) {
        file->chunk_max = threads;
        lum_mcap_packer_set_threads(file->packer, threads);
    }
}

int lum_mcap_add_channel(lum_mcap_file *file, const char *topic,
                         const char *type, const char *definition,
                         const char *qos, lum_error *error)
{
    const uint16_t id = (uint16_t)(file->counts[LUM_MCAP_CHANNELS] + 1u);
    lum_bytes *r = begin_own(file, OP_SCHEMA);
    lum_bytes_put_u16(r, id);
    lum_bytes_put_text(r, type);
    lum_bytes_put_text(r, "ros2msg");
    lum_bytes_put_text(r, definition);
    if (put_twice(file, LUM_MCAP_SCHEMAS, error) != 0) {
        return -1;
    }
    r = begin_own(file, OP_CHANNEL);
    lum_bytes_put_u16(r, id);
    lum_bytes_put_u16(r, id);
    lum_bytes_put_text(r, topic);
    lum_bytes_put_text(r, "cdr");
    const size_t map = lum_bytes_begin_u32(r);
    lum_bytes_put_text(r, "offered_qos_profiles");
    lum_bytes_put_text(r, qos);
    lum_bytes_end_u32(r, map);
    return put_twice(file, LUM_MCAP_CHANNELS, error);
}

int lum_mcap_add_metadata(lum_mcap_file *file, const char *name,
                          const char *const *pairs, lum_error *error)
{
    const uint64_t offset = lum_sink_bytes(file->sink);
    lum_bytes *r = begin_own(file, OP_METADATA);
    lum_bytes_put_text(r, name);
    const size_t map = lum_bytes_begin_u32(r);
    for (; *pairs != NULL; pairs++) {
        lum_bytes_put_text(r, *pairs);
    }
    lum_bytes_end_u32(r, map);
    if (put_own(file, error) != 0) {
        return -1;
    }
    lum_bytes *index = &file->groups[LUM_MCAP_METADATA];
    const size_t at = begin_record(index, OP_METADATA_INDEX);
    lum_bytes_put_u64(index, offset);
    lum_bytes_put_u64(index, file->record.len);
    lum_bytes_put_text(index, name);
    end_record(index, at);
    file->counts[LUM_MCAP_METADATA]++;
    return 0;
}

int lum_mcap_add_attachment(lum_mcap_file *file, const char *name,
                            const char *media_type, const char *text,
                            lum_error *error)
{
    const size_t n = strlen(text);
    const uint64_t offset = lum_sink_bytes(file->sink);
    lum_bytes *r = begin_own(file, OP_ATTACHMENT);
    lum_bytes_put_u64(r, 0); /* log_time */
    lum_bytes_put_u64(r, 0); /* create_time */
    lum_bytes_put_text(r, name);
    lum_bytes_put_text(r, media_type);
    lum_bytes_put_u64(r, n);
    lum_bytes_put(r, text, n);
    lum_bytes_put_u32(r, r->failed
                             ? 0
                             : lum_crc32_add(&file->crc, 0, r->at + RECORD_HEAD,
                                             r->len - RECORD_HEAD));
    if (put_own(file, error) != 0) {
        return -1;
    }
    lum_bytes *index = &file->groups[LUM_MCAP_ATTACHMENTS];
    const size_t at = begin_record(index, OP_ATTACHMENT_INDEX);
    lum_bytes_put_u64(index, offset);
    lum_bytes_put_u64(index, file->record.len);
    lum_bytes_put_u64(index, 0);
    lum_bytes_put_u64(index, 0);
    lum_bytes_put_u64(index, n);
    lum_bytes_put_text(index, name);
    lum_bytes_put_text(index, media_type);
    end_record(index, at);
    file->counts[LUM_MCAP_ATTACHMENTS]++;
    return 0;
}

/* --- Chunks --- */

static lum_mcap_chunk *chunk_at(lum_mcap_file *file, uint64_t number)
{
    return &file->chunks[number % file->chunk_max];
}

/* Being filled. */
static lum_mcap_chunk *present(lum_mcap_file *file)
{
    return chunk_at(file, file->chunks_ended);
}

/* What of a chunk is written: itself, or compressed. */
static lum_bytes *body_of(const lum_mcap_file *file, lum_mcap_chunk *chunk)
{
    return file->packer != NULL ? &chunk->packing.packed : &chunk->messages;
}

/* Its record up to the messages. */
static int put_chunk_head(lum_mcap_file *file, const lum_mcap_chunk *chunk,
                          uint64_t bytes, uint32_t sum, uint64_t packed,
                          lum_error *error)
{
    lum_bytes *r = begin_own(file, OP_CHUNK);
    lum_bytes_put_u64(r, time_of(chunk->begin_ns));
    lum_bytes_put_u64(r, time_of(chunk->end_ns));
    lum_bytes_put_u64(r, bytes);
    lum_bytes_put_u32(r, sum);
    lum_bytes_put_text(r, file->packer != NULL ? lum_mcap_pack_name : "");
    lum_bytes_put_u64(r, packed);
    if (!r->failed) {
        (void)lum_put_le64(r->at + 1, r->len - RECORD_HEAD + packed);
    }
    return put(file, r, error);
}

/* The messages of each channel; where that stands goes into the index of
 * chunks. */
static int put_message_indexes(lum_mcap_file *file, lum_mcap_chunk *chunk,
                               lum_bytes *offsets, lum_error *error)
{
    for (unsigned i = 0; i < file->counts[LUM_MCAP_CHANNELS]; i++) {
        lum_bytes *index = &chunk->indexes[i];
        if (index->len == 0) {
            continue;
        }
        lum_bytes_put_u16(offsets, (uint16_t)(i + 1u));
        lum_bytes_put_u64(offsets, lum_sink_bytes(file->sink));
        lum_bytes *r = begin_own(file, OP_MESSAGE_INDEX);
        lum_bytes_put_u16(r, (uint16_t)(i + 1u));
        lum_bytes_put_u32(r, (uint32_t)index->len);
        lum_bytes_put(r, index->at, index->len);
        if (put_own(file, error) != 0) {
            return -1;
        }
        index->len = 0;
    }
    return 0;
}

/* What begins there has been put. */
static int index_chunk(lum_mcap_file *file, lum_mcap_chunk *chunk,
                       uint64_t offset, uint64_t bytes, uint64_t packed,
                       lum_error *error)
{
    lum_bytes *index = &file->groups[LUM_MCAP_CHUNKS];
    const uint64_t end = lum_sink_bytes(file->sink);
    const size_t at = begin_record(index, OP_CHUNK_INDEX);
    lum_bytes_put_u64(index, time_of(chunk->begin_ns));
    lum_bytes_put_u64(index, time_of(chunk->end_ns));
    lum_bytes_put_u64(index, offset);
    lum_bytes_put_u64(index, end - offset);
    const size_t map = lum_bytes_begin_u32(index);
    if (put_message_indexes(file, chunk, index, error) != 0) {
        return -1;
    }
    lum_bytes_end_u32(index, map);
    lum_bytes_put_u64(index, lum_sink_bytes(file->sink) - end);
    lum_bytes_put_text(index, file->packer != NULL ? lum_mcap_pack_name : "");
    lum_bytes_put_u64(index, packed);
    lum_bytes_put_u64(index, bytes);
    end_record(index, at);
    file->counts[LUM_MCAP_CHUNKS]++;
    chunk->messages.len = 0;
    return index->failed ? out_of_memory(file, error) : 0;
}

static int put_indexed_chunk(lum_mcap_file *file, lum_mcap_chunk *chunk,
                             lum_error *error)
{
    const lum_bytes *body = body_of(file, chunk);
    const lum_bytes *messages = &chunk->messages;
    const uint64_t offset = lum_sink_bytes(file->sink);
    if (body->failed) {
        return out_of_memory(file, error);
    }
    const uint32_t sum =
        file->packer != NULL
            ? chunk->packing.crc
            : lum_crc32_add(&file->crc, 0, messages->at, messages->len);
    return put_chunk_head(file, chunk, messages->len, sum, body->len, error) ==
                       0 &&
                   lum_sink_lend(file->sink, body->at, body->len, error) == 0
               ? index_chunk(file, chunk, offset, messages->len, body->len,
                             error)
               : -1;
}

/* Put chunks that have ended, until at most `left` are under way. Of the others
 * those that are compressed already. */
static int put_ended(lum_mcap_file *file, uint64_t left, lum_error *error)
{
    while (file->chunks_put < file->chunks_ended) {
        lum_mcap_chunk *chunk = chunk_at(file, file->chunks_put);
        const bool waits = file->chunks_ended - file->chunks_put > left;
        if (file->packer != NULL &&
            !lum_mcap_packer_is_done(file->packer, &chunk->packing, waits)) {
            return 0;
        }
        file->chunks_put++;
        if (put_indexed_chunk(file, chunk, error) != 0) {
            return -1;
        }
    }
    return 0;
}

/* The present one, which has messages. */
static int end_present(lum_mcap_file *file, lum_error *error)
{
    lum_mcap_chunk *chunk = present(file);
    chunk->packing.chunk = &chunk->messages;
    if (file->packer != NULL) {
        lum_mcap_packer_give(file->packer, &chunk->packing);
    }
    file->chunks_ended++;
    return put_ended(file, file->chunk_max, error);
}

int lum_mcap_end_chunk(lum_mcap_file *file, lum_error *error)
{
    const lum_bytes *messages = &present(file)->messages;
    const bool is_free =
        file->chunks_ended - file->chunks_put < file->chunk_max;
    if (messages->failed) {
        return out_of_memory(file, error);
    }
    if (is_free && messages->len > 0 && end_present(file, error) != 0) {
        return -1;
    }
    return put_ended(file, 0, error);
}

/* --- Messages --- */

static uint64_t count_messages(const lum_mcap_file *file)
{
    uint64_t n = 0;
    for (unsigned i = 0; i < file->counts[LUM_MCAP_CHANNELS]; i++) {
        n += file->messages[i];
    }
    return n;
}

static void widen(int64_t *begin_ns, int64_t *end_ns, bool is_first,
                  int64_t time_ns)
{
    *begin_ns = is_first || time_ns < *begin_ns ? time_ns : *begin_ns;
    *end_ns = is_first || time_ns > *end_ns ? time_ns : *end_ns;
}

/* The chunk for a message. A new one is filled when its memory is free and what
 * was lent to the sink is written. */
static lum_mcap_chunk *chunk_for(lum_mcap_file *file, int64_t time_ns,
                                 lum_error *error)
{
    if (put_ended(file, file->chunk_max - 1u, error) != 0) {
        return NULL;
    }
    const lum_mcap_chunk *chunk = present(file);
    if (chunk->messages.len > 0 &&
        time_ns - chunk->begin_ns >= LUM_MCAP_CHUNK_NS &&
        (end_present(file, error) != 0 ||
         put_ended(file, file->chunk_max - 1u, error) != 0)) {
        return NULL;
    }
    return present(file)->messages.len > 0 ||
                   lum_sink_settle(file->sink, error) == 0
               ? present(file)
               : NULL;
}

int lum_mcap_begin_message(lum_mcap_file *file, unsigned channel,
                           int64_t time_ns, lum_bytes **out, lum_error *error)
{
    lum_mcap_chunk *chunk = chunk_for(file, time_ns, error);
    if (chunk == NULL) {
        return -1;
    }
    lum_bytes *messages = &chunk->messages;
    lum_bytes *index = &chunk->indexes[channel];
    widen(&file->begin_ns, &file->end_ns, count_messages(file) == 0, time_ns);
    widen(&chunk->begin_ns, &chunk->end_ns, messages->len == 0, time_ns);
    lum_bytes_put_u64(index, time_of(time_ns));
    lum_bytes_put_u64(index, messages->len);
    file->message = begin_record(messages, OP_MESSAGE);
    lum_bytes_put_u16(messages, (uint16_t)(channel + 1u));
    lum_bytes_put_u32(messages, (uint32_t)file->messages[channel]);
    lum_bytes_put_u64(messages, time_of(time_ns));
    lum_bytes_put_u64(messages, time_of(time_ns));
    file->messages[channel]++;
    *out = messages;
    return messages->failed || index->failed ? out_of_memory(file, error) : 0;
}

int lum_mcap_expect(lum_mcap_file *file, size_t n, lum_error *error)
{
    lum_bytes *messages = &present(file)->messages;
    lum_mcap_large *large = &file->large;
    large->is_begun = file->can_patch && file->packer == NULL &&
                      n >= LUM_MCAP_CHUNK_BYTES && !messages->failed;
    if (!large->is_begun) {
        const bool has_room = lum_bytes_extend(messages, n) != NULL;
        messages->len -= has_room ? n : 0;
        return has_room ? 0 : out_of_memory(file, error);
    }
    large->offset = lum_sink_bytes(file->sink);
    large->bytes = (uint64_t)messages->len + n;
    (void)lum_put_le64(messages->at + file->message + 1,
                       large->bytes - file->message - RECORD_HEAD);
    large->sum = lum_crc32_add(&file->crc, 0, messages->at, messages->len);
    return put_chunk_head(file, present(file), large->bytes, 0, large->bytes,
                          error) == 0
               ? put(file, messages, error)
               : -1;
}

int lum_mcap_put_expected(lum_mcap_file *file, const void *bytes, size_t n,
                          lum_error *error)
{
    if (!file->large.is_begun) {
        lum_bytes_put(&present(file)->messages, bytes, n);
        return 0;
    }
    file->large.sum = lum_crc32_add(&file->crc, file->large.sum, bytes, n);
    return lum_sink_write(file->sink, bytes, n, error);
}

static int end_large(lum_mcap_file *file, lum_error *error)
{
    lum_mcap_large *large = &file->large;
    unsigned char sum[SUM_BYTES];
    (void)lum_put_le32(sum, large->sum);
    large->is_begun = false;
    return lum_sink_patch(file->sink, large->offset + SUM_AT, sum, sizeof sum,
                          error) == 0
               ? index_chunk(file, present(file), large->offset, large->bytes,
                             large->bytes, error)
               : -1;
}

int lum_mcap_end_message(lum_mcap_file *file, lum_error *error)
{
    lum_bytes *messages = &present(file)->messages;
    if (file->large.is_begun) {
        return end_large(file, error);
    }
    if (messages->failed) {
        return out_of_memory(file, error);
    }
    end_record(messages, file->message);
    return messages->len >= LUM_MCAP_CHUNK_BYTES ? end_present(file, error) : 0;
}

/* --- The end --- */

static void make_statistics(lum_mcap_file *file)
{
    lum_bytes *r = &file->groups[LUM_MCAP_STATISTICS];
    const uint32_t channels = file->counts[LUM_MCAP_CHANNELS];
    const size_t at = begin_record(r, OP_STATISTICS);
    lum_bytes_put_u64(r, count_messages(file));
    lum_bytes_put_u16(r, (uint16_t)file->counts[LUM_MCAP_SCHEMAS]);
    lum_bytes_put_u32(r, channels);
    lum_bytes_put_u32(r, file->counts[LUM_MCAP_ATTACHMENTS]);
    lum_bytes_put_u32(r, file->counts[LUM_MCAP_METADATA]);
    lum_bytes_put_u32(r, file->counts[LUM_MCAP_CHUNKS]);
    lum_bytes_put_u64(r, time_of(file->begin_ns));
    lum_bytes_put_u64(r, time_of(file->end_ns));
    const size_t map = lum_bytes_begin_u32(r);
    for (unsigned i = 0; i < channels; i++) {
        lum_bytes_put_u16(r, (uint16_t)(i + 1u));
        lum_bytes_put_u64(r, file->messages[i]);
    }
    lum_bytes_end_u32(r, map);
    end_record(r, at);
}

/* Its groups, and where each stands. */
static int put_summary(lum_mcap_file *file, lum_bytes *offsets, uint32_t *sum,
                       lum_error *error)
{
    for (unsigned i = 0; i < LUM_MCAP_GROUPS; i++) {
        const lum_bytes *group = &file->groups[i];
        const uint64_t offset = lum_sink_bytes(file->sink);
        if (put(file, group, error) != 0) {
            return -1;
        }
        if (group->len == 0) {
            continue;
        }
        *sum = lum_crc32_add(&file->crc, *sum, group->at, group->len);
        const size_t at = begin_record(offsets, OP_SUMMARY_OFFSET);
        lum_bytes_put_u8(offsets, group_ops[i]);
        lum_bytes_put_u64(offsets, offset);
        lum_bytes_put_u64(offsets, group->len);
        end_record(offsets, at);
    }
    return 0;
}

/* Its sum is that of the summary, and of the footer up to the sum. */
static void make_footer(lum_mcap_file *file, uint64_t summary,
                        lum_bytes *offsets, uint32_t sum)
{
    const uint64_t start = lum_sink_bytes(file->sink);
    lum_bytes_put_u8(offsets, OP_FOOTER);
    lum_bytes_put_u64(offsets, FOOTER_BYTES);
    lum_bytes_put_u64(offsets, summary);
    lum_bytes_put_u64(offsets, start);
    if (!offsets->failed) {
        sum = lum_crc32_add(&file->crc, sum, offsets->at, offsets->len);
    }
    lum_bytes_put_u32(offsets, sum);
    lum_bytes_put(offsets, MAGIC, MAGIC_BYTES);
}

static int end_file(lum_mcap_file *file, lum_bytes *offsets, lum_error *error)
{
    uint32_t sum = 0;
    lum_bytes *r = begin_own(file, OP_DATA_END);
    lum_bytes_put_u32(r, 0); /* the chunks have theirs */
    if (put_own(file, error) != 0) {
        return -1;
    }
    const uint64_t summary = lum_sink_bytes(file->sink);
    make_statistics(file);
    if (put_summary(file, offsets, &sum, error) != 0) {
        return -1;
    }
    make_footer(file, summary, offsets, sum);
    return put(file, offsets, error);
}

int lum_mcap_end(lum_mcap_file *file, lum_error *error)
{
    lum_bytes offsets = {0};
    if (lum_mcap_end_chunk(file, error) != 0) {
        return -1;
    }
    const int result = end_file(file, &offsets, error);
    const int code = errno;
    lum_bytes_free(&offsets);
    errno = code;
    return result;
}

void lum_mcap_free(lum_mcap_file *file)
{
    lum_mcap_packer_free(file->packer);
    for (unsigned i = 0; i < LUM_MCAP_GROUPS; i++) {
        lum_bytes_free(&file->groups[i]);
    }
    for (unsigned i = 0; i < LUM_MCAP_THREADS_MAX; i++) {
        lum_mcap_chunk *chunk = &file->chunks[i];
        for (unsigned k = 0; k < LUM_MCAP_CHANNELS_MAX; k++) {
            lum_bytes_free(&chunk->indexes[k]);
        }
        lum_bytes_free(&chunk->messages);
        lum_bytes_free(&chunk->packing.packed);
    }
    lum_bytes_free(&file->record);
}
