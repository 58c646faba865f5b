#include "process.h"

#include "disk.h"
#include "process_internal.h"
#include "sanitizer.h"
#include "stream.h"
#include "task.h"
#include "time.h"
#include "trace.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#define PID_FIRST 1000

/* The section is there also where no other file has a variable in it. */
__attribute__((used)) WORLD_OWN static long first_own = 1;
extern char __start_world_own[];
extern char __stop_world_own[];

/* Whose static data is in place. */
static struct {
    const world_image *images;
    size_t count;
    char **fresh;          /* of each image: its data before anything ran */
    world_process **owner; /* of each image; NULL: nobody's */
    char *own_fresh;
    world_process *own_owner;
    world_process *first;
    long pids;
} processes;

static size_t data_bytes(const world_image *image)
{
    return (size_t)(image->data_end - image->data);
}

static size_t own_bytes(void)
{
    return (size_t)(__stop_world_own - __start_world_own);
}

static void *need(void *memory)
{
    if (memory == NULL) {
        abort();
    }
    return memory;
}

static char *copy(const char *bytes, size_t size)
{
    char *made = need(malloc(size + 1));
    world_copy_unchecked(made, bytes, size);
    return made;
}

void world_process_images(const world_image *images, size_t count)
{
    processes.images = images;
    processes.count = count;
    processes.fresh = need(calloc(count + 1, sizeof(char *)));
    processes.owner = need(calloc(count + 1, sizeof(world_process *)));
    for (size_t i = 0; i < count; i++) {
        processes.fresh[i] = copy(images[i].data, data_bytes(&images[i]));
    }
    processes.own_fresh = copy(__start_world_own, own_bytes());
}

static const world_image *find_image(const char *name)
{
    for (size_t i = 0; i < processes.count; i++) {
        if (strcmp(processes.images[i].name, name) == 0) {
            return &processes.images[i];
        }
    }
    return NULL;
}

/* --- static data --- */

/* The data of the one that was there is kept, unless it has ended. */
static void exchange(char *place, size_t size, char *kept, const char *wanted)
{
    if (kept != NULL) {
        world_copy_unchecked(kept, place, size);
    }
    world_copy_unchecked(place, wanted, size);
}

static void present(world_process *process)
{
    world_process **owner = &processes.owner[process->image - processes.images];
    if (*owner != process) {
        exchange(process->image->data, data_bytes(process->image),
                 *owner != NULL ? (*owner)->private->data : NULL,
                 process->private->data);
        *owner = process;
    }
    if (processes.own_owner != process) {
        exchange(__start_world_own, own_bytes(),
                 processes.own_owner != NULL ? processes.own_owner->private->own
                                             : NULL,
                 process->private->own);
        processes.own_owner = process;
    }
}

static void free_data(world_process *process)
{
    world_process **owner = &processes.owner[process->image - processes.images];
    if (*owner == process) {
        *owner = NULL;
    }
    if (processes.own_owner == process) {
        processes.own_owner = NULL;
    }
    free(process->private->data);
    free(process->private->own);
    process->private->data = NULL;
    process->private->own = NULL;
}

/* --- threads --- */

world_thread *world_thread_self(void)
{
    const world_process *process = world_process_self();
    if (process == NULL) {
        return NULL;
    }
    const world_task *self = world_task_self();
    world_thread *thread = process->private->threads;
    while (thread != NULL && thread->task != self) {
        thread = thread->next;
    }
    return thread;
}

static void *run_thread(void *argument)
{
    world_thread *thread = argument;
    void *result = thread->run(thread->argument);
    thread->has_ended = true;
    return result;
}

world_thread *world_thread_begin(world_process *process,
                                 void *(*run)(void *argument), void *argument)
{
    const world_thread *parent = world_thread_self();
    world_thread *thread = need(calloc(1, sizeof *thread));
    world_thread **last = &process->private->threads;
    while (*last != NULL) {
        last = &(*last)->next;
    }
    *last = thread;
    thread->process = process;
    thread->run = run;
    thread->argument = argument;
    thread->mask =
        parent != NULL && parent->process == process ? parent->mask : 0;
    thread->task = world_task_begin(process, run_thread, thread);
    return thread;
}

void world_thread_free(world_thread *thread)
{
    world_thread **at = &thread->process->private->threads;
    while (*at != thread) {
        at = &(*at)->next;
    }
    *at = thread->next;
    free(thread);
}

static void free_threads(world_process *process)
{
    while (process->private->threads != NULL) {
        world_thread_free(process->private->threads);
    }
}

/* --- begin --- */

static char **copy_list(const char *first, const char *const *list)
{
    size_t count = 0;
    size_t n = 0;
    while (list != NULL && list[count] != NULL) {
        count++;
    }
    char **made = need(calloc(count + 2, sizeof(char *)));
    if (first != NULL) {
        made[n++] = copy(first, strlen(first) + 1);
    }
    for (size_t i = 0; i < count; i++) {
        made[n++] = copy(list[i], strlen(list[i]) + 1);
    }
    return made;
}

static void free_list(char **list)
{
    for (char **at = list; *at != NULL; at++) {
        free(*at);
    }
    free(list);
}

