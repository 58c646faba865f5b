#include "frame_lines.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define NO_LINE UINT32_MAX

struct columns {
    const float *x;
    const float *y;
    const float *z;
    const float *range;
    const float *azimuth;
    const float *elevation;
    const float *pulse_width;
    const float *time;
    const uint16_t *pixel;
    const uint16_t *return_number;
    const uint16_t *number_of_returns;
    const uint8_t *edge;
};

struct frame_lines {
    unsigned eyes;
    frame_lines_clock *clock;
    const void *context;
    struct taken_frame taken;
    struct columns columns; /* the frame's */
    bool has_gaps;          /* some of their points are left out */
    bool was_lit;           /* words came in it */
    lum_frame_times frame_times;
    uint32_t end_before; /* of the frame before: its highest line, plus 1 */
    uint32_t end;        /* of this one */
    uint32_t rows;       /* of an eye */
    uint32_t *points; /* eye x rows x pixels: indices, or LUM_FRAME_MISSING */
    uint32_t *lines;  /* eye x rows: indices of lines, or NO_LINE */
    size_t room;      /* rows, of both eyes together */
    lum_sample samples[LUM_LINE_WORDS_MAX];
    float times[LUM_LINE_WORDS_MAX];
};

struct frame_lines *frame_lines_new(unsigned eyes, frame_lines_clock *clock,
                                    const void *context)
{
    struct frame_lines *f = calloc(1, sizeof *f);
    if (f != NULL) {
        f->eyes = eyes;
        f->clock = clock;
        f->context = context;
    }
    return f;
}

void frame_lines_free(struct frame_lines *f)
{
    if (f != NULL) {
        free(f->points);
        free(f->lines);
        free(f);
    }
}

static lum_frame_line line_at(const struct frame_lines *f, size_t i)
{
    lum_frame_line line = {.struct_size = sizeof line};
    (void)lum_frame_get_line(f->taken.frame, i, &line);
    return line;
}

/* --- How many rows --- */

static uint32_t find_end(const lum_frame *frame)
{
    uint32_t end = 0;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        const uint32_t rows = lum_frame_rows(frame, eye);
        end = rows > end ? rows : end;
    }
    return end;
}

static int make_room(struct frame_lines *f, size_t rows)
{
    if (rows <= f->room) {
        return 0;
    }
    free(f->points);
    free(f->lines);
    f->room = 0;
    f->points = malloc(rows * LUM_LINE_PIXELS * sizeof *f->points);
    f->lines = malloc(rows * sizeof *f->lines);
    if (f->points == NULL || f->lines == NULL) {
        return -1;
    }
    f->room = rows;
    return 0;
}

/* --- Laying out --- */

static uint32_t *points_of(const struct frame_lines *f, unsigned eye)
{
    return f->points + (size_t)eye * f->rows * LUM_LINE_PIXELS;
}

/* The line of each row. If several lines have its number, it is the first one
 * with points, which is the one in the grid, or else the first. */
static void find_lines(struct frame_lines *f)
{
    for (size_t i = 0; i < (size_t)LUM_EYES * f->rows; i++) {
        f->lines[i] = NO_LINE;
    }
    for (size_t i = 0; i < f->taken.lines; i++) {
        const lum_frame_line line = line_at(f, i);
        if (line.number >= f->rows) {
            continue;
        }
        uint32_t *at = &f->lines[(size_t)line.eye * f->rows + line.number];
        if (*at == NO_LINE ||
            (line.point_count > 0 && line_at(f, *at).point_count == 0)) {
            *at = (uint32_t)i;
        }
    }
}

static void count_left_out(struct frame_lines *f)
{
    const size_t cells = (size_t)LUM_EYES * f->rows * LUM_LINE_PIXELS;
    f->taken.left_out = f->taken.points;
    for (size_t i = 0; i < cells; i++) {
        f->taken.left_out -= f->points[i] != LUM_FRAME_MISSING ? 1u : 0u;
    }
}

