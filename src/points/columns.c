#include "columns.h"

#include "column_loops.h"
#include "kernels.h"

#include <string.h>

/* Number of words in a block. The columns of a block are made one after
 * another, while its words are in the first-level cache. */
#define BLOCK LUM_COLUMNS_BLOCK

/* Words that all give a requested point. */
struct chunk {
    const uint32_t *words;
    const lum_return *returns; /* of each; NULL: not needed */
    const uint8_t *strongest;  /* likewise */
    uint32_t count;
};

/* Where the chosen words are collected. */
struct gathered {
    uint32_t words[BLOCK];
    lum_return returns[BLOCK];
    uint8_t strongest[BLOCK];
};

/* --- What columns share --- */

void lum_column_work_begin(lum_column_work *work)
{
    work->has_directions = false;
    work->has_degrees = false;
    work->has_returns = false;
    work->has_strongest = false;
}

/* Angles in degrees, of the pixels that have any. */
static void compute_degrees(const lum_eye_projector *eye, const lum_line *line,
                            lum_column_work *work)
{
    for (unsigned i = 0; i < LUM_LINE_PIXELS; i++) {
        work->azimuth[i] = (float)(eye->azimuth_center +
                                   line->angles[i].azimuth * eye->azimuth_deg);
        work->elevation[i] =
            (float)(eye->elevation_center +
                    line->angles[i].elevation * eye->elevation_deg);
    }
}

/* The widest pulse of each pixel and edge is marked, the first among equals. */
static void mark_strongest(const lum_line *line, const lum_return *returns,
                           uint8_t *restrict marks)
{
    const uint32_t *words = line->words;
    const uint32_t n = line->word_count;
    uint32_t widest[2] = {0, 0}; /* of the pixel so far, by edge */
    for (uint32_t i = 0; i < n; i++) {
        uint32_t *w = &widest[lum_word_is_rising(words[i]) ? 1 : 0];
        if (returns[i].number == 1u) {
            marks[i] = 1;
            *w = i;
        } else if (returns[i].width_tof > returns[*w].width_tof) {
            marks[*w] = 0;
            marks[i] = 1;
            *w = i;
        } else {
            marks[i] = 0;
        }
    }
}

static bool needs_returns(const lum_column_places *p)
{
    return p->pulse_width != NULL || p->return_number != NULL ||
           p->number_of_returns != NULL || p->strongest != NULL;
}

/* Computes what the columns are made of, unless it is there already. */
static void prepare(const lum_column_line *l, lum_column_work *work,
                    const lum_column_places *p)
{
    const lum_line *line = l->line;
    if (!work->has_directions &&
        (p->x != NULL || p->y != NULL || p->z != NULL)) {
        lum_directions_compute(l->projector, line, work->samples.directions);
        work->has_directions = true;
    }
    if (!work->has_degrees && (p->azimuth != NULL || p->elevation != NULL)) {
        compute_degrees(&l->projector->eye[line->eye], line, work);
        work->has_degrees = true;
    }
    if (!work->has_returns && needs_returns(p)) {
        lum_returns_compute(line->words, line->word_count,
                            work->samples.returns);
        work->has_returns = true;
    }
    if (!work->has_strongest && p->strongest != NULL) {
        mark_strongest(line, work->samples.returns, work->strongest);
        work->has_strongest = true;
    }
}

/* --- Coordinates --- */

void lum_plain_columns(const lum_column_source *from, float *x, float *y,
                       float *z)
{
    const float *mount = from->mount;
    for (uint32_t i = 0; i < from->count; i++) {
        const float range = from->ranges[i];
        const lum_direction *d =
            &from->directions[lum_word_pixel(from->words[i])];
        x[i] = range * d->x + mount[0];
        y[i] = range * d->y + mount[1];
        z[i] = range * d->z + mount[2];
    }
}

/* Range, and x y z; those that were not requested are not kept. */
static void put_space(const lum_eye_projector *eye, const struct chunk *c,
                      const lum_column_work *work, const lum_column_places *p)
{
    float own[BLOCK];
    float nowhere[BLOCK];
    float *ranges = p->range != NULL ? p->range : own;
    if (p->range == NULL && p->x == NULL && p->y == NULL && p->z == NULL) {
        return;
    }
    LUM_BEST(ranges)(eye, c->words, c->count, ranges);
    if (p->x != NULL || p->y != NULL || p->z != NULL) {
        const lum_column_source from = {c->words, ranges, c->count,
                                        work->samples.directions, eye->mount};
        LUM_BEST(columns)
        (&from, p->x != NULL ? p->x : nowhere, p->y != NULL ? p->y : nowhere,
         p->z != NULL ? p->z : nowhere);
    }
}

