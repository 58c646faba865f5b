#include "internal.h"

#include "kernel/random.h"
#include "kernel/trace.h"
#include "kernel/world.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LIMIT_S     600
#define LIMIT_CALLS UINT64_C(20000000)

/* What changes without a call of a process, or in the midst of one, is looked
 * at so often. */
#define LOOK_SOON_NS  (2 * WORLD_MS)
#define LOOK_LATER_NS (200 * WORLD_MS)

#define STORIES    4096
#define CALL_NAMES 64 /* a power of 2 */

void (*user_begins)(void);
void (*user_ends)(void);
void (*user_prints)(const user_text *text);
void (*user_types)(const user_tool *tool, const char *text);
void (*user_leaves)(const char *rule, const char *why);

extern const user_story *const __start_world_stories[];
extern const user_story *const __stop_world_stories[];

static struct {
    const user_story *story;
    int64_t limit_ns;
    uint64_t calls, limit_calls;
    world_queue changed;
    bool will_change; /* the call that was last begun can be seen */
    int64_t look_ns;
    world_random any;
} telling;

/* --- the table --- */

static int by_place(const void *left, const void *right)
{
    const user_story *a = *(const user_story *const *)left;
    const user_story *b = *(const user_story *const *)right;
    const int files = strcmp(a->file, b->file);
    return files != 0 ? files : a->line - b->line;
}

/* The linker has them in an order of its own. */
const user_story *user_story_at(size_t i)
{
    static const user_story *table[STORIES];
    static size_t count;
    if (count == 0) {
        count = (size_t)(__stop_world_stories - __start_world_stories);
        if (count > STORIES) {
            abort();
        }
        memcpy(table, __start_world_stories,
               count * sizeof(const user_story *));
        qsort(table, count, sizeof(const user_story *), by_place);
    }
    return i < count ? table[i] : NULL;
}

const user_story *user_story_find(const char *name)
{
    const user_story *story = NULL;
    for (size_t i = 0; (story = user_story_at(i)) != NULL; i++) {
        if (strcmp(story->name, name) == 0) {
            return story;
        }
    }
    return NULL;
}

/* --- calls of processes --- */

/* Whether a call may change what can be seen from outside. */
static bool is_visible(const char *name)
{
    static const char *const parts[] = {"write", "print", "put",  "flush",
                                        "close", "link",  "exit", "send",
                                        "open",  "mkdir", "name", "truncate"};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        if (strstr(name, parts[i]) != NULL) {
            return true;
        }
    }
    return false;
}

/* Names of calls are constants: each is judged once. */
static bool is_visible_soon(const char *name)
{
    static struct {
        const char *name;
        bool is_visible;
    } known[CALL_NAMES];
    const size_t at = ((uintptr_t)name >> 4) % CALL_NAMES;
    if (known[at].name != name) {
        known[at].name = name;
        known[at].is_visible = is_visible(name);
    }
    return known[at].is_visible;
}

static void on_call(world_process *process, const char *name)
{
    if (++telling.calls == telling.limit_calls) {
        world_fail("the tools have called their system %" PRIu64 " times",
                   telling.calls);
    }
    if (telling.will_change) {
        user_has_changed();
    }
    telling.will_change = is_visible_soon(name);
    user_tool_calls(process, name);
}

void user_has_changed(void)
{
    telling.look_ns = LOOK_SOON_NS;
    world_wake_all(&telling.changed);
}

/* --- waiting --- */

void user_limit(int64_t seconds, uint64_t calls)
{
    telling.limit_ns = seconds * WORLD_S;
    telling.limit_calls = calls;
}

int64_t user_limit_ns(void)
{
    return telling.limit_ns;
}

void user_wait_for_more(user_place at, const char *what)
{
    if (world_now() >= telling.limit_ns) {
        user_fail(at, "waited in vain for %s", what);
    }
    int64_t until_ns = world_now() + telling.look_ns;
    if (until_ns > telling.limit_ns) {
        until_ns = telling.limit_ns;
    }
    if (telling.look_ns < LOOK_LATER_NS) {
        telling.look_ns += telling.look_ns / 2;
    }
    world_wait_deaf(&telling.changed, until_ns);
}

