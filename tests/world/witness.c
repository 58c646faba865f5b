#include "witness.h"

#include "judges/judge.h"
#include "kernel/disk.h"
#include "kernel/net.h"
#include "kernel/time.h"
#include "kernel/trace.h"
#include "user/internal.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TOOLS   512
#define HOSTS   32
#define DEVICES 128

/* What the user told of a tool. */
typedef struct knowledge {
    bool is_stalled, is_wrong, is_cut;
    unsigned held_count;
    int64_t held_ns[RECORD_SPANS];
} knowledge;

/* A sensor, as in the record. */
typedef struct device {
    size_t of; /* its tool */
    judge_watch watch;
    bool is_watched;
} device;

/* A file that a tool gave its name: all others are the user's own. */
typedef struct named {
    struct named *next;
    const world_disk *disk;
    const char *path;
} named;

static struct {
    named *named;
    struct record record;
    struct verdict verdict;
    bool knows_all;
    int64_t dark_ns;               /* the last blackout */
    const user_tool *tools[TOOLS]; /* as in the record */
    knowledge known[TOOLS];
    world_host *hosts[HOSTS];
    device devices[DEVICES];
    char rule[48];
} w;

/* What has no room any more would be judged by what is left of it. */
static void is_full(const char *table)
{
    w.record.full = table;
}

/* --- Tools --- */

static unsigned number_host(world_host *host)
{
    unsigned i = 0;
    while (i < HOSTS && w.hosts[i] != NULL && w.hosts[i] != host) {
        i++;
    }
    if (i == HOSTS) {
        is_full("hosts");
        return 0;
    }
    w.hosts[i] = host;
    return i;
}

/* The sensor of its environment. */
static uint32_t usual_of(const world_process *process)
{
    static const char name[] = "LUM_HOST=";
    for (char **e = process->environment; e != NULL && *e != NULL; e++) {
        if (strncmp(*e, name, sizeof name - 1) == 0) {
            return record_address(*e + sizeof name - 1, NULL);
        }
    }
    return 0;
}

static void take_up(const user_tool *t)
{
    const size_t n = w.record.tool_count;
    if (n == TOOLS) {
        is_full("tools");
        return;
    }
    (void)record_add_tool(&w.record, (const char *const *)t->process->arguments,
                          number_host(t->process->host), t->process->began_ns);
    w.record.tools[n].id = t->process->pid;
    w.record.tools[n].usual = usual_of(t->process);
    w.tools[n] = t;
}

/* Takes up those that are new: they are in the order of their start. */
static void look_at_tools(void)
{
    const size_t n = w.record.tool_count;
    const user_tool *t = n == 0 ? user_tool_first() : w.tools[n - 1]->next;
    for (; t != NULL; t = t->next) {
        take_up(t);
    }
}

static int find_pid(long pid)
{
    if (pid == 0) {
        return RECORD_NONE;
    }
    for (unsigned again = 0; again < 2; again++) {
        for (size_t i = w.record.tool_count; i > 0; i--) {
            if (w.record.tools[i - 1].id == pid) {
                return (int)i - 1;
            }
        }
        look_at_tools();
    }
    return RECORD_NONE;
}

static knowledge *know(const user_tool *tool)
{
    static knowledge nobody;
    const int index = find_pid(tool->process->pid);
    return index == RECORD_NONE ? &nobody : &w.known[index];
}

void witness_stalls(const user_tool *tool)
{
    know(tool)->is_stalled = true;
}

void witness_held(const user_tool *tool)
{
    knowledge *k = know(tool);
    if (k->held_count == RECORD_SPANS) {
        is_full("stops before a send");
        return;
    }
    k->held_ns[k->held_count++] = world_now();
}

void witness_wrong(const user_tool *tool)
{
    know(tool)->is_wrong = true;
}

void witness_cut(const user_tool *tool)
{
    know(tool)->is_cut = true;
}

void witness_typed(const user_tool *tool, const char *text)
{
    const int index = find_pid(tool->process->pid);
    if (index != RECORD_NONE) {
        record_type(&w.record.tools[index], world_now(), text);
    }
}

static record_clock clock_of(const world_host *host)
{
    return (record_clock){world_host_mono_ns(host), world_host_utc_ns(host),
                          host->drift_ppb};
}

