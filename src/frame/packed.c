/* A frame as messages for a page that draws it. */
#include "packed_internal.h"

#include "base/sized.h"
#include "capture/byte_order.h"
#include "lum/frame/clock_fit.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Where a piece with more than one run ends. */
#define PIECE_BYTES 49152u

#define BYTES_A_POINT 9u

/* Points, runs and the rest of a piece. */
struct piece {
    const lum_packed_run *runs;
    size_t run_count;
    size_t points;
    size_t others;
    size_t pixel_bytes;
};

/* Where the next of each goes. */
struct cursor {
    uint8_t *run;
    uint8_t *axes[LUM_PACKED_AXES];
    uint8_t *width;
    uint8_t *high;
    uint8_t *other;
    uint8_t *pixels;
};

/* --- Numbers as bytes --- */

static void put_float(uint8_t *to, float value)
{
    uint32_t bits = 0;
    memcpy(&bits, &value, sizeof bits);
    store_u32(to, bits);
}

static void put_double(uint8_t *to, double value)
{
    uint64_t bits = 0;
    memcpy(&bits, &value, sizeof bits);
    store_u32(to, (uint32_t)bits);
    store_u32(to + 4, (uint32_t)(bits >> 32));
}

static uint32_t fit32(uint64_t value)
{
    return value < UINT32_MAX ? (uint32_t)value : UINT32_MAX;
}

static inline uint32_t width_of(float ns)
{
    const float hundredths = ns * 100.0f + 0.5f;
    const float low = hundredths > 0.0f ? hundredths : 0.0f;
    return low < 65535.0f ? (uint32_t)low : 65535u;
}

/* --- Pieces --- */

static size_t piece_bytes(const struct piece *piece, size_t parts)
{
    const size_t bytes = LUM_PACKED_HEAD_BYTES + LUM_PACKED_PART_BYTES * parts +
                         LUM_PACKED_RUN_BYTES * piece->run_count +
                         BYTES_A_POINT * piece->points + piece->points % 2u +
                         2u * piece->others + piece->pixel_bytes;
    return (bytes + 3u) / 4u * 4u;
}

/* The piece that begins with a run. */
static struct piece cut_piece(const lum_packed_runs *runs, size_t begin,
                              size_t parts)
{
    struct piece piece = {.runs = runs->count > 0 ? runs->at + begin : NULL};
    for (size_t i = begin; i < runs->count; i++) {
        const lum_packed_run *run = &runs->at[i];
        struct piece next = piece;
        next.run_count++;
        next.points += run->count;
        next.others += run->others;
        next.pixel_bytes += run->pixel_bytes;
        if (i > begin && piece_bytes(&next, parts) > PIECE_BYTES) {
            break;
        }
        piece = next;
    }
    return piece;
}

/* A frame without points is one piece. */
static size_t count_pieces(const lum_packed_runs *runs, size_t parts,
                           size_t *bytes)
{
    size_t count = 0;
    size_t i = 0;
    *bytes = 0;
    do {
        const struct piece piece = cut_piece(runs, i, parts);
        *bytes += piece_bytes(&piece, parts);
        i += piece.run_count;
        count++;
    } while (i < runs->count);
    return count;
}

/* --- Writing --- */

static void put_axis(const lum_packed_run *run, unsigned axis,
                     struct cursor *cursor)
{
    const float *at = lum_packed_axis(run->part, axis) + run->begin;
    const double scale = (double)(1u << run->exponent);
    const double origin = (double)run->origin[axis] - 0.5;
    uint8_t *low = cursor->axes[axis];
    uint8_t *high = cursor->high;
    for (uint32_t i = 0; i < run->count; i++) {
        const double steps = (double)at[i] * scale - origin;
        const double most =
            steps < LUM_PACKED_STEPS_MAX ? steps : LUM_PACKED_STEPS_MAX;
        const uint32_t k = (uint32_t)(int32_t)(most > 0.0 ? most : 0.0);
        store_u16(low + 2u * i, k);
        high[i] = (uint8_t)(high[i] | k >> 16 << 2u * axis);
    }
    cursor->axes[axis] += 2u * (size_t)run->count;
}

static void put_kinds(const lum_packed_run *run, struct cursor *cursor)
{
    const float *width = run->part->pulse_width + run->begin;
    for (uint32_t i = 0; i < run->count; i++) {
        const uint16_t kind = lum_packed_kind(run->part, run->begin + i);
        unsigned code = 0;
        while (code < LUM_PACKED_KINDS && run->kinds[code] != kind) {
            code++;
        }
        if (code == LUM_PACKED_KINDS) {
            store_u16(cursor->other, kind);
            cursor->other += 2;
        }
        cursor->high[i] = (uint8_t)(code << 6);
        store_u16(cursor->width + 2u * i, width_of(width[i]));
    }
    cursor->width += 2u * (size_t)run->count;
}

