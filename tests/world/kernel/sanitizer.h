/* What AddressSanitizer has to be told of a world, because it cannot see it:
 * memory that is given and freed, static data that is exchanged, a change of
 * stacks. Nothing in other builds. */
#ifndef WORLD_SANITIZER_H
#define WORLD_SANITIZER_H

#include <stdbool.h>
#include <stddef.h>

#if defined(__SANITIZE_ADDRESS__)
#define WORLD_SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define WORLD_SANITIZED 1
#endif
#endif
#ifndef WORLD_SANITIZED
#define WORLD_SANITIZED 0
#endif

#if WORLD_SANITIZED
#define WORLD_UNCHECKED __attribute__((no_sanitize("address")))
#else
#define WORLD_UNCHECKED
#endif

/* Nobody may touch it, until it is released. */
void world_guard(const void *memory, size_t bytes);
void world_release(const void *memory, size_t bytes);

/* As memcpy(), also of what stands between variables. */
void world_copy_unchecked(void *to, const void *from, size_t bytes);

/* Before and after a change of stacks: `from` keeps what the one that is left
 * has for itself (NULL: it ends), `stack` is the one that is entered. */
void world_leave_stack(void **from, const void *stack, size_t bytes);
void world_enter_stack(void *own, const void **left, size_t *left_bytes);

/* Calls it when something is found, after the report. */
void world_tell_of_death(void (*tell)(void));

#endif
