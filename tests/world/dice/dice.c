/* What main.c asks for: a session that is made up from its seed. */
#include "dice.h"

#include "../kernel/trace.h"
#include "../telling.h"
#include "../witness.h"
#include "script.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

/* Tellings for the smallest script of a failure. */
#define TELLINGS 400

static struct {
    bool is_set;
    bool has[SCRIPT_STEPS + 1]; /* by their numbers, from 1 */
    int64_t end_ms;
} only;

bool dice_only(const char *steps, int64_t end_ms)
{
    memset(&only, 0, sizeof only);
    only.end_ms = end_ms;
    only.is_set = steps != NULL;
    if (steps == NULL || strcmp(steps, "none") == 0) {
        return true;
    }
    for (const char *at = steps;; at++) {
        char *behind = NULL;
        const unsigned long number = strtoul(at, &behind, 10);
        if (behind == at || number == 0 || number > SCRIPT_STEPS ||
            (*behind != ',' && *behind != '\0')) {
            return false;
        }
        only.has[number] = true;
        if (*behind == '\0') {
            return true;
        }
        at = behind;
    }
}

static void draw(struct script *s, uint64_t seed)
{
    script_draw(s, seed);
    if (only.is_set) {
        script_keep(s, only.has);
    }
    if (only.end_ms > 0) {
        s->ends_ms = only.end_ms;
    }
}

user_result dice_run(uint64_t seed)
{
    static struct script s;
    draw(&s, seed);
    if (world_traces) {
        script_print(&s, stderr);
    }
    return script_tell(&s);
}

/* --- The smallest --- */

/* What failed, without times and numbers. */
static void name_failure(const user_result *result, char out[96])
{
    const char *text = result->failure;
    const char *at = strstr(text, " s: ");
    (void)snprintf(out, 96, "%.40s",
                   witness_rule()[0] != '\0' ? witness_rule()
                   : at != NULL              ? at + 4
                                             : text);
}

struct hunt {
    char failure[96];
    int status; /* of what kills; 0 */
    const struct script *script;
};

static void tell_only(void *argument)
{
    const struct hunt *hunt = argument;
    (void)script_tell(hunt->script);
}

static bool fails(const struct script *script, void *context)
{
    struct hunt *hunt = context;
    char name[96];
    hunt->script = script;
    if (hunt->status != 0) {
        return telling_apart(tell_only, hunt) == hunt->status;
    }
    const user_result result = script_tell(script);
    if (result.failure[0] == '\0') {
        return false;
    }
    name_failure(&result, name);
    return strcmp(name, hunt->failure) == 0;
}

static void print_command(const struct script *s)
{
    (void)printf("  replay: script/world --dice --seed %" PRIu64 " --steps ",
                 s->seed);
    for (unsigned i = 0; i < s->count; i++) {
        (void)printf("%s%u", i > 0 ? "," : "", s->steps[i].place);
    }
    (void)printf("%s --end %.3f --trace\n\n", s->count == 0 ? "none" : "",
                 (double)s->ends_ms / 1000.0);
}

void dice_print_smallest(uint64_t seed, bool kills)
{
    static struct script s;
    struct hunt hunt = {.script = &s};
    user_result result = {.failure = ""};
    draw(&s, seed);
    if (kills) {
        hunt.status = telling_apart(tell_only, &hunt);
    } else {
        result = script_tell(&s);
        name_failure(&result, hunt.failure);
    }
    if (hunt.status == 0 && result.failure[0] == '\0') {
        return; /* only beside what was told before: there is nothing to say */
    }
    const unsigned tellings = script_shrink(&s, fails, &hunt, TELLINGS);
    if (!kills) {
        result = script_tell(&s); /* the last one was another */
    }
    (void)printf("The smallest that fails so, after %u tellings:\n", tellings);
    script_print(&s, stdout);
    (void)printf("%s%s", result.failure, kills ? "" : "\n");
    print_command(&s);
}
