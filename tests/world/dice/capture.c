#include "capture.h"

#include <string.h>

#define LINES        16u /* of each eye */
#define PERIOD_US    500000u
#define CUTS         3u
#define WORDS        40u
#define HEADERS      42u /* Ethernet, IPv4, UDP */
#define GROUP        24u
#define RECORD_BYTES (16u + HEADERS + GROUP + 4u * 334u)
#define FILE_BYTES   (24u + LINES * 2u * (CUTS + 1u) * RECORD_BYTES)

static uint8_t file[FILE_BYTES];
static size_t file_size;

static void put_u16(uint8_t *at, uint32_t value)
{
    at[0] = (uint8_t)value;
    at[1] = (uint8_t)(value >> 8);
}

static void put_u32(uint8_t *at, uint32_t value)
{
    put_u16(at, value);
    put_u16(at + 2, value >> 16);
}

static void put_be16(uint8_t *at, uint32_t value)
{
    at[0] = (uint8_t)(value >> 8);
    at[1] = (uint8_t)value;
}

/* From 10.42.0.37, port 5517, to 10.42.0.1, port 50000. */
static void put_headers(uint8_t *at, size_t len)
{
    static const uint8_t ends[8] = {10, 42, 0, 37, 10, 42, 0, 1};
    memset(at, 0, HEADERS);
    put_be16(at + 12, 0x0800);
    at[14] = 0x45;
    put_be16(at + 16, (uint32_t)len + 28u);
    at[22] = 64;
    at[23] = 17;
    memcpy(at + 26, ends, sizeof ends);
    put_be16(at + 34, 5517);
    put_be16(at + 36, 50000);
    put_be16(at + 38, (uint32_t)len + 8u);
}

/* The header of a data packet (docs/protocol.md, section 6). */
static void put_group(uint8_t *at, const uint32_t fields[5], uint32_t clock_us)
{
    static const uint8_t head[12] = {0xed, 0xfe, 0xf3, 0xa1, 0xef, 0xbe,
                                     0x34, 0x12, 8,    0,    0,    0};
    memcpy(at, head, sizeof head);
    at[12] = (uint8_t)fields[0];
    at[13] = (uint8_t)fields[1];
    put_u16(at + 14, fields[2]);
    put_u16(at + 16, fields[3]);
    put_u16(at + 18, fields[4]);
    put_u32(at + 20, clock_us);
}

static uint32_t angles(uint32_t pixel, uint32_t line)
{
    const uint32_t azimuth = (pixel * 64u - 32000u) & 0xffffu;
    const uint32_t elevation = (30000u - line * 3600u) & 0xffffu;
    return azimuth | elevation << 16;
}

static uint32_t range(uint32_t i, uint32_t line)
{
    return (5000u + 10u * line + i) << 12 | 0x400u | (i * 25u);
}

/* tag 2: angles from a pixel on; 3: ranges. */
static void add(uint32_t tag, uint32_t eye, uint32_t line, uint32_t count,
                uint32_t first)
{
    uint8_t *at = file + file_size;
    const size_t len = GROUP + 4u * (size_t)count;
    const uint32_t t_us =
        line * PERIOD_US + eye * 900u + (tag == 2 ? first : 1000u) / 2u;
    const uint32_t fields[5] = {tag, eye, line, count, first};
    put_u32(at, 1700000000u + t_us / 1000000u);
    put_u32(at + 4, t_us % 1000000u * 1000u);
    put_u32(at + 8, (uint32_t)len + HEADERS);
    put_u32(at + 12, (uint32_t)len + HEADERS);
    put_headers(at + 16, len);
    put_group(at + 16 + HEADERS, fields, line * PERIOD_US + eye * 900u);
    for (uint32_t i = 0; i < count; i++) {
        put_u32(at + 16 + HEADERS + GROUP + 4u * (size_t)i,
                tag == 2 ? angles(first + i, line) : range(i, line));
    }
    file_size += 16u + HEADERS + len;
}

static void add_line(uint32_t eye, uint32_t line)
{
    add(2, eye, line, 334, 0);
    add(2, eye, line, 334, 334);
    add(2, eye, line, 332, 668);
    add(3, eye, line, WORDS, 0);
}

const uint8_t *capture_small(size_t *size)
{
    if (file_size == 0) {
        put_u32(file, 0xa1b23c4du);
        put_u16(file + 4, 2);
        put_u16(file + 6, 4);
        put_u32(file + 16, 262144u);
        put_u32(file + 20, 1);
        file_size = 24;
        for (uint32_t line = 0; line < LINES; line++) {
            add_line(0, line);
            add_line(1, line);
        }
    }
    *size = file_size;
    return file;
}
