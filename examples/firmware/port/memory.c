/* The four functions of string.h that the core and the compiler call, for
 * targets without a C library. Whole words where both sides are aligned. */
#include <stdint.h>
#include <string.h>

typedef uint32_t __attribute__((may_alias)) word;

#define WORD_MASK (sizeof(word) - 1u)

void *memcpy(void *restrict out, const void *restrict in, size_t n)
{
    uint8_t *to = out;
    const uint8_t *from = in;

    if ((((uintptr_t)to | (uintptr_t)from) & WORD_MASK) == 0) {
        for (; n >= sizeof(word); n -= sizeof(word)) {
            *(word *)(void *)to = *(const word *)(const void *)from;
            to += sizeof(word);
            from += sizeof(word);
        }
    }
    while (n-- > 0) {
        *to++ = *from++;
    }
    return out;
}

void *memmove(void *out, const void *in, size_t n)
{
    uint8_t *to = out;
    const uint8_t *from = in;

    if ((uintptr_t)to - (uintptr_t)from >= n) {
        return memcpy(out, in, n);
    }
    if (((((uintptr_t)to + n) | ((uintptr_t)from + n)) & WORD_MASK) == 0) {
        for (; n >= sizeof(word); n -= sizeof(word)) {
            *(word *)(void *)(to + n - sizeof(word)) =
                *(const word *)(const void *)(from + n - sizeof(word));
        }
    }
    while (n-- > 0) {
        to[n] = from[n];
    }
    return out;
}

void *memset(void *out, int value, size_t n)
{
    uint8_t *to = out;
    const uint32_t fill = (uint8_t)value * 0x01010101u;

    for (; n > 0 && ((uintptr_t)to & WORD_MASK) != 0; n--) {
        *to++ = (uint8_t)value;
    }
    for (; n >= sizeof(word); n -= sizeof(word)) {
        *(word *)(void *)to = fill;
        to += sizeof(word);
    }
    while (n-- > 0) {
        *to++ = (uint8_t)value;
    }
    return out;
}

int memcmp(const void *a, const void *b, size_t n)
{
    const uint8_t *left = a;
    const uint8_t *right = b;

    for (size_t i = 0; i < n; i++) {
        if (left[i] != right[i]) {
            return left[i] < right[i] ? -1 : 1;
        }
    }
    return 0;
}
