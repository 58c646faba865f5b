#define _GNU_SOURCE
#include "signals.h"

#include "host.h"
#include "process_internal.h"
#include "signal_calls.h"
#include "task.h"
#include "time.h"
#include "trace.h"

#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>

#define CALL_NS  (1 * WORLD_US)
#define US_PER_S 1000000

struct world_signals {
    struct sigaction actions[WORLD_SIGNALS];
    uint64_t pending; /* for any thread */
    world_event *alarm;
    int64_t alarm_ns; /* the host's monotonic clock */
    int64_t interval_ns;
};

static uint64_t bit(int number)
{
    return UINT64_C(1) << (number - 1);
}

static bool is_number(int number)
{
    return number >= 1 && number < WORLD_SIGNALS;
}

static uint64_t bits_of(const sigset_t *set)
{
    uint64_t bits = 0;
    for (int i = 1; i < WORLD_SIGNALS; i++) {
        if (sigismember(set, i) == 1) {
            bits |= bit(i);
        }
    }
    return bits;
}

static void set_of(uint64_t bits, sigset_t *out)
{
    (void)sigemptyset(out);
    for (int i = 1; i < WORLD_SIGNALS; i++) {
        if ((bits & bit(i)) != 0) {
            (void)sigaddset(out, i);
        }
    }
}

/* --- what a signal does --- */

enum effect {
    IGNORED,
    HANDLED,
    STOPS,
    CONTINUES,
    ENDS
};

static enum effect by_default(int number)
{
    switch (number) {
    case SIGCHLD:
    case SIGURG:
    case SIGWINCH:
        return IGNORED;
    case SIGSTOP:
    case SIGTSTP:
    case SIGTTIN:
    case SIGTTOU:
        return STOPS;
    case SIGCONT:
        return CONTINUES;
    default:
        return ENDS;
    }
}

static enum effect effect_of(const world_process *process, int number)
{
    const struct sigaction *action = &process->signals->actions[number];
    if (number == SIGKILL || number == SIGSTOP ||
        action->sa_handler == SIG_DFL) {
        return by_default(number);
    }
    return action->sa_handler == SIG_IGN ? IGNORED : HANDLED;
}

static const char *name_of(int number)
{
    static const struct {
        int number;
        const char *name;
    } names[] = {
        {SIGHUP, "SIGHUP"},   {SIGINT, "SIGINT"},   {SIGQUIT, "SIGQUIT"},
        {SIGKILL, "SIGKILL"}, {SIGUSR1, "SIGUSR1"}, {SIGUSR2, "SIGUSR2"},
        {SIGPIPE, "SIGPIPE"}, {SIGALRM, "SIGALRM"}, {SIGTERM, "SIGTERM"},
        {SIGCONT, "SIGCONT"}, {SIGSTOP, "SIGSTOP"}, {SIGTSTP, "SIGTSTP"},
        {SIGABRT, "SIGABRT"}};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (names[i].number == number) {
            return names[i].name;
        }
    }
    return "a signal";
}

/* A process that stops in its own step gives way until it may go on. */
static void stop(world_process *process)
{
    process->is_stopped = true;
    process->signals->pending &= ~bit(SIGCONT);
    WORLD_TRACE("%s[%ld] is stopped", process->name, process->pid);
    if (process == world_process_self()) {
        world_yield();
    }
}

static void let_go_on(world_process *process)
{
    static const int stops[] = {SIGSTOP, SIGTSTP, SIGTTIN, SIGTTOU};
    for (size_t i = 0; i < sizeof stops / sizeof stops[0]; i++) {
        process->signals->pending &= ~bit(stops[i]);
    }
    if (process->is_stopped) {
        process->is_stopped = false;
        WORLD_TRACE("%s[%ld] goes on", process->name, process->pid);
    }
}

/* --- delivery --- */

/* In the task that runs. */
static void run_handler(world_thread *thread, int number)
{
    struct sigaction *action = &thread->process->signals->actions[number];
    const struct sigaction now = *action;
    const uint64_t before = thread->mask;
    thread->mask |= bits_of(&now.sa_mask);
    if ((now.sa_flags & (int)SA_NODEFER) == 0) {
        thread->mask |= bit(number);
    }
    if ((now.sa_flags & (int)SA_RESETHAND) != 0) {
        action->sa_handler = SIG_DFL;
    }
    WORLD_TRACE("handles %s", name_of(number));
    if ((now.sa_flags & SA_SIGINFO) != 0) {
        siginfo_t info = {.si_signo = number};
        now.sa_sigaction(number, &info, NULL);
    } else {
        now.sa_handler(number);
    }
    thread->mask = before;
}

