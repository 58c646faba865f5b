/* A frame as a picture that lies as the world does, and which point fills a
 * pixel. */
#include "lum/frame/image.h"

#include "base/sized.h"
#include "frame_internal.h"

#include <math.h>
#include <string.h>

/* Points whose pixels are known before they are filled, while they are in the
 * first-level cache; and the latest points, whose ranks are kept. */
#define BLOCK  1024u
#define WINDOW 8192u

/* A block's points as its sensor sees them. */
struct seen {
    const float *x;
    const float *y;
    const float *z;
    float moved[3][BLOCK];
};

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
    const lum_pose *back; /* from the points' frame to the sensor's; or NULL */
    struct seen seen;
    int32_t ranks[WINDOW]; /* of point i, at i % WINDOW */
};

/* Look at some points, at most a block. */
static void see(struct seen *out, const lum_image_points *from,
                const lum_pose *back, size_t first, size_t n)
{
    out->x = from->x + first;
    out->y = from->y + first;
    out->z = from->z + first;
    if (back == NULL) {
        return;
    }
    for (size_t i = 0; i < n; i++) {
        double at[3] = {out->x[i], out->y[i], out->z[i]};
        lum_pose_apply(back, at, at);
        for (int k = 0; k < 3; k++) {
            out->moved[k][i] = (float)at[k];
        }
    }
    out->x = out->moved[0];
    out->y = out->moved[1];
    out->z = out->moved[2];
}

/* The bits of a number that is not negative: of two, those of the smaller one
 * are the smaller integer. */
static inline int32_t bits_of(float number)
{
    int32_t bits = 0;
    memcpy(&bits, &number, sizeof bits);
    return bits;
}

/* Of two points of a pixel, the one with the smaller rank fills it. */
static void rank(const lum_image_points *p, const struct seen *seen,
                 lum_image_choice choice, size_t first, size_t n,
                 int32_t *restrict out)
{
    const float *x = seen->x;
    const float *y = seen->y;
    const float *z = seen->z;
    const int32_t sign = choice == LUM_IMAGE_FARTHEST ? -1 : 1;
    switch (choice) {
    case LUM_IMAGE_STRONGEST:
        for (size_t i = 0; i < n; i++) {
            out[i] = -bits_of(p->pulse_width[first + i]);
        }
        break;
    case LUM_IMAGE_FIRST:
    case LUM_IMAGE_LAST:
        for (size_t i = 0; i < n; i++) {
            out[i] = choice == LUM_IMAGE_LAST ? -(int32_t)(first + i) : 0;
        }
        break;
    case LUM_IMAGE_NEAREST:
    case LUM_IMAGE_FARTHEST:
    default:
        for (size_t i = 0; i < n; i++) {
            out[i] = sign * bits_of(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
        }
        break;
    }
}

/* The rank of a point that was forgotten. */
static int32_t rank_again(const struct picture *p, size_t i)
{
    struct seen seen;
    int32_t again = 0;
    see(&seen, &p->from, p->back, i, 1);
    rank(&p->from, &seen, p->options.choice, i, 1, &again);
    return again;
}

/* Most pixels are filled by this line or the one before, whose ranks are kept.
 */
static void fill(struct picture *p, size_t first, size_t n,
                 const uint32_t *pixels)
{
    const int32_t *ranks = p->ranks;
    uint32_t *out = p->out;
    uint32_t filled = 0;
    uint32_t inside = 0;
    for (size_t i = first; i < first + n; i++) {
        const uint32_t pixel = pixels[i - first];
        if (pixel != LUM_IMAGE_NONE) {
            const uint32_t held = out[pixel];
            const bool is_free = held == LUM_FRAME_MISSING;
            int32_t before = ranks[held % WINDOW];
            if ((uint64_t)held + (WINDOW - BLOCK) < i) {
                before = rank_again(p, held);
            }
            before = is_free ? INT32_MAX : before;
            out[pixel] = ranks[i % WINDOW] < before ? (uint32_t)i : held;
            filled += is_free;
            inside++;
        }
    }
    p->filled += filled;
    p->inside += inside;
}

/* Points that follow each other. */
static void add(struct picture *p, size_t first, size_t count)
{
    uint32_t block[BLOCK] = {0}; /* so that the analyser follows */
    const lum_image_points *from = &p->from;
    size_t n = 0;
    for (size_t at = first; at < first + count; at += n) {
        const size_t left = first + count - at;
        n = BLOCK - at % BLOCK;
        n = left < n ? left : n;
        uint32_t *pixels = p->pixels != NULL ? p->pixels + at : block;
        see(&p->seen, from, p->back, at, n);
        lum_image_pixels(&p->scale, p->seen.x, p->seen.y, p->seen.z, n, pixels);
        rank(from, &p->seen, p->options.choice, at, n, &p->ranks[at % WINDOW]);
        fill(p, at, n, pixels);
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

/* Other ranks are written before they are read. */
static void clear(struct picture *p, uint32_t *out, uint32_t *pixels)
{
    p->out = out;
    p->pixels = pixels;
    p->asked = 0;
    p->inside = 0;
    p->filled = 0;
    p->back = NULL;
    p->ranks[LUM_FRAME_MISSING % WINDOW] = 0;
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
        from->count > INT32_MAX ||
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
    struct picture p;
    clear(&p, out, pixels);
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
    const lum_pose pose = lum_frame_pose(frame);
    const lum_pose back = lum_pose_inverse(&pose);
    struct picture p;
    clear(&p, out, pixels);
    p.back = frame->is_placed ? &back : NULL;
    p.from = (lum_image_points){
        .count = frame->count,
        .x = lum_frame_floats(frame, LUM_COLUMN_X),
        .y = lum_frame_floats(frame, LUM_COLUMN_Y),
        .z = lum_frame_floats(frame, LUM_COLUMN_Z),
        .pulse_width = lum_frame_floats(frame, LUM_COLUMN_PULSE_WIDTH)};
    if (!begin(&p, options, counts)) {
        return LUM_E_VALUE;
    }
    for (size_t i = 0; i < frame->row_count; i++) {
        const lum_frame_line *line = &frame->store.rows[i];
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
    const float none = NAN;
    size_t wrong = 0;
    for (size_t i = 0; i < n; i++) {
        const float *at = index[i] < count ? numbers + index[i] : &none;
        out[i] = *at;
        wrong += index[i] >= count && index[i] != LUM_FRAME_MISSING;
    }
    return wrong == 0 ? LUM_OK : LUM_E_VALUE;
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
