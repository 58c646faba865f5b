/* A frame: its columns, its lines, and how a line's points get there. */
#include "frame_internal.h"

#include "base/sized.h"

#include <stdlib.h>
#include <string.h>

#define ROWS_GUESS 4096u /* until a whole line has shown the number */
#define ROWS_MORE  64u   /* believed above twice those of whole lines */

static const struct {
    const char *name;
    lum_column_type type;
} columns[LUM_COLUMN_COUNT] = {
    {"x", LUM_TYPE_FLOAT},
    {"y", LUM_TYPE_FLOAT},
    {"z", LUM_TYPE_FLOAT},
    {"range", LUM_TYPE_FLOAT},
    {"azimuth", LUM_TYPE_FLOAT},
    {"elevation", LUM_TYPE_FLOAT},
    {"pulse_width", LUM_TYPE_FLOAT},
    {"time", LUM_TYPE_FLOAT},
    {"line", LUM_TYPE_UINT32},
    {"pixel", LUM_TYPE_UINT16},
    {"return_number", LUM_TYPE_UINT16},
    {"number_of_returns", LUM_TYPE_UINT16},
    {"eye", LUM_TYPE_UINT8},
    {"edge", LUM_TYPE_UINT8},
    {"strongest", LUM_TYPE_UINT8},
};

/* Stands for the columns of a frame without points. */
static const union {
    uint8_t bytes[64];
    uint64_t aligned[8];
} nothing;

static bool is_column(lum_column column)
{
    return (unsigned)column < LUM_COLUMN_COUNT;
}

lum_column_type lum_column_get_type(lum_column column)
{
    return is_column(column) ? columns[column].type : LUM_TYPE_FLOAT;
}

const char *lum_column_name(lum_column column)
{
    return is_column(column) ? columns[column].name : NULL;
}

size_t lum_frame_count(const lum_frame *frame)
{
    return frame->count;
}

lum_columns lum_frame_columns(const lum_frame *frame)
{
    return frame->mask;
}

const void *lum_frame_column(const lum_frame *frame, lum_column column)
{
    if (!is_column(column) || (frame->mask & LUM_COLUMN_BIT(column)) == 0) {
        return NULL;
    }
    const void *at = frame->store.columns[column].at;
    return at != NULL ? at : nothing.bytes;
}

static const void *find(const lum_frame *frame, lum_column column,
                        lum_column_type type)
{
    return lum_column_get_type(column) == type ? lum_frame_column(frame, column)
                                               : NULL;
}

const float *lum_frame_floats(const lum_frame *frame, lum_column column)
{
    return find(frame, column, LUM_TYPE_FLOAT);
}

const uint32_t *lum_frame_uint32s(const lum_frame *frame, lum_column column)
{
    return find(frame, column, LUM_TYPE_UINT32);
}

const uint16_t *lum_frame_uint16s(const lum_frame *frame, lum_column column)
{
    return find(frame, column, LUM_TYPE_UINT16);
}

const uint8_t *lum_frame_uint8s(const lum_frame *frame, lum_column column)
{
    return find(frame, column, LUM_TYPE_UINT8);
}

const float *lum_frame_xyz(const lum_frame *frame, size_t *spacing)
{
    if ((frame->mask & LUM_COLUMNS_XYZ) != LUM_COLUMNS_XYZ) {
        return NULL;
    }
    *spacing = frame->count > 0 ? frame->store.columns[LUM_COLUMN_X].room : 0;
    return lum_frame_floats(frame, LUM_COLUMN_X);
}

lum_result lum_frame_get_info(const lum_frame *frame, lum_frame_info *out)
{
    return lum_sized_fill(out, &frame->info, sizeof frame->info) ? LUM_OK
                                                                 : LUM_E_VALUE;
}

lum_pose lum_frame_pose(const lum_frame *frame)
{
    return frame->is_placed ? frame->pose : lum_pose_identity();
}

size_t lum_frame_line_count(const lum_frame *frame)
{
    return frame->row_count;
}

bool lum_frame_get_line(const lum_frame *frame, size_t i, lum_frame_line *out)
{
    if (i >= frame->row_count) {
        return false;
    }
    return lum_sized_fill(out, &frame->store.rows[i],
                          sizeof frame->store.rows[i]);
}

/* From here on, only the numbers of lines with all angles are believed. */
static uint32_t find_limit(const lum_frame *frame, unsigned eye)
{
    const uint32_t here = lum_frame_whole_rows(frame, eye);
    const uint32_t before = frame->rows_before[eye];
    const uint32_t whole = here > before ? here : before;
    return whole > 0 ? 2u * whole + ROWS_MORE : ROWS_GUESS;
}

uint32_t lum_frame_rows(const lum_frame *frame, unsigned eye)
{
    if (eye >= LUM_EYES) {
        return 0;
    }
    uint32_t rows = 0;
    const uint32_t limit = find_limit(frame, eye);
    for (size_t i = 0; i < frame->row_count; i++) {
        const lum_frame_line *row = &frame->store.rows[i];
        const bool is_believed = row->angle_count == LUM_LINE_PIXELS ||
                                 (row->point_count > 0 && row->number < limit);
        if (row->eye == eye && is_believed && row->number >= rows &&
            row->number < LUM_FRAME_ROWS_MAX) {
            rows = row->number + 1u;
        }
    }
    return rows;
}

size_t lum_column_bytes(lum_column column)
{
    static const size_t bytes[] = {[LUM_TYPE_FLOAT] = sizeof(float),
                                   [LUM_TYPE_UINT32] = sizeof(uint32_t),
                                   [LUM_TYPE_UINT16] = sizeof(uint16_t),
                                   [LUM_TYPE_UINT8] = sizeof(uint8_t)};
    return bytes[columns[column].type];
}

