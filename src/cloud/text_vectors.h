/** @file
 * Rows of text by vector code, on processors that have it. Internal to
 * cloud. */
#ifndef LUM_CLOUD_TEXT_VECTORS_H
#define LUM_CLOUD_TEXT_VECTORS_H

#include "text_columns.h"

/** Whether this processor has it, and LUM_CPU in the environment does not ask
 * for less. */
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
LUM_ALWAYS_INLINE char *lum_put_text_rows(char *p, lum_text_line *text,
                                          const lum_sample *samples, size_t n,
                                          lum_text_style style)
{
    const bool has_vectors = lum_text_has_vectors();
    lum_text_rows_begin(text);
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
