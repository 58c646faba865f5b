/* Where a sensor cuts a line into packets. */
#ifndef LUM_CORE_CUTS_H
#define LUM_CORE_CUTS_H

#include "lum/group.h"

#include <stddef.h>
#include <stdint.h>

/* How many angles each packet of angles has. */
static const uint32_t line_cuts[] = {334, 334, 332};

#define LINE_CUTS (sizeof line_cuts / sizeof line_cuts[0])

/* Where a packet of words ends that begins with a word: before the first pixel
 * whose words do not all fit. More than room where those of its first pixel do
 * not. */
static inline size_t cut_words(const uint32_t *words, size_t count,
                               size_t begin, size_t room)
{
    size_t end = begin;
    for (size_t i = begin; i < count && (i - begin < room || end == begin);
         i++) {
        const size_t next = i + 1u;
        if (next == count ||
            lum_word_pixel(words[next]) != lum_word_pixel(words[i])) {
            end = next;
        }
    }
    return end;
}

#endif