static int lay_out(struct frame_lines *f)
{
    f->end_before = f->end;
    f->end = find_end(f->taken.frame);
    f->rows = f->end > f->end_before ? f->end : f->end_before;
    if (make_room(f, (size_t)LUM_EYES * f->rows) != 0) {
        return -1;
    }
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        (void)lum_frame_grid_index(f->taken.frame, eye, f->rows, 1,
                                   points_of(f, eye));
    }
    find_lines(f);
    count_left_out(f);
    return 0;
}

static struct columns columns_of(const lum_frame *f)
{
    return (struct columns){
        .x = lum_frame_floats(f, LUM_COLUMN_X),
        .y = lum_frame_floats(f, LUM_COLUMN_Y),
        .z = lum_frame_floats(f, LUM_COLUMN_Z),
        .range = lum_frame_floats(f, LUM_COLUMN_RANGE),
        .azimuth = lum_frame_floats(f, LUM_COLUMN_AZIMUTH),
        .elevation = lum_frame_floats(f, LUM_COLUMN_ELEVATION),
        .pulse_width = lum_frame_floats(f, LUM_COLUMN_PULSE_WIDTH),
        .time = lum_frame_floats(f, LUM_COLUMN_TIME),
        .pixel = lum_frame_uint16s(f, LUM_COLUMN_PIXEL),
        .return_number = lum_frame_uint16s(f, LUM_COLUMN_RETURN_NUMBER),
        .number_of_returns = lum_frame_uint16s(f, LUM_COLUMN_NUMBER_OF_RETURNS),
        .edge = lum_frame_uint8s(f, LUM_COLUMN_EDGE)};
}

int frame_lines_take(struct frame_lines *f, const lum_frame *frame,
                     bool wants_rows)
{
    lum_frame_info info = {.struct_size = sizeof info};
    lum_frame_get_info(frame, &info);
    f->taken = (struct taken_frame){
        .frame = frame,
        .number = info.number,
        .is_whole = info.is_complete && (info.lines_dark == 0 || f->was_lit),
        .points = lum_frame_count(frame),
        .lines = lum_frame_line_count(frame)};
    f->columns = columns_of(frame);
    f->has_gaps = false;
    f->was_lit = info.lines_dark < (uint64_t)info.lines[0] + info.lines[1];
    f->frame_times = info.times;
    return wants_rows ? lay_out(f) : 0;
}

void frame_lines_move(struct frame_lines *f, const struct moved *moved)
{
    f->columns.x = moved->x;
    f->columns.y = moved->y;
    f->columns.z = moved->z;
    f->has_gaps = moved->without > 0;
    f->taken.points -= moved->without;
}

/* --- Asking --- */

const struct taken_frame *frame_lines_taken(const struct frame_lines *f)
{
    return &f->taken;
}

int64_t frame_lines_begin_ns(const struct frame_lines *f, bool by_arrival)
{
    return frame_begin_ns(&f->frame_times, by_arrival);
}

int64_t frame_begin_ns(const lum_frame_times *times, bool by_arrival)
{
    return by_arrival || times->begin_utc_ns == 0 ? times->begin_arrival_ns
                                                  : times->begin_utc_ns;
}

static lum_sample sample_at(const struct columns *c, size_t i)
{
    return (lum_sample){.x = c->x[i],
                        .y = c->y[i],
                        .z = c->z[i],
                        .range = c->range[i],
                        .azimuth = c->azimuth[i],
                        .elevation = c->elevation[i],
                        .pulse_width = c->pulse_width[i],
                        .pixel = c->pixel[i],
                        .return_number = c->return_number[i],
                        .number_of_returns = c->number_of_returns[i],
                        .edge = c->edge[i]};
}

/* What messages have of it. */
static void set_brief(lum_sample *s, const struct columns *c, size_t i)
{
    s->x = c->x[i];
    s->y = c->y[i];
    s->z = c->z[i];
    s->pulse_width = c->pulse_width[i];
    s->return_number = c->return_number[i];
}

