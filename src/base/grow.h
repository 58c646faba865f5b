/** @file
 * An array that grows with what is added to it. Internal. */
#ifndef LUM_BASE_GROW_H
#define LUM_BASE_GROW_H

#include <stddef.h>
#include <stdlib.h>

/** Make room for more elements behind those that are used.
 * @param array from malloc(); NULL: there is none yet.
 * @param size  of an element.
 * @param room  elements that there is memory for; gets what there is then.
 * @return the array, perhaps elsewhere; NULL without memory: then it stays as
 *         it is. */
static inline void *lum_grown(void *array, size_t used, size_t more,
                              size_t size, size_t *room)
{
    if (array != NULL && *room >= used + more) {
        return array;
    }
    const size_t wanted = 2u * used + more + 16u;
    void *larger = realloc(array, wanted * size);
    if (larger != NULL) {
        *room = wanted;
    }
    return larger;
}

#endif
