#include "task.h"

#include "random.h"
#include "stack.h"
#include "task_internal.h"
#include "time.h"
#include "time_internal.h"
#include "trace.h"

#include <errno.h>
#include <stdlib.h>

/* A task runs this long before another one that is ready has its turn. */
#define SLICE_NS (100 * WORLD_US)

/* A call gives way once in so many, though nothing asks for it: the places
 * where a real scheduler would change threads. */
#define GIVE_WAY_ONCE_IN 32

/* Events and turns without time going on: something goes round. */
#define TURNS_IN_A_MOMENT 1000000u

enum task_state {
    TASK_READY,
    TASK_WAITING,
    TASK_ENDED
};

/* A task's place in one of the queues that it waits on. */
typedef struct world_waiter {
    world_task *task;
    world_queue *queue; /* NULL: not in one */
    struct world_waiter *before, *after;
} world_waiter;

struct world_task {
    world_task *next; /* in the order of their beginning */
    unsigned number;
    world_process *process;
    enum task_state state;
    bool is_dropped; /* ended from outside: nobody joins it */
    bool is_joined;
    void *(*run)(void *argument);
    void *argument;
    void *result;
    world_queue ended; /* who joins */
    world_waiter waiters[WORLD_WAITS];
    unsigned waiter_count;
    world_event *alarm;
    world_wake wake;
    int error; /* its errno while another one runs */
    world_stack *stack;
};

bool (*world_task_deliver)(void);
void (*world_task_present)(world_process *process);
void (*world_hook)(world_process *process, const char *name);

static struct {
    world_task *first, *last;
    world_task *self;
    world_process *present; /* whose static data is in place */
    world_task **ready;
    size_t ready_count, ready_room;
    unsigned numbers;
    int64_t slice_end_ns;
    world_random order;
} tasks;

world_task *world_task_self(void)
{
    return tasks.self;
}

world_process *world_task_process(const world_task *task)
{
    return task->process;
}

unsigned world_task_number(const world_task *task)
{
    return task->number;
}

world_task *world_task_next(const world_process *process,
                            const world_task *after)
{
    world_task *task = after == NULL ? tasks.first : after->next;
    while (task != NULL &&
           (task->process != process || task->state == TASK_ENDED)) {
        task = task->next;
    }
    return task;
}

static void make_ready(world_task *task)
{
    if (tasks.ready_count == tasks.ready_room) {
        tasks.ready_room = tasks.ready_room == 0 ? 16 : 2 * tasks.ready_room;
        tasks.ready =
            realloc(tasks.ready, tasks.ready_room * sizeof(world_task *));
        if (tasks.ready == NULL) {
            abort();
        }
    }
    task->state = TASK_READY;
    tasks.ready[tasks.ready_count++] = task;
}

static void not_ready(size_t i)
{
    tasks.ready_count--;
    for (; i < tasks.ready_count; i++) {
        tasks.ready[i] = tasks.ready[i + 1];
    }
}

/* On its own stack. */
static void run_task(void)
{
    world_task *task = tasks.self;
    world_task_end(task->run(task->argument));
}

world_task *world_task_begin(world_process *process,
                             void *(*run)(void *argument), void *argument)
{
    world_task *task = calloc(1, sizeof *task);
    if (task == NULL) {
        abort();
    }
    task->process = process;
    task->run = run;
    task->argument = argument;
    task->number = ++tasks.numbers;
    task->stack = world_stack_new(run_task, task->number);
    if (tasks.last != NULL) {
        tasks.last->next = task;
    } else {
        tasks.first = task;
    }
    tasks.last = task;
    make_ready(task);
    return task;
}

/* --- queues --- */

static void join_queue(world_task *task, world_queue *queue)
{
    world_waiter *waiter = &task->waiters[task->waiter_count++];
    *waiter = (world_waiter){
        .task = task, .queue = queue, .before = queue->last, .after = NULL};
    if (queue->last != NULL) {
        queue->last->after = waiter;
    } else {
        queue->first = waiter;
    }
    queue->last = waiter;
}

