#include "coordinates.h"
#include "kernels.h"

#include <string.h>

/* The word takes the place of the fourth number. */
static inline void put_point(lum_point *to, float range, const lum_direction *d,
                             const lum_direction *mount, uint32_t word)
{
    lum_put_lanes(to, range, d, mount);
    to->word = word;
}

/* Sums of bit 10 stay below 2^32. There is no branch for each word, so that
 * compilers make vector code. */
uint32_t lum_plain_count_below(const uint32_t *words, uint32_t n,
                               int32_t min_tof, uint32_t *rising)
{
    uint32_t below = 0;
    uint32_t edges = 0;
    for (uint32_t i = 0; i < n; i++) {
        const uint32_t is_below = lum_word_tof(words[i]) < min_tof ? 1u : 0u;
        below += is_below;
        edges += words[i] & LUM_WORD_RISING & (is_below - 1u);
    }
    *rising = edges / LUM_WORD_RISING;
    return below;
}

/* Two short loops: compilers make vector code of the first. */
void lum_plain_points(const lum_eye_projector *eye, const uint32_t *words,
                      uint32_t n, const lum_direction *directions,
                      lum_point *out)
{
    const lum_direction mount = {eye->mount[0], eye->mount[1], eye->mount[2],
                                 0.0f};
    const float lsb = (float)eye->range_lsb;
    const float offset = (float)eye->range_offset;
    float ranges[LUM_POINTS_BLOCK];
    for (uint32_t i = 0; i < n; i++) {
        ranges[i] = (float)lum_word_tof(words[i]) * lsb + offset;
    }
    for (uint32_t i = 0; i < n; i++) {
        put_point(&out[i], ranges[i], &directions[lum_word_pixel(words[i])],
                  &mount, words[i]);
    }
}

/* A word without a range is overwritten by the next, which is faster than a
 * branch that nobody can predict. */
static size_t put_those_with_range(const lum_eye_projector *eye,
                                   const uint32_t *words, uint32_t n,
                                   const lum_direction *directions,
                                   lum_point *to)
{
    const lum_direction mount = {eye->mount[0], eye->mount[1], eye->mount[2],
                                 0.0f};
    const float lsb = (float)eye->range_lsb;
    const float offset = (float)eye->range_offset;
    const int32_t min_tof = eye->min_tof;
    size_t count = 0;
    for (uint32_t i = 0; i < n; i++) {
        const int32_t tof = lum_word_tof(words[i]);
        put_point(&to[count], (float)tof * lsb + offset,
                  &directions[lum_word_pixel(words[i])], &mount, words[i]);
        count += tof >= min_tof ? 1u : 0u;
    }
    return count;
}

/* Every pixel has angles. */
static size_t project_whole(const lum_eye_projector *p, const lum_line *line,
                            const lum_direction *directions, lum_point *out)
{
    size_t count = 0;
    for (uint32_t begin = 0; begin < line->word_count;
         begin += LUM_POINTS_BLOCK) {
        const uint32_t left = line->word_count - begin;
        const uint32_t n = left < LUM_POINTS_BLOCK ? left : LUM_POINTS_BLOCK;
        const uint32_t *words = line->words + begin;
        uint32_t rising = 0;
        if (LUM_BEST(count_below)(words, n, p->min_tof, &rising) != 0) {
            count += put_those_with_range(p, words, n, directions, out + count);
        } else {
            LUM_BEST(points)(p, words, n, directions, out + count);
            count += n;
        }
    }
    return count;
}

static size_t project_marked(const lum_eye_projector *p, const lum_line *line,
                             const lum_direction *directions, lum_point *out,
                             lum_point_losses *losses)
{
    const lum_direction mount = {p->mount[0], p->mount[1], p->mount[2], 0.0f};
    const float lsb = (float)p->range_lsb;
    const float offset = (float)p->range_offset;
    size_t n = 0;
    for (uint32_t i = 0; i < line->word_count; i++) {
        const uint32_t word = line->words[i];
        const uint32_t pixel = lum_word_pixel(word);
        const int32_t tof = lum_word_tof(word);
        if (!lum_line_has_angles(line, pixel)) {
            losses->no_angle++;
        } else if (tof < p->min_tof) {
            losses->no_range++;
        } else {
            const float range = (float)tof * lsb + offset;
            put_point(&out[n++], range, &directions[pixel], &mount, word);
        }
    }
    return n;
}

size_t lum_points_compute(const lum_projector *projector, const lum_line *line,
                          const lum_direction *directions, lum_point *out,
                          lum_point_losses *losses)
{
    const lum_eye_projector *p = &projector->eye[line->eye];
    if (line->angle_count < LUM_LINE_PIXELS) {
        return project_marked(p, line, directions, out, losses);
    }
    const size_t n = project_whole(p, line, directions, out);
    losses->no_range += line->word_count - n;
    return n;
}

static void count_marked(const lum_line *line, int32_t min_tof,
                         uint32_t *rising, uint32_t *all, uint64_t *no_angle)
{
    *rising = 0;
    *all = 0;
    for (uint32_t i = 0; i < line->word_count; i++) {
        const uint32_t word = line->words[i];
        if (!lum_line_has_angles(line, lum_word_pixel(word))) {
            (*no_angle)++;
        } else if (lum_word_tof(word) >= min_tof) {
            (*all)++;
            *rising += lum_word_is_rising(word) ? 1u : 0u;
        }
    }
}

void lum_points_mark(const lum_projector *projector, const lum_line *line,
                     uint8_t *out)
{
    const int32_t min_tof = projector->eye[line->eye].min_tof;
    for (uint32_t i = 0; i < line->word_count; i++) {
        const uint32_t word = line->words[i];
        const bool has_range = lum_word_tof(word) >= min_tof;
        const bool has_angles = lum_line_has_angles(line, lum_word_pixel(word));
        out[i] = (has_range && has_angles) ? 1u : 0u;
    }
}

void lum_points_count(const lum_projector *projector, const lum_line *line,
                      uint64_t *rising, uint64_t *falling,
                      lum_point_losses *losses)
{
    const int32_t min_tof = projector->eye[line->eye].min_tof;
    uint32_t up = 0;
    uint32_t all = 0;
    uint64_t no_angle = 0;
    if (line->angle_count < LUM_LINE_PIXELS) {
        count_marked(line, min_tof, &up, &all, &no_angle);
    } else {
        all =
            line->word_count -
            LUM_BEST(count_below)(line->words, line->word_count, min_tof, &up);
    }
    *rising = up;
    *falling = all - up;
    losses->no_angle += no_angle;
    losses->no_range += line->word_count - all - no_angle;
}