/* The first that is due to the thread, taken from what is pending; 0: none. */
static int take_due(world_thread *thread)
{
    struct world_signals *signals = thread->process->signals;
    const uint64_t due = (thread->pending | signals->pending) & ~thread->mask;
    if (due == 0) {
        return 0;
    }
    int number = 1;
    while ((due & bit(number)) == 0) {
        number++;
    }
    if ((thread->pending & bit(number)) != 0) {
        thread->pending &= ~bit(number);
    } else {
        signals->pending &= ~bit(number);
    }
    return number;
}

/* True: a handler ran that ends waits. */
static bool act(world_thread *thread, int number)
{
    bool ends_waits = false;
    switch (effect_of(thread->process, number)) {
    case HANDLED:
        ends_waits = (thread->process->signals->actions[number].sa_flags &
                      SA_RESTART) == 0;
        run_handler(thread, number);
        break;
    case STOPS:
        stop(thread->process);
        break;
    case ENDS:
        world_process_end(thread->process, number);
        break;
    case IGNORED:
    case CONTINUES:
    default:
        break;
    }
    return ends_waits;
}

bool world_signals_deliver(void)
{
    world_thread *thread = world_thread_self();
    bool ends_waits = false;
    if (thread == NULL) {
        return false;
    }
    for (int number = take_due(thread); number != 0;
         number = take_due(thread)) {
        ends_waits = act(thread, number) || ends_waits;
    }
    return ends_waits;
}

/* The first thread that does not block it takes a signal of the process. */
static world_thread *taker(const world_process *process, int number)
{
    world_thread *thread = process->private->threads;
    while (thread != NULL &&
           ((thread->mask & bit(number)) != 0 || thread->has_ended)) {
        thread = thread->next;
    }
    return thread;
}

/* What needs no step of the process happens at once. */
static bool acts_at_once(const world_process *process, enum effect effect)
{
    return (effect == ENDS || effect == STOPS) && !process->is_stopped &&
           process != world_process_self();
}

static void post(world_process *process, int number)
{
    const enum effect effect = effect_of(process, number);
    world_thread *thread = taker(process, number);
    if (thread != NULL && (effect == IGNORED || effect == CONTINUES)) {
        return;
    }
    if (thread != NULL && acts_at_once(process, effect)) {
        if (effect == STOPS) {
            stop(process);
        } else {
            world_process_end(process, number);
        }
        return;
    }
    process->signals->pending |= bit(number);
    if (thread != NULL) {
        world_task_interrupt(thread->task);
    }
}

void world_process_signal(world_process *process, int number)
{
    if (process->has_ended || !is_number(number)) {
        return;
    }
    WORLD_TRACE("%s for %s[%ld]", name_of(number), process->name, process->pid);
    if (number == SIGKILL) {
        world_process_end(process, number);
    } else if (number == SIGSTOP) {
        stop(process);
    } else {
        if (number == SIGCONT) {
            let_go_on(process);
        }
        post(process, number);
    }
}

void world_signal_self(int number)
{
    world_thread *thread = world_thread_self();
    if (effect_of(thread->process, number) != IGNORED ||
        (thread->mask & bit(number)) != 0) {
        thread->pending |= bit(number);
        (void)world_signals_deliver();
    }
}

void world_signal_mask(const sigset_t *mask, sigset_t *old)
{
    world_thread *thread = world_thread_self();
    if (old != NULL) {
        set_of(thread->mask, old);
    }
    thread->mask = bits_of(mask) & ~(bit(SIGKILL) | bit(SIGSTOP));
}

/* --- calls --- */

int world_call_sigaction(int number, const struct sigaction *action,
                         struct sigaction *old)
{
    world_call(CALL_NS);
    world_process *process = world_process_self();
    if (!is_number(number) ||
        (action != NULL && (number == SIGKILL || number == SIGSTOP))) {
        errno = EINVAL;
        return -1;
    }
    if (old != NULL) {
        *old = process->signals->actions[number];
    }
    if (action != NULL) {
        process->signals->actions[number] = *action;
        if (effect_of(process, number) == IGNORED) {
            process->signals->pending &= ~bit(number);
        }
    }
    return 0;
}

int world_call_pthread_sigmask(int how, const sigset_t *set, sigset_t *old)
{
    world_call(CALL_NS);
    world_thread *thread = world_thread_self();
    const uint64_t before = thread->mask;
    uint64_t wanted = before;
    if (set != NULL) {
        const uint64_t bits = bits_of(set);
        switch (how) {
        case SIG_BLOCK:
            wanted |= bits;
            break;
        case SIG_UNBLOCK:
            wanted &= ~bits;
            break;
        case SIG_SETMASK:
            wanted = bits;
            break;
        default:
            return EINVAL;
        }
    }
    if (old != NULL) {
        set_of(before, old);
    }
    thread->mask = wanted & ~(bit(SIGKILL) | bit(SIGSTOP));
    (void)world_signals_deliver();
    return 0;
}

