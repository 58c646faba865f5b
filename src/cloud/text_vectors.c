/* Rows of text by AVX2. The eight numbers of a row, from x to pixel, are made
 * at once: each is an integer of eight digits, three before the point and five
 * behind it. A table says for each length and sign where the digits, the point,
 * the sign and the separator stand. */
#include "text_columns.h"

#if defined(__x86_64__) && defined(__GNUC__) &&                                \
    (defined(__clang__) || !defined(_WIN32))

#include <immintrin.h>

#define VECTORS static inline __attribute__((target("avx2"), always_inline))

bool lum_text_has_vectors(void)
{
    return strncmp(lum_points_vectors(), "avx", 3) == 0;
}

/* --- What stands where --- */

/* Without and with a sign: 1 to 3 digits before the point. */
#define SHAPES 6u

/* The places of bytes behind the eight digits. */
#define DOT  8
#define SEP  9
#define SIGN 10

/* The length of a text stands behind its bytes. */
#define LENGTH_AT 15

#define SHAPE(length, ...)                                                     \
    {                                                                          \
        __VA_ARGS__, [LENGTH_AT] = (length)                                    \
    }
#define DECIMALS(behind, ...)                                                  \
    SHAPE((behind) + 1, 2, __VA_ARGS__),                                       \
        SHAPE((behind) + 2, 1, 2, __VA_ARGS__),                                \
        SHAPE((behind) + 3, 0, 1, 2, __VA_ARGS__),                             \
        SHAPE((behind) + 2, SIGN, 2, __VA_ARGS__),                             \
        SHAPE((behind) + 3, SIGN, 1, 2, __VA_ARGS__),                          \
        SHAPE((behind) + 4, SIGN, 0, 1, 2, __VA_ARGS__)

static const uint8_t shapes[4u * SHAPES][16] = {
    DECIMALS(1, SEP), DECIMALS(5, DOT, 3, 4, 5, SEP),
    DECIMALS(6, DOT, 3, 4, 5, 6, SEP), DECIMALS(7, DOT, 3, 4, 5, 6, 7, SEP)};

/* Where the shapes of numbers with so many decimals begin. */
#define SHAPES_OF(decimals) ((int)(((decimals)-2u) * SHAPES))
#define SHAPES_OF_COUNTS    0

/* --- Numbers of a row --- */

/* The numbers, in the order in which vectors leave their digits. */
enum {
    X,
    Y,
    AZIMUTH,
    ELEVATION,
    Z,
    RANGE,
    WIDTH,
    PIXEL,
    NUMBERS
};

/* They are made of a few rows, then put together: each of the two loops has the
 * registers that it needs. */
#define BLOCK 16u

struct numbers {
    uint8_t digits[NUMBERS][8];
    uint32_t shape[NUMBERS]; /* where it begins in the table, in bytes */
};

/* An integer for x, y, z and range, then for azimuth, elevation, pulse width
 * and pixel: the order of a sample. */
#define FOR_EACH(metres, degrees, width, pixel)                                \
    _mm256_setr_epi32(metres, metres, metres, metres, degrees, degrees, width, \
                      pixel)

VECTORS __m256i load_sample(const lum_sample *sample)
{
    const void *from = sample;
    return _mm256_loadu_si256((const __m256i *)from);
}

/* What of a sample is a number: no signs, and the pixel alone. */
VECTORS __m256i magnitudes(__m256i sample)
{
    return _mm256_and_si256(
        sample, FOR_EACH(0x7fffffff, 0x7fffffff, 0x7fffffff, 0xffff));
}

VECTORS bool are_short(__m256i numbers)
{
    const __m256i most =
        FOR_EACH(LUM_BITS_OF_999, LUM_BITS_OF_999, LUM_BITS_OF_999, 999);
    const __m256i longer = _mm256_cmpgt_epi32(numbers, most);
    return _mm256_testz_si256(longer, longer) != 0;
}

/* As in lum_put_column(). */
VECTORS __m128i round_four(__m128 v, __m256d unit)
{
    const __m256d scaled = _mm256_mul_pd(_mm256_cvtps_pd(v), unit);
    return _mm256_cvttpd_epi32(_mm256_add_pd(scaled, _mm256_set1_pd(0.5)));
}

/* In units of their last decimals. */
VECTORS __m256i to_integers(__m256i numbers)
{
    const __m256i is_pixel = FOR_EACH(0, 0, 0, -1);
    const __m256 floats =
        _mm256_castsi256_ps(_mm256_andnot_si256(is_pixel, numbers));
    const __m128i space =
        round_four(_mm256_castps256_ps128(floats), _mm256_set1_pd(1e4));
    const __m128i others = round_four(_mm256_extractf128_ps(floats, 1),
                                      _mm256_setr_pd(1e5, 1e5, 1e3, 0.0));
    return _mm256_or_si256(_mm256_set_m128i(others, space),
                           _mm256_and_si256(is_pixel, numbers));
}