/* A device whose log is known. */
static bool has_log(const record_tool *tool)
{
    const char *log = record_option(tool, "--log");
    return record_is_program(tool, "lumsim") && log != NULL &&
           strcmp(log, "-") == 0;
}

/* --- At each event --- */

static void fail_by(const verdict_finding *f)
{
    if (w.rule[0] == '\0') {
        (void)snprintf(w.rule, sizeof w.rule, "%s", f->rule);
        world_fail("%s: %s (%+.6f s)", f->rule, f->text,
                   (double)f->t_ns * 1e-9);
    }
}

/* What is broken now ends the session here, so that its log does too. */
static void stop_if_broken(void)
{
    for (unsigned i = 0; i < w.verdict.count; i++) {
        if (!verdict_is_left(&w.verdict, w.verdict.findings[i].rule)) {
            fail_by(&w.verdict.findings[i]);
            return;
        }
    }
}

static int64_t true_of(void *context, int64_t mono_ns)
{
    return world_host_true_ns(context, mono_ns);
}

/* A sensor logs what it does within this time. */
#define LOGGED_NS (5 * WORLD_MS)

static void watch_laser(void *argument);

/* One event at a time: it looks again when the laser may be late then. */
static void watch_until_due(unsigned i)
{
    const int64_t due_ns = judge_watch_due(&w.devices[i].watch);
    if (due_ns != RECORD_NEVER && !w.devices[i].is_watched) {
        w.devices[i].is_watched = true;
        (void)world_at(due_ns + LOGGED_NS, watch_laser, &w.devices[i]);
    }
}

static void watch_laser(void *argument)
{
    device *d = argument;
    d->is_watched = false;
    if (w.tools[d->of]->process->has_ended) {
        return;
    }
    const int64_t logged_ns = world_now() - LOGGED_NS;
    if (logged_ns >= judge_watch_due(&d->watch)) {
        judge_watch_until(&d->watch, logged_ns, &w.verdict);
        stop_if_broken();
    }
    watch_until_due((unsigned)(d - w.devices));
}

static unsigned find_device(size_t of)
{
    unsigned i = 0;
    while (i < w.record.device_count && w.devices[i].of != of) {
        i++;
    }
    if (i == DEVICES) {
        is_full("sensors");
        return 0;
    }
    if (i == w.record.device_count) {
        const record_tool *tool = &w.record.tools[of];
        w.devices[i].of = of;
        (void)record_add_device(&w.record, tool->host, tool->began_ns);
    }
    return i;
}

/* Each lumsim that logs to its output is a device. */
static void read_device(size_t of)
{
    const unsigned i = find_device(of);
    record_device *d = &w.record.devices[i];
    size_t n = d->count;
    record_read_log(&w.record, i, user_out(w.tools[of]),
                    user_size_out(w.tools[of]), true_of,
                    w.tools[of]->process->host);
    for (; n < d->count; n++) {
        judge_watch_line(&w.devices[i].watch, &d->lines[n], &w.verdict);
        if (d->lines[n].event == RECORD_LASER && d->lines[n].is_yes) {
            judge_rise(d, n, &w.verdict);
        }
    }
    watch_until_due(i);
    stop_if_broken();
}

/* The tool whose text it is; the count: it is none's. */
static size_t find_printer(const user_text *text)
{
    look_at_tools();
    for (size_t i = w.record.tool_count; i > 0; i--) {
        if (w.tools[i - 1]->out == text || w.tools[i - 1]->err == text) {
            return i - 1;
        }
    }
    return w.record.tool_count;
}

static void note_print(const user_text *text)
{
    const size_t i = find_printer(text);
    if (i == w.record.tool_count) {
        return;
    }
    const user_tool *of = w.tools[i];
    if (!record_is_program(&w.record.tools[i], "lumsim")) {
        record_add_print(&w.record.tools[i],
                         (record_print){world_now(), of->out->size,
                                        of->err->size,
                                        clock_of(of->process->host)});
    } else if (of->out == text && has_log(&w.record.tools[i])) {
        read_device(i);
    }
}

