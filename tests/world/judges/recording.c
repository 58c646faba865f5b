/* What a recording holds equals what arrived at its socket, byte for byte. */
#include "judge.h"
#include "packets.h"

#include <stdio.h>
#include <string.h>

static const char same[] = "recording";
static const char whole[] = "recording-whole";
static const char counted[] = "counts-of-recording";

/* A recording is written at least once a second (docs/man/lumdump.1, A SENSOR),
 * and each of its threads may have been about to. */
#define WRITTEN_NS (1300 * RECORD_MS)

/* What the writer read of its sensor, one after the other. */
struct reading {
    const struct record *record;
    size_t writer;
    uint32_t sensor;
    unsigned port;
    size_t next;
    uint64_t passed;
};

static const record_datagram *next_read(struct reading *r)
{
    while (r->next < r->record->datagram_count) {
        const record_datagram *d = &r->record->datagrams[r->next++];
        if (d->reader == (int)r->writer && d->fate == RECORD_READ &&
            d->from.address == r->sensor && d->from.port == r->port) {
            return d;
        }
    }
    return NULL;
}

/* The reading in the order of the numbers is that of sending; what was
 * overtaken on the way is looked for in a window. */
#define WINDOW 4096

struct window {
    const record_datagram *at[WINDOW];
    unsigned count;
};

static void fill(struct window *w, struct reading *r)
{
    const record_datagram *d = NULL;
    while (w->count < WINDOW && (d = next_read(r)) != NULL) {
        unsigned i = w->count++;
        for (; i > 0 && w->at[i - 1]->fate_ns > d->fate_ns; i--) {
            w->at[i] = w->at[i - 1];
        }
        w->at[i] = d;
    }
}

static void drop(struct window *w, unsigned n)
{
    w->count -= n;
    for (unsigned i = 0; i < w->count; i++) {
        w->at[i] = w->at[i + n];
    }
}

/* Passes over what came before the datagram that is in the recording. Those of
 * one moment were read in one batch. False: none is like it. */
static bool pass_to(struct window *w, struct reading *r, uint64_t hash,
                    size_t len)
{
    for (unsigned i = 0; i < w->count; i++) {
        if (w->at[i]->hash == hash && w->at[i]->len == len) {
            unsigned first = i;
            while (first > 0 &&
                   w->at[first - 1]->fate_ns == w->at[i]->fate_ns) {
                first--;
            }
            const record_datagram *found = w->at[i];
            for (unsigned k = i; k > first; k--) {
                w->at[k] = w->at[k - 1];
            }
            w->at[first] = found;
            r->passed += first;
            drop(w, first + 1);
            return true;
        }
    }
    return false;
}

static bool tells_drops(const record_tool *tool)
{
    uint64_t n = 0;
    return tool->has_stalled ||
           (tool->err != NULL &&
            strstr(tool->err, "missing from this recording") != NULL) ||
           (record_json_number(tool->out, "recording_drops", &n) && n > 0);
}

static int64_t last_beat_ns(const struct record *record, size_t writer)
{
    int64_t last_ns = 0;
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->sender == (int)writer && d->packet == RECORD_IS_HEARTBEAT) {
            last_ns = d->sent_ns;
        }
    }
    return last_ns;
}

/* What came until then has to be in it. A session that ends reads on. */
static int64_t due_until(const struct record *record, size_t writer,
                         bool is_final)
{
    const record_tool *tool = &record->tools[writer];
    const int64_t ended_ns =
        tool->ended_ns < record->now_ns ? tool->ended_ns : record->now_ns;
    const int64_t beat_ns = last_beat_ns(record, writer);
    const int64_t written_ns =
        ended_ns - WRITTEN_NS - record_stopped_ns(tool, 0, ended_ns);
    return is_final || beat_ns < written_ns ? beat_ns : written_ns;
}

static void judge_rest(const struct record *record, size_t writer,
                       const judge_file *file, struct window *w,
                       struct reading *r, struct verdict *out)
{
    const int64_t due_ns = due_until(record, writer, file->is_final);
    verdict_asked(out, whole);
    fill(w, r);
    if (w->count > 0 && w->at[0]->fate_ns < due_ns) {
        verdict_broken(out, whole, file->t_ns,
                       "%s lacks datagram %llu, read at %.3f s, and all later "
                       "ones",
                       file->name, (unsigned long long)w->at[0]->number,
                       (double)w->at[0]->fate_ns * 1e-9);
    } else if (r->passed > 0) {
        verdict_broken(out, whole, file->t_ns,
                       "%s lacks %llu datagrams in its midst, and nothing "
                       "says so",
                       file->name, (unsigned long long)r->passed);
    }
}

/* What its summary says of an output that is done; false: nothing. */
static bool find_said(const record_tool *tool, const char *name, uint64_t *out)
{
    char key[300];
    (void)snprintf(key, sizeof key, "{\"name\": \"%s\", \"end\": \"done\"",
                   name);
    const char *at = tool->out != NULL ? strstr(tool->out, key) : NULL;
    return at != NULL && record_json_number(at, "datagrams", out);
}

static void judge_number(const record_tool *tool, const judge_file *file,
                         uint64_t n, struct verdict *out)
{
    uint64_t said = 0;
    if (!find_said(tool, file->name, &said)) {
        return;
    }
    verdict_asked(out, counted);
    if (said != n) {
        verdict_broken(out, counted, file->t_ns,
                       "lumdump [%ld] says that %s has %llu datagrams, and it "
                       "has %llu",
                       tool->id, file->name, (unsigned long long)said,
                       (unsigned long long)n);
    }
}

void judge_recording(const struct record *record, size_t writer,
                     const judge_file *file, struct verdict *out)
{
    static struct window w; /* too large for a task's stack */
    struct reading r = {.record = record,
                        .writer = writer,
                        .sensor = record_host_of(&record->tools[writer]),
                        .port = record_port_of(&record->tools[writer])};
    struct packets p;
    const uint8_t *payload = NULL;
    size_t len = 0;
    uint64_t n = 0;
    w.count = 0;
    if (!packets_open(&p, file->bytes, file->size)) {
        return; /* for judge_whole() */
    }
    verdict_asked(out, same);
    while (packets_next(&p, &payload, &len) == PACKETS_ONE) {
        n++;
        fill(&w, &r);
        if (!pass_to(&w, &r, record_hash(payload, len), len)) {
            verdict_broken(out, same, file->t_ns,
                           "%s: packet %llu is none that its program read",
                           file->name, (unsigned long long)n);
            return;
        }
    }
    judge_number(&record->tools[writer], file, n, out);
    if (!tells_drops(&record->tools[writer])) {
        judge_rest(record, writer, file, &w, &r, out);
    }
}
