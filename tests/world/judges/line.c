/* Lines of a device's log. */
#include "record.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const names[RECORD_OTHER] = {
    [RECORD_START] = "start",
    [RECORD_HEARTBEAT] = "heartbeat",
    [RECORD_TIMESTAMP] = "timestamp",
    [RECORD_TLV] = "tlv",
    [RECORD_SET_IP] = "set_ip",
    [RECORD_REPLY] = "reply",
    [RECORD_UNSENT] = "unsent",
    [RECORD_STATUS] = "status",
    [RECORD_LASER] = "laser",
    [RECORD_STREAM] = "stream",
    [RECORD_MOVE] = "move",
    [RECORD_FAULT] = "fault",
    [RECORD_STOP] = "stop"};

/* The text of a key, as far as it has room; "" where there is none. */
static void find_text(const char *line, const char *key, char *out, size_t size)
{
    char quoted[32];
    (void)snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *at = strstr(line, quoted);
    size_t n = 0;
    if (at != NULL) {
        at += strlen(quoted);
        at += strspn(at, " ");
    }
    if (at != NULL && *at == '"') {
        for (at++; *at != '"' && *at != '\0' && n + 1 < size; at++) {
            out[n++] = *at;
        }
    }
    out[n] = '\0';
}

static bool read_endpoint(const char *text, record_endpoint *out)
{
    const char *behind = NULL;
    const uint32_t address = record_address(text, &behind);
    if (address == 0) {
        return false;
    }
    out->address = address;
    out->port = (uint16_t)(*behind == ':' ? strtoul(behind + 1, NULL, 10) : 0);
    return true;
}

static record_event find_event(const char *line)
{
    char name[24];
    find_text(line, "event", name, sizeof name);
    for (unsigned i = 0; i < RECORD_OTHER; i++) {
        if (strcmp(name, names[i]) == 0) {
            return (record_event)i;
        }
    }
    return RECORD_OTHER;
}

static void find_peer(const char *line, record_endpoint *out)
{
    static const char *const keys[] = {"from", "to", "address"};
    char text[32];
    for (unsigned i = 0; i < sizeof keys / sizeof keys[0]; i++) {
        find_text(line, keys[i], text, sizeof text);
        if (read_endpoint(text, out)) {
            return;
        }
    }
}

/* What is true or false of the event. */
static bool find_yes(const char *line, record_event event)
{
    static const char *const keys[RECORD_OTHER] = {[RECORD_LASER] = "up",
                                                   [RECORD_MOVE] = "done",
                                                   [RECORD_FAULT] = "ends",
                                                   [RECORD_REPLY] = "lost"};
    bool is_yes = false;
    return event < RECORD_OTHER && keys[event] != NULL &&
           record_json_bool(line, keys[event], &is_yes) && is_yes;
}

static void find_note(const char *line, record_event event, char *out,
                      size_t size)
{
    const char *key = event == RECORD_REPLY    ? "kind"
                      : event == RECORD_FAULT  ? "name"
                      : event == RECORD_UNSENT ? "reason"
                                               : "note";
    find_text(line, key, out, size);
}

static char *copy(const char *text)
{
    const size_t size = strlen(text) + 1;
    char *out = malloc(size);
    if (out == NULL) {
        abort();
    }
    return memcpy(out, text, size);
}

/* False: it has no time. */
static bool read_line(const char *line, record_line *out)
{
    char note[400];
    uint64_t number = 0;
    const char *t = strstr(line, "\"t\":");
    if (t == NULL) {
        return false;
    }
    *out = (record_line){.event = find_event(line)};
    out->t_ns = (int64_t)(strtod(t + 4, NULL) * 1e6 + 0.5) * RECORD_US;
    out->is_yes = find_yes(line, out->event);
    find_peer(line, &out->peer);
    if (record_json_number(line, "sequence", &number)) {
        out->sequence = (uint32_t)number;
    }
    if (record_json_number(line, "status", &number)) {
        out->status = (unsigned)number;
    }
    find_note(line, out->event, note, sizeof note);
    out->text = copy(note);
    return true;
}

static void add(record_device *device, const record_line *line)
{
    if (device->count == device->room) {
        device->room = device->room == 0 ? 256 : device->room * 2;
        record_line *grown =
            realloc(device->lines, device->room * sizeof *device->lines);
        if (grown == NULL) {
            abort();
        }
        device->lines = grown;
    }
    device->lines[device->count++] = *line;
}

static void take(record_device *device, const char *text, size_t len,
                 int64_t (*true_ns)(void *context, int64_t mono_ns),
                 void *context)
{
    char line[1024];
    record_line out;
    const size_t n = len < sizeof line ? len : sizeof line - 1;
    memcpy(line, text, n);
    line[n] = '\0';
    if (read_line(line, &out)) {
        out.t_ns = true_ns != NULL ? true_ns(context, out.t_ns) : out.t_ns;
        add(device, &out);
    }
}

void record_read_log(struct record *record, size_t device, const char *bytes,
                     size_t size,
                     int64_t (*true_ns)(void *context, int64_t mono_ns),
                     void *context)
{
    record_device *d = &record->devices[device];
    const char *end = NULL;
    while (d->read < size &&
           (end = memchr(bytes + d->read, '\n', size - d->read)) != NULL) {
        const size_t len = (size_t)(end - (bytes + d->read));
        take(d, bytes + d->read, len, true_ns, context);
        d->read += len + 1;
    }
}
