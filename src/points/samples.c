/* Words to samples: points with their range, angles, width and return
 * numbers. */
#include "lum/points.h"

#include "columns.h"
#include "coordinates.h"
#include "kernels.h"

void lum_selection_default(lum_selection *out)
{
    *out =
        (lum_selection){.edges = LUM_EDGES_RISING, .returns = LUM_RETURNS_ALL};
}

/* The word of the widest pulse of a pixel and edge, the first among equals,
 * among the words of the line read so far. */
struct strongest {
    uint32_t end;     /* of the pixel's words */
    uint32_t word[2]; /* by edge: falling, rising */
};

static void find_strongest(const lum_line *line, const lum_return *returns,
                           uint32_t i, struct strongest *out)
{
    const uint32_t pixel = lum_word_pixel(line->words[i]);
    bool found[2] = {false, false};
    for (; i < line->word_count && lum_word_pixel(line->words[i]) == pixel;
         i++) {
        const unsigned edge = lum_word_is_rising(line->words[i]) ? 1 : 0;
        if (!found[edge] ||
            returns[i].width_tof > returns[out->word[edge]].width_tof) {
            found[edge] = true;
            out->word[edge] = i;
        }
    }
    out->end = i;
}

static bool is_strongest(const lum_line *line, const lum_return *returns,
                         uint32_t i, struct strongest *strongest)
{
    /* words that are not requested are skipped, so the first requested word of
     * this pixel may not be its first word */
    uint32_t first = i;
    if (i >= strongest->end) {
        const uint32_t pixel = lum_word_pixel(line->words[i]);
        while (first > strongest->end &&
               lum_word_pixel(line->words[first - 1u]) == pixel) {
            first--;
        }
        find_strongest(line, returns, first, strongest);
    }
    return strongest->word[lum_word_is_rising(line->words[i]) ? 1 : 0] == i;
}

static bool is_chosen(const lum_selection *s, const lum_line *line,
                      const lum_return *returns, uint32_t i,
                      struct strongest *strongest)
{
    switch (s->returns) {
    case LUM_RETURNS_FIRST:
        return returns[i].number == 1;
    case LUM_RETURNS_LAST:
        return returns[i].number == returns[i].count;
    case LUM_RETURNS_NUMBER:
        return returns[i].number == s->return_number;
    case LUM_RETURNS_STRONGEST:
        return is_strongest(line, returns, i, strongest);
    case LUM_RETURNS_ALL:
    default:
        return true;
    }
}

static inline bool is_between(float value, float min, float max)
{
    return value >= min && value <= max;
}

static bool is_inside(const lum_selection *s, const lum_sample *p)
{
    if (s->has_range && !is_between(p->range, s->range_min, s->range_max)) {
        return false;
    }
    return !s->has_box || (is_between(p->x, s->box_min[0], s->box_max[0]) &&
                           is_between(p->y, s->box_min[1], s->box_max[1]) &&
                           is_between(p->z, s->box_min[2], s->box_max[2]));
}

/* What all samples of a line are made with. */
struct maker {
    const lum_direction *directions;
    const lum_angle *angles;
    lum_eye_projector eye;
    lum_direction mount;
    double tof_lsb_ns;
    lum_word_choice choice;
    bool is_whole;
    bool has_degrees;
    bool has_returns;
    const lum_return *returns; /* of the words, if it has them */
};

static struct maker make_maker(const lum_projector *projector,
                               const lum_line *line,
                               const lum_selection *selection, unsigned leaves,
                               const lum_sample_workspace *workspace)
{
    const lum_eye_projector *eye = &projector->eye[line->eye];
    return (struct maker){
        .directions = workspace->directions,
        .angles = line->angles,
        .eye = *eye,
        .mount = {eye->mount[0], eye->mount[1], eye->mount[2], 0.0f},
        .tof_lsb_ns = projector->tof_lsb_ns,
        .choice = lum_word_choice_of((unsigned)selection->edges, eye->min_tof),
        .is_whole = line->angle_count == LUM_LINE_PIXELS,
        .has_degrees = (leaves & LUM_LEAVE_DEGREES) == 0,
        .has_returns = (leaves & LUM_LEAVE_RETURNS) == 0 ||
                       selection->returns != LUM_RETURNS_ALL,
        .returns = workspace->returns};
}

static inline void fill_sample(const struct maker *m, uint32_t word,
                               float range, const lum_return *r,
                               lum_sample *restrict out)
{
    const uint32_t pixel = lum_word_pixel(word);
    lum_put_lanes(&out->x, range, &m->directions[pixel], &m->mount);
    out->range = range; /* in the place of the fourth number */
    if (m->has_degrees) {
        out->azimuth = (float)(m->eye.azimuth_center +
                               m->angles[pixel].azimuth * m->eye.azimuth_deg);
        out->elevation =
            (float)(m->eye.elevation_center +
                    m->angles[pixel].elevation * m->eye.elevation_deg);
    }
    if (m->has_returns) {
        out->pulse_width = (float)(r->width_tof * m->tof_lsb_ns);
        out->return_number = r->number;
        out->number_of_returns = r->count;
    }
    out->pixel = (uint16_t)pixel;
    out->edge = lum_word_is_rising(word) ? 1 : 0;
    out->pad = 0;
}

