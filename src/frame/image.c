#include "lum/frame/image.h"

#include "base/sized.h"
#include "frame_internal.h"

#include <math.h>
#include <string.h>

/* Points whose pixels are known before they are filled, while they are in the
 * first-level cache. */
#define BLOCK 1024u

/* A picture while it is made. */
struct picture {
    lum_image_points from;
    lum_image_options options;
    lum_image_scale scale;
    uint32_t *out;
    uint32_t *pixels; /* or NULL */
    uint64_t asked;   /* points of the eyes */
    uint64_t inside;
    uint64_t filled;
};

static inline float square_of(const lum_image_points *p, uint32_t i)
{
    return p->x[i] * p->x[i] + p->y[i] * p->y[i] + p->z[i] * p->z[i];
}

/* Whether a point takes a pixel from one before it. */
static inline bool takes(const lum_image_points *p, lum_image_choice choice,
                         uint32_t point, uint32_t held)
{
    switch (choice) {
    case LUM_IMAGE_FARTHEST:
        return square_of(p, point) > square_of(p, held);
    case LUM_IMAGE_STRONGEST:
        return p->pulse_width[point] > p->pulse_width[held];
    case LUM_IMAGE_FIRST:
        return false;
    case LUM_IMAGE_LAST:
        return true;
    case LUM_IMAGE_NEAREST:
    default:
        return square_of(p, point) < square_of(p, held);
    }
}

/* Without branches that a processor would have to guess: a pixel without a
 * point is as if it were the new one's. */
static inline void fill(struct picture *p, lum_image_choice choice,
                        uint32_t first, uint32_t n, const uint32_t *pixels)
{
    const lum_image_points from = p->from;
    uint32_t *out = p->out;
    uint32_t filled = 0;
    uint32_t inside = 0;
    for (uint32_t i = 0; i < n; i++) {
        if (pixels[i] != LUM_IMAGE_NONE) {
            const uint32_t point = first + i;
            const uint32_t before = out[pixels[i]];
            const bool is_free = before == LUM_FRAME_MISSING;
            const uint32_t held = is_free ? point : before;
            out[pixels[i]] = takes(&from, choice, point, held) ? point : held;
            filled += is_free;
            inside++;
        }
    }
    p->filled += filled;
    p->inside += inside;
}

/* A loop for each choice. */
static void fill_block(struct picture *p, uint32_t first, uint32_t n,
                       const uint32_t *pixels)
{
    switch (p->options.choice) {
    case LUM_IMAGE_FARTHEST:
        fill(p, LUM_IMAGE_FARTHEST, first, n, pixels);
        break;
    case LUM_IMAGE_STRONGEST:
        fill(p, LUM_IMAGE_STRONGEST, first, n, pixels);
        break;
    case LUM_IMAGE_FIRST:
        fill(p, LUM_IMAGE_FIRST, first, n, pixels);
        break;
    case LUM_IMAGE_LAST:
        fill(p, LUM_IMAGE_LAST, first, n, pixels);
        break;
    case LUM_IMAGE_NEAREST:
    default:
        fill(p, LUM_IMAGE_NEAREST, first, n, pixels);
        break;
    }
}

/* Points that follow each other. */
static void add(struct picture *p, size_t first, size_t count)
{
    uint32_t block[BLOCK];
    const lum_image_points *from = &p->from;
    for (size_t i = 0; i < count; i += BLOCK) {
        const size_t at = first + i;
        const size_t n = count - i < BLOCK ? count - i : BLOCK;
        uint32_t *pixels = p->pixels != NULL ? p->pixels + at : block;
        lum_image_pixels(&p->scale, from->x + at, from->y + at, from->z + at, n,
                         pixels);
        fill_block(p, (uint32_t)at, (uint32_t)n, pixels);
    }
    p->asked += count;
}

/* Likewise, all of one eye. Those of an eye that was not asked for lie nowhere.
 */
static void add_of_eye(struct picture *p, size_t first, size_t count,
                       unsigned eye)
{
    if (eye < LUM_EYES && (p->options.eyes >> eye & 1u) != 0) {
        add(p, first, count);
    } else if (p->pixels != NULL) {
        memset(p->pixels + first, 0xff, count * sizeof *p->pixels);
    }
}

static bool is_sized(const lum_image_counts *counts)
{
    return counts == NULL || counts->struct_size > sizeof counts->struct_size;
}

