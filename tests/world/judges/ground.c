/* What the other judges stand on: no table of what was seen was too short, and
 * a story leaves no rule without need. */
#include "judge.h"

static const char room[] = "room-for-all";
static const char needed[] = "leave-needed";

void judge_ground(const struct record *record, struct verdict *out)
{
    for (unsigned i = 0; i < out->left_count; i++) {
        verdict_asked(out, needed);
        if (!verdict_has(out, out->left[i])) {
            verdict_broken(out, needed, record->now_ns,
                           "the story leaves %s, and keeps it", out->left[i]);
        }
    }
    verdict_asked(out, room);
    if (record->full != NULL || out->is_full) {
        verdict_broken(out, room, record->now_ns,
                       "the judges' table of %s is full",
                       record->full != NULL ? record->full : "rules");
    }
}