/* --- Other columns, and chunks --- */

void lum_plain_numbers(const lum_column_numbers *from,
                       const lum_column_places *to)
{
    lum_numbers_loop(from, to);
}

#define MOVE_ON(place, n) ((place) = (place) != NULL ? (place) + (n) : NULL)

static void move_on(lum_column_places *p, size_t n)
{
    MOVE_ON(p->x, n);
    MOVE_ON(p->y, n);
    MOVE_ON(p->z, n);
    MOVE_ON(p->range, n);
    MOVE_ON(p->azimuth, n);
    MOVE_ON(p->elevation, n);
    MOVE_ON(p->pulse_width, n);
    MOVE_ON(p->pixel, n);
    MOVE_ON(p->return_number, n);
    MOVE_ON(p->number_of_returns, n);
    MOVE_ON(p->edge, n);
    MOVE_ON(p->strongest, n);
}

static void put_chunk(const lum_column_line *l, const struct chunk *c,
                      const lum_column_work *work, lum_column_places *p)
{
    const lum_column_numbers numbers = {.words = c->words,
                                        .returns = c->returns,
                                        .count = c->count,
                                        .azimuth = work->azimuth,
                                        .elevation = work->elevation,
                                        .tof_lsb_ns = l->projector->tof_lsb_ns};
    put_space(&l->projector->eye[l->line->eye], c, work, p);
    LUM_BEST(numbers)(&numbers, p);
    if (c->strongest != NULL) {
        memcpy(p->strongest, c->strongest, c->count);
    }
    move_on(p, c->count);
}

/* Which words give a requested point. */
struct sieve {
    const lum_line *line;
    lum_word_choice choice;
    bool all; /* all of them do */
};

/* --- Selections --- */

/* A word that was not chosen is overwritten by the next, which is faster than a
 * branch that nobody can predict. */
uint32_t lum_plain_choose(const lum_word_choice *choice, const uint32_t *words,
                          uint32_t n, uint32_t *restrict out)
{
    const lum_word_choice own = *choice;
    uint32_t count = 0;
    for (uint32_t i = 0; i < n; i++) {
        out[count] = words[i];
        count += lum_word_is_chosen(&own, words[i]);
    }
    return count;
}

/* Where the chosen words are, of pixels that have angles. */
static uint32_t find_chosen(const struct sieve *s, const struct chunk *from,
                            uint16_t *places)
{
    const uint32_t *marks = s->line->angle_marks;
    const bool is_whole = s->line->angle_count == LUM_LINE_PIXELS;
    uint32_t n = 0;
    for (uint32_t i = 0; i < from->count; i++) {
        const uint32_t pixel = lum_word_pixel(from->words[i]);
        places[n] = (uint16_t)i;
        n += lum_word_is_chosen(&s->choice, from->words[i]) &
             (is_whole ? 1u : marks[pixel / 32u] >> pixel % 32u);
    }
    return n;
}

static void take_places(const struct chunk *from, const uint16_t *places,
                        uint32_t n, struct gathered *to)
{
    for (uint32_t i = 0; i < n; i++) {
        to->words[i] = from->words[places[i]];
    }
    for (uint32_t i = 0; from->returns != NULL && i < n; i++) {
        to->returns[i] = from->returns[places[i]];
    }
    for (uint32_t i = 0; from->strongest != NULL && i < n; i++) {
        to->strongest[i] = from->strongest[places[i]];
    }
}

static void gather(const struct sieve *s, const struct chunk *from,
                   struct gathered *to, struct chunk *out)
{
    uint32_t n = 0;
    if (s->line->angle_count == LUM_LINE_PIXELS && from->returns == NULL) {
        n = LUM_BEST(choose)(&s->choice, from->words, from->count, to->words);
    } else {
        uint16_t places[BLOCK] = {0}; /* so that the analyser follows */
        n = find_chosen(s, from, places);
        take_places(from, places, n, to);
    }
    *out = (struct chunk){to->words, from->returns != NULL ? to->returns : NULL,
                          from->strongest != NULL ? to->strongest : NULL, n};
}

