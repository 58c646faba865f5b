#include "sweep_judge.h"

#include "judges/packets.h"
#include "judges/record.h"
#include "kernel/trace.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SENSORS   32
#define DATAGRAMS 400000
#define MARGIN_NS (1 * WORLD_MS)   /* between the sensor's log and the wire */
#define LINE_NS   (200 * WORLD_MS) /* a line of that number is the same */
#define DARK_NS   (3200 * WORLD_MS)

const char sweep_letters[SWEEP_SETTINGS + 1] = "fypgbhGBT";

/* A packet of the sensor, as it was sent. */
typedef struct sent {
    uint64_t number, hash;
    int64_t sent_ns, utc_ns; /* utc_ns: of the host that it came to */
    long reader;             /* 0: nobody read it */
    uint32_t to;
    unsigned tag, eye, line; /* of data; tag 0: it is none */
} sent;

/* One step as it was before a run. */
typedef struct before {
    const char *line; /* of the manifest, where it was done */
    bool has_file;
    uint64_t hash;
} before;

static struct {
    user_bench bench;
    const char *folder;
    const sweep_plan *plan;
    bool has_laser;
    const user_sensor *sensors[SENSORS];
    unsigned sensor_count;
    sent *sent;
    size_t sent_count, seen;
    before before[SWEEP_STEPS];
    unsigned manifests;
    char wrong[256]; /* with a manifest that was just named */
} j;

static const char *path_of(const char *name)
{
    return user_format("%s/%s", j.folder, name);
}

/* --- What is seen --- */

static void note_sent(const world_datagram *d)
{
    const uint8_t *at = d->bytes;
    if (j.sent_count == DATAGRAMS) {
        world_fail("more data than there is room for");
        return;
    }
    sent *s = &j.sent[j.sent_count++];
    *s = (sent){.number = d->number,
                .hash = record_hash(d->bytes, d->len),
                .sent_ns = d->sent_ns,
                .to = d->to};
    if (d->len >= 24 && at[8] == 8) {
        s->tag = at[12];
        s->eye = at[13];
        s->line = packets_u16(at + 14);
    }
}

static void note_end(const world_datagram *d)
{
    for (size_t i = j.sent_count; i > 0; i--) {
        sent *s = &j.sent[i - 1];
        if (s->number == d->number) {
            s->reader = d->receiver_pid;
            s->utc_ns = d->private.utc_ns;
            return;
        }
    }
}

static void note_datagram(void *context, const world_datagram *d)
{
    (void)context;
    if (d->from_port != RECORD_PORT) {
        return;
    }
    if (d->fate == WORLD_UNDER_WAY) {
        note_sent(d);
    } else if (d->fate == WORLD_RECEIVED) {
        note_end(d);
    }
}

/* Behind a text that begins here. */
static size_t skip_text(const char *text, size_t size, size_t i)
{
    for (i++; i < size && text[i] != '"'; i++) {
        i += text[i] == '\\' ? 1 : 0;
    }
    return i + 1;
}

/* Brackets that fit, and nothing behind the object but the end of its line. */
static bool is_whole(const char *text, size_t size)
{
    int64_t depth = 0;
    size_t i = 0;
    do {
        const char c = i < size ? text[i] : '\0';
        if (c == '"') {
            i = skip_text(text, size, i);
            continue;
        }
        depth += (c == '{' || c == '[') ? 1 : 0;
        depth -= (c == '}' || c == ']') ? 1 : 0;
        i++;
    } while (i < size && depth > 0);
    return depth == 0 && i + 1 == size && text[i] == '\n';
}

/* Each file that it names is there. */
static void look_at_manifest(const char *text, size_t size)
{
    world_disk *disk = world_disk_of(j.bench.host);
    const char *at = text;
    j.manifests++;
    if (!is_whole(text, size)) {
        (void)snprintf(j.wrong, sizeof j.wrong, "a manifest is not whole");
    }
    while ((at = strstr(at, "\"file\": \"")) != NULL) {
        char path[128];
        at += strlen("\"file\": \"");
        (void)snprintf(path, sizeof path, "/home/%s/%.*s", j.folder,
                       (int)strcspn(at, "\""), at);
        if (!world_disk_has(disk, path)) {
            (void)snprintf(j.wrong, sizeof j.wrong,
                           "the manifest names %s, which is not there", path);
        }
    }
}

