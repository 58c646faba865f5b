/* Delta debugging (Zeller, Hildebrandt 2002) over the steps of a script, under
 * its own seed. Each kind of chance has its own stream, so most of what is left
 * meets what it met before; where it does not, the step stays. */
#include "script.h"

#include <string.h>

struct shrinking {
    bool (*fails)(const struct script *script, void *context);
    void *context;
    unsigned tellings, most;
};

static bool still_fails(struct shrinking *s, const struct script *script)
{
    s->tellings++;
    return s->fails(script, s->context);
}

/* Without some steps. */
static void leave_out(const struct script *from, unsigned first, unsigned count,
                      struct script *out)
{
    *out = *from;
    out->count = from->count - count;
    memmove(out->steps + first, from->steps + first + count,
            (from->count - first - count) * sizeof from->steps[0]);
}

/* One pass over all pieces of a size. True: something could go. */
static bool pass(struct shrinking *s, struct script *best, unsigned size)
{
    static struct script smaller;
    bool has_shrunk = false;
    for (unsigned first = 0; first < best->count && s->tellings < s->most;) {
        const unsigned left = best->count - first;
        leave_out(best, first, size < left ? size : left, &smaller);
        if (still_fails(s, &smaller)) {
            *best = smaller;
            has_shrunk = true;
        } else {
            first += size;
        }
    }
    return has_shrunk;
}

/* The idle time at its end. */
static void cut_end(struct shrinking *s, struct script *best)
{
    static struct script shorter;
    int64_t last_ms = 0;
    for (unsigned i = 0; i < best->count; i++) {
        const int64_t end_ms = best->steps[i].at_ms + best->steps[i].lasts_ms;
        last_ms = end_ms > last_ms ? end_ms : last_ms;
    }
    shorter = *best;
    shorter.ends_ms = last_ms + 5000;
    if (shorter.ends_ms < best->ends_ms && still_fails(s, &shorter)) {
        *best = shorter;
    }
}

unsigned script_shrink(struct script *script,
                       bool (*fails)(const struct script *script,
                                     void *context),
                       void *context, unsigned tellings_max)
{
    struct shrinking s = {.fails = fails, .context = context};
    s.most = tellings_max;
    for (unsigned size = (script->count + 1) / 2; size > 0; size /= 2) {
        while (pass(&s, script, size) && size == 1) {
        }
    }
    cut_end(&s, script);
    return s.tellings;
}
