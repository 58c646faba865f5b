#include "ros_points.h"

#include "le.h"
#include "ros_messages.h"

#include <math.h>

#define NO_RING UINT16_MAX /* of a line beyond the number */

/* What is kept of a point: the first five fields of its message, with the time
 * from the beginning of the frame; then the line and the number of the return;
 * then its extra values. By a preset, its row stands in their place, and the
 * message has nothing else. */
#define TIME_AT    16u
#define LINE_AT    20u
#define NUMBER_AT  24u
#define KEPT_BYTES 25u

static size_t extra_bytes(const lum_ros_points *points)
{
    return points->preset != NULL   ? lum_preset_bytes(points->preset)
           : points->extras != NULL ? lum_extras_bytes(points->extras)
                                    : 0;
}

static float time_of(const unsigned char *kept)
{
    return lum_get_f32(kept + TIME_AT);
}

static uint32_t line_of(const unsigned char *kept)
{
    return lum_get_le32(kept + LINE_AT);
}

void lum_ros_points_free(lum_ros_points *points)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        lum_bytes_free(&points->eyes[eye].kept);
    }
    lum_bytes_free(&points->spare);
    *points = (lum_ros_points){0};
}

/* --- Adding --- */

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

static unsigned known_eye(unsigned eye)
{
    return eye < LUM_EYES ? eye : 0;
}

int lum_ros_points_add(lum_ros_points *points, const lum_line_samples *line,
                       float from_s)
{
    lum_ros_eye *eye = &points->eyes[known_eye(line->eye)];
    const bool has_extra = points->preset == NULL && extra_bytes(points) > 0;
    const size_t n = line->count * (KEPT_BYTES + extra_bytes(points));
    unsigned char *p = lum_bytes_extend(&eye->kept, n);
    if (p == NULL) {
        return -1;
    }
    note_line(points, line->line);
    bool is_unsorted = false;
    float before = eye->count > 0 ? eye->last_s : -INFINITY;
    for (size_t i = 0; i < line->count; i++) {
        const lum_sample *s = &line->samples[i];
        const float time = line->times != NULL ? line->times[i] : from_s;
        is_unsorted |= time < before;
        before = time;
        p = lum_put_f32(p, s->x);
        p = lum_put_f32(p, s->y);
        p = lum_put_f32(p, s->z);
        p = lum_put_f32(p, s->pulse_width);
        p = lum_put_f32(p, time);
        p = lum_put_le32(p, line->line);
        p = lum_put_u8(p,
                       (uint8_t)(s->return_number < UINT8_MAX ? s->return_number
                                                              : UINT8_MAX));
        if (has_extra) {
            p = lum_extras_put(p, points->extras, line->extra, i);
        } else if (points->preset != NULL) {
            p = lum_preset_put_row(p, points->preset, line, s, 0.0);
        }
    }
    eye->is_unsorted |= is_unsorted;
    eye->last_s = before;
    eye->count += line->count;
    eye->to_come -= line->count < eye->to_come ? line->count : eye->to_come;
    return 0;
}

size_t lum_ros_points_count(const lum_ros_points *points)
{
    return points->eyes[0].count + points->eyes[1].count;
}

/* --- Order --- */

/* Two sorted parts of `from`, into `to`; of equal ones those of the first part
 * come first. */
static void merge(const unsigned char *from, size_t middle, size_t end,
                  size_t bytes, unsigned char *to)
{
    const unsigned char *a = from;
    const unsigned char *b = from + middle * bytes;
    const unsigned char *const a_end = b;
    const unsigned char *const b_end = from + end * bytes;
    for (size_t i = 0; i < end; i++, to += bytes) {
        const bool takes_a =
            a < a_end && (b == b_end || !(time_of(b) < time_of(a)));
        memcpy(to, takes_a ? a : b, bytes);
        a += takes_a ? bytes : 0;
        b += takes_a ? 0 : bytes;
    }
}

/* Lines that came late are rare. */
static int sort_eye(lum_ros_points *points, lum_ros_eye *eye)
{
    const size_t bytes = KEPT_BYTES + extra_bytes(points);
    for (size_t width = 1; eye->is_unsorted && width < eye->count;
         width *= 2u) {
        points->spare.len = 0;
        unsigned char *to = lum_bytes_extend(&points->spare, eye->kept.len);
        if (to == NULL) {
            return -1;
        }
        for (size_t i = 0; i < eye->count; i += 2u * width) {
            const size_t left = eye->count - i;
            merge(eye->kept.at + i * bytes, width < left ? width : left,
                  2u * width < left ? 2u * width : left, bytes, to + i * bytes);
        }
        const lum_bytes sorted = points->spare;
        points->spare = eye->kept;
        eye->kept = sorted;
    }
    eye->is_unsorted = false;
    return 0;
}