/* Why is for its reader. */
static void note_leave(const char *rule, const char *why)
{
    (void)why;
    verdict_leave(&w.verdict, rule);
}

/* --- Datagrams --- */

static record_fate fate_of(world_fate fate)
{
    switch (fate) {
    case WORLD_UNDER_WAY:
        return RECORD_UNDER_WAY;
    case WORLD_RECEIVED:
        return RECORD_READ;
    case WORLD_LOST_BUFFER:
    case WORLD_LOST_CHECKSUM: /* Linux counts both in one number */
        return RECORD_DROPPED;
    case WORLD_LOST_UNREAD:
        return RECORD_UNREAD;
    case WORLD_LOST_LINK:
    case WORLD_LOST_CUT:
    case WORLD_LOST_QUEUE:
    case WORLD_LOST_NO_ANSWER:
    case WORLD_LOST_FOREIGN:
    case WORLD_LOST_NO_SOCKET:
    case WORLD_FATES:
        break;
    }
    return RECORD_LOST;
}

static void note_sent(const world_datagram *d)
{
    record_datagram *out = record_add_datagram(&w.record);
    record_look_at(out, d->bytes, d->len);
    out->number = d->number;
    out->sent_ns = d->sent_ns;
    out->sender = d->sender != NULL ? find_pid(d->sender->pid) : RECORD_NONE;
    out->from = (record_endpoint){d->from, d->from_port};
    out->to = (record_endpoint){d->to, d->to_port};
    out->is_copy = d->first != d->number;
}

/* They are numbered in the order in which they were sent. */
static record_datagram *find_datagram(uint64_t number)
{
    size_t low = 0;
    size_t high = w.record.datagram_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (w.record.datagrams[middle].number < number) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low < w.record.datagram_count &&
                   w.record.datagrams[low].number == number
               ? &w.record.datagrams[low]
               : NULL;
}

/* The host whose tool a time stamp is for. */
static const world_host *asker_of(const record_datagram *d, bool is_answer)
{
    const record_tool *tool =
        is_answer                  ? record_sender(&w.record, d->to, d->sent_ns)
        : d->sender != RECORD_NONE ? &w.record.tools[d->sender]
                                   : NULL;
    return tool != NULL ? w.tools[tool - w.record.tools]->process->host : NULL;
}

static void note_stamp(const record_datagram *d, bool is_answer)
{
    const int of = is_answer ? d->sender : d->reader;
    const world_host *host = asker_of(d, is_answer);
    if (host != NULL && of != RECORD_NONE) {
        record_add_stamp(
            &w.record,
            (record_stamp){.number = d->number,
                           .t_ns = world_now(),
                           .asker = clock_of(host),
                           .sensor = clock_of(w.tools[of]->process->host)});
    }
}

/* Requests when they are read, and answers when they are sent. */
static void look_at_stamp(const record_datagram *d)
{
    if (d->packet != RECORD_IS_TIMESTAMP) {
        return;
    }
    if (d->fates == 0 && d->from.port == RECORD_PORT) {
        note_stamp(d, true);
    } else if (d->fate == RECORD_READ && d->to.port == RECORD_PORT) {
        note_stamp(d, false);
    }
}

static void note_reader(record_datagram *out, long pid)
{
    out->reader = find_pid(pid);
    if (out->reader != RECORD_NONE && out->fate == RECORD_READ &&
        (out->sender == RECORD_NONE ||
         !has_log(&w.record.tools[out->sender]))) {
        w.record.tools[out->reader].met_others = true;
    }
}

/* For the points of a recording. */
static void keep_bytes(const record_datagram *out, const world_datagram *d)
{
    record_tool *tool =
        out->reader != RECORD_NONE ? &w.record.tools[out->reader] : NULL;
    if (tool != NULL && out->fate == RECORD_READ &&
        record_is_program(tool, "lumdump") && d->from == record_host_of(tool) &&
        d->from_port == record_port_of(tool)) {
        record_keep(tool, d->bytes, d->len);
    }
}

static void note_fate(record_datagram *out, const world_datagram *d)
{
    out->fates++;
    out->fate = fate_of(d->fate);
    out->fate_ns = d->ended_ns;
    out->is_damaged = d->is_altered;
    if (d->is_altered) {
        out->hash = record_hash(d->bytes, d->len);
    }
    if (d->receiver != NULL) {
        note_reader(out,
                    d->receiver_pid != 0 ? d->receiver_pid : d->receiver->pid);
        keep_bytes(out, d);
    }
}

