#define _GNU_SOURCE
#include "telling.h"

#include "dice/dice.h"
#include "witness.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* Of a processor: a telling that takes longer goes round somewhere. */
#define TELLING_S 300

/* What one process may be ahead of another one. */
#define PIPE_BYTES (1024 * 1024)

telling_plan telling_of = {.first_seed = 1};

static struct {
    unsigned count;
    uint64_t next; /* the index whose result is to come */
    struct {
        pid_t pid;
        int results; /* a pipe */
    } * each;
} processes;

/* --- Which --- */

uint64_t telling_each(void)
{
    size_t count = 0;
    if (telling_of.is_dice || telling_of.story != NULL) {
        return 1;
    }
    while (user_story_at(count) != NULL) {
        count++;
    }
    return count;
}

uint64_t telling_seed(uint64_t index)
{
    return telling_of.first_seed + index / telling_each();
}

static const user_story *story_of(uint64_t index)
{
    return telling_of.story != NULL || telling_of.is_dice
               ? telling_of.story
               : user_story_at((size_t)(index % telling_each()));
}

void telling_name(uint64_t index, char *out, size_t room)
{
    const user_story *story = story_of(index);
    (void)snprintf(out, room, "%s%s --seed %" PRIu64,
                   story != NULL ? "--story " : "--dice",
                   story != NULL ? story->name : "", telling_seed(index));
}

/* --- Here --- */

static user_result tell(uint64_t index)
{
    const user_story *story = story_of(index);
    return story != NULL ? user_tell(story, telling_seed(index))
                         : dice_run(telling_seed(index));
}

static void tell_again(telling *t)
{
    const user_result again = tell(t->index);
    if (again.digest != t->result.digest || again.calls != t->result.calls) {
        (void)snprintf(t->rule, sizeof t->rule, "twice");
        (void)snprintf(t->result.failure, sizeof t->result.failure,
                       "told twice, it was not the same: %" PRIx64
                       " after %" PRIu64 " calls, %" PRIx64 " after %" PRIu64,
                       t->result.digest, t->result.calls, again.digest,
                       again.calls);
    }
}

static int64_t cpu_ns(void)
{
    struct timespec now;
    (void)clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (int64_t)now.tv_sec * INT64_C(1000000000) + now.tv_nsec;
}

void telling_run(uint64_t index, telling *out)
{
    const struct itimerval most = {.it_value = {.tv_sec = TELLING_S}};
    const int64_t begun_ns = cpu_ns();
    (void)setitimer(ITIMER_VIRTUAL, &most, NULL);
    memset(out, 0, sizeof *out);
    out->index = index;
    out->result = tell(index);
    if (out->result.failure[0] != '\0') {
        (void)snprintf(out->rule, sizeof out->rule, "%s",
                       witness_rule()[0] != '\0' ? witness_rule() : "none");
    }
    out->programs = witness_programs();
    coverage_take(&out->met, witness_verdict());
    if (telling_of.is_twice && out->result.failure[0] == '\0') {
        tell_again(out);
    }
    out->cpu_ns = cpu_ns() - begun_ns;
}

/* --- Side by side --- */

int telling_apart(void (*run)(void *argument), void *argument)
{
    int status = 0;
    (void)fflush(stdout);
    const pid_t pid = fork();
    if (pid == 0) {
        const struct itimerval most = {.it_value = {.tv_sec = TELLING_S}};
        (void)setitimer(ITIMER_VIRTUAL, &most, NULL);
        run(argument);
        (void)fflush(stdout);
        _exit(0);
    }
    if (pid < 0 || waitpid(pid, &status, 0) != pid) {
        perror("world: a process");
        exit(1);
    }
    return status;
}

/* Whoever reads may have gone. */
static void write_all(int fd, const void *bytes, size_t size)
{
    const char *at = bytes;
    while (size > 0) {
        const ssize_t n = write(fd, at, size);
        if (n < 0 && errno != EINTR) {
            _exit(1);
        }
        at += n > 0 ? n : 0;
        size -= n > 0 ? (size_t)n : 0;
    }
}

static bool read_all(int fd, void *out, size_t size)
{
    char *at = out;
    while (size > 0) {
        const ssize_t n = read(fd, at, size);
        if (n == 0 || (n < 0 && errno != EINTR)) {
            return false;
        }
        at += n > 0 ? n : 0;
        size -= n > 0 ? (size_t)n : 0;
    }
    return true;
}

__attribute__((noreturn)) static void work(uint64_t index, int results)
{
    static telling t;
    for (;; index += processes.count) {
        telling_run(index, &t);
        write_all(results, &t, sizeof t);
    }
}

/* From an index on. */
static void begin(unsigned which, uint64_t index)
{
    int ends[2];
    (void)fflush(stdout);
    if (pipe2(ends, O_CLOEXEC) != 0) {
        perror("world: pipe");
        exit(1);
    }
    (void)fcntl(ends[1], F_SETPIPE_SZ, PIPE_BYTES); /* less is slower alone */
    const pid_t pid = fork();
    if (pid == 0) {
        (void)close(ends[0]);
        work(index, ends[1]);
    }
    if (pid < 0) {
        perror("world: fork");
        exit(1);
    }
    (void)close(ends[1]);
    processes.each[which].pid = pid;
    processes.each[which].results = ends[0];
}

void tellings_begin(unsigned count)
{
    processes.count = count;
    processes.next = 0;
    processes.each = calloc(count, sizeof processes.each[0]);
    if (processes.each == NULL) {
        abort();
    }
    for (unsigned i = 0; i < count; i++) {
        begin(i, i);
    }
}

/* It took its process with it. */
static void tell_crash(telling *out, int status)
{
    memset(out, 0, sizeof *out);
    out->index = processes.next;
    if (WIFSIGNALED(status) && WTERMSIG(status) == SIGVTALRM) {
        (void)snprintf(out->rule, sizeof out->rule, "no-end");
        (void)snprintf(out->result.failure, sizeof out->result.failure,
                       "no end in %d s of a processor", TELLING_S);
        return;
    }
    (void)snprintf(out->rule, sizeof out->rule, "crash");
    (void)snprintf(out->result.failure, sizeof out->result.failure,
                   "the program ended with %s %d",
                   WIFSIGNALED(status) ? "signal" : "status",
                   WIFSIGNALED(status) ? WTERMSIG(status)
                                       : WEXITSTATUS(status));
}

static int stop(unsigned which)
{
    int status = 0;
    (void)close(processes.each[which].results);
    (void)waitpid(processes.each[which].pid, &status, 0);
    return status;
}

void tellings_next(telling *out)
{
    const unsigned which = (unsigned)(processes.next % processes.count);
    if (!read_all(processes.each[which].results, out, sizeof *out)) {
        tell_crash(out, stop(which));
        begin(which, processes.next + processes.count);
    }
    processes.next++;
}

void tellings_end(void)
{
    for (unsigned i = 0; i < processes.count; i++) {
        (void)kill(processes.each[i].pid, SIGKILL);
        (void)stop(i);
    }
    free(processes.each);
    processes.each = NULL;
}
