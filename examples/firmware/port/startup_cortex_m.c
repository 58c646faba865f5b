/* Cortex-M: vector table, reset, a counter of core clocks, calls to the host.
 */
#include "board.h"
#include "port.h"

#define FLOAT_UNIT        (0xfu << 20)
#define COUNTER_MAX       0xffffffu
#define COUNTER_BITS      24u
#define COUNT_CORE_CLOCKS 7u /* on, with interrupt, by the core's clock */

/* Of the linker script: the stack's end, and registers of the core. */
extern uint32_t board_stack_top[];
extern volatile uint32_t board_systick[];      /* control, reload, value */
extern volatile uint32_t board_coprocessors[]; /* access to them */

void board_reset(void);
void board_tick(void);

static volatile uint32_t counter_laps;

__attribute__((section(".vectors"), used)) static const struct {
    void *stack;
    void (*reset)(void);
    void (*others[13])(void); /* faults, and what is not used */
    void (*tick)(void);
} vectors = {board_stack_top,
             board_reset,
             {board_fault, board_fault, board_fault, board_fault, board_fault,
              board_fault, board_fault, board_fault, board_fault, board_fault,
              board_fault, board_fault, board_fault},
             board_tick};

void board_tick(void)
{
    counter_laps = counter_laps + 1u;
}

void board_reset(void)
{
#if defined(__ARM_FP)
    board_coprocessors[0] |= FLOAT_UNIT;
    __asm__ volatile("dsb\n\tisb" ::: "memory");
#endif
    board_systick[1] = COUNTER_MAX;
    board_systick[2] = 0;
    board_systick[0] = COUNT_CORE_CLOCKS;
    board_run();
}

uint32_t port_ticks(void)
{
    uint32_t laps;
    uint32_t left;

    do {
        laps = counter_laps;
        left = board_systick[2];
    } while (laps != counter_laps);
    return (laps << COUNTER_BITS) + (COUNTER_MAX - left);
}

long board_call(long operation, const void *arguments)
{
    register long r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = arguments;

    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory", "cc");
    return r0;
}
