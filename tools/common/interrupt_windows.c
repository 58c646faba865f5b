#include "interrupt.h"

#include <signal.h>
#include <stdlib.h>

#include <windows.h>

/* Console events come in a thread of their own. */
static volatile LONG caught;
static volatile LONG is_held;
static lum_cancel *volatile attached;

static BOOL WINAPI note(DWORD event)
{
    if (InterlockedExchange(&caught,
                            event == CTRL_C_EVENT ? SIGINT : SIGTERM) != 0 &&
        is_held == 0) {
        interrupt_die();
    }
    lum_cancel_raise(attached);
    return TRUE;
}

void interrupt_catch(void)
{
    (void)SetConsoleCtrlHandler(note, TRUE);
}

/* A process group of its own is started with Ctrl-C switched off. */
void interrupt_insist(void)
{
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

void interrupt_forget(void)
{
    (void)InterlockedExchange(&caught, 0);
    if (attached != NULL) {
        lum_cancel_reset(attached);
    }
}

void interrupt_hold(void)
{
    (void)InterlockedExchange(&is_held, 1);
}

/* Nothing is timed here. */
void interrupt_linger(void)
{
    (void)InterlockedExchange(&is_held, 0);
}

void interrupt_release(void)
{
    (void)InterlockedExchange(&is_held, 0);
}

/* What a console program that does not handle the event ends with. */
void interrupt_die(void)
{
    ExitProcess(STATUS_CONTROL_C_EXIT);
}
