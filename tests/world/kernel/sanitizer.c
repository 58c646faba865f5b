#include "sanitizer.h"

#include <stdint.h>
#include <string.h>

#if WORLD_SANITIZED
#include <sanitizer/asan_interface.h>
#include <sanitizer/common_interface_defs.h>

/* Processes end without freeing anything, as they may. What a function leaves
 * behind on its stack is not kept apart. Stories look for words in logs that
 * grow: strstr() would measure them each time. */
const char *__asan_default_options(void);
const char *__asan_default_options(void)
{
    return "detect_leaks=0:detect_stack_use_after_return=0:intercept_strstr=0";
}

void world_guard(const void *memory, size_t bytes)
{
    __asan_poison_memory_region(memory, bytes);
}

void world_release(const void *memory, size_t bytes)
{
    __asan_unpoison_memory_region(memory, bytes);
}

/* volatile: no call of memcpy(), which would check, is made of it. */
WORLD_UNCHECKED void world_copy_unchecked(void *to, const void *from,
                                          size_t bytes)
{
    volatile char *out = to;
    const volatile char *in = from;
    size_t i = 0;
    if (((uintptr_t)to | (uintptr_t)from) % sizeof(uint64_t) == 0) {
        for (; bytes - i >= sizeof(uint64_t); i += sizeof(uint64_t)) {
            *(volatile uint64_t *)(volatile void *)(out + i) =
                *(const volatile uint64_t *)(const volatile void *)(in + i);
        }
    }
    for (; i < bytes; i++) {
        out[i] = in[i];
    }
}

void world_leave_stack(void **from, const void *stack, size_t bytes)
{
    __sanitizer_start_switch_fiber(from, stack, bytes);
}

void world_enter_stack(void *own, const void **left, size_t *left_bytes)
{
    __sanitizer_finish_switch_fiber(own, left, left_bytes);
}

void world_tell_of_death(void (*tell)(void))
{
    __sanitizer_set_death_callback(tell);
}

#else
void world_guard(const void *memory, size_t bytes)
{
    (void)memory;
    (void)bytes;
}

void world_release(const void *memory, size_t bytes)
{
    (void)memory;
    (void)bytes;
}

void world_copy_unchecked(void *to, const void *from, size_t bytes)
{
    memcpy(to, from, bytes);
}

void world_leave_stack(void **from, const void *stack, size_t bytes)
{
    (void)from;
    (void)stack;
    (void)bytes;
}

void world_enter_stack(void *own, const void **left, size_t *left_bytes)
{
    (void)own;
    (void)left;
    (void)left_bytes;
}

void world_tell_of_death(void (*tell)(void))
{
    (void)tell;
}
#endif
