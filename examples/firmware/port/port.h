/* What a program of this directory needs from its environment: a file, a text
 * output, its exit status, and on a board a counter. port_host.c gives them by
 * stdio, port_semihosting.c by a debugger's host or an emulator. A program has
 * an ordinary main(); startup_*.c calls it with the words of the command line
 * and exits with what it returns. */
#ifndef PORT_H
#define PORT_H

#include <stddef.h>
#include <stdint.h>

/* Open a file of the host for reading, instead of the one before. Returns a
 * handle, or -1. */
int port_open(const char *path);

/* Read up to size bytes. Returns how many; fewer at the end only; -1 when the
 * host cannot. */
long port_read(int file, void *out, size_t size);

/* Write to the host's standard output. Returns 0, or -1. */
int port_write(const char *text, size_t len);

/* Leave the program; the emulator ends with this status. */
void port_exit(int status);

/* Boards only: clocks of the core since the reset, modulo 2^32. Under an
 * emulator that counts instructions (-icount shift=5) the 25 MHz Cortex-M
 * boards show 4 ticks for 5 instructions, and RISC-V 32 for each. */
uint32_t port_ticks(void);

#endif