/* The first time of two eyes, of which one may have none. */
static float first_of(bool has_blue, float blue_s, bool has_green,
                      float green_s)
{
    if (!has_blue && !has_green) {
        return 0.0f;
    }
    return has_green && (!has_blue || green_s < blue_s) ? green_s : blue_s;
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
    const bool has_green = green->count > 0;
    *first_s = first_of(has_blue, has_blue ? time_of(blue->kept.at) : 0.0f,
                        has_green, has_green ? time_of(green->kept.at) : 0.0f);
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
    return (points->preset == NULL ? LUM_ROS_POINT_BYTES : 0u) +
           extra_bytes(points);
}

/* A sequence has a length of 32 bits, and a chunk is in memory. */
size_t lum_ros_points_max(const lum_ros_points *points)
{
    return UINT32_MAX / lum_ros_points_bytes(points) / 2u;
}

/* What the points of a message share. */
typedef struct common {
    float first_s;
    uint32_t lines;
    size_t extra_bytes;
    const lum_preset *preset;
} common;

static common common_of(const lum_ros_points *points, float first_s)
{
    return (common){first_s, points->lines, extra_bytes(points),
                    points->preset};
}

static unsigned char *put_point(unsigned char *p, const unsigned char *kept,
                                const common *of, unsigned eye)
{
    const uint32_t line = line_of(kept);
    const float time = time_of(kept) - of->first_s;
    if (of->preset != NULL) {
        memcpy(p, kept + KEPT_BYTES, of->extra_bytes);
        lum_preset_put_time(p, of->preset, (double)time);
        return p + of->extra_bytes;
    }
    memcpy(p, kept, TIME_AT);
    p = lum_put_f32(p + TIME_AT, time);
    p = lum_put_le16(p, line < of->lines ? (uint16_t)(eye * of->lines + line)
                                         : NO_RING);
    p = lum_put_u8(p, kept[NUMBER_AT]);
    p = lum_put_u8(p, (uint8_t)eye);
    if (of->extra_bytes > 0) {
        memcpy(p, kept + KEPT_BYTES, of->extra_bytes);
    }
    return p + of->extra_bytes;
}

static unsigned char *put_points(unsigned char *p, const unsigned char *kept,
                                 size_t n, const common *of, unsigned eye)
{
    for (size_t i = 0; i < n; i++) {
        p = put_point(p, kept + i * (KEPT_BYTES + of->extra_bytes), of, eye);
    }
    return p;
}

/* The eye's points that were not taken. */
static const unsigned char *next_of(const lum_ros_points *points, unsigned eye)
{
    return points->eyes[eye].kept.at +
           points->taken[eye] * (KEPT_BYTES + extra_bytes(points));
}

static size_t left_of(const lum_ros_points *points, unsigned eye)
{
    return points->eyes[eye].count - points->taken[eye];
}

static void forget(lum_ros_points *points)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        points->eyes[eye].kept.len = 0;
        points->eyes[eye].count = 0;
        points->eyes[eye].is_unsorted = false;
        points->eyes[eye].to_come = 0;
        points->taken[eye] = 0;
    }
}

/* Until one eye has none left. Which has the next point is as good as random,
 * so it is computed and not branched on. */
static unsigned char *put_both(lum_ros_points *points, const common *of,
                               unsigned char *out)
{
    const size_t bytes = KEPT_BYTES + of->extra_bytes;
    size_t blues = left_of(points, 0);
    size_t greens = left_of(points, 1);
    if (blues == 0 || greens == 0) {
        return out;
    }
    const unsigned char *blue = next_of(points, 0);
    const unsigned char *green = next_of(points, 1);
    while (blues > 0 && greens > 0) {
        const unsigned eye = time_of(green) < time_of(blue) ? 1u : 0u;
        out = put_point(out, eye != 0 ? green : blue, of, eye);
        blue += bytes * (1u - eye);
        green += bytes * eye;
        blues -= 1u - eye;
        greens -= eye;
    }
    points->taken[0] = points->eyes[0].count - blues;
    points->taken[1] = points->eyes[1].count - greens;
    return out;
}