/* Divides by 10,000, for 32 bits. */
VECTORS __m256i by_10000(__m256i v)
{
    const __m256i factor = _mm256_set1_epi64x(0xd1b71759);
    const __m256i even = _mm256_srli_epi64(_mm256_mul_epu32(v, factor), 45);
    const __m256i odd = _mm256_srli_epi64(
        _mm256_mul_epu32(_mm256_srli_epi64(v, 32), factor), 45);
    return _mm256_or_si256(even, _mm256_slli_epi64(odd, 32));
}

/* Of numbers of 16 bits, below 100: the first digit is the lower byte. The
 * product is of bytes, because gcc makes shifts and sums of others. */
VECTORS __m256i two_digits(__m256i v)
{
    const __m256i tens = _mm256_mulhi_epu16(v, _mm256_set1_epi16(6554));
    const __m256i ones =
        _mm256_sub_epi16(v, _mm256_maddubs_epi16(tens, _mm256_set1_epi16(10)));
    return _mm256_or_si256(_mm256_or_si256(tens, _mm256_slli_epi16(ones, 8)),
                           _mm256_set1_epi8('0'));
}

VECTORS void put_digits(__m256i v, struct numbers *out)
{
    const __m256i high = by_10000(v);
    const __m256i low =
        _mm256_sub_epi32(v, _mm256_madd_epi16(high, _mm256_set1_epi32(10000)));
    const __m256i fours = _mm256_or_si256(high, _mm256_slli_epi32(low, 16));
    const __m256i hundreds = _mm256_srli_epi16(
        _mm256_mulhi_epu16(fours, _mm256_set1_epi16(5243)), 3);
    const __m256i rest = _mm256_sub_epi16(
        fours, _mm256_maddubs_epi16(hundreds, _mm256_set1_epi16(100)));
    void *lower = out->digits[X];
    void *upper = out->digits[Z];
    _mm256_storeu_si256((__m256i *)lower,
                        two_digits(_mm256_unpacklo_epi16(hundreds, rest)));
    _mm256_storeu_si256((__m256i *)upper,
                        two_digits(_mm256_unpackhi_epi16(hundreds, rest)));
}

/* v has five decimals. is_negative and what is compared are -1 where they
 * hold. */
VECTORS void put_shapes(__m256i v, __m256i is_negative, struct numbers *out)
{
    const __m256i first =
        FOR_EACH(SHAPES_OF(LUM_METRE_DECIMALS), SHAPES_OF(LUM_DEGREE_DECIMALS),
                 SHAPES_OF(LUM_WIDTH_DECIMALS), SHAPES_OF_COUNTS);
    const __m256i of_sign =
        _mm256_and_si256(is_negative, _mm256_set1_epi32(SHAPES / 2u));
    const __m256i longer =
        _mm256_add_epi32(_mm256_cmpgt_epi32(v, _mm256_set1_epi32(999999)),
                         _mm256_cmpgt_epi32(v, _mm256_set1_epi32(9999999)));
    const __m256i shape =
        _mm256_sub_epi32(_mm256_add_epi32(first, of_sign), longer);
    void *to = out->shape;
    _mm256_storeu_si256((__m256i *)to, _mm256_permute4x64_epi64(
                                           _mm256_slli_epi32(shape, 4), 0xd8));
}

/* A pixel has no sign: where that would be are bits of the return, which are
 * 0. */
VECTORS void make_numbers(__m256i sample, struct numbers *out)
{
    const __m256i v = to_integers(magnitudes(sample));
    const __m256i is_negative =
        _mm256_and_si256(_mm256_srai_epi32(sample, 31),
                         _mm256_cmpgt_epi32(v, _mm256_setzero_si256()));
    const __m256i with_five =
        _mm256_mullo_epi32(v, FOR_EACH(10, 1, 100, 100000));
    put_digits(with_five, out);
    put_shapes(with_five, is_negative, out);
}

/* The columns of a return, 16 bits each, the edge and the padding. */
VECTORS uint64_t return_of(const lum_sample *sample)
{
    uint64_t v;
    memcpy(&v, &sample->pixel, sizeof v);
    return v >> 16;
}

/* Whether each has one digit: then neither it nor 6 more needs a fifth bit. */
VECTORS bool is_short_return(uint64_t v)
{
    return ((v | (v + 0x60006)) & 0xfffefff0fff0) == 0;
}

