/* Words that an interrupt and the main loop share. Data that one side wrote
 * before it stores such a word is visible to the other side after it loaded the
 * word. With a compiler without these builtins: a volatile access and a memory
 * barrier. */
#ifndef SHARED_H
#define SHARED_H

#include <stdint.h>

static inline uint32_t shared_load(const uint32_t *word)
{
    return __atomic_load_n(word, __ATOMIC_ACQUIRE);
}

static inline void shared_store(uint32_t *word, uint32_t value)
{
    __atomic_store_n(word, value, __ATOMIC_RELEASE);
}

#endif