static void put_pixels(const lum_packed_run *run, struct cursor *cursor)
{
    const uint16_t *pixel = run->part->pixel + run->begin;
    memset(cursor->pixels, 0, run->pixel_bytes);
    for (uint32_t i = 0; i < run->count; i++) {
        const uint32_t bit = i + pixel[i] - pixel[0];
        uint8_t *to = cursor->pixels + bit / 8u;
        *to = (uint8_t)(*to | 1u << bit % 8u);
    }
    cursor->pixels += run->pixel_bytes;
}

static void put_run(const lum_packed_run *run, struct cursor *cursor)
{
    uint8_t *to = cursor->run;
    store_u32(to, run->first);
    store_u32(to + 4, run->part->line[run->begin]);
    for (unsigned axis = 0; axis < LUM_PACKED_AXES; axis++) {
        store_u32(to + 8 + 4u * axis, (uint32_t)run->origin[axis]);
    }
    store_u16(to + 20, run->count);
    store_u16(to + 22, run->part->pixel[run->begin]);
    for (unsigned k = 0; k < LUM_PACKED_KINDS; k++) {
        store_u16(to + 24 + 2u * k, run->kinds[k]);
    }
    to[30] = run->exponent;
    to[31] = run->part->eye[run->begin] & 1u;
    cursor->run += LUM_PACKED_RUN_BYTES;
    put_kinds(run, cursor);
    for (unsigned axis = 0; axis < LUM_PACKED_AXES; axis++) {
        put_axis(run, axis, cursor);
    }
    cursor->high += run->count;
    put_pixels(run, cursor);
}

static void put_head(uint8_t *to, const lum_packed_head *head, size_t parts)
{
    store_u32(to, LUM_PACKED_MAGIC);
    store_u16(to + 4, LUM_PACKED_VERSION);
    store_u16(to + 6, LUM_PACKED_HEAD_BYTES);
    put_double(to + 8, (double)head->frame);
    put_double(to + 16, (double)head->clock_us);
    put_double(to + 24, (double)head->utc_ns * 1e-9);
    to[36] = head->edges;
    to[37] = head->smooth;
    to[38] = head->time;
    to[39] = head->is_rig ? (uint8_t)parts : 0;
    store_u32(to + 40, head->lines);
    store_u32(to + 44, fit32(head->lost_words));
    store_u32(to + 48, head->sensor);
    store_u32(to + 52, fit32(head->shown));
    put_double(to + 56, (double)head->complete_ns * 1e-9);
    put_double(to + 64, head->utc_error_ns != LUM_CLOCK_ERROR_UNKNOWN
                            ? (double)head->utc_error_ns * 1e-9
                            : (double)NAN);
    put_float(to + 76, 1.0f / (float)(1u << LUM_PACKED_COARSEST));
}

static void put_parts(uint8_t *to, const lum_packed_part *parts, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        put_double(to, (double)parts[i].frame);
        store_u32(to + 8, (uint32_t)parts[i].count);
        store_u32(to + 12, parts[i].sensor);
        to += LUM_PACKED_PART_BYTES;
    }
}

/* Behind the sensors of a rig. */
static void put_piece(uint8_t *to, const struct piece *piece)
{
    struct cursor cursor = {.run = to};
    to += LUM_PACKED_RUN_BYTES * piece->run_count;
    for (unsigned axis = 0; axis < LUM_PACKED_AXES; axis++) {
        cursor.axes[axis] = to;
        to += 2u * piece->points;
    }
    cursor.width = to;
    cursor.high = cursor.width + 2u * piece->points;
    cursor.other = cursor.high + piece->points;
    if (piece->points % 2u != 0) {
        *cursor.other++ = 0;
    }
    cursor.pixels = cursor.other + 2u * piece->others;
    for (size_t i = 0; i < piece->run_count; i++) {
        put_run(&piece->runs[i], &cursor);
    }
}

/* What is the same in all messages of a frame. */
struct common {
    uint8_t bytes[LUM_PACKED_HEAD_BYTES +
                  LUM_PACKED_PARTS_MAX * LUM_PACKED_PART_BYTES];
    size_t len;
    size_t parts; /* of a rig */
};

static void put_pieces(uint8_t *to, const lum_packed_runs *runs,
                       struct common *common, size_t pieces)
{
    size_t run = 0;
    for (size_t i = 0; i < pieces; i++) {
        const struct piece piece = cut_piece(runs, run, common->parts);
        const size_t len = piece_bytes(&piece, common->parts);
        store_u32(common->bytes + 80, (uint32_t)len);
        store_u32(common->bytes + 84, (uint32_t)i);
        store_u32(common->bytes + 88, (uint32_t)pieces);
        store_u32(common->bytes + 92, (uint32_t)piece.points);
        store_u32(common->bytes + 96, (uint32_t)piece.run_count);
        store_u32(common->bytes + 100, (uint32_t)piece.others);
        memcpy(to, common->bytes, common->len);
        memset(to + len - 3, 0, 3);
        put_piece(to + common->len, &piece);
        run += piece.run_count;
        to += len;
    }
}