/* The tool may put its arguments in another order, and must not change ours. */
static void *run_main(void *argument)
{
    world_process *process = argument;
    int count = 0;
    while (process->arguments[count] != NULL) {
        count++;
    }
    char **words = world_calloc((size_t)count + 1, sizeof(char *));
    for (int i = 0; i < count; i++) {
        const size_t size = strlen(process->arguments[i]) + 1;
        words[i] = memcpy(world_malloc(size), process->arguments[i], size);
    }
    const int code = process->image->main(count, words);
    world_stdio_flush();
    world_process_exit(code);
}

static world_file *or_null(world_file *file, world_host *host)
{
    return file != NULL
               ? file
               : world_disk_open(world_disk_of(host), "/dev/null", O_RDWR);
}

static void tell_start(const world_process *process)
{
    char line[512];
    size_t used = 0;
    for (char **word = process->arguments; *word != NULL && used < sizeof line;
         word++) {
        used += (size_t)snprintf(line + used, sizeof line - used, " %s", *word);
    }
    world_trace("%s[%ld] on %s starts:%s", process->name, process->pid,
                process->host->name, line);
}

static world_process *make(const world_start *start, const world_image *image)
{
    world_process *process = need(calloc(1, sizeof *process));
    const size_t index = (size_t)(image - processes.images);
    process->image = image;
    process->host = start->host;
    process->pid = PID_FIRST + processes.pids++;
    process->group = process->pid;
    (void)snprintf(process->name, sizeof process->name, "%s", image->name);
    (void)snprintf(process->directory, sizeof process->directory, "%s",
                   start->directory != NULL ? start->directory : "/home");
    process->arguments = copy_list(start->program, start->arguments);
    process->environment = copy_list(NULL, start->environment);
    process->began_ns = world_now();
    process->private = need(calloc(1, sizeof *process->private));
    process->private->data = copy(processes.fresh[index], data_bytes(image));
    process->private->own = copy(processes.own_fresh, own_bytes());
    process->private->chance = world_stream("process", (uint64_t)process->pid);
    return process;
}

static void append(world_process *process)
{
    world_process **last = &processes.first;
    while (*last != NULL) {
        last = &(*last)->next;
    }
    *last = process;
}

world_process *world_process_start(const world_start *start)
{
    const world_image *image = find_image(start->program);
    if (image == NULL) {
        world_fail("there is no program %s", start->program);
        return NULL;
    }
    world_task_deliver = world_signals_deliver;
    world_task_present = present;
    world_process *process = make(start, image);
    append(process);
    world_memory_begin(process, (unsigned)(process->pid - PID_FIRST));
    world_signals_begin(process, start);
    (void)world_fd_take(process, or_null(start->input, start->host), 0);
    (void)world_fd_take(process, or_null(start->output, start->host), 0);
    (void)world_fd_take(process, or_null(start->error, start->host), 0);
    world_stdio_begin(process);
    if (world_traces) {
        tell_start(process);
    }
    (void)world_thread_begin(process, run_main, process);
    return process;
}

/* --- look --- */

world_process *world_process_self(void)
{
    const world_task *task = world_task_self();
    return task != NULL ? world_task_process(task) : NULL;
}

world_process *world_process_first(void)
{
    return processes.first;
}

world_process *world_process_find(long pid)
{
    world_process *process = processes.first;
    while (process != NULL && process->pid != pid) {
        process = process->next;
    }
    return process;
}

bool world_process_wait(world_process *process, int64_t until_ns)
{
    while (!process->has_ended && world_now() < until_ns) {
        (void)world_wait(&process->private->ended, until_ns);
    }
    return process->has_ended;
}

/* --- end --- */

static void tell_end(const world_process *process, int status)
{
    if (WIFSIGNALED(status)) {
        world_trace("%s[%ld] ends by signal %d", process->name, process->pid,
                    WTERMSIG(status));
    } else {
        world_trace("%s[%ld] ends with %d", process->name, process->pid,
                    WEXITSTATUS(status));
    }
}

/* What a process has while it runs. */
static void free_parts(world_process *process)
{
    world_fd_close_all(process);
    world_stdio_end(process);
    world_signals_free(process);
    free_threads(process);
    world_memory_free(process);
    free_data(process);
}

void world_process_end(world_process *process, int wait_status)
{
    if (process->has_ended) {
        return;
    }
    if (world_traces) {
        tell_end(process, wait_status);
    }
    const bool is_self = process == world_process_self();
    process->has_ended = true;
    process->is_stopped = false;
    process->status = wait_status;
    process->ended_ns = world_now();
    world_task_drop_others(process);
    free_parts(process);
    world_wake_all(&process->private->ended);
    if (is_self) {
        world_task_end(NULL);
    }
}

void world_process_exit(int code)
{
    world_process_end(world_process_self(), (code & 0xff) << 8);
    abort(); /* unreachable */
}

/* --- a new world --- */

void world_process_reset(void)
{
    while (processes.first != NULL) {
        world_process *process = processes.first;
        processes.first = process->next;
        if (!process->has_ended) {
            free_parts(process);
        }
        free_list(process->arguments);
        free_list(process->environment);
        free(process->private);
        free(process);
    }
    processes.pids = 0;
    world_memory_reset();
}
