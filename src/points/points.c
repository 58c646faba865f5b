#include "lum/points.h"

static inline bool has_angles(const uint32_t *marks, uint32_t pixel)
{
    return ((marks[pixel / 32u] >> (pixel % 32u)) & 1u) != 0;
}

/* Every pixel has angles: a point is written for each word and stays if its
 * range is one. */
static size_t project_whole(const lum_eye_projector *p, const lum_line *line,
                            const lum_direction *restrict directions,
                            lum_point *restrict out)
{
    const float lsb = (float)p->range_lsb;
    const float offset = (float)p->range_offset;
    const float mx = p->mount[0], my = p->mount[1], mz = p->mount[2];
    const int32_t min_tof = p->min_tof;
    const uint32_t *restrict words = line->words;
    lum_point *to = out;
    for (uint32_t i = 0; i < line->word_count; i++) {
        const uint32_t word = words[i];
        const int32_t tof = lum_word_tof(word);
        const lum_direction d = directions[lum_word_pixel(word)];
        const float range = (float)tof * lsb + offset;
        to->x = range * d.x + mx;
        to->y = range * d.y + my;
        to->z = range * d.z + mz;
        to->word = word;
        to += tof >= min_tof;
    }
    return (size_t)(to - out);
}

static size_t project_marked(const lum_eye_projector *p, const lum_line *line,
                             const lum_direction *directions, lum_point *out,
                             lum_point_losses *losses)
{
    const float lsb = (float)p->range_lsb;
    const float offset = (float)p->range_offset;
    size_t n = 0;
    for (uint32_t i = 0; i < line->word_count; i++) {
        const uint32_t word = line->words[i];
        const uint32_t pixel = lum_word_pixel(word);
        const int32_t tof = lum_word_tof(word);
        if (!has_angles(line->angle_marks, pixel)) {
            losses->no_angle++;
        } else if (tof < p->min_tof) {
            losses->no_range++;
        } else {
            const float range = (float)tof * lsb + offset;
            const lum_direction d = directions[pixel];
            out[n++] = (lum_point){range * d.x + p->mount[0],
                                   range * d.y + p->mount[1],
                                   range * d.z + p->mount[2], word};
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

static void count_whole(const lum_line *line, int32_t min_tof,
                        uint32_t *restrict rising, uint32_t *restrict all)
{
    const uint32_t *restrict words = line->words;
    uint32_t r = 0;
    uint32_t n = 0;
    for (uint32_t i = 0; i < line->word_count; i++) {
        const uint32_t has_range =
            lum_word_tof(words[i]) >= min_tof ? 1u : 0u;
        n += has_range;
        r += has_range & (words[i] / LUM_WORD_RISING);
    }
    *rising = r;
    *all = n;
}

static void count_marked(const lum_line *line, int32_t min_tof,
                         uint32_t *rising, uint32_t *all, uint64_t *no_angle)
{
    *rising = 0;
    *all = 0;
    for (uint32_t i = 0; i < line->word_count; i++) {
        const uint32_t word = line->words[i];
        if (!has_angles(line->angle_marks, lum_word_pixel(word))) {
            (*no_angle)++;
        } else if (lum_word_tof(word) >= min_tof) {
            (*all)++;
            *rising += lum_word_is_rising(word) ? 1u : 0u;
        }
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
        count_whole(line, min_tof, &up, &all);
    }
    *rising = up;
    *falling = all - up;
    losses->no_angle += no_angle;
    losses->no_range += line->word_count - all - no_angle;
}