static void note_name(const world_name_event *event, void *context)
{
    const char *end = strstr(event->path, "/manifest.json");
    size_t size = 0;
    (void)context;
    if (end == NULL || strcmp(end, "/manifest.json") != 0 || event->pid == 0 ||
        event->change != WORLD_NAME_GIVEN) {
        return;
    }
    char *text = world_disk_read_inode(event->disk, event->inode, &size);
    if (text != NULL) {
        look_at_manifest(text, size);
    }
    free(text);
}

void sweep_judge_begin(const user_bench *bench, const char *folder,
                       const sweep_plan *plan, bool has_laser)
{
    static sent room[DATAGRAMS]; /* of one story at a time */
    memset(&j, 0, sizeof j);
    j.bench = *bench;
    j.folder = folder;
    j.plan = plan;
    j.has_laser = has_laser;
    j.sent = room;
    world_net_watch(note_datagram, NULL);
    world_disk_watch(note_name, NULL);
}

void sweep_judge_sensor(const user_sensor *sensor)
{
    user_expect(j.sensor_count < SENSORS);
    j.sensors[j.sensor_count++] = sensor;
}

/* --- What a sensor did --- */

/* All that is in force at a moment. */
typedef struct state {
    char set[SWEEP_SETTINGS][8];
} state;

static void take_piece(state *s, const char *piece, size_t len)
{
    static const char table[] = "Y-scan table of ";
    const bool is_table = strncmp(piece, table, sizeof table - 1) == 0;
    const size_t digits = strspn(piece, "0123456789");
    const char letter = is_table ? 'T' : piece[len - 1];
    const char *found = strchr(sweep_letters, letter);
    if (found == NULL || (!is_table && (digits == 0 || digits + 1 != len)) ||
        len == 0) {
        return; /* it sets nothing, or was refused */
    }
    (void)snprintf(s->set[found - sweep_letters], sizeof s->set[0], "%.*s",
                   is_table ? 1 : (int)len, is_table ? "T" : piece);
    if (letter == 'f' || letter == 'y') {
        s->set[strlen(sweep_letters) - 1][0] = '\0';
    }
    if (letter == 'T') {
        s->set[1][0] = '\0';
    }
}

static void take_event(state *s, const user_event *e)
{
    const char *note =
        strcmp(e->kind, "tlv") == 0 ? user_value(e->line, "note") : NULL;
    if (strcmp(e->kind, "start") == 0 ||
        (strcmp(e->kind, "fault") == 0 && user_has(e->line, "reboot"))) {
        memset(s, 0, sizeof *s);
    }
    while (note != NULL && *note != '\0') {
        const char *end = strstr(note, "; ");
        const size_t len = end != NULL ? (size_t)(end - note) : strlen(note);
        take_piece(s, note, len);
        note = end != NULL ? end + 2 : NULL;
    }
}

static bool has_all(const state *s, const sweep_plan_step *step)
{
    for (unsigned i = 0; i < SWEEP_SETTINGS; i++) {
        if (step->in_force[i][0] != '\0' &&
            strcmp(step->in_force[i], s->set[i]) != 0) {
            return false;
        }
    }
    return true;
}

/* The sensors' events, one after the other. */
struct walk {
    state now;
    bool is_up;
    unsigned sensor;
};

static const user_event *next_event(struct walk *w, const user_event *e)
{
    e = e != NULL ? e->next : j.sensors[0]->first;
    while (e == NULL && w->sensor + 1 < j.sensor_count) {
        e = j.sensors[++w->sensor]->first;
    }
    return e;
}

