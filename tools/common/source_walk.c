#include "source_walk.h"

#include <stdio.h>

/* Longer than all but the name. */
#define SENTENCE_BYTES 80u

bool source_walk_step(struct source_walk *walk)
{
    struct source_walk *w = walk;
    if (w->next > 0 && w->source.records > 0) {
        w->reach_ns = w->has_before && w->reach_ns > w->source.last_ns
                          ? w->reach_ns
                          : w->source.last_ns;
        w->has_before = true;
    }
    if (w->next == lum_capture_source_count(w->capture)) {
        return false;
    }
    lum_capture_get_source(w->capture, w->next++, &w->source);
    w->gap_ns = w->has_before && w->source.records > 0
                    ? w->source.first_ns - w->reach_ns
                    : 0;
    return true;
}

bool source_walk_is_gap(const struct source_walk *walk)
{
    return walk->gap_ns >= SOURCE_WALK_GAP_NS;
}

bool source_walk_is_overlap(const struct source_walk *walk)
{
    return walk->gap_ns <= -SOURCE_WALK_OVERLAP_NS;
}

const char *source_walk_text(const struct source_walk *walk, char *out,
                             size_t room)
{
    const int len = room > SENTENCE_BYTES ? (int)(room - SENTENCE_BYTES) : 0;
    if (walk->gap_ns > 0) {
        (void)snprintf(out, room, "seconds without a capture before %.*s", len,
                       walk->source.name);
    } else {
        (void)snprintf(out, room,
                       "seconds by which %.*s begins before the end of those "
                       "before it",
                       len, walk->source.name);
    }
    return out;
}
