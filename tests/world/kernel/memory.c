#define _GNU_SOURCE /* MAP_FIXED_NOREPLACE */
#include "process_internal.h"
#include "sanitizer.h"
#include "trace.h"

#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#define MARK      UINT64_C(0x6d656d6f72793a21)
#define MARK_FREE UINT64_C(0x667265653a212121)

/* Every process has its memory at addresses of its own, the same in each run of
 * a seed: tools take chance from addresses. They are reserved, and cost nothing
 * until they are used. */
#define BASE        ((uintptr_t)0x200000000000)
#define ARENA_BYTES ((size_t)4 << 30)
#define ARENAS      1024u
#define OF_WORLD    (ARENAS - 1u) /* what no process asked for */

/* Sizes are rounded up to one of these: steps of 16 bytes, then quarters of a
 * power of two. */
#define STEP    16u
#define SMALL   1024u
#define STEPS   (SMALL / STEP)
#define CLASSES (STEPS + 4u * 23u)

/* A sanitizer guards some bytes behind each block, and what has been freed
 * until so much has been given. */
#define BEHIND (WORLD_SANITIZED ? (size_t)16 : (size_t)0)
#define KEPT   ((size_t)32 << 20)

/* From here on, memory is 0 at first, and only its beginning is filled: a tool
 * may use little of a large buffer. */
#define LARGE  ((size_t)256 * 1024)
#define FILLED ((size_t)4096)
#define PAGE   ((size_t)65536) /* of any machine, or several */

typedef struct block {
    size_t bytes; /* as asked for */
    uint64_t mark;
} block;

typedef struct free_block {
    block head;
    struct free_block *next;
} free_block;

typedef struct arena {
    char *start; /* NULL: not reserved yet */
    size_t used;
    free_block *free[CLASSES];
} arena;

static arena *arenas[ARENAS];

static arena *reserve(unsigned number)
{
    arena *a = calloc(1, sizeof *a);
    void *wanted = (void *)(BASE + (uintptr_t)number * ARENA_BYTES);
    if (a == NULL ||
        mmap(wanted, ARENA_BYTES, PROT_READ | PROT_WRITE,
             MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE | MAP_FIXED_NOREPLACE,
             -1, 0) != wanted) {
        abort();
    }
    a->start = wanted;
    return a;
}

static arena *own(void)
{
    const world_process *process = world_process_self();
    const unsigned number =
        process != NULL ? process->private->arena : OF_WORLD;
    if (arenas[number] == NULL) {
        arenas[number] = reserve(number);
    }
    return arenas[number];
}

/* The rounded size, and which of the classes that is. */
static size_t round_up(size_t bytes, unsigned *class)
{
    size_t power = SMALL;
    *class = STEPS - 1u;
    if (bytes <= SMALL) {
        const size_t steps = bytes == 0 ? 1 : (bytes + STEP - 1) / STEP;
        *class = (unsigned)steps - 1u;
        return steps * STEP;
    }
    while (bytes > 2 * power) {
        power *= 2;
        *class += 4u;
    }
    const size_t quarters = (bytes - power + power / 4 - 1) / (power / 4);
    *class += (unsigned)quarters;
    return power + quarters * (power / 4);
}

/* Of a block, all in all. */
static size_t size_of(size_t bytes, unsigned *class)
{
    return round_up(sizeof(block) + bytes + BEHIND, class);
}

static bool is_large(size_t bytes)
{
    return bytes >= LARGE;
}

static WORLD_UNCHECKED block *get(size_t bytes)
{
    unsigned class = 0;
    if (bytes > ARENA_BYTES / 2) {
        return NULL;
    }
    arena *a = own();
    const size_t size = size_of(bytes, &class);
    free_block *old = a->free[class];
    if (old != NULL && (!WORLD_SANITIZED || a->used >= KEPT)) {
        a->free[class] = old->next;
        return &old->head;
    }
    if (size > ARENA_BYTES - a->used) {
        return NULL;
    }
    block *fresh = (block *)(void *)(a->start + a->used);
    a->used += size;
    return fresh;
}