static void pass(struct walk *w, const user_event *e)
{
    take_event(&w->now, e);
    if (strcmp(e->kind, "laser") == 0) {
        w->is_up = user_has(e->line, "\"up\": true");
    }
}

static bool is_so(const struct walk *w, const sweep_plan_step *step)
{
    return has_all(&w->now, step) && (w->is_up || !j.has_laser);
}

/* The moment in a span at which a setting of a step was not in force, or the
 * laser not up; -1: there is none. */
static int64_t find_lapse(const sweep_plan_step *step, int64_t from_ns,
                          int64_t to_ns)
{
    struct walk w = {.is_up = false};
    const user_event *e = next_event(&w, NULL);
    for (; e != NULL && e->t_ns <= from_ns; e = next_event(&w, e)) {
        pass(&w, e);
    }
    if (!is_so(&w, step)) {
        return from_ns;
    }
    for (; e != NULL && e->t_ns < to_ns - MARGIN_NS; e = next_event(&w, e)) {
        pass(&w, e);
        if (!is_so(&w, step)) {
            return e->t_ns;
        }
    }
    return -1;
}

/* --- Times --- */

static int64_t days_of(int64_t year, int64_t month, int64_t day)
{
    const int64_t y = month <= 2 ? year - 1 : year;
    const int64_t m = month <= 2 ? month + 9 : month - 3;
    return 365 * y + y / 4 - y / 100 + y / 400 + (153 * m + 2) / 5 + day - 1 -
           719468;
}

static int64_t field(const char *text, unsigned at)
{
    return strtol(text + at, NULL, 10);
}

/* "2026-11-28T03:49:27.123Z", in ms. */
static int64_t utc_ms(const char *text)
{
    user_expect(text != NULL && strlen(text) == 24);
    const int64_t days =
        days_of(field(text, 0), field(text, 5), field(text, 8));
    return ((days * 24 + field(text, 11)) * 60 + field(text, 14)) * 60000 +
           field(text, 17) * 1000 + field(text, 20);
}

static int64_t true_of_utc(int64_t utc_ns)
{
    return utc_ns - (world_host_utc_ns(j.bench.host) - world_now());
}

/* --- A recording --- */

/* What stands in a file. Of the moments of its first and its last packet others
 * may have come too. */
typedef struct held {
    uint64_t packets;
    uint64_t within, sum;      /* between those moments, and of the hashes */
    int64_t first_ns, last_ns; /* UTC */
} held;

static void count_within(held *h, int64_t t_ns, uint64_t hash)
{
    if (t_ns > h->first_ns && t_ns < h->last_ns) {
        h->within++;
        h->sum += hash;
    }
}

static int64_t time_of(const uint8_t *payload)
{
    const uint8_t *block = payload - 42 - 28;
    return (int64_t)((uint64_t)packets_u32(block + 12) << 32 |
                     packets_u32(block + 16));
}

/* Twice: first its ends. */
static void read_packets(const char *bytes, size_t size, bool is_first, held *h)
{
    struct packets p;
    const uint8_t *payload = NULL;
    size_t len = 0;
    packets_step step = PACKETS_ONE;
    user_expect(packets_open(&p, (const uint8_t *)bytes, size));
    while ((step = packets_next(&p, &payload, &len)) == PACKETS_ONE) {
        const int64_t t_ns = time_of(payload);
        if (is_first) {
            h->first_ns = h->packets++ == 0 ? t_ns : h->first_ns;
            h->last_ns = t_ns;
        } else {
            count_within(h, t_ns, record_hash(payload, len));
        }
    }
    user_expect_equal(step, PACKETS_END);
}

static held read_file(const char *name)
{
    held h = {.first_ns = 0};
    size_t size = 0;
    char *bytes = world_disk_read(world_disk_of(j.bench.host),
                                  user_path(path_of(name)), &size);
    user_expect(bytes != NULL);
    read_packets(bytes, size, true, &h);
    read_packets(bytes, size, false, &h);
    free(bytes);
    return h;
}