static size_t put_words(const lum_column_line *l, const struct sieve *sieve,
                        const lum_column_work *work, lum_column_places *p)
{
    const lum_line *line = l->line;
    struct gathered gathered;
    size_t count = 0;
    for (uint32_t at = 0; at < line->word_count; at += BLOCK) {
        const uint32_t left = line->word_count - at;
        struct chunk c = {
            line->words + at,
            needs_returns(p) ? work->samples.returns + at : NULL,
            p->strongest != NULL ? work->strongest + at : NULL,
            left < BLOCK ? left : BLOCK,
        };
        if (!sieve->all) {
            const struct chunk from = c;
            gather(sieve, &from, &gathered, &c);
        }
        put_chunk(l, &c, work, p);
        count += c.count;
    }
    return count;
}

/* --- All columns of a line --- */

/* Samples are in the order of the words, so the word of each sample is
 * ahead. */
static void put_strongest(const lum_line *line, const lum_column_work *work,
                          size_t n, uint8_t *out)
{
    const lum_return *returns = work->samples.returns;
    uint32_t at = 0;
    for (size_t i = 0; i < n; i++) {
        const lum_sample *s = &work->sample[i];
        while (lum_word_pixel(line->words[at]) != s->pixel ||
               lum_word_is_rising(line->words[at]) != (s->edge != 0) ||
               returns[at].number != s->return_number) {
            at++;
        }
        out[i] = work->strongest[at];
    }
}

#define PUT(place, field)                                                      \
    for (size_t i = 0; (place) != NULL && i < n; i++) {                        \
        (place)[i] = s[i].field;                                               \
    }

static void put_floats(const lum_sample *s, size_t n,
                       const lum_column_places *p)
{
    PUT(p->x, x)
    PUT(p->y, y)
    PUT(p->z, z)
    PUT(p->range, range)
    PUT(p->azimuth, azimuth)
    PUT(p->elevation, elevation)
    PUT(p->pulse_width, pulse_width)
}

static void put_integers(const lum_sample *s, size_t n,
                         const lum_column_places *p)
{
    PUT(p->pixel, pixel)
    PUT(p->return_number, return_number)
    PUT(p->number_of_returns, number_of_returns)
    PUT(p->edge, edge)
}

/* For selections that need whole samples. */
static size_t put_samples(const lum_column_line *l,
                          const lum_selection *selection, lum_column_work *work,
                          const lum_column_places *p)
{
    const bool needs =
        needs_returns(p) || selection->returns != LUM_RETURNS_ALL;
    unsigned leaves = 0;
    if (!needs) {
        leaves |= LUM_LEAVE_RETURNS;
    }
    if (p->azimuth == NULL && p->elevation == NULL) {
        leaves |= LUM_LEAVE_DEGREES;
    }
    const size_t n = lum_samples_make(l->projector, l->line, selection, leaves,
                                      &work->samples, work->sample);
    work->has_directions = true;
    work->has_returns = work->has_returns || needs;
    put_floats(work->sample, n, p);
    put_integers(work->sample, n, p);
    if (p->strongest != NULL) {
        prepare(l, work, &(lum_column_places){.strongest = p->strongest});
        put_strongest(l->line, work, n, p->strongest);
    }
    return n;
}

size_t lum_columns_compute(const lum_column_line *line,
                           const lum_selection *selection,
                           lum_column_work *work,
                           const lum_column_places *places)
{
    const unsigned edges = (unsigned)selection->edges;
    const uint64_t wanted =
        ((edges & LUM_EDGES_RISING) != 0 ? line->rising : 0) +
        ((edges & LUM_EDGES_FALLING) != 0 ? line->falling : 0);
    lum_column_places to = *places;
    if (selection->has_range || selection->has_box ||
        selection->returns != LUM_RETURNS_ALL) {
        return put_samples(line, selection, work, places);
    }
    const struct sieve sieve = {
        .line = line->line,
        .choice = lum_word_choice_of(
            edges, line->projector->eye[line->line->eye].min_tof),
        .all = wanted == line->line->word_count};
    prepare(line, work, places);
    return put_words(line, &sieve, work, &to);
}