/* Where a column goes on; NULL: it is not asked for. */
static void *end_of(const lum_frame *frame, lum_column column)
{
    uint8_t *at = frame->store.columns[column].at;
    return (frame->mask & LUM_COLUMN_BIT(column)) != 0
               ? at + frame->count * lum_column_bytes(column)
               : NULL;
}

lum_frame_places lum_frame_next_places(const lum_frame *frame)
{
    return (lum_frame_places){
        .columns = {.x = end_of(frame, LUM_COLUMN_X),
                    .y = end_of(frame, LUM_COLUMN_Y),
                    .z = end_of(frame, LUM_COLUMN_Z),
                    .range = end_of(frame, LUM_COLUMN_RANGE),
                    .azimuth = end_of(frame, LUM_COLUMN_AZIMUTH),
                    .elevation = end_of(frame, LUM_COLUMN_ELEVATION),
                    .pulse_width = end_of(frame, LUM_COLUMN_PULSE_WIDTH),
                    .pixel = end_of(frame, LUM_COLUMN_PIXEL),
                    .return_number = end_of(frame, LUM_COLUMN_RETURN_NUMBER),
                    .number_of_returns =
                        end_of(frame, LUM_COLUMN_NUMBER_OF_RETURNS),
                    .edge = end_of(frame, LUM_COLUMN_EDGE),
                    .strongest = end_of(frame, LUM_COLUMN_STRONGEST)},
        .line = end_of(frame, LUM_COLUMN_LINE),
        .time = end_of(frame, LUM_COLUMN_TIME),
        .eye = end_of(frame, LUM_COLUMN_EYE)};
}

bool lum_column_work_allocate(lum_column_work *work, size_t words)
{
    work->samples.returns = malloc(words * sizeof *work->samples.returns);
    work->sample = malloc(words * sizeof *work->sample);
    work->strongest = malloc(words * sizeof *work->strongest);
    work->pixel = malloc(words * sizeof *work->pixel);
    return work->samples.returns != NULL && work->sample != NULL &&
           work->strongest != NULL && work->pixel != NULL;
}

void lum_column_work_release(lum_column_work *work)
{
    free(work->samples.returns);
    free(work->sample);
    free(work->strongest);
    free(work->pixel);
}

/* Data that all points of a line share, and the pixels from which times are
 * computed at the end. */
static void fill_line(const lum_frame_places *to, const lum_line *line,
                      size_t n, const uint16_t *pixels)
{
    for (size_t i = 0; to->line != NULL && i < n; i++) {
        to->line[i] = line->number;
    }
    for (size_t i = 0; to->time != NULL && pixels != NULL && i < n; i++) {
        to->time[i] = (float)pixels[i];
    }
    if (to->eye != NULL) {
        memset(to->eye, line->eye, n);
    }
}

size_t lum_frame_make_points(const lum_frame_part *part,
                             const lum_frame_places *places)
{
    lum_column_places to = places->columns;
    if (to.pixel == NULL && places->time != NULL) {
        to.pixel = part->work->pixel;
    }
    const size_t n =
        lum_columns_compute(&part->line, part->selection, part->work, &to);
    fill_line(places, part->line.line, n, to.pixel);
    return n;
}

static void add_row(lum_frame *frame, const lum_line *line, size_t points)
{
    frame->store.rows[frame->row_count++] =
        (lum_frame_line){.struct_size = sizeof(lum_frame_line),
                         .clock_us = line->clock_us,
                         .arrival_ns = line->arrival,
                         .number = line->number,
                         .first_point = (uint32_t)frame->count,
                         .point_count = (uint32_t)points,
                         .lost_words = line->lost_words,
                         .angle_count = line->angle_count,
                         .eye = line->eye};
}

static void add_up(lum_frame_info *info, const lum_frame_part *part)
{
    const lum_line *line = part->line.line;
    const uint64_t before = (uint64_t)info->lines[0] + info->lines[1];
    const bool is_dark = line->word_count == 0 && info->lines_dark == before;
    info->lines_dark += is_dark ? 1u : 0u;
    info->lines[line->eye]++;
    info->lines_missing_angles += line->angle_count < LUM_LINE_PIXELS ? 1u : 0u;
    info->lost_words += line->lost_words;
    info->losses.no_angle += part->losses.no_angle;
    info->losses.no_range += part->losses.no_range;
}

size_t lum_frame_points_left(const lum_frame *frame)
{
    return frame->row_count < LUM_FRAME_LINES_MAX
               ? frame->points_max - frame->count
               : 0;
}

void lum_frame_add_made(lum_frame *frame, const lum_frame_part *part, size_t n)
{
    add_row(frame, part->line.line, n);
    add_up(&frame->info, part);
    frame->count += n;
}

void lum_frame_add(lum_frame *frame, const lum_frame_part *part)
{
    const size_t room = lum_frame_points_left(frame);
    const bool has_points = frame->mask != 0 && part->line.line->word_count > 0;
    size_t n = 0;
    if (has_points) {
        const lum_frame_places places = lum_frame_next_places(frame);
        n = lum_frame_make_points(part, &places);
    }
    frame->info.points_cut += n > room ? n - room : 0;
    if (frame->row_count == LUM_FRAME_LINES_MAX) {
        frame->info.lines_cut++;
        return;
    }
    lum_frame_add_made(frame, part, n < room ? n : room);
}