/* What its program read in a file's span. */
static held read_of(long pid, const held *file)
{
    held h = {.first_ns = file->first_ns, .last_ns = file->last_ns};
    for (size_t i = j.seen; i < j.sent_count; i++) {
        const sent *s = &j.sent[i];
        if (s->reader == pid) {
            count_within(&h, s->utc_ns, s->hash);
        }
    }
    return h;
}

/* --- What is lost --- */

#define EYES  2
#define LINES 1024

/* A line of an eye that is under way. */
typedef struct line {
    int64_t first_ns, last_ns; /* it was sent */
    unsigned came, lost;
    unsigned lost_angles, lost_ranges;
    bool is_last_lost; /* of its ranges: nobody can know of them */
} line;

/* Where half of all is lost, the framer takes a few lines at the end of a frame
 * for none (seed 920: 130 of 132 are told). */
#define SLACK 1.05

/* Whole frames that are lost in a gap are told by the gap. How many lines the
 * first frame has is not known before its end. */
#define GAP_S    0.05
#define FRAME_NS (550 * WORLD_MS)

/* Lines that lost something. */
typedef struct hurt {
    uint64_t lines; /* that lost angles, or all */
    uint64_t words; /* that lost ranges alone: of each, a word at least */
} hurt;

/* A span in which they are counted. */
typedef struct span {
    int64_t from_ns, to_ns;
    bool has_gap;
} span;

static void end_line(line *l, const span *s, hurt *out)
{
    const bool is_within =
        l->first_ns > s->from_ns + LINE_NS && l->last_ns + LINE_NS < s->to_ns;
    const bool is_whole = l->lost == 0;
    const bool is_lost =
        l->came == 0 && !s->has_gap && l->first_ns > s->from_ns + FRAME_NS;
    const bool lacks_angles = l->came > 0 && l->lost_angles > 0;
    const bool lacks_words =
        l->came > 0 && l->lost_ranges > 0 && !l->is_last_lost;
    if (is_within && !is_whole) {
        out->lines += is_lost || lacks_angles ? 1 : 0;
        out->words += !lacks_angles && lacks_words ? 1 : 0;
    }
    memset(l, 0, sizeof *l);
}

static void take_line(line *l, const sent *s, bool has_come)
{
    l->first_ns = l->first_ns == 0 ? s->sent_ns : l->first_ns;
    l->last_ns = s->sent_ns;
    if (has_come) {
        l->came++;
        l->is_last_lost = s->tag == 3 ? false : l->is_last_lost;
    } else {
        l->lost++;
        l->lost_angles += s->tag == 2 ? 1 : 0;
        l->lost_ranges += s->tag == 3 ? 1 : 0;
        l->is_last_lost = s->tag == 3 ? true : l->is_last_lost;
    }
}

/* Lines of which something was sent to the bench in a span, and did not come:
 * a lower bound. */
static hurt count_hurt(long pid, const span *within)
{
    static line lines[EYES][LINES];
    const uint32_t own = WORLD_ADDRESS(10, 42, 0, 1);
    hurt count = {.lines = 0};
    memset(lines, 0, sizeof lines);
    for (size_t i = j.seen; i < j.sent_count; i++) {
        const sent *s = &j.sent[i];
        if (s->to != own || s->sent_ns < within->from_ns ||
            s->sent_ns > within->to_ns || s->tag == 0 || s->eye >= EYES ||
            s->line >= LINES) {
            continue;
        }
        line *l = &lines[s->eye][s->line];
        if (l->last_ns != 0 && s->sent_ns - l->last_ns > LINE_NS) {
            end_line(l, within, &count);
        }
        take_line(l, s, s->reader == pid);
    }
    for (size_t i = 0; i < EYES * (size_t)LINES; i++) {
        end_line(&lines[0][0] + i, within, &count);
    }
    return count;
}

