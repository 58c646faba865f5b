#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "mcap_image.h"

#include "base/crc32.h"

#include <stdlib.h>
#include <string.h>

#define MAGIC "\x89MCAP0\r\n"

static uint32_t check_sum(const image *records)
{
    lum_crc32 crc;
    lum_crc32_init(&crc);
    return lum_crc32_add(&crc, 0, records->bytes, records->len);
}

void put(image *im, const void *bytes, size_t len)
{
    const size_t needed = im->len + len + 1u;
    if (im->room < needed) {
        im->room = 2u * needed;
        im->bytes = realloc(im->bytes, im->room);
        assert_non_null(im->bytes);
    }
    if (len != 0) {
        memcpy(im->bytes + im->len, bytes, len);
    }
    im->len += len;
}

void set_int(const image *im, size_t at, uint64_t value, size_t len)
{
    for (size_t i = 0; i < len; i++) {
        im->bytes[at + i] = (uint8_t)(value >> (8u * i) & 0xffu);
    }
}

void put_int(image *im, uint64_t value, size_t len)
{
    static const uint8_t zeros[8];
    put(im, zeros, len);
    set_int(im, im->len - len, value, len);
}

void put_text(image *im, const char *text)
{
    put_int(im, strlen(text), 4);
    put(im, text, strlen(text));
}

size_t begin_record(image *im, unsigned opcode)
{
    put_int(im, opcode, 1);
    put_int(im, 0, 8);
    return im->len - 9u;
}

void end_record(const image *im, size_t from)
{
    set_int(im, from + 1u, im->len - from - 9u, 8);
}

void put_record(image *im, unsigned opcode, size_t len)
{
    const size_t from = begin_record(im, opcode);
    for (size_t i = 0; i < len; i++) {
        put_int(im, 0, 1);
    }
    end_record(im, from);
}

void put_schema(image *im, unsigned id, const char *name)
{
    const size_t from = begin_record(im, OP_SCHEMA);
    put_int(im, id, 2);
    put_text(im, name);
    put_text(im, "ros2msg");
    put_text(im, "uint8 x");
    end_record(im, from);
}

void put_channel(image *im, unsigned id, unsigned schema, const char *topic,
                 const char *encoding)
{
    const size_t from = begin_record(im, OP_CHANNEL);
    put_int(im, id, 2);
    put_int(im, schema, 2);
    put_text(im, topic);
    put_text(im, encoding);
    put_int(im, 0, 4);
    end_record(im, from);
}

image begin_file(void)
{
    image im = {.bytes = NULL};
    put(&im, MAGIC, 8);
    const size_t from = begin_record(&im, OP_HEADER);
    put_text(&im, "ros2");
    put_text(&im, "a test");
    end_record(&im, from);
    return im;
}

void end_file_with(image *im, const image *described)
{
    put_record(im, OP_DATA_END, 4);
    const size_t summary = im->len;
    put(im, described->bytes, described->len);
    size_t from = begin_record(im, OP_STATISTICS);
    put_int(im, im->messages, 8);
    put_int(im, 0, 8);
    end_record(im, from);
    put_record(im, OP_CHUNK_INDEX, 20);
    put_record(im, OP_SUMMARY_OFFSET, 17);
    from = begin_record(im, OP_FOOTER);
    put_int(im, described->len != 0 ? summary : 0, 8);
    put_int(im, 0, 8);
    put_int(im, 0, 4);
    end_record(im, from);
    put(im, MAGIC, 8);
    im->room = im->len; /* a byte too far is noticed */
    im->bytes = realloc(im->bytes, im->room);
    assert_non_null(im->bytes);
}

void end_file(image *im)
{
    const image none = {.bytes = NULL};
    end_file_with(im, &none);
}

void put_chunk_as(image *im, const image *bytes, const struct chunk *c)
{
    const size_t from = begin_record(im, OP_CHUNK);
    put_int(im, 0, 8);
    put_int(im, 0, 8);
    put_int(im, c->unpacked, 8);
    put_int(im, c->crc, 4);
    put_text(im, c->compression);
    put_int(im, c->packed, 8);
    put(im, bytes->bytes, bytes->len);
    end_record(im, from);
    put_record(im, OP_MESSAGE_INDEX, 22);
}

void put_plain(image *im, image *records)
{
    const struct chunk c = {"", check_sum(records), records->len, records->len};
    put_chunk_as(im, records, &c);
    im->messages += records->messages;
    free(records->bytes);
}

/* One frame of one block as it is. */
image stored(const image *records)
{
    image im = {.bytes = NULL};
    put_int(&im, 0xfd2fb528, 4);
    put_int(&im, 0xa0, 1);
    put_int(&im, records->len, 4);
    put_int(&im, records->len << 3 | 1u, 3);
    put(&im, records->bytes, records->len);
    return im;
}

/* Likewise, with a sum of the frame's head alone. */
image stored_lz4(const image *records)
{
    image im = {.bytes = NULL};
    put(&im, "\x04\x22\x4d\x18\x60\x40\x82", 7);
    put_int(&im, records->len | UINT32_C(0x80000000), 4);
    put(&im, records->bytes, records->len);
    put_int(&im, 0, 4);
    return im;
}

static void put_packed(image *im, image *records, const char *compression,
                       image packed)
{
    const struct chunk c = {compression, check_sum(records), records->len,
                            packed.len};
    put_chunk_as(im, &packed, &c);
    im->messages += records->messages;
    free(packed.bytes);
    free(records->bytes);
}

void put_zstd(image *im, image *records)
{
    put_packed(im, records, "zstd", stored(records));
}

void put_lz4(image *im, image *records)
{
    put_packed(im, records, "lz4", stored_lz4(records));
}
