#include "lum/points.h"

void lum_selection_default(lum_selection *out)
{
    *out =
        (lum_selection){.edges = LUM_EDGES_RISING, .returns = LUM_RETURNS_ALL};
}

/* By edge: the word of the widest pulse, the first among equals, of the pixel
 * whose words begin at i. */
static void find_strongest(const lum_line *line, const lum_return *returns,
                           uint32_t i, uint32_t strongest[2])
{
    const uint32_t pixel = lum_word_pixel(line->words[i]);
    bool found[2] = {false, false};
    for (; i < line->word_count && lum_word_pixel(line->words[i]) == pixel;
         i++) {
        const unsigned edge = lum_word_is_rising(line->words[i]) ? 1 : 0;
        if (!found[edge] ||
            returns[i].width_tof > returns[strongest[edge]].width_tof) {
            found[edge] = true;
            strongest[edge] = i;
        }
    }
}

static bool is_wanted(const lum_selection *s, const lum_return *r,
                      bool is_rising, bool is_strongest)
{
    const unsigned edge = is_rising ? LUM_EDGES_RISING : LUM_EDGES_FALLING;
    if (((unsigned)s->edges & edge) == 0) {
        return false;
    }
    switch (s->returns) {
    case LUM_RETURNS_FIRST:
        return r->number == 1;
    case LUM_RETURNS_LAST:
        return r->number == r->count;
    case LUM_RETURNS_NUMBER:
        return r->number == s->return_number;
    case LUM_RETURNS_STRONGEST:
        return is_strongest;
    case LUM_RETURNS_ALL:
    default:
        return true;
    }
}

static bool is_inside(const lum_selection *s, const lum_sample *p)
{
    if (s->has_range &&
        !(p->range >= s->range_min && p->range <= s->range_max)) {
        return false;
    }
    return !s->has_box || (p->x >= s->box_min[0] && p->x <= s->box_max[0] &&
                           p->y >= s->box_min[1] && p->y <= s->box_max[1] &&
                           p->z >= s->box_min[2] && p->z <= s->box_max[2]);
}

static void fill_sample(const lum_projector *projector, const lum_line *line,
                        const lum_direction *directions, uint32_t i,
                        const lum_return *r, lum_sample *out)
{
    const lum_eye_projector *p = &projector->eye[line->eye];
    const uint32_t word = line->words[i];
    const uint32_t pixel = lum_word_pixel(word);
    const lum_direction d = directions[pixel];
    const float range =
        (float)(lum_word_tof(word) * p->range_lsb + p->range_offset);
    *out = (lum_sample){
        .x = range * d.x + p->mount[0],
        .y = range * d.y + p->mount[1],
        .z = range * d.z + p->mount[2],
        .range = range,
        .azimuth =
            (float)(p->azimuth_center + line->azimuth[pixel] * p->azimuth_deg),
        .elevation = (float)(p->elevation_center +
                             line->elevation[pixel] * p->elevation_deg),
        .pulse_width = (float)(r->width_tof * projector->tof_lsb_ns),
        .pixel = (uint16_t)pixel,
        .return_number = r->number,
        .number_of_returns = r->count,
        .edge = lum_word_is_rising(word) ? 1 : 0,
    };
}

size_t lum_samples_compute(const lum_projector *projector, const lum_line *line,
                           const lum_selection *selection,
                           lum_sample_workspace *workspace, lum_sample *out,
                           lum_point_losses *losses)
{
    const int32_t min_tof = projector->eye[line->eye].min_tof;
    const lum_return *returns = workspace->returns;
    uint32_t strongest[2] = {0, 0};
    uint32_t pixel = LUM_LINE_PIXELS;
    size_t n = 0;
    lum_directions_compute(projector, line, workspace->directions);
    lum_returns_compute(line->words, line->word_count, workspace->returns);
    for (uint32_t i = 0; i < line->word_count; i++) {
        const uint32_t word = line->words[i];
        const bool is_rising = lum_word_is_rising(word);
        if (lum_word_pixel(word) != pixel) {
            pixel = lum_word_pixel(word);
            find_strongest(line, returns, i, strongest);
        }
        if (!lum_line_has_angles(line, pixel)) {
            losses->no_angle++;
        } else if (lum_word_tof(word) < min_tof) {
            losses->no_range++;
        } else if (is_wanted(selection, &returns[i], is_rising,
                             strongest[is_rising ? 1 : 0] == i)) {
            fill_sample(projector, line, workspace->directions, i, &returns[i],
                        &out[n]);
            n += is_inside(selection, &out[n]) ? 1u : 0u;
        }
    }
    return n;
}