static void judge_losses(const char *json, const char *at, long pid,
                         const held *file)
{
    const double dropped =
        user_number(json, user_format("%s.packets_not_written", at));
    const double lines =
        user_number(json, user_format("%s.lines_incomplete", at)) +
        user_number(json, user_format("%s.lines_missing", at)) + dropped;
    const double words =
        user_number(json, user_format("%s.lost_words", at)) + dropped;
    const double gap_s = user_number(json, user_format("%s.longest_gap_s", at));
    const span within = {true_of_utc(file->first_ns),
                         true_of_utc(file->last_ns), gap_s > GAP_S};
    const hurt found = count_hurt(pid, &within);
    if ((double)found.lines > lines * SLACK ||
        (double)found.words > words * SLACK) {
        user_fail(USER_HERE,
                  "%s: %llu lines lost angles and %.0f are told, %llu ranges "
                  "and %.0f are told: %s",
                  at, (unsigned long long)found.lines, lines,
                  (unsigned long long)found.words, words, user_value(json, at));
    }
}

/* --- A step that is done --- */

static void judge_recording(const char *json, const char *at, long pid,
                            const sweep_plan_step *step)
{
    const char *name = user_value(json, user_format("%s.file", at));
    user_expect(name != NULL);
    const held file = read_file(name);
    const held came = read_of(pid, &file);
    const uint64_t dropped =
        (uint64_t)user_number(json, user_format("%s.packets_not_written", at));
    user_expect_equal(user_number(json, user_format("%s.packets", at)),
                      file.packets);
    user_expect_equal(
        utc_ms(user_value(json, user_format("%s.first_packet", at))),
        file.first_ns / WORLD_MS);
    user_expect_equal(
        utc_ms(user_value(json, user_format("%s.last_packet", at))),
        file.last_ns / WORLD_MS);
    user_expect_equal(file.within + dropped, came.within);
    user_expect(dropped > 0 || file.sum == came.sum);
    const int64_t lapse_ns =
        find_lapse(step, true_of_utc(file.first_ns), true_of_utc(file.last_ns));
    if (lapse_ns >= 0) {
        user_fail(USER_HERE,
                  "%s is done, and not all it says was so at %.6f s, "
                  "in %.6f to %.6f s",
                  at, (double)lapse_ns * 1e-9,
                  (double)true_of_utc(file.first_ns) * 1e-9,
                  (double)true_of_utc(file.last_ns) * 1e-9);
    }
    judge_losses(json, at, pid, &file);
}

/* --- The manifest --- */

/* NULL: there is none. */
static const char *manifest_text(void)
{
    return user_size(j.bench.host, path_of("manifest.json")) < 0
               ? NULL
               : user_file(j.bench.host, path_of("manifest.json"));
}

static const char *name_file(unsigned step)
{
    return user_format("step-%04u.pcapng", step + 1);
}

static bool is_done(const char *json, unsigned step)
{
    const char *done =
        json != NULL ? user_value(json, user_format("steps.%u.done", step))
                     : NULL;
    return done != NULL && strcmp(done, "true") == 0;
}

unsigned sweep_judge_done(void)
{
    const char *json = manifest_text();
    unsigned n = 0;
    for (unsigned i = 0; i < j.plan->count; i++) {
        n += is_done(json, i) ? 1 : 0;
    }
    return n;
}

static uint64_t hash_file(unsigned step)
{
    size_t size = 0;
    char *bytes = world_disk_read(world_disk_of(j.bench.host),
                                  user_path(path_of(name_file(step))), &size);
    const uint64_t hash = bytes != NULL ? record_hash(bytes, size) : 0;
    free(bytes);
    return hash;
}

void sweep_judge_start(void)
{
    const char *json = manifest_text();
    for (unsigned i = 0; i < j.plan->count; i++) {
        j.before[i] = (before){
            .line = is_done(json, i)
                        ? user_value(json, user_format("steps.%u", i))
                        : NULL,
            .has_file = user_size(j.bench.host, path_of(name_file(i))) >= 0,
            .hash = hash_file(i)};
    }
    j.seen = j.sent_count;
}

