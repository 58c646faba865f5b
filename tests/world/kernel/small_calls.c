#define _GNU_SOURCE /* setpriority, sched_getaffinity */
#include "small_calls.h"

#include "disk.h"
#include "stream.h"
#include "task.h"
#include "time.h"

#include <errno.h>
#include <signal.h>
#include <stdint.h>
#include <string.h>

#define CALL_NS (1 * WORLD_US)

/* The shell of all of them. */
#define PARENT 900

/* --- memory --- */

void *world_call_malloc(size_t bytes)
{
    return world_malloc(bytes);
}

void *world_call_calloc(size_t count, size_t bytes)
{
    return world_calloc(count, bytes);
}

void *world_call_realloc(void *old, size_t bytes)
{
    return world_realloc(old, bytes);
}

void world_call_free(void *memory)
{
    world_free(memory);
}

char *world_call_strndup(const char *text, size_t most)
{
    const char *end = memchr(text, '\0', most);
    const size_t length = end != NULL ? (size_t)(end - text) : most;
    char *made = world_malloc(length + 1);
    if (made != NULL) {
        memcpy(made, text, length);
        made[length] = '\0';
    }
    return made;
}

char *world_call_strdup(const char *text)
{
    return world_call_strndup(text, strlen(text));
}

/* --- who it is --- */

char *world_call_getenv(const char *name)
{
    const size_t length = strlen(name);
    char **at = world_process_self()->environment;
    while (*at != NULL &&
           (strncmp(*at, name, length) != 0 || (*at)[length] != '=')) {
        at++;
    }
    return *at != NULL ? *at + length + 1 : NULL;
}

pid_t world_call_getpid(void)
{
    return (pid_t)world_process_self()->pid;
}

pid_t world_call_getppid(void)
{
    return PARENT;
}

pid_t world_call_getpgrp(void)
{
    return (pid_t)world_process_self()->group;
}

uid_t world_call_geteuid(void)
{
    return WORLD_UID;
}

/* Of two cores, so that what works on all of them has a thread beside it. */
int world_call_sched_getaffinity(pid_t pid, size_t bytes, cpu_set_t *out)
{
    (void)pid;
    memset(out, 0, bytes);
    CPU_SET(0, out);
    CPU_SET(1, out);
    return 0;
}

/* --- ends --- */

void world_call_exit(int code)
{
    world_call(CALL_NS);
    world_stdio_flush();
    world_process_exit(code);
}

void world_call__exit(int code)
{
    world_call(CALL_NS);
    world_process_exit(code);
}

void world_call_abort(void)
{
    world_process_end(world_process_self(), SIGABRT);
    world_process_exit(1); /* not reached */
}

/* --- what the world does not have --- */

int world_call_prctl(int option, ...)
{
    world_call(CALL_NS);
    (void)option;
    return 0;
}

/* Threads of the world have no ranks; one may always be less important. */
int world_call_setpriority(__priority_which_t which, id_t who, int nice)
{
    world_call(CALL_NS);
    (void)which;
    (void)who;
    if (nice < 0) {
        errno = EACCES;
        return -1;
    }
    return 0;
}

/* As where there are too many processes. */
pid_t world_call_fork(void)
{
    world_call(CALL_NS);
    errno = EAGAIN;
    return -1;
}

int world_call_execv(const char *path, char *const arguments[])
{
    world_call(CALL_NS);
    (void)path;
    (void)arguments;
    errno = ENOENT;
    return -1;
}

pid_t world_call_waitpid(pid_t pid, int *status, int options)
{
    world_call(CALL_NS);
    (void)pid;
    (void)status;
    (void)options;
    errno = ECHILD;
    return -1;
}
