#include "ros_points.h"

#include "le.h"
#include "ros_messages.h"

#include <stdlib.h>

#define NO_RING UINT16_MAX /* of a line beyond the number */

void lum_ros_points_free(lum_ros_points *points)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        free(points->eyes[eye].at);
    }
    free(points->spare);
    free(points->rows);
    *points = (lum_ros_points){0};
}

/* --- Adding --- */

static int make_room(lum_ros_point **at, size_t *room, size_t n)
{
    if (n <= *room) {
        return 0;
    }
    const size_t more = *room + *room / 2u;
    const size_t now = n > more ? n : more;
    lum_ros_point *bigger = realloc(*at, now * sizeof *bigger);
    if (bigger == NULL) {
        return -1;
    }
    *at = bigger;
    *room = now;
    return 0;
}

static void note_line(lum_ros_points *points, uint32_t line)
{
    if (!points->has_line[1] || line >= points->highest[1]) {
        points->has_line[0] = points->has_line[1];
        points->highest[0] = points->highest[1];
        points->has_line[1] = true;
        points->highest[1] = line;
    } else if (!points->has_line[0] || line > points->highest[0]) {
        points->has_line[0] = true;
        points->highest[0] = line;
    }
}

static size_t row_bytes(const lum_ros_points *points)
{
    return points->extras != NULL ? lum_extras_bytes(points->extras) : 0;
}

/* Behind those of all points before. */
static int add_rows(lum_ros_points *points, const lum_line_samples *line)
{
    const size_t bytes = row_bytes(points);
    const size_t before = lum_ros_points_count(points) * bytes;
    const size_t n = before + line->count * bytes;
    if (n > points->row_room) {
        const size_t room = n + n / 2u;
        unsigned char *bigger = realloc(points->rows, room);
        if (bigger == NULL) {
            return -1;
        }
        points->rows = bigger;
        points->row_room = room;
    }
    for (size_t i = 0; bytes > 0 && i < line->count; i++) {
        (void)lum_extras_put(points->rows + before + i * bytes, points->extras,
                             line->extra, i);
    }
    return 0;
}

int lum_ros_points_add(lum_ros_points *points, const lum_line_samples *line,
                       float from_s)
{
    lum_ros_eye *eye = &points->eyes[line->eye < LUM_EYES ? line->eye : 0];
    const size_t row = lum_ros_points_count(points);
    if (make_room(&eye->at, &eye->room, eye->count + line->count) != 0 ||
        add_rows(points, line) != 0) {
        return -1;
    }
    note_line(points, line->line);
    float before = eye->count > 0 ? eye->at[eye->count - 1u].time : 0.0f;
    for (size_t i = 0; i < line->count; i++) {
        const lum_sample *s = &line->samples[i];
        const float time = line->times != NULL ? line->times[i] : from_s;
        eye->is_unsorted = eye->is_unsorted || time < before;
        before = time;
        eye->at[eye->count + i] = (lum_ros_point){
            .x = s->x,
            .y = s->y,
            .z = s->z,
            .intensity = s->pulse_width,
            .time = time,
            .line = line->line,
            .row = (uint32_t)(row + i),
            .number = (uint8_t)(s->return_number < UINT8_MAX ? s->return_number
                                                             : UINT8_MAX)};
    }
    eye->count += line->count;
    return 0;
}

size_t lum_ros_points_count(const lum_ros_points *points)
{
    return points->eyes[0].count + points->eyes[1].count;
}

/* --- Order --- */

/* Two sorted parts of `from`, into `to`; of equal ones those of the first part
 * come first. */
static void merge(const lum_ros_point *from, size_t middle, size_t end,
                  lum_ros_point *to)
{
    size_t a = 0;
    size_t b = middle;
    for (size_t i = 0; i < end; i++) {
        const bool takes_a =
            a < middle && (b == end || !(from[b].time < from[a].time));
        to[i] = from[takes_a ? a : b];
        a += takes_a ? 1u : 0u;
        b += takes_a ? 0u : 1u;
    }
}

/* Lines that came late are rare. */
static int sort_eye(lum_ros_points *points, lum_ros_eye *eye)
{
    if (!eye->is_unsorted) {
        return 0;
    }
    if (make_room(&points->spare, &points->spare_room, eye->room) != 0) {
        return -1;
    }
    for (size_t width = 1; width < eye->count; width *= 2u) {
        for (size_t i = 0; i < eye->count; i += 2u * width) {
            const size_t left = eye->count - i;
            merge(eye->at + i, width < left ? width : left,
                  2u * width < left ? 2u * width : left, points->spare + i);
        }
        lum_ros_point *sorted = points->spare;
        const size_t room = points->spare_room;
        points->spare = eye->at;
        points->spare_room = eye->room;
        eye->at = sorted;
        eye->room = room;
    }
    eye->is_unsorted = false;
    return 0;
}