static WORLD_UNCHECKED void *add(size_t bytes)
{
    unsigned class = 0;
    block *b = get(bytes);
    if (b == NULL) {
        errno = ENOMEM;
        return NULL;
    }
    *b = (block){.bytes = bytes, .mark = MARK};
    world_guard(b, size_of(bytes, &class));
    world_release(b + 1, bytes);
    return b + 1;
}

/* What a tool reads before it has written there differs from seed to seed. */
static void fill(void *memory, size_t bytes)
{
    world_process *process = world_process_self();
    const int junk =
        process != NULL
            ? (int)(world_random_u64(&process->private->chance) & 0xff)
            : 0;
    memset(memory, junk, bytes < FILLED || !is_large(bytes) ? bytes : FILLED);
}

void *world_malloc(size_t bytes)
{
    void *memory = add(bytes);
    if (memory != NULL) {
        fill(memory, bytes);
    }
    return memory;
}

void *world_calloc(size_t count, size_t bytes)
{
    if (bytes != 0 && count > SIZE_MAX / bytes) {
        errno = ENOMEM;
        return NULL;
    }
    void *memory = add(count * bytes);
    if (memory != NULL) {
        memset(memory, 0,
               is_large(count * bytes) ? sizeof(free_block) : count * bytes);
    }
    return memory;
}

/* NULL: it was not given by these functions, or has been freed. */
static WORLD_UNCHECKED block *block_of(void *memory)
{
    block *b = (block *)memory - 1;
    const arena *a = own();
    if ((char *)memory < a->start || (char *)memory >= a->start + a->used ||
        b->mark != MARK) {
        world_fail("free() or realloc() of memory that was not given, or has "
                   "been freed");
        return NULL;
    }
    return b;
}

/* Whole pages of a large block are given back, which makes them 0. */
static void clear(block *b, size_t size)
{
    const uintptr_t from =
        ((uintptr_t)(b + 1) + sizeof(free_block) + PAGE - 1) / PAGE * PAGE;
    const uintptr_t to = ((uintptr_t)b + size) / PAGE * PAGE;
    memset(b + 1, 0, from - (uintptr_t)(b + 1));
    (void)madvise((void *)from, to - from, MADV_DONTNEED);
    memset((void *)to, 0, (uintptr_t)b + size - to);
}

WORLD_UNCHECKED void world_free(void *memory)
{
    block *b = memory != NULL ? block_of(memory) : NULL;
    if (b != NULL) {
        arena *a = own();
        unsigned class = 0;
        const size_t size = size_of(b->bytes, &class);
        world_release(b, size);
        if (is_large(b->bytes)) {
            clear(b, size);
        }
        b->mark = MARK_FREE;
        free_block *freed = (free_block *)(void *)b;
        freed->next = a->free[class];
        a->free[class] = freed;
        world_guard(freed, size);
    }
}

/* It always moves: nobody may keep the old place. */
WORLD_UNCHECKED void *world_realloc(void *old, size_t bytes)
{
    if (old == NULL) {
        return world_malloc(bytes);
    }
    const block *b = block_of(old);
    void *memory = b != NULL ? world_malloc(bytes) : NULL;
    if (memory != NULL) {
        memcpy(memory, old, bytes < b->bytes ? bytes : b->bytes);
        world_free(old);
    }
    return memory;
}

/* The next one who has these addresses finds them as new. */
static void empty(unsigned number)
{
    arena *a = arenas[number];
    if (a != NULL) {
        world_release(a->start, a->used);
        (void)madvise(a->start, a->used, MADV_DONTNEED);
        a->used = 0;
        memset(a->free, 0, sizeof a->free);
    }
}

void world_memory_begin(world_process *process, unsigned number)
{
    if (number >= OF_WORLD) {
        world_fail("more than %u processes in one run", OF_WORLD);
        number = OF_WORLD;
    }
    process->private->arena = number;
}

void world_memory_free(world_process *process)
{
    empty(process->private->arena);
}

void world_memory_reset(void)
{
    empty(OF_WORLD);
}