static bool begin(struct picture *p, const lum_image_options *options,
                  const lum_image_counts *counts)
{
    if (!is_sized(counts) ||
        lum_sized_take(&p->options, sizeof p->options, options, "options",
                       "lum_image_options", NULL) != 0) {
        return false;
    }
    const lum_image_options *o = &p->options;
    const lum_image_points *from = &p->from;
    const bool is_known = o->eyes >= LUM_IMAGE_BLUE &&
                          o->eyes <= LUM_IMAGE_BOTH &&
                          (unsigned)o->choice <= LUM_IMAGE_LAST;
    const bool is_strongest = o->choice == LUM_IMAGE_STRONGEST;
    if (!is_known || from->x == NULL || from->y == NULL || from->z == NULL ||
        (is_strongest && from->pulse_width == NULL) ||
        from->count >= LUM_FRAME_MISSING ||
        lum_image_scale_init(&p->scale, &o->view) != LUM_OK) {
        return false;
    }
    memset(p->out, 0xff,
           (size_t)o->view.rows * o->view.columns * sizeof *p->out);
    return true;
}

static void count(const struct picture *p, lum_image_counts *counts)
{
    const lum_image_counts made = {.struct_size = sizeof made,
                                   .filled = p->filled,
                                   .hidden = p->inside - p->filled,
                                   .outside = p->asked - p->inside};
    if (counts != NULL) {
        (void)lum_sized_fill(counts, &made, sizeof made);
    }
}

lum_result lum_image_index(const lum_image_points *points,
                           const lum_image_options *options, uint32_t *out,
                           uint32_t *pixels, lum_image_counts *counts)
{
    struct picture p = {.out = out, .pixels = pixels};
    if (lum_sized_take(&p.from, sizeof p.from, points, "points",
                       "lum_image_points", NULL) != 0 ||
        !begin(&p, options, counts)) {
        return LUM_E_VALUE;
    }
    const uint8_t *eye = p.from.eye;
    if (eye == NULL) {
        add(&p, 0, p.from.count);
    }
    size_t end = 0;
    for (size_t first = 0; eye != NULL && first < p.from.count; first = end) {
        while (end < p.from.count && eye[end] == eye[first]) {
            end++;
        }
        add_of_eye(&p, first, end - first, eye[first]);
    }
    count(&p, counts);
    return LUM_OK;
}

lum_result lum_frame_image_index(const lum_frame *frame,
                                 const lum_image_options *options,
                                 uint32_t *out, uint32_t *pixels,
                                 lum_image_counts *counts)
{
    struct picture p = {.from = {.count = frame->count,
                                 .x = lum_frame_floats(frame, LUM_COLUMN_X),
                                 .y = lum_frame_floats(frame, LUM_COLUMN_Y),
                                 .z = lum_frame_floats(frame, LUM_COLUMN_Z),
                                 .pulse_width = lum_frame_floats(
                                     frame, LUM_COLUMN_PULSE_WIDTH)},
                        .out = out,
                        .pixels = pixels};
    if (!begin(&p, options, counts)) {
        return LUM_E_VALUE;
    }
    for (size_t i = 0; i < frame->row_count; i++) {
        const lum_line_row *line = &frame->store.rows[i];
        add_of_eye(&p, line->first_point, line->point_count, line->eye);
    }
    count(&p, counts);
    return LUM_OK;
}

lum_result lum_frame_image_default(const lum_frame *frame, uint32_t eyes,
                                   lum_image_options *out)
{
    lum_image_options made = {
        .struct_size = sizeof made, .eyes = eyes, .choice = LUM_IMAGE_NEAREST};
    uint32_t lines = 0;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        const uint32_t rows =
            (eyes >> eye & 1u) != 0 ? lum_frame_rows(frame, eye) : 0;
        lines = rows > lines ? rows : lines;
    }
    lum_image_view_default(&made.view, eyes, lines);
    return lum_sized_fill(out, &made, sizeof made) ? LUM_OK : LUM_E_VALUE;
}

lum_result lum_image_take(const float *numbers, size_t count,
                          const uint32_t *index, size_t n, float *out)
{
    bool is_right = true;
    for (size_t i = 0; i < n; i++) {
        const bool is_point = index[i] < count;
        out[i] = is_point ? numbers[index[i]] : NAN;
        is_right &= is_point || index[i] == LUM_FRAME_MISSING;
    }
    return is_right ? LUM_OK : LUM_E_VALUE;
}

lum_result lum_frame_image(const lum_frame *frame, lum_column column,
                           const uint32_t *index, size_t n, float *out)
{
    const float *numbers = lum_frame_floats(frame, column);
    if (numbers != NULL) {
        return lum_image_take(numbers, frame->count, index, n, out);
    }
    if (lum_frame_column(frame, column) == NULL) {
        return LUM_E_VALUE;
    }
    bool is_right = true;
    for (size_t i = 0; i < n; i++) {
        const bool is_point = index[i] < frame->count;
        out[i] = is_point ? lum_frame_number(frame, column, index[i]) : NAN;
        is_right &= is_point || index[i] == LUM_FRAME_MISSING;
    }
    return is_right ? LUM_OK : LUM_E_VALUE;
}