int lum_ros_points_sort(lum_ros_points *points, float *first_s)
{
    const lum_ros_eye *blue = &points->eyes[0];
    const lum_ros_eye *green = &points->eyes[1];
    if (sort_eye(points, &points->eyes[0]) != 0 ||
        sort_eye(points, &points->eyes[1]) != 0) {
        return -1;
    }
    const bool has_blue = blue->count > 0;
    if (!has_blue && green->count == 0) {
        *first_s = 0.0f;
    } else if (!has_blue ||
               (green->count > 0 && green->at[0].time < blue->at[0].time)) {
        *first_s = green->at[0].time;
    } else {
        *first_s = blue->at[0].time;
    }
    return 0;
}

/* --- Rings --- */

/* What the sensor can be set to, and what its Y scan could hold at most. A
 * single line beyond the number can be of a damaged packet. */
static void count_lines(lum_ros_points *points)
{
    static const uint32_t numbers[] = {64, 640, LUM_MCAP_LINES_MAX};
    if (points->lines == 0) {
        points->lines = numbers[0];
    }
    const bool grows = !points->lines_are_stated && points->has_line[0] &&
                       points->highest[0] >= points->lines;
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        if (grows && points->highest[1] >= points->lines &&
            numbers[i] > points->lines) {
            points->lines = numbers[i];
        }
    }
    points->has_line[0] = false;
    points->has_line[1] = false;
}

/* --- Writing --- */

size_t lum_ros_points_bytes(const lum_ros_points *points)
{
    return LUM_ROS_POINT_BYTES + row_bytes(points);
}

static unsigned char *put_point(unsigned char *p, const lum_ros_points *points,
                                const lum_ros_point *point, float first_s,
                                unsigned eye)
{
    const uint32_t lines = points->lines;
    const size_t bytes = row_bytes(points);
    p = lum_put_f32(p, point->x);
    p = lum_put_f32(p, point->y);
    p = lum_put_f32(p, point->z);
    p = lum_put_f32(p, point->intensity);
    p = lum_put_f32(p, point->time - first_s);
    p = lum_put_le16(p, point->line < lines
                            ? (uint16_t)(eye * lines + point->line)
                            : NO_RING);
    p = lum_put_u8(p, point->number);
    p = lum_put_u8(p, (uint8_t)eye);
    if (bytes > 0) {
        memcpy(p, points->rows + point->row * bytes, bytes);
    }
    return p + bytes;
}

static void forget(lum_ros_points *points)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        points->eyes[eye].count = 0;
        points->eyes[eye].is_unsorted = false;
        points->taken[eye] = 0;
    }
}

void lum_ros_points_take(lum_ros_points *points, float first_s,
                         unsigned char *out)
{
    lum_ros_eye *blue = &points->eyes[0];
    lum_ros_eye *green = &points->eyes[1];
    size_t b = 0;
    size_t g = 0;
    count_lines(points);
    while (b < blue->count || g < green->count) {
        while (b < blue->count &&
               (g == green->count || !(green->at[g].time < blue->at[b].time))) {
            out = put_point(out, points, &blue->at[b++], first_s, 0);
        }
        while (g < green->count &&
               (b == blue->count || green->at[g].time < blue->at[b].time)) {
            out = put_point(out, points, &green->at[g++], first_s, 1);
        }
    }
    forget(points);
}

/* --- Line after line --- */

static bool is_earlier(const lum_ros_points *points, unsigned eye,
                       unsigned than)
{
    return points->eyes[eye].at[points->taken[eye]].time <
           points->eyes[than].at[points->taken[than]].time;
}

lum_ros_line lum_ros_points_next_line(lum_ros_points *points)
{
    lum_ros_line line = {.count = 0};
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        const bool has_more = points->taken[eye] < points->eyes[eye].count;
        if (has_more &&
            (line.count == 0 || is_earlier(points, eye, line.eye))) {
            line.eye = eye;
            line.count = 1;
        }
    }
    if (line.count == 0) {
        forget(points);
        return line;
    }
    const lum_ros_eye *of = &points->eyes[line.eye];
    const size_t first = points->taken[line.eye];
    line.first_s = of->at[first].time;
    while (first + line.count < of->count &&
           of->at[first + line.count].line == of->at[first].line) {
        line.count++;
    }
    return line;
}

void lum_ros_points_take_line(lum_ros_points *points, const lum_ros_line *line,
                              unsigned char *out)
{
    const lum_ros_point *at = points->eyes[line->eye].at;
    count_lines(points);
    for (size_t i = 0; i < line->count; i++) {
        out = put_point(out, points, &at[points->taken[line->eye]++],
                        line->first_s, line->eye);
    }
}