/* Returns how many rows it is: up to the first that is too long. */
VECTORS size_t make_block(const lum_sample *samples, size_t n,
                          struct numbers out[BLOCK])
{
    const size_t most = n < BLOCK ? n : BLOCK;
    size_t i = 0;
    for (; i < most; i++) {
        const __m256i sample = load_sample(&samples[i]);
        if (!are_short(magnitudes(sample)) ||
            !is_short_return(return_of(&samples[i]))) {
            break;
        }
        make_numbers(sample, &out[i]);
    }
    return i;
}

/* --- Rows --- */

/* digits: those of the number, in front of the bytes that the table names. */
VECTORS char *put_number(char *p, uint32_t shape, __m128i digits)
{
    const void *table = shapes;
    const uint8_t *of_shape = (const uint8_t *)table + shape;
    const void *from = of_shape;
    void *to = p;
    _mm_storeu_si128(
        (__m128i *)to,
        _mm_shuffle_epi8(digits, _mm_loadu_si128((const __m128i *)from)));
    return p + of_shape[LENGTH_AT];
}

/* Digits of a number and the next. */
VECTORS __m128i digits_from(const struct numbers *n, unsigned i)
{
    const void *from = n->digits[i];
    return _mm_loadu_si128((const __m128i *)from);
}

VECTORS char *put_first(char *p, const struct numbers *n, unsigned i,
                        __m128i others)
{
    return put_number(p, n->shape[i],
                      _mm_unpacklo_epi64(digits_from(n, i), others));
}

VECTORS char *put_second(char *p, const struct numbers *n, unsigned i,
                         __m128i others)
{
    return put_number(p, n->shape[i],
                      _mm_unpackhi_epi64(digits_from(n, i - 1u), others));
}

/* Digits, separators and the end of the row are added at once. */
VECTORS char *put_return(char *p, uint64_t v, char separator)
{
    const uint64_t gaps = 0x1000100 * (uint64_t)(unsigned char)separator;
    lum_put_eight(p, v + (gaps | 0x0a3000300030));
    return p + 6;
}

VECTORS char *put_row(char *p, const lum_text_line *text,
                      const struct numbers *n, lum_text_style style)
{
    const __m128i others = _mm_set1_epi64x('.' | (int64_t)style.separator << 8 |
                                           (int64_t)'-' << 16);
    p = put_first(p, n, X, others);
    p = put_second(p, n, Y, others);
    p = put_first(p, n, Z, others);
    if (style.width_first) {
        p = put_first(p, n, WIDTH, others);
    }
    p = put_second(p, n, RANGE, others);
    p = put_first(p, n, AZIMUTH, others);
    p = put_second(p, n, ELEVATION, others);
    if (!style.width_first) {
        p = put_first(p, n, WIDTH, others);
    }
    p = lum_put_shared(p, text->line, text->line_bytes, LUM_LINE_COPY);
    return put_second(p, n, PIXEL, others);
}

VECTORS char *put_rows(char *p, const lum_text_line *text,
                       const lum_sample *samples, size_t n,
                       lum_text_style style, size_t *done)
{
    const size_t tail_bytes = text->tail_bytes;
    struct numbers block[BLOCK];
    size_t count = BLOCK;
    size_t i = 0;
    while (i < n && count == BLOCK) {
        count = make_block(samples + i, n - i, block);
        for (size_t k = 0; k < count; k++) {
            p = put_row(p, text, &block[k], style);
            p = put_return(p, return_of(&samples[i + k]), style.separator);
            if (tail_bytes != 0) {
                p = lum_put_shared(p - 1, text->tail, tail_bytes,
                                   LUM_TAIL_COPY);
            }
        }
        i += count;
    }
    *done = i;
    return p;
}

__attribute__((target("avx2"))) char *lum_put_vector_rows(
    char *p, const lum_text_line *text, const lum_sample *samples, size_t n,
    lum_text_style style, size_t *done)
{
    const char separator = style.separator;
    return style.width_first
               ? put_rows(p, text, samples, n,
                          (lum_text_style){separator, true}, done)
               : put_rows(p, text, samples, n,
                          (lum_text_style){separator, false}, done);
}

#else

bool lum_text_has_vectors(void)
{
    return false;
}

char *lum_put_vector_rows(char *p, const lum_text_line *text,
                          const lum_sample *samples, size_t n,
                          lum_text_style style, size_t *done)
{
    (void)text;
    (void)samples;
    (void)n;
    (void)style;
    *done = 0;
    return p;
}

#endif
