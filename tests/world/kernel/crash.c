#define _GNU_SOURCE
#include "crash.h"

#include "process.h"
#include "sanitizer.h"
#include "time.h"
#include "world.h"

#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#define STACK_BYTES 65536 /* the task's own may be what has run out */

static char stack[STACK_BYTES];

/* Nothing is safe any more, so only little is done. */
static void tell_what(const char *what)
{
    char line[512];
    const world_process *process = world_process_self();
    const int used = snprintf(
        line, sizeof line, "world: %s at %+.6f s in %s[%ld], seed %llu\n", what,
        (double)world_now() / 1e9, process != NULL ? process->name : "user",
        process != NULL ? process->pid : 0L, (unsigned long long)world_seed());
    const ssize_t written = write(STDERR_FILENO, line, (size_t)used);
    (void)written;
}

static void tell(int number)
{
    tell_what(number == SIGSEGV ? "SIGSEGV, or a stack that ran out"
                                : strsignal(number));
    (void)raise(number); /* with its default action, SA_RESETHAND */
}

static void tell_found(void)
{
    tell_what("the sanitizer's find");
}

void world_crash_tell(void)
{
    static const int crashes[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
    const stack_t other = {.ss_sp = stack, .ss_size = sizeof stack};
    struct sigaction action = {
        .sa_handler = tell,
        .sa_flags = (int)(SA_ONSTACK | SA_RESETHAND | SA_NODEFER)};
    if (WORLD_SANITIZED) { /* it has handlers of its own, which say more */
        world_tell_of_death(tell_found);
        return;
    }
    (void)sigaltstack(&other, NULL);
    (void)sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < sizeof crashes / sizeof crashes[0]; i++) {
        (void)sigaction(crashes[i], &action, NULL);
    }
}
