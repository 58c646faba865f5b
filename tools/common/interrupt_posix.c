/* Signals that end a run, with handlers of POSIX. */
#define _XOPEN_SOURCE 700 /* setitimer */
#include "interrupt.h"

#include <signal.h>
#include <stddef.h>
#include <sys/time.h>

/* A signal may come just before a read or a write begins to wait, which then
 * would not notice. So it is followed by ticks that end such waits, and at last
 * by the end of a process that cannot tidy up in time. */
#define TICK_US   50000
#define TICKS_MAX 60

#define CAME_MASK 0x7f /* what any sig_atomic_t holds */

static volatile sig_atomic_t caught;
static volatile sig_atomic_t ticks;
static volatile sig_atomic_t came;         /* signals; it wraps */
static volatile sig_atomic_t is_spare;     /* the next one is only noted */
static volatile sig_atomic_t is_held;      /* a second signal does not count */
static volatile sig_atomic_t is_timed = 1; /* three seconds do */
static lum_cancel *volatile attached;
static lum_cancel *volatile second; /* never freed: a handler may use it */

static const int signals[] = {SIGINT, SIGTERM, SIGHUP};

static void set_handler(int signal_number, void (*handler)(int))
{
    struct sigaction action = {.sa_handler = handler};
    (void)sigfillset(&action.sa_mask); /* one after another */
    (void)sigaction(signal_number, &action, NULL);
}

static void tick(int signal_number)
{
    (void)signal_number;
    ticks = ticks + 1;
    if (ticks > TICKS_MAX) {
        interrupt_die();
    }
}

static void start_ticks(void)
{
    const struct itimerval timer = {.it_interval = {.tv_usec = TICK_US},
                                    .it_value = {.tv_usec = TICK_US}};
    (void)setitimer(ITIMER_REAL, &timer, NULL);
}

static void stop_ticks(void)
{
    const struct itimerval stopped = {.it_value = {0}};
    (void)setitimer(ITIMER_REAL, &stopped, NULL);
    ticks = 0;
}

static void note(int signal_number)
{
    if (caught != 0 && is_held == 0 && is_spare == 0) {
        interrupt_die();
    }
    is_spare = 0;
    came = (came + 1) & CAME_MASK;
    if (caught != 0) {
        lum_cancel_raise(second);
    }
    if (caught == 0 || caught == SIGINT) {
        caught = signal_number; /* a Ctrl-C hides no other */
    }
    lum_cancel_raise(attached);
    if (is_timed != 0) {
        start_ticks();
    }
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

/* What a write fails by is told where it was made. */
void interrupt_catch_none(void)
{
    set_handler(SIGPIPE, SIG_IGN);
    set_handler(SIGXFSZ, SIG_IGN);
}

void interrupt_catch(void)
{
    set_handler(SIGALRM, tick);
    interrupt_catch_none();
    for (size_t i = 0; i < sizeof signals / sizeof signals[0]; i++) {
        catch_unless_ignored(signals[i]);
    }
}

static void make_second(void)
{
    lum_error error = {""};
    lum_cancel *made = NULL;
    if (second == NULL && lum_cancel_new(&made, &error) == 0) {
        second = made;
    }
}

void interrupt_insist(void)
{
    make_second();
    static const int insisted[] = {SIGINT, SIGTERM, SIGQUIT};
    sigset_t set;
    (void)sigemptyset(&set);
    for (size_t i = 0; i < sizeof insisted / sizeof insisted[0]; i++) {
        set_handler(insisted[i], note);
        (void)sigaddset(&set, insisted[i]);
    }
    (void)sigprocmask(SIG_UNBLOCK, &set, NULL);
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
    return caught;
}

unsigned interrupt_count(void)
{
    return (unsigned)came;
}

void interrupt_forget(void)
{
    stop_ticks();
    caught = 0;
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
    is_held = 1;
    is_timed = 0;
    stop_ticks();
}

void interrupt_linger(void)
{
    is_held = 0;
    is_spare = 1;
    is_timed = 0;
    stop_ticks();
}

const lum_cancel *interrupt_second(void)
{
    return second;
}

void interrupt_release(void)
{
    is_held = 0;
    is_spare = 0;
    is_timed = 1;
    if (caught != 0) {
        start_ticks();
    }
}

void interrupt_die(void)
{
    const int signal_number = caught;
    sigset_t one;
    set_handler(signal_number, SIG_DFL);
    (void)sigemptyset(&one);
    (void)sigaddset(&one, signal_number);
    (void)sigprocmask(SIG_UNBLOCK, &one, NULL);
    (void)raise(signal_number);
}
