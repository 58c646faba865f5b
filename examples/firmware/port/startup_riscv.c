/* RISC-V, machine mode: reset, a counter of instructions or clocks, calls to
 * the host. */
#include "board.h"
#include "port.h"

void board_reset(void);

__attribute__((naked, noreturn, section(".vectors"), used)) void board_reset(
    void)
{
    __asm__ volatile(".option push\n\t"
                     ".option norelax\n\t"
                     ".option arch, +zicsr\n\t"
                     "la gp, __global_pointer$\n\t"
                     "la sp, board_stack_top\n\t"
                     "la t0, board_trap\n\t"
                     "csrw mtvec, t0\n\t"
                     ".option pop\n\t"
                     "tail board_run");
}

/* mtvec wants its two lowest bits clear. */
__attribute__((naked, noreturn, aligned(4), used)) void board_trap(void);

void board_trap(void)
{
    __asm__ volatile("tail board_fault");
}

uint32_t port_ticks(void)
{
    uint32_t count;

    __asm__ volatile(".option push\n\t"
                     ".option arch, +zicsr\n\t"
                     "csrr %0, mcycle\n\t"
                     ".option pop"
                     : "=r"(count)::"memory");
    return count;
}

/* The three instructions are the request; they may not be compressed, nor lie
 * on two pages. */
__attribute__((noinline)) long board_call(long operation, const void *arguments)
{
    register long a0 __asm__("a0") = operation;
    register const void *a1 __asm__("a1") = arguments;

    __asm__ volatile(".option push\n\t"
                     ".option norvc\n\t"
                     ".balign 16\n\t"
                     "slli zero, zero, 0x1f\n\t"
                     "ebreak\n\t"
                     "srai zero, zero, 7\n\t"
                     ".option pop"
                     : "+r"(a0)
                     : "r"(a1)
                     : "memory");
    return a0;
}
