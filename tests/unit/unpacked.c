#include "unpacked.h"

#include "lum/frame/packed.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A piece, and what of it is read next. */
struct reader {
    const uint8_t *bytes;
    size_t len;
    size_t points;
    size_t others;
    const uint8_t *runs;
    const uint8_t *axes[3];
    const uint8_t *width;
    const uint8_t *high;
    const uint8_t *other;
    const uint8_t *end_others;
    size_t bit;
    size_t point;
};

struct run {
    uint32_t first;
    uint32_t line;
    int32_t origin[3];
    uint32_t count;
    uint32_t pixel;
    uint16_t kinds[3];
    unsigned exponent;
    unsigned eye;
};

static uint32_t u16(const uint8_t *b)
{
    return b[0] | (uint32_t)b[1] << 8;
}

static uint32_t u32(const uint8_t *b)
{
    return u16(b) | u16(b + 2) << 16;
}

uint32_t unpacked_u32(const uint8_t *bytes, size_t at)
{
    return u32(bytes + at);
}

double unpacked_double(const uint8_t *bytes, size_t at)
{
    const uint64_t bits = u32(bytes + at) | (uint64_t)u32(bytes + at + 4) << 32;
    double value = 0.0;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static int32_t i32(const uint8_t *b)
{
    const uint32_t bits = u32(b);
    return bits < 0x80000000u ? (int32_t)bits : -(int32_t)~bits - 1;
}

static bool open_piece(struct reader *r)
{
    const uint8_t *b = r->bytes;
    const size_t runs = u32(b + 96);
    r->points = u32(b + 92);
    r->others = u32(b + 100);
    const size_t begin =
        LUM_PACKED_HEAD_BYTES + (size_t)LUM_PACKED_PART_BYTES * b[39];
    const size_t need = begin + LUM_PACKED_RUN_BYTES * runs + 9u * r->points +
                        r->points % 2u + 2u * r->others;
    if (runs > r->len || r->points > r->len || r->others > r->len ||
        need > r->len || runs > r->points) {
        return false;
    }
    r->runs = b + begin;
    for (size_t axis = 0; axis < 3; axis++) {
        r->axes[axis] =
            r->runs + LUM_PACKED_RUN_BYTES * runs + 2u * r->points * axis;
    }
    r->width = r->axes[2] + 2u * r->points;
    r->high = r->width + 2u * r->points;
    r->other = r->high + r->points + r->points % 2u;
    r->end_others = r->other + 2u * r->others;
    r->bit = 8u * need;
    return true;
}

static struct run open_run(const uint8_t *b)
{
    return (struct run){
        .first = u32(b),
        .line = u32(b + 4),
        .origin = {i32(b + 8), i32(b + 12), i32(b + 16)},
        .count = u16(b + 20),
        .pixel = u16(b + 22),
        .kinds = {(uint16_t)u16(b + 24), (uint16_t)u16(b + 26),
                  (uint16_t)u16(b + 28)},
        .exponent = b[30],
        .eye = b[31],
    };
}

/* The next point's pixel; false: there is none any more. */
static bool take_pixel(struct reader *r, uint32_t *pixel)
{
    while (r->bit < 8u * r->len &&
           (r->bytes[r->bit / 8u] >> r->bit % 8u & 1u) == 0) {
        r->bit++;
        (*pixel)++;
    }
    r->bit++;
    return r->bit <= 8u * r->len && *pixel <= UINT16_MAX;
}

static bool take_kind(struct reader *r, const struct run *run, unsigned code,
                      uint32_t *kind)
{
    if (code < 3u) {
        *kind = run->kinds[code];
        return true;
    }
    if (r->other == r->end_others) {
        return false;
    }
    *kind = u16(r->other);
    r->other += 2;
    return true;
}

static bool take_point(struct reader *r, const struct run *run,
                       struct unpacked *out, size_t to, uint32_t *pixel)
{
    const size_t i = r->point++;
    const unsigned high = r->high[i];
    uint32_t kind = 0;
    if (out->has_come[to] || !take_pixel(r, pixel) ||
        !take_kind(r, run, high >> 6, &kind)) {
        return false;
    }
    for (unsigned axis = 0; axis < 3u; axis++) {
        const uint32_t steps =
            u16(r->axes[axis] + 2u * i) | (high >> 2u * axis & 3u) << 16;
        out->xyz[to][axis] = ldexp((double)run->origin[axis] + (double)steps,
                                   -(int)run->exponent);
    }
    out->step[to] = ldexp(1.0, -(int)run->exponent);
    out->width[to] = (uint16_t)u16(r->width + 2u * i);
    out->line[to] = run->line;
    out->pixel[to] = (uint16_t)*pixel;
    out->turn[to] = (uint8_t)kind;
    out->bits[to] = (uint8_t)(kind >> 8 | run->eye);
    out->has_come[to] = true;
    return true;
}

static bool take_run(struct reader *r, const struct run *run,
                     struct unpacked *out)
{
    uint32_t pixel = run->pixel;
    if (run->count == 0 || run->count > 4096u || run->exponent < 9u ||
        run->exponent > 12u || run->eye > 1u ||
        run->count > r->points - r->point || run->first > out->count ||
        run->count > out->count - run->first) {
        return false;
    }
    for (uint32_t i = 0; i < run->count; i++) {
        if (!take_point(r, run, out, run->first + i, &pixel)) {
            return false;
        }
    }
    r->bit = (r->bit + 7u) / 8u * 8u;
    return true;
}

static bool take_piece(struct reader *r, struct unpacked *out)
{
    bool is_good = open_piece(r);
    const size_t runs = is_good ? u32(r->bytes + 96) : 0;
    for (size_t i = 0; i < runs && is_good; i++) {
        const struct run run = open_run(r->runs + LUM_PACKED_RUN_BYTES * i);
        is_good = take_run(r, &run, out);
    }
    return is_good && r->point == r->points && r->other == r->end_others &&
           r->len - r->bit / 8u < 4u;
}

/* All messages of a frame have the same head, but for what is the piece's. */
static bool is_head(const uint8_t *first, const uint8_t *b, size_t left,
                    size_t piece)
{
    return left >= LUM_PACKED_HEAD_BYTES && memcmp(first, b, 80) == 0 &&
           u32(b) == LUM_PACKED_MAGIC && u16(b + 4) == LUM_PACKED_VERSION &&
           u16(b + 6) == LUM_PACKED_HEAD_BYTES &&
           u32(b + 80) >= LUM_PACKED_HEAD_BYTES && u32(b + 80) <= left &&
           u32(b + 80) <= LUM_PACKED_PIECE_BYTES && u32(b + 84) == piece &&
           u32(b + 88) == u32(first + 88);
}

static void *room(size_t count, size_t size)
{
    return calloc(count + 1u, size);
}

static bool begin(struct unpacked *out, size_t count)
{
    *out = (struct unpacked){.count = count,
                             .xyz = room(count, sizeof *out->xyz),
                             .step = room(count, sizeof *out->step),
                             .width = room(count, sizeof *out->width),
                             .line = room(count, sizeof *out->line),
                             .pixel = room(count, sizeof *out->pixel),
                             .turn = room(count, sizeof *out->turn),
                             .bits = room(count, sizeof *out->bits),
                             .has_come = room(count, sizeof *out->has_come)};
    return out->xyz != NULL && out->step != NULL && out->width != NULL &&
           out->line != NULL && out->pixel != NULL && out->turn != NULL &&
           out->bits != NULL && out->has_come != NULL;
}

static bool are_all_there(const struct unpacked *u)
{
    size_t i = 0;
    while (i < u->count && u->has_come[i]) {
        i++;
    }
    return i == u->count;
}

bool unpack(const uint8_t *bytes, size_t len, struct unpacked *out)
{
    *out = (struct unpacked){.count = 0};
    if (len < LUM_PACKED_HEAD_BYTES ||
        u32(bytes + 32) > LUM_PACKED_POINTS_MAX ||
        !begin(out, u32(bytes + 32))) {
        return false;
    }
    for (size_t at = 0; at < len; out->pieces++) {
        struct reader reader = {.bytes = bytes + at};
        if (!is_head(bytes, bytes + at, len - at, out->pieces)) {
            return false;
        }
        reader.len = u32(bytes + at + 80);
        if (!take_piece(&reader, out)) {
            return false;
        }
        at += reader.len;
    }
    return out->pieces == u32(bytes + 88) && are_all_there(out);
}

void unpacked_free(struct unpacked *u)
{
    free(u->xyz);
    free(u->step);
    free(u->width);
    free(u->line);
    free(u->pixel);
    free(u->turn);
    free(u->bits);
    free(u->has_come);
}