/* Was it done before, then this run left it as it was. */
static void judge_kept(const char *json, unsigned step, const user_tool *tool)
{
    const before *b = &j.before[step];
    user_expect_same(user_value(json, user_format("steps.%u", step)), b->line);
    user_expect(hash_file(step) == b->hash);
    user_expect_lacks(user_out(tool), user_format("step %u of %u: done",
                                                  step + 1, j.plan->count));
}

#define SET_PARTS 20

/* It held when the sensor had answered all: at some moment of the millisecond
 * that is told. The next step may follow in the same one. */
static bool was_set(const sweep_plan_step *step, int64_t set_ms)
{
    const int64_t set_ns = true_of_utc(set_ms * WORLD_MS);
    for (unsigned i = 0; i <= SET_PARTS; i++) {
        const int64_t t_ns = set_ns + i * (WORLD_MS / SET_PARTS);
        if (find_lapse(step, t_ns, t_ns) < 0) {
            return true;
        }
    }
    return false;
}

static void judge_settings(const char *json, const char *at,
                           const sweep_plan_step *step)
{
    const int64_t set_ms = utc_ms(user_value(json, user_format("%s.set", at)));
    if (!was_set(step, set_ms)) {
        user_fail(USER_HERE, "%s is done, and was not so when it was set", at);
    }
    if (j.has_laser) {
        const int status = (int)user_number(json, user_format("%s.status", at));
        user_expect_equal(status & 0x0bff, 0x0800);
    }
}

static void judge_step(const char *json, unsigned step, const user_tool *tool,
                       bool may_be_late)
{
    const char *at = user_format("steps.%u", step);
    user_expect_equal(user_number(json, user_format("%s.step", at)), step + 1);
    if (j.before[step].line != NULL) {
        judge_kept(json, step, tool);
    } else if (!is_done(json, step)) {
        const char *why = user_value(json, user_format("%s.why", at));
        user_expect(why != NULL && *why != '\0');
        user_expect(may_be_late || j.before[step].has_file ||
                    user_size(j.bench.host, path_of(name_file(step))) < 0);
        return;
    }
    if (j.before[step].line == NULL) {
        judge_settings(json, at, &j.plan->steps[step]);
    }
    if (j.before[step].line == NULL && j.plan->steps[step].records) {
        judge_recording(json, at, tool->process->pid, &j.plan->steps[step]);
    }
}

const char *sweep_judge_address(void)
{
    const char *json = manifest_text();
    return json != NULL ? user_value(json, "sensor") : NULL;
}

/* One that was refused writes nothing. */
static bool is_of_this_run(user_tool *tool)
{
    return !user_has(user_err(tool), "name another folder with -o") &&
           !user_has(user_err(tool),
                     user_format("%u of %u steps were done before",
                                 j.plan->count, j.plan->count));
}

void sweep_judge_run(user_tool *tool, bool had_disk_fault)
{
    const int status = user_wait(tool);
    const bool may_be_late = had_disk_fault || status == -SIGKILL;
    const char *json = manifest_text();
    if (j.wrong[0] != '\0') {
        user_fail(USER_HERE, "%s", j.wrong);
    }
    for (unsigned i = 0; json != NULL && i < j.plan->count; i++) {
        judge_step(json, i, tool, may_be_late);
    }
    if (status == 0) {
        user_expect_equal(sweep_judge_done(), j.plan->count);
    }
    const char *said = json != NULL ? user_value(json, "exit_status") : NULL;
    if (said != NULL && status >= 0 && !may_be_late && is_of_this_run(tool)) {
        user_expect_equal(strtol(said, NULL, 10), status);
    }
}

void sweep_judge_dark(int64_t since_ns)
{
    for (unsigned i = 0; i < j.sensor_count; i++) {
        const user_sensor *s = j.sensors[i];
        if (user_ended(s->tool)) {
            continue;
        }
        user_until(!user_laser_is_on(s));
        const user_event *last = user_last(s, "laser");
        user_expect_at_most(last != NULL ? last->t_ns : 0, since_ns + DARK_NS);
    }
}