static void leave_queues(world_task *task)
{
    for (unsigned i = 0; i < task->waiter_count; i++) {
        world_waiter *w = &task->waiters[i];
        if (w->before != NULL) {
            w->before->after = w->after;
        } else {
            w->queue->first = w->after;
        }
        if (w->after != NULL) {
            w->after->before = w->before;
        } else {
            w->queue->last = w->before;
        }
    }
    task->waiter_count = 0;
}

/* A task that waits goes on. */
static void wake(world_task *task, world_wake why)
{
    leave_queues(task);
    if (task->alarm != NULL) {
        world_cancel_event(task->alarm);
        task->alarm = NULL;
    }
    task->wake = why;
    make_ready(task);
}

static void ring(void *argument)
{
    world_task *task = argument;
    task->alarm = NULL;
    wake(task, WORLD_TIMED_OUT);
}

void world_wake_all(world_queue *queue)
{
    while (queue->first != NULL) {
        wake(queue->first->task, WORLD_WOKEN);
    }
}

void world_wake_one(world_queue *queue)
{
    size_t count = 0;
    for (const world_waiter *w = queue->first; w != NULL; w = w->after) {
        count++;
    }
    if (count == 0) {
        return;
    }
    world_waiter *chosen = queue->first;
    for (uint64_t skip = world_random_below(&tasks.order, count); skip > 0;
         skip--) {
        chosen = chosen->after;
    }
    wake(chosen->task, WORLD_WOKEN);
}

void world_task_interrupt(world_task *task)
{
    if (task->state == TASK_WAITING) {
        wake(task, WORLD_INTERRUPTED);
    }
}

/* --- turns --- */

/* Back to the scheduler; returns when the task has its next turn. */
static void give_turn(void)
{
    world_task *self = tasks.self;
    self->error = errno;
    world_stack_rest(self->stack);
    errno = self->error;
}

/* The one that asks to wait, to give way or to end; an event cannot. */
static world_task *self_of_task(void)
{
    if (tasks.self == NULL) {
        abort();
    }
    return tasks.self;
}

static void block(world_queue *const *queues, unsigned count, int64_t until_ns)
{
    world_task *self = self_of_task();
    if (count > WORLD_WAITS) {
        abort();
    }
    for (unsigned i = 0; i < count; i++) {
        join_queue(self, queues[i]);
    }
    if (until_ns != WORLD_NEVER) {
        self->alarm = world_at(until_ns, ring, self);
    }
    self->state = TASK_WAITING;
    give_turn();
}

static bool deliver(void)
{
    return tasks.self->process != NULL && world_task_deliver != NULL &&
           world_task_deliver();
}

/* A signal may come before the wait, or be what ends it. */
world_wake world_wait_any(world_queue *const *queues, unsigned count,
                          int64_t until_ns)
{
    world_task *self = self_of_task();
    if (deliver()) {
        return WORLD_INTERRUPTED;
    }
    block(queues, count, until_ns);
    if (deliver()) {
        return WORLD_INTERRUPTED;
    }
    /* A signal that was taken by a handler that ends no wait. */
    return self->wake == WORLD_INTERRUPTED ? WORLD_WOKEN : self->wake;
}

world_wake world_wait(world_queue *queue, int64_t until_ns)
{
    return world_wait_any(&queue, 1, until_ns);
}

void world_wait_deaf(world_queue *queue, int64_t until_ns)
{
    block(&queue, 1, until_ns);
}

void world_yield(void)
{
    make_ready(self_of_task());
    give_turn();
}

void world_call_of(const char *name, int64_t cost_ns)
{
    const world_task *self = tasks.self;
    if (self == NULL) {
        return;
    }
    if (self->process == NULL) {
        world_spend(cost_ns);
        return;
    }
    if (world_hook != NULL) {
        world_hook(self->process, name);
    }
    world_spend(cost_ns * (int64_t)self->process->host->slowness);
    if (world_now() >= tasks.slice_end_ns ||
        world_next_event_ns() <= world_now() || self->process->is_stopped ||
        self->process->has_ended ||
        (tasks.ready_count > 0 &&
         world_random_below(&tasks.order, GIVE_WAY_ONCE_IN) == 0)) {
        world_yield();
    }
    (void)deliver();
}

/* --- ends --- */

static void end(world_task *task)
{
    leave_queues(task);
    if (task->alarm != NULL) {
        world_cancel_event(task->alarm);
        task->alarm = NULL;
    }
    for (size_t i = 0; i < tasks.ready_count; i++) {
        if (tasks.ready[i] == task) {
            not_ready(i);
            break;
        }
    }
    task->state = TASK_ENDED;
}

