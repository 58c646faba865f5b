#define _POSIX_C_SOURCE 200809L
#include "interrupt.h"

#include <signal.h>
#include <stddef.h>

static volatile sig_atomic_t caught;

static const int signals[] = {SIGINT, SIGTERM, SIGHUP};

static void note(int signal_number)
{
    caught = signal_number;
}

static void set_handler(int signal_number, void (*handler)(int))
{
    struct sigaction action = {.sa_handler = handler};
    (void)sigemptyset(&action.sa_mask);
    (void)sigaction(signal_number, &action, NULL);
}

/* A signal that the parent has ignored, as nohup does, stays ignored. */
static void catch_unless_ignored(int signal_number)
{
    struct sigaction before;
    if (sigaction(signal_number, NULL, &before) == 0 &&
        before.sa_handler != SIG_IGN) {
        set_handler(signal_number, note);
    }
}

void interrupt_catch(void)
{
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; i++) {
        catch_unless_ignored(signals[i]);
    }
    set_handler(SIGPIPE, SIG_IGN);
}

int interrupt_signal(void)
{
    return caught;
}

void interrupt_die(void)
{
    const int signal_number = caught;
    set_handler(signal_number, SIG_DFL);
    (void)raise(signal_number);
}