void user_wait_on(world_queue *queue, const char *what)
{
    if (world_now() >= telling.limit_ns) {
        user_fail(USER_HERE, "waited in vain for %s", what);
    }
    world_wait_deaf(queue, telling.limit_ns);
}

void user_pause_ms(int64_t ms)
{
    world_queue nobody = {NULL, NULL};
    const int64_t until_ns = world_now() + ms * WORLD_MS;
    if (until_ns >= telling.limit_ns) {
        user_fail(USER_HERE, "a pause beyond the limit");
    }
    user_trace("waits %" PRId64 " ms", ms);
    world_wait_deaf(&nobody, until_ns);
}

void user_pause_between_ms(int64_t least, int64_t most)
{
    user_pause_ms(user_any(least, most));
}

int64_t user_any(int64_t least, int64_t most)
{
    return world_random_between(&telling.any, least, most);
}

void user_trace(const char *format, ...)
{
    va_list arguments;
    char text[512];
    if (!world_traces) {
        return;
    }
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    world_trace("%s", text);
}

/* --- expecting --- */

static const char *file_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash != NULL ? slash + 1 : path;
}

void user_fail(user_place at, const char *format, ...)
{
    va_list arguments;
    char text[512];
    char tools[768];
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    user_tell_tools(tools, sizeof tools);
    world_fail("%s:%d: %s%s", file_name(at.file), at.line, text, tools);
    world_task_end(NULL);
}

void user_check_equal(user_place at, const char *what, int64_t left,
                      int64_t right)
{
    if (left != right) {
        user_fail(at, "%s is %" PRId64 " and not %" PRId64, what, left, right);
    }
}

void user_check_order(user_place at, const char *what, int64_t left,
                      int64_t right, bool at_least)
{
    if (at_least ? left < right : left > right) {
        user_fail(at, "%s is %" PRId64 ", %s %" PRId64, what, left,
                  at_least ? "less than" : "more than", right);
    }
}

/* The end of a text that may be long. */
static const char *tail(const char *text)
{
    const size_t size = strlen(text);
    return size > 300 ? text + size - 300 : text;
}

void user_check_has(user_place at, const char *text, const char *part,
                    bool expected)
{
    if (user_has(text, part) != expected) {
        user_fail(at, "'%s' is %s in '%s'", part, expected ? "not" : "found",
                  tail(text));
    }
}

void user_check_same(user_place at, const char *left, const char *right)
{
    if (strcmp(left, right) != 0) {
        user_fail(at, "'%s' is not '%s'", tail(left), tail(right));
    }
}

void user_check_like(user_place at, const char *text, const char *pattern)
{
    if (!user_like(text, pattern)) {
        user_fail(at, "'%s' does not match '%s'", pattern, tail(text));
    }
}

/* --- judges --- */

void user_leave(const char *rule, const char *why)
{
    user_trace("leaves the rule %s: %s", rule, why);
    if (user_leaves != NULL) {
        user_leaves(rule, why);
    }
}

/* --- a telling --- */

static void *tell(void *unused)
{
    (void)unused;
    WORLD_TRACE("%s: %s", telling.story->name, telling.story->fact);
    telling.story->tell();
    WORLD_TRACE("all is told");
    return NULL;
}

static void begin(const user_story *story, uint64_t seed)
{
    world_begin(seed);
    memset(&telling, 0, sizeof telling);
    telling.story = story;
    telling.look_ns = LOOK_SOON_NS;
    telling.any = world_stream("story", 0);
    user_limit(LIMIT_S, LIMIT_CALLS);
    world_hook = on_call;
    if (user_begins != NULL) {
        user_begins();
    }
}

user_result user_tell(const user_story *story, uint64_t seed)
{
    user_result result = {.failure = ""};
    begin(story, seed);
    const bool has_ended =
        world_run(world_task_begin(NULL, tell, NULL), WORLD_NEVER);
    if (!has_ended && world_failure()[0] == '\0') {
        world_fail("nothing can happen any more, and the story waits");
    }
    if (user_ends != NULL) {
        user_ends();
    }
    (void)snprintf(result.failure, sizeof result.failure, "%s",
                   world_failure());
    result.lasted_ns = world_now();
    result.calls = telling.calls;
    result.digest = world_digest();
    world_hook = NULL;
    user_tool_reset();
    user_bench_reset();
    world_end();
    user_text_reset();
    return result;
}
