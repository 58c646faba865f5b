/* Processes: tools that run in the world. A tool's program is in an image: its
 * own objects and the project's libraries, whose calls to the system were
 * renamed to world_call_*. Its static data is put back to its first state at
 * each start, and exchanged where two processes of one tool take turns. */
#ifndef WORLD_PROCESS_H
#define WORLD_PROCESS_H

#include "file.h"
#include "host.h"

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define WORLD_FDS     256
#define WORLD_SIGNALS 65

struct world_task;
struct world_queue;

/* A tool as it was built for the world (image/make_image). Its static data is
 * from data to data_end. */
typedef struct world_image {
    const char *name;
    int (*main)(int argc, char **argv);
    char *data, *data_end;
} world_image;

/* The programs that there are: once, before the first process. The array stays
 * the caller's, and is used until the end. */
void world_process_images(const world_image *images, size_t count);

/* Of a variable of the kernel: each process has its own, which begins as it is
 * initialized. Only its tasks may use it. */
#define WORLD_OWN __attribute__((section("world_own")))

/* Declares world_call_NAME, the world's function in place of the system's. */
#define WORLD_CALL(name) __typeof__(name) world_call_##name

typedef struct world_process {
    struct world_process
        *next; /* in the order of their start; ended ones stay */
    const struct world_image *image;
    world_host *host;
    long pid, group;
    char name[16];
    char **arguments; /* NULL-terminated copies */
    char **environment;
    char directory[256]; /* working directory, absolute */
    struct world_fd {
        world_file *file; /* NULL: free */
        int flags;        /* FD_CLOEXEC */
    } fds[WORLD_FDS];
    bool has_ended;
    bool is_stopped; /* by SIGSTOP */
    int status;      /* as waitpid() gives it, once it has ended */
    int64_t began_ns, ended_ns;

    struct world_process_private *private; /* process.c: data, memory, tasks */
    struct world_signals *signals;         /* signals.c */
    struct world_stdio *stdio;             /* stdio.c */
} world_process;

/* What a process starts with. */
typedef struct world_start {
    world_host *host;
    const char *program;          /* name of an image: "lumctl" */
    const char *const *arguments; /* NULL-terminated, without the program */
    const char *const
        *environment;      /* NULL-terminated "NAME=value"; NULL: none */
    const char *directory; /* NULL: "/home" */
    world_file *input, *output, *error; /* NULL: /dev/null; a use of each is
                                         * taken over by the process */
    bool is_background; /* not in the foreground of its terminal */
    bool ignores_int;   /* as `program &` of a shell without job control */
    int ignores;        /* a further signal, as of nohup; 0: none */
} world_start;

world_process *world_process_start(const world_start *start);

/* The one whose task runs; NULL for the user and in events. */
world_process *world_process_self(void);
world_process *world_process_first(void);
world_process *world_process_find(long pid);

/* As the user sends it: SIGKILL, SIGSTOP and SIGCONT act at once. */
void world_process_signal(world_process *process, int number);
/* The task that runs gets a signal for what it did itself (SIGPIPE). It does
 * not return if that ends the process. */
void world_signal_self(int number);

/* Waits, as the user, until it ends or until a moment. False: it still runs. */
bool world_process_wait(world_process *process, int64_t until_ns);

/* The process that runs ends: files are closed, tasks dropped, memory freed. */
__attribute__((noreturn)) void world_process_exit(int code);
/* A process ends by a signal, or with its power. */
void world_process_end(world_process *process, int wait_status);

/* Memory of the process that runs, or of the world where none does. It is
 * filled with chance, and freed at the latest with the process. */
void *world_malloc(size_t bytes);
void *world_calloc(size_t count, size_t bytes);
void *world_realloc(void *old, size_t bytes);
void world_free(void *memory);

#endif