/* --- Frames --- */

static bool is_whole(const lum_packed_head *head, const lum_packed_part *parts,
                     size_t count)
{
    const size_t most = head->is_rig ? LUM_PACKED_PARTS_MAX : 2u;
    size_t left = LUM_PACKED_POINTS_MAX;
    bool is_good = count > 0 && count <= most;
    for (size_t i = 0; i < count && is_good; i++) {
        is_good =
            parts[i].struct_size == sizeof *parts && parts[i].count <= left;
        left -= is_good ? parts[i].count : 0;
    }
    return is_good;
}

/* What it held is not needed. */
static lum_result reserve(lum_packed *out, size_t len)
{
    if (len > out->room) {
        lum_packed_free(out);
        out->room = len + len / 8u;
        out->bytes = malloc(out->room);
    }
    if (out->bytes == NULL) {
        out->room = 0;
        return LUM_E_SPACE;
    }
    out->len = len;
    return LUM_OK;
}

static lum_result pack(lum_packed_runs *runs, const lum_packed_head *head,
                       const lum_packed_part *parts, size_t count,
                       lum_packed *out)
{
    struct common common = {.parts = head->is_rig ? count : 0};
    size_t bytes = 0;
    size_t points = 0;
    lum_packed_runs_sort(runs);
    const size_t pieces = count_pieces(runs, common.parts, &bytes);
    if (reserve(out, bytes) != LUM_OK) {
        return LUM_E_SPACE;
    }
    for (size_t i = 0; i < count; i++) {
        points += parts[i].count;
    }
    put_head(common.bytes, head, count);
    store_u32(common.bytes + 32, (uint32_t)points);
    store_u32(common.bytes + 72,
              head->is_rig || count < 2u ? 0 : (uint32_t)parts[1].count);
    put_parts(common.bytes + LUM_PACKED_HEAD_BYTES, parts, common.parts);
    common.len = LUM_PACKED_HEAD_BYTES + LUM_PACKED_PART_BYTES * common.parts;
    put_pieces(out->bytes, runs, &common, pieces);
    return LUM_OK;
}

lum_result lum_packed_make(const lum_packed_head *head,
                           const lum_packed_part *parts, size_t count,
                           lum_packed *out)
{
    lum_packed_runs runs = {.at = NULL};
    lum_packed_head taken;
    uint32_t first = 0;
    lum_result result = LUM_OK;
    out->len = 0;
    if (lum_sized_take(&taken, sizeof taken, head, "head", "lum_packed_head",
                       NULL) != 0 ||
        !is_whole(&taken, parts, count)) {
        return LUM_E_VALUE;
    }
    for (size_t i = 0; i < count && result == LUM_OK; i++) {
        result = lum_packed_runs_add(&runs, &parts[i], first);
        first += (uint32_t)parts[i].count;
    }
    if (result == LUM_OK) {
        result = pack(&runs, &taken, parts, count, out);
    }
    free(runs.at);
    return result;
}

lum_result lum_packed_part_of(const lum_frame *frame, lum_packed_part *out)
{
    if ((lum_frame_columns(frame) & LUM_PACKED_COLUMNS) != LUM_PACKED_COLUMNS) {
        return LUM_E_VALUE;
    }
    const lum_packed_part made = {
        .struct_size = sizeof made,
        .count = lum_frame_count(frame),
        .x = lum_frame_floats(frame, LUM_COLUMN_X),
        .y = lum_frame_floats(frame, LUM_COLUMN_Y),
        .z = lum_frame_floats(frame, LUM_COLUMN_Z),
        .pulse_width = lum_frame_floats(frame, LUM_COLUMN_PULSE_WIDTH),
        .line = lum_frame_uint32s(frame, LUM_COLUMN_LINE),
        .pixel = lum_frame_uint16s(frame, LUM_COLUMN_PIXEL),
        .return_number = lum_frame_uint16s(frame, LUM_COLUMN_RETURN_NUMBER),
        .number_of_returns =
            lum_frame_uint16s(frame, LUM_COLUMN_NUMBER_OF_RETURNS),
        .eye = lum_frame_uint8s(frame, LUM_COLUMN_EYE),
        .edge = lum_frame_uint8s(frame, LUM_COLUMN_EDGE),
        .strongest = lum_frame_uint8s(frame, LUM_COLUMN_STRONGEST)};
    return lum_sized_fill(out, &made, sizeof made) ? LUM_OK : LUM_E_VALUE;
}

void lum_packed_free(lum_packed *packed)
{
    free(packed->bytes);
    *packed = (lum_packed){.bytes = NULL};
}

size_t lum_packed_piece(const lum_packed *packed, size_t at)
{
    if (at >= packed->len) {
        return 0;
    }
    return load_u32(packed->bytes + at + 80);
}