static void judge_datagram(const record_datagram *d)
{
    if (d->fates == 0) {
        judge_on_sent(&w.record, d, &w.verdict);
    } else {
        judge_fate(d, &w.verdict);
    }
    if (w.verdict.count > 0) {
        stop_if_broken();
    }
}

static void note_datagram(void *context, const world_datagram *d)
{
    (void)context;
    record_datagram *out = find_datagram(d->number);
    if (out == NULL) {
        note_sent(d);
        out = &w.record.datagrams[w.record.datagram_count - 1];
    }
    if (d->fate != WORLD_UNDER_WAY) {
        note_fate(out, d);
    }
    look_at_stamp(out);
    judge_datagram(out);
}

/* --- Files --- */

/* What is under way has other names. */
static bool is_of_own_name(const char *path)
{
    const size_t len = strlen(path);
    return !(len > 5 && strcmp(path + len - 5, ".part") == 0) &&
           strstr(path, ".lumsdk") == NULL;
}

static void look_at_file(const char *path, const char *bytes, size_t size,
                         bool is_final)
{
    const judge_file file = {path, (const uint8_t *)bytes, size, world_now(),
                             is_final};
    judge_whole(&file, &w.verdict);
}

/* All its bytes are on the disk before it gets its name; a capture grows under
 * it (docs/man/lumdump.1, FILES). */
static void look_at_sync(const world_name_event *event)
{
    static const char synced[] = "file-synced";
    if (event->change != WORLD_NAME_GIVEN ||
        strstr(event->path, ".pcap") != NULL ||
        strstr(event->path, "/lumsdk/") != NULL) {
        return;
    }
    verdict_asked(&w.verdict, synced);
    if (!event->is_synced) {
        verdict_broken(&w.verdict, synced, world_now(),
                       "%s got its name before it was on the disk",
                       event->path);
    }
}

static bool is_of_tools(const world_disk *disk, const char *path)
{
    const named *n = w.named;
    while (n != NULL && (n->disk != disk || strcmp(n->path, path) != 0)) {
        n = n->next;
    }
    return n != NULL;
}

static void note_of_tools(const world_disk *disk, const char *path)
{
    named *n = user_keep(sizeof *n);
    *n = (named){w.named, disk, user_keep_text(path, strlen(path))};
    w.named = n;
}

static void note_name(const world_name_event *event, void *context)
{
    size_t size = 0;
    (void)context;
    if (event->pid == 0 || event->change == WORLD_NAME_REMOVED ||
        event->change == WORLD_NAME_LOST || !is_of_own_name(event->path)) {
        return;
    }
    note_of_tools(event->disk, event->path);
    look_at_sync(event);
    char *bytes = world_disk_read_inode(event->disk, event->inode, &size);
    if (bytes != NULL && event->change == WORLD_NAME_GIVEN) {
        look_at_file(event->path, bytes, size, false);
    }
    free(bytes);
    stop_if_broken();
}

/* Lines are added to it one by one. */
static bool is_of_rows(const char *name)
{
    for (size_t i = 0; i < w.record.tool_count; i++) {
        const char *rows = record_option(&w.record.tools[i], "--csv");
        if (rows != NULL && strcmp(rows, name) == 0) {
            return true;
        }
    }
    return false;
}

/* A capture that grew may have holes then: it is not synced while it grows. */
void witness_blackout(world_host *host)
{
    w.dark_ns = world_now();
    world_disk *disk = world_disk_of(host);
    const char *name = NULL;
    for (unsigned n = 0; (name = world_disk_name(disk, "/home", n)) != NULL;
         n++) {
        size_t size = 0;
        char *bytes = is_of_own_name(name) && strstr(name, ".pcap") == NULL &&
                              !is_of_rows(name)
                          ? world_disk_read(disk, user_path(name), &size)
                          : NULL;
        if (bytes != NULL) {
            look_at_file(name, bytes, size, false);
        }
        free(bytes);
    }
}