/* Without points that are left out. */
static void close_gaps(struct frame_lines *f, const lum_frame_line *line,
                       lum_line_samples *out)
{
    size_t n = 0;
    for (uint32_t k = 0; k < line->point_count; k++) {
        if (!isnan(f->samples[k].x)) {
            f->times[n] = f->columns.time[line->first_point + k];
            f->samples[n++] = f->samples[k];
        }
    }
    out->count = n;
    out->times = f->times;
}

void frame_lines_get(struct frame_lines *f, size_t i, lum_line_samples *out)
{
    const lum_frame_line line = line_at(f, i);
    const bool is_brief = f->columns.pixel == NULL;
    for (uint32_t k = 0; k < line.point_count && is_brief; k++) {
        set_brief(&f->samples[k], &f->columns, line.first_point + k);
    }
    for (uint32_t k = 0; k < line.point_count && !is_brief; k++) {
        f->samples[k] = sample_at(&f->columns, line.first_point + k);
    }
    *out = (lum_line_samples){.struct_size = sizeof *out,
                              .samples = f->samples,
                              .count = line.point_count,
                              .frame = f->taken.number,
                              .timestamp_us = f->clock(f->context, &line),
                              .line = line.number,
                              .eye = line.eye,
                              .times = f->columns.time + line.first_point};
    if (f->has_gaps) {
        close_gaps(f, &line, out);
    }
}

bool frame_lines_outline(const struct frame_lines *f, size_t i,
                         lum_line_samples *out)
{
    const lum_frame_line line = line_at(f, i);
    *out = (lum_line_samples){.struct_size = sizeof *out,
                              .count = line.point_count,
                              .frame = f->taken.number,
                              .line = line.number,
                              .eye = line.eye,
                              .times = f->columns.time + line.first_point};
    return !f->has_gaps;
}

uint32_t frame_lines_rows(const struct frame_lines *f)
{
    return f->rows * ((f->eyes & 1u) + (f->eyes >> 1 & 1u));
}

static void put_missing(struct frame_lines *f, unsigned pixel)
{
    f->times[pixel] = NAN;
    f->samples[pixel] = (lum_sample){.x = NAN,
                                     .y = NAN,
                                     .z = NAN,
                                     .range = NAN,
                                     .azimuth = NAN,
                                     .elevation = NAN,
                                     .pulse_width = NAN,
                                     .pixel = (uint16_t)pixel};
}

static int64_t timestamp_of(const struct frame_lines *f, uint32_t i)
{
    lum_frame_line line;
    if (i == NO_LINE) {
        return LUM_TIMESTAMP_NONE;
    }
    line = line_at(f, i);
    return f->clock(f->context, &line);
}

void frame_lines_get_row(struct frame_lines *f, uint32_t row,
                         lum_line_samples *out)
{
    const unsigned eye = row / f->rows + ((f->eyes & 1u) != 0 ? 0u : 1u);
    const uint32_t number = row % f->rows;
    const uint32_t *points =
        points_of(f, eye) + (size_t)number * LUM_LINE_PIXELS;
    for (unsigned pixel = 0; pixel < LUM_LINE_PIXELS; pixel++) {
        const uint32_t point = points[pixel];
        if (point == LUM_FRAME_MISSING || isnan(f->columns.x[point])) {
            put_missing(f, pixel);
        } else {
            f->samples[pixel] = sample_at(&f->columns, point);
            f->times[pixel] = f->columns.time[point];
        }
    }
    *out = (lum_line_samples){.struct_size = sizeof *out,
                              .samples = f->samples,
                              .count = LUM_LINE_PIXELS,
                              .frame = f->taken.number,
                              .timestamp_us = timestamp_of(
                                  f, f->lines[(size_t)eye * f->rows + number]),
                              .line = number,
                              .eye = (uint8_t)eye,
                              .times = f->times};
}