void world_task_end(void *result)
{
    world_task *self = self_of_task();
    self->result = result;
    end(self);
    world_wake_all(&self->ended);
    world_stack_end(self->stack);
}

void *world_task_join(world_task *task)
{
    while (task->state != TASK_ENDED) {
        world_wait_deaf(&task->ended, WORLD_NEVER);
    }
    task->is_joined = true;
    return task->result;
}

static void free_task(world_task *task)
{
    if (task->stack != NULL) {
        world_stack_free(task->stack);
    }
    free(task);
}

void world_task_drop_others(world_process *process)
{
    for (world_task *task = tasks.first; task != NULL; task = task->next) {
        if (task->process == process && task != tasks.self &&
            task->state != TASK_ENDED) {
            end(task);
            task->is_dropped = true;
        }
    }
}

/* Those that nobody can ask for any more. Not the one whose stack may be in
 * use: this runs on the scheduler's. */
static void sweep(void)
{
    world_task **at = &tasks.first;
    tasks.last = NULL;
    while (*at != NULL) {
        world_task *task = *at;
        if (task->state == TASK_ENDED && task->stack != NULL) {
            world_stack_free(task->stack);
            task->stack = NULL;
        }
        if (task->state == TASK_ENDED &&
            (task->is_joined || task->is_dropped ||
             (task->process != NULL && task->process->has_ended))) {
            *at = task->next;
            free_task(task);
        } else {
            tasks.last = task;
            at = &task->next;
        }
    }
}

/* --- the scheduler --- */

static void turn(world_task *task)
{
    tasks.self = task;
    tasks.slice_end_ns = world_now() + SLICE_NS;
    world_digest_add((uint64_t)world_now() ^ (uint64_t)task->number << 48);
    if (task->process != NULL && task->process != tasks.present &&
        world_task_present != NULL) {
        world_task_present(task->process);
        tasks.present = task->process;
    }
    world_stack_turn(task->stack);
    tasks.self = NULL;
    if (task->state == TASK_ENDED) {
        sweep();
    }
}

static bool can_run(const world_task *task)
{
    return task->process == NULL || !task->process->is_stopped;
}

/* One of those that are ready, by the seed. */
static world_task *choose(void)
{
    size_t able = 0;
    for (size_t i = 0; i < tasks.ready_count; i++) {
        able += can_run(tasks.ready[i]) ? 1 : 0;
    }
    if (able == 0) {
        return NULL;
    }
    uint64_t skip = able == 1 ? 0 : world_random_below(&tasks.order, able);
    for (size_t i = 0;; i++) {
        world_task *task = tasks.ready[i];
        if (can_run(task) && skip-- == 0) {
            not_ready(i);
            return task;
        }
    }
}

bool world_run(world_task *user, int64_t until_ns)
{
    unsigned turns = 0;
    int64_t moment = world_now();
    while (user->state != TASK_ENDED && world_failure()[0] == '\0') {
        turns = world_now() == moment ? turns + 1 : 0;
        moment = world_now();
        if (turns > TURNS_IN_A_MOMENT) {
            world_fail(
                "time stands still: something goes round without a wait");
            return false;
        }
        if (moment >= until_ns) {
            return false;
        }
        if (world_run_due()) {
            continue;
        }
        world_task *task = choose();
        if (task != NULL) {
            turn(task);
        } else if (world_next_event_ns() != WORLD_NEVER) {
            world_jump(world_next_event_ns());
        } else {
            return false;
        }
    }
    return user->state == TASK_ENDED;
}

/* None is left in a queue, which others free later. */
void world_task_reset(void)
{
    for (world_task *task = tasks.first; task != NULL; task = task->next) {
        leave_queues(task);
    }
    while (tasks.first != NULL) {
        world_task *task = tasks.first;
        tasks.first = task->next;
        free_task(task);
    }
    tasks.last = NULL;
    tasks.self = NULL;
    tasks.present = NULL;
    tasks.ready_count = 0;
    tasks.numbers = 0;
    tasks.order = world_stream("order", 0);
    world_hook = NULL;
}
