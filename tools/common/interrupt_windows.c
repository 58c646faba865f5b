/* Console events of Windows as signals that end a run. */
#include "interrupt.h"

#include <signal.h>
#include <stdbool.h>

#include <windows.h>

/* Console events come in a thread of their own. */
static volatile LONG caught;
static volatile LONG is_held;
static volatile LONG came;     /* signals; it wraps */
static volatile LONG is_spare; /* the next one is only noted */
static lum_cancel *volatile attached;
static lum_cancel *volatile second; /* never freed: a handler may use it */

static BOOL WINAPI note(DWORD event)
{
    const bool is_spared = InterlockedExchange(&is_spare, 0) != 0;
    (void)InterlockedIncrement(&came);
    /* A Ctrl-C hides no other. */
    const LONG before = event == CTRL_C_EVENT
                            ? InterlockedCompareExchange(&caught, SIGINT, 0)
                            : InterlockedExchange(&caught, SIGTERM);
    if (before != 0) {
        if (is_held == 0 && !is_spared) {
            interrupt_die();
        }
        lum_cancel_raise(second);
    }
    lum_cancel_raise(attached);
    return TRUE;
}

/* No signal comes from a pipe. */
void interrupt_catch_none(void)
{
}

void interrupt_catch(void)
{
    (void)SetConsoleCtrlHandler(note, TRUE);
}

static void make_second(void)
{
    lum_error error = {""};
    lum_cancel *made = NULL;
    if (second == NULL && lum_cancel_new(&made, &error) == 0) {
        second = made;
    }
}

/* A new process group starts with Ctrl-C switched off. */
void interrupt_insist(void)
{
    make_second();
    (void)SetConsoleCtrlHandler(NULL, FALSE);
}

void interrupt_attach(lum_cancel *cancel)
{
    attached = cancel;
    if (caught != 0) {
        lum_cancel_raise(cancel);
    }
}

int interrupt_signal(void)
{
    return (int)caught;
}

unsigned interrupt_count(void)
{
    return (unsigned)came;
}

void interrupt_forget(void)
{
    (void)InterlockedExchange(&caught, 0);
    if (attached != NULL) {
        lum_cancel_reset(attached);
    }
    if (second != NULL) {
        lum_cancel_reset(second);
    }
}

void interrupt_hold(void)
{
    make_second();
    (void)InterlockedExchange(&is_held, 1);
}

const lum_cancel *interrupt_second(void)
{
    return second;
}

/* Nothing is timed here. */
void interrupt_linger(void)
{
    (void)InterlockedExchange(&is_spare, 1);
    (void)InterlockedExchange(&is_held, 0);
}

void interrupt_release(void)
{
    (void)InterlockedExchange(&is_spare, 0);
    (void)InterlockedExchange(&is_held, 0);
}

/* What a console program that does not handle the event ends with. */
void interrupt_die(void)
{
    ExitProcess(STATUS_CONTROL_C_EXIT);
}