/* Words that are looked at together: what is made of them stays in the
 * first-level cache. */
#define BLOCK 256u

/* Those that give a point. */
struct chosen {
    uint32_t words[BLOCK];
    lum_return returns[BLOCK];
    uint32_t count;
};

/* A word that is not chosen is overwritten by the next, which is faster than a
 * branch that nobody can predict. */
static void choose(const struct maker *m, const uint32_t *words, uint32_t n,
                   const lum_return *returns, struct chosen *out)
{
    uint32_t count = 0;
    if (!m->has_returns) {
        out->count = LUM_BEST(choose)(&m->choice, words, n, out->words);
        return;
    }
    for (uint32_t i = 0; i < n; i++) {
        out->words[count] = words[i];
        out->returns[count] = returns[i];
        count += lum_word_is_chosen(&m->choice, words[i]);
    }
    out->count = count;
}

static void leave_out_without_angles(const lum_line *line, struct chosen *c)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < c->count; i++) {
        c->words[count] = c->words[i];
        c->returns[count] = c->returns[i];
        count +=
            lum_line_has_angles(line, lum_word_pixel(c->words[i])) ? 1u : 0u;
    }
    c->count = count;
}

/* Samples of all returns, without limits. */
static size_t put_all(const struct maker *m, const lum_line *line,
                      lum_sample *out)
{
    struct chosen chosen;
    float ranges[BLOCK];
    lum_sample *to = out;
    for (uint32_t at = 0; at < line->word_count; at += BLOCK) {
        const uint32_t left = line->word_count - at;
        choose(m, line->words + at, left < BLOCK ? left : BLOCK,
               m->returns + at, &chosen);
        if (!m->is_whole) {
            leave_out_without_angles(line, &chosen);
        }
        LUM_BEST(ranges)(&m->eye, chosen.words, chosen.count, ranges);
        for (uint32_t i = 0; i < chosen.count; i++) {
            fill_sample(m, chosen.words[i], ranges[i], &chosen.returns[i],
                        to++);
        }
    }
    return (size_t)(to - out);
}

/* Whether a word is of an edge that is asked for and gives a point. */
static inline bool gives_point(const struct maker *m, const lum_line *line,
                               uint32_t word)
{
    return lum_word_is_chosen(&m->choice, word) != 0 &&
           (m->is_whole || lum_line_has_angles(line, lum_word_pixel(word)));
}

/* Samples of some returns, or within limits. */
static size_t put_selected(const struct maker *m, const lum_line *line,
                           const lum_selection *selection, lum_sample *out)
{
    const bool has_limits = selection->has_range || selection->has_box;
    struct strongest strongest = {.end = 0};
    lum_sample *to = out;
    for (uint32_t i = 0; i < line->word_count; i++) {
        const uint32_t word = line->words[i];
        if (gives_point(m, line, word) &&
            is_chosen(selection, line, m->returns, i, &strongest)) {
            float range = 0.0f;
            lum_plain_ranges(&m->eye, &word, 1, &range);
            fill_sample(m, word, range, &m->returns[i], to);
            to += !has_limits || is_inside(selection, to) ? 1 : 0;
        }
    }
    return (size_t)(to - out);
}

static void count_losses(const lum_projector *projector, const lum_line *line,
                         lum_point_losses *losses)
{
    uint64_t rising = 0;
    uint64_t falling = 0;
    lum_points_count(projector, line, &rising, &falling, losses);
}

size_t lum_samples_make(const lum_projector *projector, const lum_line *line,
                        const lum_selection *selection, unsigned leaves,
                        lum_sample_workspace *workspace, lum_sample *out)
{
    const struct maker maker =
        make_maker(projector, line, selection, leaves, workspace);
    const bool takes_all = selection->returns == LUM_RETURNS_ALL &&
                           !selection->has_range && !selection->has_box;
    lum_directions_compute(projector, line, workspace->directions);
    if (maker.has_returns) {
        lum_returns_compute(line->words, line->word_count, workspace->returns);
    }
    return takes_all ? put_all(&maker, line, out)
                     : put_selected(&maker, line, selection, out);
}

size_t lum_samples_compute(const lum_projector *projector, const lum_line *line,
                           const lum_selection *selection,
                           lum_sample_workspace *workspace, lum_sample *out,
                           lum_point_losses *losses)
{
    if (losses != NULL) {
        count_losses(projector, line, losses);
    }
    return lum_samples_make(projector, line, selection, 0, workspace, out);
}
