/* Any file of an index, with the right sum or not, and any states in it, over
 * one small capture: seeks end, with frames or without. The first byte says
 * where to go; the rest is the body of the file. */
#include "frame/reader_internal.h"

#include "lum/group.h"
#include "lum/wire.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define LINES      30u
#define RECORDS    (LINES * 4u)
#define BYTES_MAX  (RECORDS * 200u)
#define EVENTS_MAX 20000u

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

static uint8_t capture[BYTES_MAX];
static size_t capture_len;

static void store(uint8_t *to, uint32_t value)
{
    for (unsigned i = 0; i < 4; i++) {
        to[i] = (uint8_t)(value >> (8u * i) & 0xffu);
    }
}

/* A line's datagram of four; its length. */
static size_t put_datagram(const lum_layout *layout, uint32_t line, uint32_t k,
                           uint8_t *to)
{
    const lum_group group = {.line = line % 10u,
                             .num_samples = 5,
                             .first_sample_index = 5u * (k / 2u),
                             .clock_raw = 1000u * line,
                             .eye = (uint8_t)(k % 2u),
                             .tag = LUM_TAG_RANGES};
    size_t len = 0;
    if (lum_group_encode(layout, &group, to, 100, &len) != LUM_OK) {
        abort();
    }
    for (uint32_t i = 0; i < group.num_samples; i++) {
        lum_word_encode(lum_word_make(3000, true, i + group.first_sample_index),
                        to + len);
        len += LUM_SAMPLE_BYTES;
    }
    return len;
}

/* One datagram of a line, or all four joined. */
static void add_record(const lum_layout *layout, uint32_t line, uint32_t k,
                       uint32_t count)
{
    uint8_t *record = capture + capture_len;
    uint8_t *packet = record + 16;
    size_t all = 28;
    memset(record, 0, 16u + all);
    for (uint32_t i = 0; i < count; i++) {
        all += put_datagram(layout, line, k + i, packet + all);
    }
    store(record, 1700000000u);
    store(record + 4, 1000u * line);
    store(record + 8, (uint32_t)all);
    store(record + 12, (uint32_t)all);
    memcpy(packet, "\x45\0\0\0\0\0\0\0\x40\x11\0\0\x0a\x2a\0\x25\x0a\x2a\0\1",
           20);
    packet[3] = (uint8_t)all;
    memcpy(packet + 20, "\x15\x8d\xc3\x50\0\0\0\0", 8);
    packet[25] = (uint8_t)(all - 20u);
    capture_len += 16u + all;
}

/* Three frames of ten lines; those of every other line are joined. */
static void make_capture(void)
{
    lum_layout layout;
    lum_layout_default(&layout);
    store(capture, 0xa1b2c3d4);
    store(capture + 4, 0x00040002);
    store(capture + 16, 65535);
    store(capture + 20, 228);
    capture_len = 24;
    for (uint32_t i = 0; i < LINES; i++) {
        const uint32_t count = i % 2u == 0 ? 4 : 1;
        for (uint32_t k = 0; k < 4; k += count) {
            add_record(&layout, i, k, count);
        }
    }
}

static void go(lum_reader *reader, unsigned where)
{
    const lum_frame *frame = NULL;
    int result = 0;
    unsigned events = 0;
    switch (where % 3u) {
    case 0:
        result = lum_reader_seek_frame(reader, where / 3u % 5u, NULL);
        break;
    case 1:
        result =
            lum_reader_seek_number(reader, 0x0a2a0025, where / 3u % 5u, NULL);
        break;
    default:
        result = lum_reader_seek_time(reader,
                                      INT64_C(1700000000000000000) +
                                          (int64_t)(where / 3u) * 1000000,
                                      NULL);
        break;
    }
    while (result == 0 && lum_reader_next_frame(reader, &frame, NULL) > 0) {
        if (++events > EVENTS_MAX) {
            abort();
        }
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (capture_len == 0) {
        make_capture();
    }
    if (size == 0) {
        return 0;
    }
    lum_reader *reader = NULL;
    const lum_reader_options options = {
        .struct_size = sizeof options,
        .source = lum_source_from_memory("capture", capture, capture_len),
        .keeps_index = true};
    if (lum_reader_open(&options, &reader, NULL) != 0) {
        abort();
    }
    lum_place_begin(reader);
    lum_pack body = lum_pack_of(data + 1, size - 1u);
    if (lum_index_read_body(&reader->place.index, &body)) {
        go(reader, data[0]);
        go(reader, data[0] / 2u);
    }
    lum_reader_close(reader);
    return 0;
}
