/** @file
 * The columns of a point as text: a row of CSV, and of PLY and PCD in ascii.
 * Internal to cloud. */
#ifndef LUM_CLOUD_TEXT_COLUMNS_H
#define LUM_CLOUD_TEXT_COLUMNS_H

#include "decimal.h"

#include "lum/cloud/writer.h"

#include <math.h>
#include <stdbool.h>

/** Room that a row takes at most, what the writing of decimals overruns
 * included. */
#define LUM_TEXT_ROW_ROOM 512u

#define LUM_METRE_DECIMALS  4u /**< x, y, z, range */
#define LUM_DEGREE_DECIMALS 5u /**< azimuth, elevation */
#define LUM_WIDTH_DECIMALS  3u /**< pulse width */

#define LUM_LINE_COPY 32u /**< bytes that hold nearly every line's columns */
#define LUM_TAIL_COPY 8u  /**< bytes that hold the tail of one small integer */

/** What rows of a line share: text that is made once. */
typedef struct lum_text_line {
    char line[3u * LUM_DECIMAL_ROOM]; /**< timestamp, frame, eye, line */
    size_t line_bytes;                /**< of those */
    const char *tail;  /**< what each row has behind the edge, its newline
                            included, with room for a copy of LUM_TAIL_COPY */
    size_t tail_bytes; /**< of those; 0: the newline alone */
} lum_text_line;

/** How rows of a format differ. */
typedef struct lum_text_style {
    char separator;   /**< between columns */
    bool width_first; /**< the pulse width stands behind z (as intensity), not
                           behind the elevation */
} lum_text_style;

/** A timestamp as a number; NaN where there is none. */
static inline double lum_timestamp_number(int64_t timestamp_us)
{
    return timestamp_us == LUM_TIMESTAMP_NONE ? (double)NAN
                                              : (double)timestamp_us;
}

/** Begin a line: make the text of its own columns. */
static inline void lum_text_line_begin(lum_text_line *text,
                                       const lum_line_samples *line,
                                       char separator)
{
    char *p = text->line;
    if (line->timestamp_us == LUM_TIMESTAMP_NONE) {
        memcpy(p, "nan", 3);
        p += 3;
    } else {
        p = lum_put_i64(p, line->timestamp_us);
    }
    *p++ = separator;
    p = lum_put_i64(p, line->frame);
    *p++ = separator;
    p = lum_put_three(p, line->eye);
    *p++ = separator;
    p = lum_put_u64(p, line->line);
    *p++ = separator;
    text->line_bytes = (size_t)(p - text->line);
    text->tail_bytes = 0;
}

/** Append n bytes of `from`, which has room behind them; most often the first
 * `mostly` are all, and a copy of fixed size is quick. */
LUM_ALWAYS_INLINE char *lum_put_shared(char *p, const char *from, size_t n,
                                       size_t mostly)
{
    memcpy(p, from, mostly);
    if (n > mostly) {
        memcpy(p + mostly, from + mostly, n - mostly);
    }
    return p + n;
}

/** A column of a small integer. */
LUM_ALWAYS_INLINE char *lum_put_count(char *p, uint16_t v, char separator)
{
    p = v < 1000u ? lum_put_three(p, v) : lum_put_u64(p, v);
    *p = separator;
    return p + 1;
}

/** The columns of a return; nearly all have numbers of one digit. */
LUM_ALWAYS_INLINE char *lum_put_return(char *p, const lum_sample *sample,
                                       char separator)
{
    if (sample->return_number < 10u && sample->number_of_returns < 10u) {
        p[0] = (char)('0' + sample->return_number);
        p[1] = separator;
        p[2] = (char)('0' + sample->number_of_returns);
        p[3] = separator;
        return p + 4;
    }
    p = lum_put_count(p, sample->return_number, separator);
    return lum_put_count(p, sample->number_of_returns, separator);
}

/** A row.
 * @param p has LUM_TEXT_ROW_ROOM bytes.
 * @return its end, behind the newline. */
LUM_ALWAYS_INLINE char *lum_put_text_row(char *p, const lum_text_line *text,
                                         const lum_sample *sample,
                                         lum_text_style style)
{
    const lum_sample *s = sample;
    const char separator = style.separator;
    p = lum_put_column(p, s->x, LUM_METRE_DECIMALS, separator);
    p = lum_put_column(p, s->y, LUM_METRE_DECIMALS, separator);
    p = lum_put_column(p, s->z, LUM_METRE_DECIMALS, separator);
    if (style.width_first) {
        p = lum_put_column(p, s->pulse_width, LUM_WIDTH_DECIMALS, separator);
    }
    p = lum_put_column(p, s->range, LUM_METRE_DECIMALS, separator);
    p = lum_put_column(p, s->azimuth, LUM_DEGREE_DECIMALS, separator);
    p = lum_put_column(p, s->elevation, LUM_DEGREE_DECIMALS, separator);
    if (!style.width_first) {
        p = lum_put_column(p, s->pulse_width, LUM_WIDTH_DECIMALS, separator);
    }
    p = lum_put_shared(p, text->line, text->line_bytes, LUM_LINE_COPY);
    p = lum_put_count(p, s->pixel, separator);
    p = lum_put_return(p, s, separator);
    p[0] = s->edge != 0 ? '1' : '0';
    p[1] = '\n';
    return text->tail_bytes == 0
               ? p + 2
               : lum_put_shared(p + 1, text->tail, text->tail_bytes,
                                LUM_TAIL_COPY);
}

/** Whether this processor has vectors for rows, and LUM_CPU in the environment
 * does not ask for less. */
bool lum_text_has_vectors(void);

/** Write rows as lum_put_text_row() does, up to the first whose numbers are too
 * long for this: 999 m, degrees or ns and more, pixel 1000 and more, return 10
 * and more. Only if lum_text_has_vectors().
 * @param done gets how many rows these are.
 * @return the end of the last. */
char *lum_put_vector_rows(char *p, const lum_text_line *text,
                          const lum_sample *samples, size_t n,
                          lum_text_style style, size_t *done);

/** Write n rows at a place that has LUM_TEXT_ROW_ROOM bytes for each.
 * @return the end of the last. */
LUM_ALWAYS_INLINE char *lum_put_text_rows(char *p, const lum_text_line *text,
                                          const lum_sample *samples, size_t n,
                                          lum_text_style style)
{
    const bool has_vectors = lum_text_has_vectors();
    for (size_t i = 0; i < n; i++) {
        if (has_vectors) {
            size_t done = 0;
            p = lum_put_vector_rows(p, text, samples + i, n - i, style, &done);
            i += done;
        }
        if (i < n) {
            p = lum_put_text_row(p, text, &samples[i], style);
        }
    }
    return p;
}

#endif