static bool ends_with(const char *text, const char *end)
{
    const size_t len = strlen(text);
    return len > strlen(end) && strcmp(text + len - strlen(end), end) == 0;
}

static bool is_writer(const record_tool *tool, const char *name)
{
    for (unsigned a = 1; a + 1 < tool->count; a++) {
        if (strcmp(tool->arguments[a], "-o") == 0 &&
            strcmp(tool->arguments[a + 1], name) == 0) {
            return true;
        }
    }
    return false;
}

/* A later run may have put another file in its place. */
static bool is_last_writer(size_t index, const char *name)
{
    for (size_t i = index + 1; i < w.record.tool_count; i++) {
        const record_tool *tool = &w.record.tools[i];
        if (tool->host == w.record.tools[index].host && is_writer(tool, name)) {
            return false;
        }
    }
    return true;
}

/* Of one output of a recording. */
static void look_at_output(size_t index, const char *name)
{
    const record_tool *tool = &w.record.tools[index];
    world_disk *disk = world_disk_of(w.tools[index]->process->host);
    size_t size = 0;
    if (!is_last_writer(index, name)) {
        return;
    }
    char *bytes = world_disk_read(disk, user_path(name), &size);
    const bool is_final = record_exit_status(tool) == 0;
    if (bytes == NULL || (!is_final && w.dark_ns >= tool->began_ns) ||
        !is_of_tools(disk, user_path(name))) {
        free(bytes);
        return;
    }
    const judge_file file = {name, (const uint8_t *)bytes, size, world_now(),
                             is_final};
    judge_whole(&file, &w.verdict);
    judge_cloud(&w.record, index, &file, &w.verdict);
    if (record_owns(tool) &&
        (ends_with(name, ".pcap") || ends_with(name, ".pcapng"))) {
        judge_recording(&w.record, index, &file, &w.verdict);
    }
    free(bytes);
}

/* Lines of --csv: each whole, as long as no program was killed at one. */
static void look_at_rows(size_t index)
{
    const record_tool *tool = &w.record.tools[index];
    const char *name = record_option(tool, "--csv");
    size_t size = 0;
    char *bytes =
        name != NULL && record_exit_status(tool) >= 0 &&
                w.dark_ns < tool->began_ns
            ? world_disk_read(world_disk_of(w.tools[index]->process->host),
                              user_path(name), &size)
            : NULL;
    if (bytes != NULL && size > 0) {
        look_at_file(name, bytes, size, true);
    }
    free(bytes);
}

static void look_at_outputs(void)
{
    for (size_t i = 0; i < w.record.tool_count; i++) {
        const record_tool *tool = &w.record.tools[i];
        look_at_rows(i);
        for (unsigned a = 1; a + 1 < tool->count; a++) {
            if (strcmp(tool->arguments[0], "lumdump") == 0 &&
                strcmp(tool->arguments[a], "-o") == 0 &&
                strcmp(tool->arguments[a + 1], "-") != 0) {
                look_at_output(i, tool->arguments[a + 1]);
            }
        }
    }
}

#define FILES 512

/* A blackout may leave what was under way. */
static void look_at_folders(void)
{
    for (unsigned i = 0; w.dark_ns == 0 && i < HOSTS && w.hosts[i] != NULL;
         i++) {
        const char *names[FILES + 1] = {NULL};
        unsigned n = 0;
        const char *name = NULL;
        while ((name = world_disk_name(world_disk_of(w.hosts[i]), "/home",
                                       n)) != NULL &&
               n < FILES) {
            names[n++] = name;
        }
        if (name != NULL) {
            is_full("names of files");
        }
        judge_left(&w.record, i, names, &w.verdict);
    }
}

/* --- The end --- */

static char *copy(const char *text)
{
    const size_t size = strlen(text) + 1;
    char *out = malloc(size);
    if (out == NULL) {
        abort();
    }
    return memcpy(out, text, size);
}

static void take_signals(record_tool *out, const user_tool *tool)
{
    if (tool->signal_count == USER_SIGNALS) {
        is_full("signals of the user");
    }
    for (unsigned i = 0; i < tool->signal_count; i++) {
        if (tool->signals[i].t_ns <= out->ended_ns) {
            record_signal_to(&w.record, out, tool->signals[i].t_ns,
                             tool->signals[i].number);
        }
    }
}

