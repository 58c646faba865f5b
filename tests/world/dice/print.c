/* A script as a text for people. */
#include "script.h"

#include <inttypes.h>
#include <signal.h>
#include <string.h>

static const char *way(const script_step *step)
{
    static const char *const ways[] = {[SCRIPT_BOTH] = "both ways",
                                       [SCRIPT_OUT] = "from the bench",
                                       [SCRIPT_IN] = "to the bench"};
    return ways[step->way];
}

static void print_faults(const script_step *step, FILE *out)
{
    const user_faults *f = &step->faults;
    const struct {
        double value;
        const char *format;
    } all[] = {{f->lose, " loses %g"},         {f->repeat, " repeats %g"},
               {f->corrupt, " corrupts %g"},   {f->reorder, " reorders %g"},
               {f->reorder_ms, " (%g ms)"},    {f->delay_ms, " delay %g ms"},
               {f->jitter_ms, " jitter %g ms"}};
    (void)fprintf(out, "the wire %s:", way(step));
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        if (all[i].value > 0) {
            (void)fprintf(out, all[i].format, all[i].value);
        }
    }
}

static void print_run(const script_step *step, FILE *out)
{
    (void)fprintf(out, "[%u]%s $ %s", step->tool,
                  step->is_far ? " (other)" : "", step->text);
    if (step->is_stalled) {
        (void)fprintf(out, " | (a reader of %" PRId64 " bytes a second%s)",
                      step->value, step->lasts_ms > 0 ? ", which goes" : "");
    }
    (void)fputs(step->ignores_int ? " &" : "", out);
}

/* What befalls a tool. */
static void print_of_tool(const script_step *step, FILE *out)
{
    if (step->kind == SCRIPT_TYPE) {
        (void)fprintf(out, "[%u] is typed: %s", step->tool,
                      step->text[0] != '\0' ? step->text : "(the end)");
    } else if (step->kind == SCRIPT_SIGNAL) {
        (void)fprintf(out, "[%u] gets signal %d", step->tool, step->number);
    } else if (step->kind == SCRIPT_STOP) {
        (void)fprintf(out, "[%u] is stopped", step->tool);
    } else if (step->number == SIGSTOP) {
        (void)fprintf(
            out, "[%u] is stopped for %.3f s before its %u. call of %s",
            step->tool, (double)step->value / 1e3, step->n, step->call);
    } else {
        (void)fprintf(out, "[%u] gets signal %d before its %u. call of %s",
                      step->tool, step->number, step->n, step->call);
    }
}

/* What befalls the bench: with a number, or without. */
static void print_of_bench(const script_step *step, FILE *out)
{
    static const char *const texts[] = {
        [SCRIPT_CABLE] = "the cable is pulled",
        [SCRIPT_ADDRESS] = "the bench loses its address",
        [SCRIPT_POWER] = "the sensor's power is off"};
    if (step->kind == SCRIPT_CLOCK) {
        (void)fprintf(out, "the calendar is set by %" PRId64 " ms",
                      step->value);
    } else if (step->kind == SCRIPT_DRIFT) {
        (void)fprintf(out, "the bench's clock is fast by %" PRId64 " ppm",
                      step->value);
    } else if (step->kind == SCRIPT_SLOW) {
        (void)fprintf(out, "the bench is %" PRId64 " times as slow",
                      step->value);
    } else if (step->kind == SCRIPT_BLACKOUT) {
        (void)fprintf(out, "the bench's power is cut (%" PRId64 " %% kept)",
                      step->value);
    } else {
        (void)fputs(texts[step->kind], out);
    }
}

static void print_plan(const script_step *step, FILE *out)
{
    (void)fprintf(out, "writes plan%u.yaml:", step->n);
    for (const char *at = step->text; *at != '\0';) {
        const size_t len = strcspn(at, "\n");
        (void)fprintf(out, "\n                 %.*s", (int)len, at);
        at += len + (at[len] == '\n' ? 1 : 0);
    }
}

static void print_own(const script_step *step, FILE *out)
{
    switch (step->kind) {
    case SCRIPT_RUN:
        print_run(step, out);
        break;
    case SCRIPT_TYPE:
    case SCRIPT_SIGNAL:
    case SCRIPT_STOP:
    case SCRIPT_AT_CALL:
        print_of_tool(step, out);
        break;
    case SCRIPT_PLAN:
        print_plan(step, out);
        break;
    case SCRIPT_WIRE:
        print_faults(step, out);
        break;
    case SCRIPT_CUT:
        (void)fprintf(out, "the wire is cut, %s", way(step));
        break;
    case SCRIPT_DISK:
        (void)fprintf(out, "the disk: %s", step->text);
        break;
    case SCRIPT_SENSOR:
        (void)fprintf(out, "the sensor: %s", step->text);
        break;
    case SCRIPT_CABLE:
    case SCRIPT_ADDRESS:
    case SCRIPT_CLOCK:
    case SCRIPT_DRIFT:
    case SCRIPT_SLOW:
    case SCRIPT_POWER:
    case SCRIPT_BLACKOUT:
        print_of_bench(step, out);
        break;
    }
}

/* What it waits for. */
static void print_aim(const script_step *step, FILE *out)
{
    if (step->call[0] != '\0' && step->kind != SCRIPT_AT_CALL) {
        (void)fprintf(out, "from the %u. call of %s by [%u] on: ", step->n,
                      step->call, step->tool);
    }
}

void script_print(const struct script *script, FILE *out)
{
    (void)fprintf(out, "script of seed %" PRIu64 "; the sensor: lumsim %s\n",
                  script->seed, script->sensor);
    for (unsigned i = 0; i < script->count; i++) {
        const script_step *step = &script->steps[i];
        (void)fprintf(out, "%4u %8.3f s  ", step->place,
                      (double)step->at_ms / 1000.0);
        print_aim(step, out);
        print_own(step, out);
        if (step->lasts_ms > 0) {
            (void)fprintf(out, "%s %.3f s",
                          step->kind == SCRIPT_RUN ? " after" : " for",
                          (double)step->lasts_ms / 1000.0);
        }
        if (step->kind == SCRIPT_RUN && script_process(step->tool)[0] != '\0') {
            (void)fprintf(out, "    ([%u] = %s)", step->tool,
                          script_process(step->tool));
        }
        (void)fputc('\n', out);
    }
    (void)fprintf(out, "     %8.3f s  the end\n",
                  (double)script->ends_ms / 1000.0);
}
