/* The laser is never on later than 3.2 s after the last heartbeat of an owner
 * that lives, and an owner that is to end sends none. */
#include "judge.h"

/* The sensor switches off 3 s after the last heartbeat (docs/protocol.md,
 * section 6); 0.2 s for its own tick and the way (docs/safety.md, "What turns
 * it off"). */
#define LATEST_NS (3200 * RECORD_MS)

/* After a signal that ends it: what waits in the kernel is taken for up to
 * 0.5 s (docs/man/lumdump.1: the data that still waits is written), while the
 * session goes on; then the laser is switched off without heartbeats
 * (docs/safety.md). */
#define LAST_BEAT_NS (1000 * RECORD_MS)

static const char late[] = "laser-late";
static const char beat[] = "heartbeat-late";

void judge_watch_until(judge_watch *w, int64_t t_ns, struct verdict *out)
{
    if (!w->is_up || w->is_told) {
        return;
    }
    if (!w->has_beat) {
        verdict_broken(out, late, t_ns,
                       "the laser is on, and no heartbeat ever came");
    } else if (t_ns - w->beat_ns > LATEST_NS) {
        verdict_broken(out, late, t_ns,
                       "the laser is on %.3f s after the last heartbeat",
                       (double)(t_ns - w->beat_ns) * 1e-9);
    } else {
        return;
    }
    w->is_told = true;
}

void judge_watch_line(judge_watch *w, const record_line *line,
                      struct verdict *out)
{
    if (line->event == RECORD_HEARTBEAT) {
        judge_watch_until(w, line->t_ns, out);
        w->beat_ns = line->t_ns;
        w->has_beat = true;
    } else if (line->event == RECORD_LASER) {
        if (line->is_yes) {
            verdict_asked(out, late);
        } else {
            judge_watch_until(w, line->t_ns, out);
        }
        w->is_up = line->is_yes;
        w->is_told = false;
    }
}

int64_t judge_watch_due(const judge_watch *w)
{
    return w->is_up && w->has_beat && !w->is_told ? w->beat_ns + LATEST_NS + 1
                                                  : RECORD_NEVER;
}

static void judge_device(const struct record *record,
                         const record_device *device, struct verdict *out)
{
    judge_watch w = {0};
    const int64_t end_ns =
        device->ended_ns < record->now_ns ? device->ended_ns : record->now_ns;
    for (size_t i = 0; i < device->count; i++) {
        judge_watch_line(&w, &device->lines[i], out);
    }
    judge_watch_until(&w, end_ns, out);
}

/* A stop does not count: nothing is sent in it. */
static void judge_beats(const struct record *record, const record_tool *tool,
                        int index, struct verdict *out)
{
    const int64_t asked_ns = record_asked_to_end(tool);
    if (asked_ns == RECORD_NEVER || !record_owns(tool)) {
        return;
    }
    verdict_asked(out, beat);
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->sender != index || d->packet != RECORD_IS_HEARTBEAT) {
            continue;
        }
        const int64_t after_ns = d->sent_ns - asked_ns -
                                 record_stopped_ns(tool, asked_ns, d->sent_ns);
        if (after_ns > LAST_BEAT_NS) {
            verdict_broken(out, beat, d->sent_ns,
                           "%s [%ld] was told to end at %.3f s and sends a "
                           "heartbeat %.3f s later",
                           tool->arguments[0], tool->id,
                           (double)asked_ns * 1e-9, (double)after_ns * 1e-9);
            return;
        }
    }
}

void judge_laser_late(const struct record *record, struct verdict *out)
{
    for (size_t i = 0; i < record->device_count; i++) {
        judge_device(record, &record->devices[i], out);
    }
    for (size_t i = 0; i < record->tool_count; i++) {
        judge_beats(record, &record->tools[i], (int)i, out);
    }
}