static void take_tool(size_t index)
{
    record_tool *out = &w.record.tools[index];
    const user_tool *tool = w.tools[index];
    const world_process *p = tool->process;
    const knowledge *k = &w.known[index];
    out->ended_ns = p->has_ended ? p->ended_ns : RECORD_NEVER;
    out->status = p->status;
    out->out = copy(user_out(tool));
    out->err = copy(user_err(tool));
    out->has_stalled = k->is_stalled;
    out->is_wrong = k->is_wrong;
    out->was_cut = k->is_cut;
    take_signals(out, tool);
    for (unsigned i = 0; i < k->held_count; i++) {
        record_stop_before_send(out, k->held_ns[i]);
    }
}

/* They were read as they grew. */
static void end_devices(void)
{
    for (size_t i = 0; i < w.record.device_count; i++) {
        w.record.devices[i].ended_ns = w.record.tools[w.devices[i].of].ended_ns;
    }
}

/* --- What a story does not tell --- */

/* What was met begins so. */
static bool has_met(const char *beginning)
{
    for (unsigned i = 0; i < world_met_count(); i++) {
        if (strncmp(world_met_name(i), beginning, strlen(beginning)) == 0) {
            return true;
        }
    }
    return false;
}

/* One whose tools, sensors and wire are left alone. */
static bool is_disturbed(void)
{
    bool is_slow = false;
    for (unsigned i = 0; i < HOSTS && w.hosts[i] != NULL; i++) {
        is_slow = is_slow || w.hosts[i]->slowness != 1;
    }
    return is_slow || has_met("fault:") || has_met("net:");
}

/* From what befell: a story that disturbs anything is not calm anywhere. */
static void guess(void)
{
    static const char *const ways[] = {"story", "cable", "address",
                                       "slow-host"};
    const bool is_stalled = has_met("fault:disk") || has_met("fault:reader");
    const bool is_dark = has_met("fault:power-cut");
    for (unsigned i = 0; is_disturbed() && i < sizeof ways / sizeof *ways;
         i++) {
        (void)record_add_fault(&w.record, ways[i], 0, RECORD_NEVER);
    }
    for (size_t i = 0; i < w.record.tool_count; i++) {
        w.known[i].is_stalled = w.known[i].is_stalled || is_stalled;
        w.known[i].is_cut = w.known[i].is_cut || is_dark;
    }
}

/* --- What is found --- */

static void tell_findings(void)
{
    for (unsigned i = 0; i < w.verdict.count; i++) {
        const verdict_finding *f = &w.verdict.findings[i];
        WORLD_TRACE("%s: %s at %+.6f s: %s",
                    verdict_is_left(&w.verdict, f->rule) ? "left" : "broken",
                    f->rule, (double)f->t_ns * 1e-9, f->text);
        if (!verdict_is_left(&w.verdict, f->rule)) {
            fail_by(f);
        }
    }
}

static void end(void)
{
    look_at_tools();
    w.record.now_ns = world_now();
    if (!w.knows_all) {
        guess();
    }
    for (size_t i = 0; i < w.record.tool_count; i++) {
        take_tool(i);
    }
    end_devices();
    look_at_outputs();
    look_at_folders();
    judge_all(&w.record, &w.verdict);
    judge_ground(&w.record, &w.verdict);
    tell_findings();
}

static void begin(void)
{
    record_free(&w.record);
    memset(&w, 0, sizeof w);
    world_net_watch(note_datagram, NULL);
    world_disk_watch(note_name, NULL);
}

void witness_install(void)
{
    user_begins = begin;
    user_ends = end;
    user_prints = note_print;
    user_types = witness_typed;
    user_leaves = note_leave;
}

void witness_knows_all(void)
{
    w.knows_all = true;
}

void witness_fault(const char *name, int64_t from_ns, int64_t to_ns)
{
    (void)record_add_fault(&w.record, name, from_ns, to_ns);
}

const char *witness_rule(void)
{
    return w.rule;
}

const struct verdict *witness_verdict(void)
{
    return &w.verdict;
}

size_t witness_programs(void)
{
    return w.record.tool_count;
}
