#define _GNU_SOURCE
#include "stack.h"

#include "random.h"
#include "sanitizer.h"

#include <setjmp.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <ucontext.h>

/* Stacks are at the same addresses in each run, the lowest that are free: a
 * tool may read there what it has not written, also the address of something.
 * Of each, the part that tools use is filled with chance when a task begins,
 * and what is deeper is 0. They are reserved, and cost nothing until they are
 * used. Below the memory of processes (memory.c). */
#define STACK_BASE ((uintptr_t)0x180000000000)
#define STACKS     1024u
/* What a sanitizer puts between variables needs room too. */
#define STACK_BYTES  ((size_t)(WORLD_SANITIZED ? 4096 : 512) * 1024)
#define FILLED_BYTES ((size_t)64 * 1024)
#define GUARD_BYTES  ((size_t)64 * 1024) /* pages of any machine */

/* A jump costs no call of the system. AddressSanitizer takes it for the end of
 * all functions that it has seen on the stack, and watches them no more: there
 * the slower way. */
#if WORLD_SANITIZED
typedef ucontext_t place;
#else
typedef jmp_buf place;
#endif

struct world_stack {
    unsigned number;
    void (*run)(void);
    bool has_begun;
    void *fake; /* the sanitizer's */
    place here;
};

static struct {
    char *start; /* NULL: not reserved yet */
    bool is_taken[STACKS], was_taken[STACKS];
} stacks;

static struct {
    place here;
    void *fake;
    const void *memory; /* the sanitizer's idea of its stack */
    size_t bytes;
    world_stack *entered;
} scheduler;

/* The lowest byte that a task may use. */
static char *memory_of(const world_stack *stack)
{
    return stacks.start + stack->number * (GUARD_BYTES + STACK_BYTES) +
           GUARD_BYTES;
}

static void reserve_stacks(void)
{
    void *wanted = (void *)STACK_BASE;
    stacks.start = mmap(
        wanted, STACKS * (GUARD_BYTES + STACK_BYTES), PROT_READ | PROT_WRITE,
        MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_FIXED_NOREPLACE, -1,
        0);
    if (stacks.start != wanted) {
        abort();
    }
}

static unsigned take_number(void)
{
    unsigned number = 0;
    if (stacks.start == NULL) {
        reserve_stacks();
    }
    while (number < STACKS && stacks.is_taken[number]) {
        number++;
    }
    if (number == STACKS) {
        abort();
    }
    stacks.is_taken[number] = true;
    return number;
}

/* Below a stack nothing can be touched, so that a task that needs too much
 * stops there. */
static void prepare(const world_stack *stack, unsigned task)
{
    world_random chance = world_stream("stack", task);
    char *memory = memory_of(stack);
    if (stacks.was_taken[stack->number]
            ? madvise(memory, STACK_BYTES - FILLED_BYTES, MADV_DONTNEED) != 0
            : mprotect(memory - GUARD_BYTES, GUARD_BYTES, PROT_NONE) != 0) {
        abort();
    }
    stacks.was_taken[stack->number] = true;
    memset(memory + STACK_BYTES - FILLED_BYTES,
           (int)(world_random_u64(&chance) & 0xff), FILLED_BYTES);
}

world_stack *world_stack_new(void (*run)(void), unsigned task)
{
    world_stack *stack = calloc(1, sizeof *stack);
    if (stack == NULL) {
        abort();
    }
    stack->run = run;
    stack->number = take_number();
    prepare(stack, task);
    return stack;
}

/* Functions that never returned have left marks on it. */
void world_stack_free(world_stack *stack)
{
    world_release(memory_of(stack), STACK_BYTES);
    stacks.is_taken[stack->number] = false;
    free(stack);
}

/* --- from one to another --- */

#if WORLD_SANITIZED
static void change(place *from, place *to)
{
    volatile bool is_back = false;
    (void)getcontext(from);
    if (!is_back) {
        is_back = true;
        (void)setcontext(to);
        abort();
    }
}
#else
static void change(place *from, place *to)
{
    if (_setjmp(*from) == 0) {
        _longjmp(*to, 1);
    }
}
#endif

static void begin(void)
{
    world_stack *stack = scheduler.entered;
    world_enter_stack(NULL, &scheduler.memory, &scheduler.bytes);
    stack->run();
    abort();
}

/* Onto the new stack. */
static void enter(world_stack *stack)
{
    ucontext_t context;
    (void)getcontext(&context);
    context.uc_stack.ss_sp = memory_of(stack);
    context.uc_stack.ss_size = STACK_BYTES;
    context.uc_link = NULL;
    makecontext(&context, begin, 0);
#if WORLD_SANITIZED
    change(&scheduler.here, &context);
#else
    if (_setjmp(scheduler.here) == 0) {
        (void)setcontext(&context);
        abort();
    }
#endif
}

void world_stack_turn(world_stack *stack)
{
    scheduler.entered = stack;
    world_leave_stack(&scheduler.fake, memory_of(stack), STACK_BYTES);
    if (stack->has_begun) {
        change(&scheduler.here, &stack->here);
    } else {
        stack->has_begun = true;
        enter(stack);
    }
    world_enter_stack(scheduler.fake, NULL, NULL);
}

void world_stack_rest(world_stack *stack)
{
    world_leave_stack(&stack->fake, scheduler.memory, scheduler.bytes);
    change(&stack->here, &scheduler.here);
    world_enter_stack(stack->fake, &scheduler.memory, &scheduler.bytes);
}

void world_stack_end(world_stack *stack)
{
    world_leave_stack(NULL, scheduler.memory, scheduler.bytes);
    change(&stack->here, &scheduler.here);
    abort();
}
