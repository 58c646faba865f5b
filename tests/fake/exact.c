#include "exact.h"

#include <stdlib.h>
#include <string.h>

#ifndef __has_feature
#define __has_feature(name) 0
#endif

#if defined(__SANITIZE_ADDRESS__) || __has_feature(address_sanitizer)

#include <sanitizer/asan_interface.h>

#define SLOTS 256u
#define SLOT_BYTES                                                             \
    ((EXACT_BYTES + 16u) / 8u * 8u) /* some are always barred                  \
                                     */

/* A fuzzer makes millions: malloc() would keep a stack for each. */
static uint64_t slots[SLOTS][SLOT_BYTES / 8u];
static unsigned made;

uint8_t *exact_copy(const uint8_t *bytes, size_t len)
{
    uint8_t *slot = (uint8_t *)slots[made++ % SLOTS];
    ASAN_POISON_MEMORY_REGION(slot, SLOT_BYTES);
    ASAN_UNPOISON_MEMORY_REGION(slot, len);
    memcpy(slot, bytes, len);
    return slot;
}

void exact_free(uint8_t *copy)
{
    if (copy != NULL) {
        ASAN_POISON_MEMORY_REGION(copy, SLOT_BYTES);
    }
}

#else

uint8_t *exact_copy(const uint8_t *bytes, size_t len)
{
    uint8_t *copy = malloc(len > 0 ? len : 1u);
    if (copy == NULL) {
        abort();
    }
    memcpy(copy, bytes, len);
    return copy;
}

void exact_free(uint8_t *copy)
{
    free(copy);
}

#endif