static unsigned char *put_rest(lum_ros_points *points, const common *of,
                               unsigned eye, unsigned char *out)
{
    const size_t left = left_of(points, eye);
    if (left == 0) {
        return out;
    }
    const unsigned char *next = next_of(points, eye);
    points->taken[eye] += left;
    return put_points(out, next, left, of, eye);
}

void lum_ros_points_take(lum_ros_points *points, float first_s,
                         unsigned char *out)
{
    count_lines(points);
    const common of = common_of(points, first_s);
    out = put_both(points, &of, out);
    out = put_rest(points, &of, 0, out);
    (void)put_rest(points, &of, 1, out);
    forget(points);
}

/* --- While they are added --- */

void lum_ros_points_foresee(lum_ros_points *points,
                            const lum_line_samples *line)
{
    lum_ros_eye *eye = &points->eyes[known_eye(line->eye)];
    const float *times = line->times;
    if (line->count == 0) {
        return;
    }
    note_line(points, line->line);
    if (times == NULL) {
        eye->is_unsorted = true;
    } else {
        bool is_unsorted = eye->to_come > 0 && times[0] < eye->last_s;
        for (size_t i = 1; i < line->count; i++) {
            is_unsorted |= times[i] < times[i - 1u];
        }
        eye->is_unsorted |= is_unsorted;
        eye->first_s = eye->to_come > 0 ? eye->first_s : times[0];
        eye->last_s = times[line->count - 1u];
    }
    eye->to_come += line->count;
}

size_t lum_ros_points_to_come(const lum_ros_points *points, unsigned eye)
{
    return points->eyes[known_eye(eye)].to_come;
}

void lum_ros_points_end_merge(lum_ros_points *points)
{
    forget(points);
    points->has_line[0] = false;
    points->has_line[1] = false;
}

bool lum_ros_points_can_merge(lum_ros_points *points, size_t *count,
                              float *first_s)
{
    const lum_ros_eye *blue = &points->eyes[0];
    const lum_ros_eye *green = &points->eyes[1];
    const size_t n = blue->to_come + green->to_come;
    const bool can = n > 0 && n <= lum_ros_points_max(points) &&
                     !blue->is_unsorted && !green->is_unsorted;
    if (!can) {
        lum_ros_points_end_merge(points);
        return false;
    }
    count_lines(points);
    *count = n;
    *first_s = first_of(blue->to_come > 0, blue->first_s, green->to_come > 0,
                        green->first_s);
    return true;
}

/* So that what is kept does not grow. Less is moved than was taken. */
static void close_up(lum_ros_points *points, unsigned eye)
{
    lum_bytes *kept = &points->eyes[eye].kept;
    const size_t left = left_of(points, eye);
    if (left <= points->taken[eye] && points->taken[eye] > 0) {
        const unsigned char *next = next_of(points, eye);
        kept->len -= (size_t)(next - kept->at);
        memmove(kept->at, next, kept->len);
        points->eyes[eye].count = left;
        points->taken[eye] = 0;
    }
}

unsigned char *lum_ros_points_merge(lum_ros_points *points, float first_s,
                                    unsigned char *out)
{
    const common of = common_of(points, first_s);
    out = put_both(points, &of, out);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        const unsigned other = 1u - eye;
        if (left_of(points, other) == 0 && points->eyes[other].to_come == 0) {
            out = put_rest(points, &of, eye, out);
        }
        close_up(points, eye);
    }
    return out;
}

/* --- Line after line --- */

lum_ros_line lum_ros_points_next_line(lum_ros_points *points)
{
    const size_t bytes = KEPT_BYTES + extra_bytes(points);
    lum_ros_line line = {.count = 0};
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        if (left_of(points, eye) > 0 &&
            (line.count == 0 || time_of(next_of(points, eye)) < line.first_s)) {
            line.eye = eye;
            line.first_s = time_of(next_of(points, eye));
            line.count = 1;
        }
    }
    if (line.count == 0) {
        forget(points);
        return line;
    }
    const unsigned char *first = next_of(points, line.eye);
    const size_t left = left_of(points, line.eye);
    while (line.count < left &&
           line_of(first + line.count * bytes) == line_of(first)) {
        line.count++;
    }
    return line;
}

void lum_ros_points_take_line(lum_ros_points *points, const lum_ros_line *line,
                              unsigned char *out)
{
    count_lines(points);
    const common of = common_of(points, line->first_s);
    (void)put_points(out, next_of(points, line->eye), line->count, &of,
                     line->eye);
    points->taken[line->eye] += line->count;
}
