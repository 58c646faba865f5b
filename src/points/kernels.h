/* The loops that are written for each kind of processor. All kinds give the
 * same bits. Internal to points. */
#ifndef LUM_POINTS_KERNELS_H
#define LUM_POINTS_KERNELS_H

#include "columns.h"
#include "lum/image.h"
#include "lum/points.h"
#include "motion.h"
#include "polynomials.h"

#include <stddef.h>
#include <stdint.h>

/* Words that are looked at before they are projected, while they are in the
 * first-level cache. */
#define LUM_POINTS_BLOCK  256u
#define LUM_COLUMNS_BLOCK 512u

/* Which words are asked for: those whose time of flight is not below the least,
 * and that have this value in these bits. */
typedef struct lum_word_choice {
    int32_t min_tof;
    uint32_t mask;
    uint32_t value;
} lum_word_choice;

static inline lum_word_choice lum_word_choice_of(unsigned edges,
                                                 int32_t min_tof)
{
    const uint32_t mask =
        edges == (unsigned)LUM_EDGES_BOTH ? 0 : LUM_WORD_RISING;
    return (lum_word_choice){.min_tof = min_tof,
                             .mask = mask,
                             .value = edges == (unsigned)LUM_EDGES_RISING ? mask
                                                                          : 0};
}

static inline uint32_t lum_word_is_chosen(const lum_word_choice *c,
                                          uint32_t word)
{
    const uint32_t has_range = lum_word_tof(word) >= c->min_tof ? 1u : 0u;
    return (word & c->mask) == c->value ? has_range : 0;
}

/* What columns are made of. */
typedef struct lum_column_source {
    const uint32_t *words;
    const float *ranges; /* of each word */
    uint32_t count;
    const lum_direction *directions; /* of the line's pixels */
    const float *mount;
} lum_column_source;

/* What the columns of degrees and integers are made of. */
typedef struct lum_column_numbers {
    const uint32_t *words;
    const lum_return *returns; /* of each word; NULL: not needed */
    uint32_t count;
    const float *azimuth; /* of the line's pixels, in degrees */
    const float *elevation;
    double tof_lsb_ns;
} lum_column_numbers;

typedef struct lum_kernels {
    const char *name;

    /* LUM_LINE_PIXELS directions. */
    void (*directions)(const lum_polynomials *polynomials,
                       const lum_angle *angles, lum_direction *out);

    /* How many of n words have a time of flight below min_tof; rising gets how
     * many of the others are of rising edges. */
    uint32_t (*count_below)(const uint32_t *words, uint32_t n, int32_t min_tof,
                            uint32_t *rising);

    /* The words of n that are asked for, in their order; their number. What is
     * behind them in the n places of out is of no use. */
    uint32_t (*choose)(const lum_word_choice *choice, const uint32_t *words,
                       uint32_t n, uint32_t *out);

    /* The points of up to LUM_POINTS_BLOCK words, all of which give one. */
    void (*points)(const lum_eye_projector *eye, const uint32_t *words,
                   uint32_t n, const lum_direction *directions, lum_point *out);

    /* The ranges of n words, computed in double. */
    void (*ranges)(const lum_eye_projector *eye, const uint32_t *words,
                   uint32_t n, float *out);

    /* The coordinates of up to LUM_COLUMNS_BLOCK words with these ranges. */
    void (*columns)(const lum_column_source *from, float *x, float *y,
                    float *z);

    /* Degrees, pulse widths, pixels, edges, and numbers of returns, as far as
     * there are places for them. */
    void (*numbers)(const lum_column_numbers *from,
                    const lum_column_places *to);

    /* As those of motion.h. */
    void (*times)(float *pixels, size_t n, int64_t from_ns, int64_t period_ns);
    size_t (*count)(const lum_motion *motion, const float *time, size_t n);
    void (*move)(const lum_motion *motion, const lum_motion_points *from,
                 size_t n, float *const out[3]);

    /* lum_image_pixels() */
    void (*pixels)(const lum_image_scale *scale, const float *x, const float *y,
                   const float *z, size_t n, uint32_t *out);
} lum_kernels;

/* What vectors/ has for the target at all: it needs gcc 12 or
 * clang, numbers whose lowest byte is first, and an operating system that keeps
 * the registers. gcc's code for Windows does not align the stack as wider
 * vectors need it (its bug 54412). LUM_PLAIN_POINTS leaves plain C alone, for
 * what measures tests. */
#if defined(__has_builtin) && __STDC_HOSTED__ && !defined(LUM_PLAIN_POINTS)
#if __has_builtin(__builtin_shufflevector) &&                                  \
    __has_builtin(__builtin_convertvector)
#if defined(__x86_64__)
#define LUM_HAS_SSE2
#if defined(__clang__) || !defined(_WIN32)
#define LUM_HAS_WIDE
#endif
#elif defined(__aarch64__) && !defined(__AARCH64EB__)
#define LUM_HAS_NEON
#endif
#endif
#endif
#if defined(LUM_HAS_SSE2) || defined(LUM_HAS_NEON)
#define LUM_HAS_KERNELS
#endif

void lum_plain_directions(const lum_polynomials *polynomials,
                          const lum_angle *angles, lum_direction *out);
uint32_t lum_plain_count_below(const uint32_t *words, uint32_t n,
                               int32_t min_tof, uint32_t *rising);
uint32_t lum_plain_choose(const lum_word_choice *choice, const uint32_t *words,
                          uint32_t n, uint32_t *out);
void lum_plain_points(const lum_eye_projector *eye, const uint32_t *words,
                      uint32_t n, const lum_direction *directions,
                      lum_point *out);
void lum_plain_ranges(const lum_eye_projector *eye, const uint32_t *words,
                      uint32_t n, float *out);
void lum_plain_columns(const lum_column_source *from, float *x, float *y,
                       float *z);
void lum_plain_numbers(const lum_column_numbers *from,
                       const lum_column_places *to);
void lum_plain_times(float *pixels, size_t n, int64_t from_ns,
                     int64_t period_ns);
size_t lum_plain_count(const lum_motion *motion, const float *time, size_t n);
void lum_plain_move(const lum_motion *motion, const lum_motion_points *from,
                    size_t n, float *const out[3]);
void lum_plain_pixels(const lum_image_scale *scale, const float *x,
                      const float *y, const float *z, size_t n, uint32_t *out);

#define LUM_KERNELS_MAX 4u

/* Those that this processor can run, the widest first and plain C last; their
 * number. */
size_t lum_kernels_list(const lum_kernels *out[LUM_KERNELS_MAX]);

#if defined(LUM_HAS_KERNELS)
extern const lum_kernels lum_kernels_4; /* lanes: SSE2 or NEON */
#if defined(LUM_HAS_WIDE)
extern const lum_kernels lum_kernels_8;  /* AVX2 */
extern const lum_kernels lum_kernels_16; /* AVX-512 */
#endif

/* The first of the list, or the one that LUM_CPU in the environment names. The
 * choice is made once. Safe from any thread. */
const lum_kernels *lum_kernels_choose(void);

#define LUM_BEST(loop) (lum_kernels_choose()->loop)
#else
#define LUM_BEST(loop) lum_plain_##loop
#endif

#endif