int world_call_sigprocmask(int how, const sigset_t *set, sigset_t *old)
{
    const int code = world_call_pthread_sigmask(how, set, old);
    if (code != 0) {
        errno = code;
        return -1;
    }
    return 0;
}

int world_call_raise(int number)
{
    world_call(CALL_NS);
    world_process *process = world_process_self();
    if (!is_number(number)) {
        errno = EINVAL;
        return -1;
    }
    if (number == SIGKILL || number == SIGSTOP) {
        world_process_signal(process, number);
    } else {
        world_signal_self(number);
    }
    return 0;
}

static bool is_meant(const world_process *process, const world_process *self,
                     pid_t pid)
{
    if (process->has_ended || process->host != self->host) {
        return false;
    }
    if (pid > 0) {
        return process->pid == pid;
    }
    return process->group == (pid == 0 ? self->group : -(long)pid);
}

int world_call_kill(pid_t pid, int number)
{
    world_call(CALL_NS);
    const world_process *self = world_process_self();
    bool is_self = false;
    bool found = false;
    if (number != 0 && !is_number(number)) {
        errno = EINVAL;
        return -1;
    }
    for (world_process *p = world_process_first(); p != NULL; p = p->next) {
        if (!is_meant(p, self, pid)) {
            continue;
        }
        found = true;
        is_self = is_self || p == self;
        if (number != 0 && p != self) {
            world_process_signal(p, number);
        }
    }
    if (!found) {
        errno = ESRCH;
        return -1;
    }
    if (is_self && number != 0) {
        return world_call_raise(number);
    }
    return 0;
}

/* --- the alarm --- */

static void ring(void *argument)
{
    world_process *process = argument;
    struct world_signals *signals = process->signals;
    signals->alarm = NULL;
    if (signals->interval_ns > 0) {
        signals->alarm_ns += signals->interval_ns;
        signals->alarm =
            world_at(world_host_true_ns(process->host, signals->alarm_ns), ring,
                     process);
    }
    post(process, SIGALRM);
}

static int64_t ns_of(struct timeval t)
{
    return (int64_t)t.tv_sec * WORLD_S + (int64_t)t.tv_usec * WORLD_US;
}

static struct timeval timeval_of(int64_t ns)
{
    return (struct timeval){.tv_sec = (time_t)(ns / WORLD_S),
                            .tv_usec = (suseconds_t)(ns % WORLD_S / WORLD_US)};
}

static void silence(struct world_signals *signals)
{
    if (signals->alarm != NULL) {
        world_cancel_event(signals->alarm);
        signals->alarm = NULL;
    }
}

static bool is_valid(const struct timeval *t)
{
    return t->tv_sec >= 0 && t->tv_usec >= 0 && t->tv_usec < US_PER_S;
}

int world_call_setitimer(__itimer_which_t which, const struct itimerval *wanted,
                         struct itimerval *old)
{
    world_call(CALL_NS);
    world_process *process = world_process_self();
    struct world_signals *signals = process->signals;
    const int64_t now = world_host_mono_ns(process->host);
    if (which != ITIMER_REAL || !is_valid(&wanted->it_value) ||
        !is_valid(&wanted->it_interval)) {
        errno = EINVAL;
        return -1;
    }
    if (old != NULL) {
        const int64_t left =
            signals->alarm == NULL ? 0 : signals->alarm_ns - now;
        old->it_value = timeval_of(left > 0 ? left : 0);
        old->it_interval = timeval_of(signals->interval_ns);
    }
    silence(signals);
    signals->interval_ns = ns_of(wanted->it_interval);
    if (ns_of(wanted->it_value) > 0) {
        signals->alarm_ns = now + ns_of(wanted->it_value);
        signals->alarm =
            world_at(world_host_true_ns(process->host, signals->alarm_ns), ring,
                     process);
    }
    return 0;
}

/* --- begin and end --- */

void world_signals_begin(world_process *process, const world_start *start)
{
    process->signals = calloc(1, sizeof *process->signals);
    if (process->signals == NULL) {
        abort();
    }
    if (start->ignores_int) {
        process->signals->actions[SIGINT].sa_handler = SIG_IGN;
        process->signals->actions[SIGQUIT].sa_handler = SIG_IGN;
    }
    if (start->ignores != 0) {
        process->signals->actions[start->ignores].sa_handler = SIG_IGN;
    }
}

void world_signals_free(world_process *process)
{
    silence(process->signals);
    free(process->signals);
    process->signals = NULL;
}
