#include "record.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

/* --- Memory --- */

/* A judge without memory says nothing any more. */
static void *grow(void *old, size_t size)
{
    void *grown = realloc(old, size);
    if (grown == NULL) {
        (void)fputs("world: no memory for what judges look at\n", stderr);
        abort();
    }
    return grown;
}

static char *copy_text(const char *text, size_t len)
{
    char *copy = grow(NULL, len + 1);
    memcpy(copy, text, len);
    copy[len] = '\0';
    return copy;
}

static void free_tool(record_tool *tool)
{
    for (unsigned i = 0; i < tool->count; i++) {
        free(tool->arguments[i]);
    }
    for (size_t i = 0; i < tool->typed_count; i++) {
        free(tool->typed[i].text);
    }
    free(tool->typed);
    free(tool->prints);
    free(tool->kept);
    free(tool->out);
    free(tool->err);
}

void record_free(struct record *record)
{
    for (size_t i = 0; i < record->device_count; i++) {
        for (size_t k = 0; k < record->devices[i].count; k++) {
            free(record->devices[i].lines[k].text);
        }
        free(record->devices[i].lines);
    }
    for (size_t i = 0; i < record->tool_count; i++) {
        free_tool(&record->tools[i]);
    }
    free(record->devices);
    free(record->tools);
    free(record->datagrams);
    free(record->faults);
    free(record->stamps);
    memset(record, 0, sizeof *record);
}

/* --- What is added --- */

size_t record_add_device(struct record *record, unsigned host, int64_t t_ns)
{
    const size_t n = record->device_count++;
    record->devices =
        grow(record->devices, record->device_count * sizeof *record->devices);
    record->devices[n] = (record_device){
        .host = host, .began_ns = t_ns, .ended_ns = RECORD_NEVER};
    return n;
}

size_t record_add_tool(struct record *record, const char *const *arguments,
                       unsigned host, int64_t t_ns)
{
    const size_t n = record->tool_count++;
    record->tools =
        grow(record->tools, record->tool_count * sizeof *record->tools);
    record_tool *tool = &record->tools[n];
    *tool =
        (record_tool){.host = host, .began_ns = t_ns, .ended_ns = RECORD_NEVER};
    for (; arguments[tool->count] != NULL && tool->count < RECORD_ARGUMENTS;
         tool->count++) {
        const char *text = arguments[tool->count];
        tool->arguments[tool->count] = copy_text(text, strlen(text));
    }
    if (arguments[tool->count] != NULL) {
        record->full = "arguments of a tool";
    }
    return n;
}

record_datagram *record_add_datagram(struct record *record)
{
    if (record->datagram_count == record->datagram_room) {
        record->datagram_room =
            record->datagram_room == 0 ? 1024 : record->datagram_room * 2;
        record->datagrams =
            grow(record->datagrams,
                 record->datagram_room * sizeof *record->datagrams);
    }
    record_datagram *out = &record->datagrams[record->datagram_count++];
    *out = (record_datagram){.sender = RECORD_NONE, .reader = RECORD_NONE};
    return out;
}

size_t record_add_fault(struct record *record, const char *name,
                        int64_t from_ns, int64_t to_ns)
{
    const size_t n = record->fault_count++;
    record->faults =
        grow(record->faults, record->fault_count * sizeof *record->faults);
    record->faults[n] = (record_fault){.from_ns = from_ns, .to_ns = to_ns};
    (void)snprintf(record->faults[n].name, sizeof record->faults[n].name, "%s",
                   name);
    return n;
}

static void note_stop(struct record *record, record_tool *tool, int64_t t_ns)
{
    const bool is_stopped =
        tool->stop_count > 0 &&
        tool->stops[tool->stop_count - 1].to_ns == RECORD_NEVER;
    if (is_stopped) {
        return;
    }
    if (tool->stop_count == RECORD_SPANS) {
        record->full = "stops of a tool";
        return;
    }
    tool->stops[tool->stop_count++] = (record_span){t_ns, RECORD_NEVER, false};
}

static void note_end_of_stop(record_tool *tool, int64_t t_ns)
{
    if (tool->stop_count > 0 &&
        tool->stops[tool->stop_count - 1].to_ns == RECORD_NEVER) {
        tool->stops[tool->stop_count - 1].to_ns = t_ns;
    }
}

void record_signal_to(struct record *record, record_tool *tool, int64_t t_ns,
                      int number)
{
    if (number == SIGSTOP) {
        note_stop(record, tool, t_ns);
        return;
    }
    if (number == SIGCONT || number == SIGKILL) {
        note_end_of_stop(tool, t_ns);
    }
    tool->was_cut = tool->was_cut || number == SIGKILL;
    if (number == SIGCONT) {
        return;
    }
    if (tool->signal_count == RECORD_SPANS) {
        record->full = "signals to a tool";
        return;
    }
    tool->signals[tool->signal_count++] = (record_signal){t_ns, number};
}

static void type_line(record_tool *tool, int64_t t_ns, const char *text,
                      size_t len)
{
    tool->typed =
        grow(tool->typed, (tool->typed_count + 1) * sizeof *tool->typed);
    tool->typed[tool->typed_count++] =
        (record_typed){t_ns, copy_text(text, len)};
}

void record_type(record_tool *tool, int64_t t_ns, const char *text)
{
    while (*text != '\0') {
        const size_t len = strcspn(text, "\n");
        type_line(tool, t_ns, text, len);
        text += len + (text[len] == '\n' ? 1 : 0);
    }
}

void record_add_print(record_tool *tool, record_print print)
{
    if (tool->print_count == tool->print_room) {
        tool->print_room = tool->print_room == 0 ? 16 : tool->print_room * 2;
        tool->prints =
            grow(tool->prints, tool->print_room * sizeof *tool->prints);
    }
    tool->prints[tool->print_count++] = print;
}

#define KEPT_MOST (UINT32_C(24) << 20)

void record_keep(record_tool *tool, const void *bytes, size_t len)
{
    if (tool->is_too_much || tool->kept_size + len + 4 > KEPT_MOST) {
        tool->is_too_much = true;
        return;
    }
    while (tool->kept_size + len + 4 > tool->kept_room) {
        tool->kept_room = tool->kept_room == 0 ? 65536 : tool->kept_room * 2;
        tool->kept = grow(tool->kept, tool->kept_room);
    }
    uint8_t *at = tool->kept + tool->kept_size;
    for (unsigned i = 0; i < 4; i++) {
        at[i] = (uint8_t)(len >> (8 * i));
    }
    memcpy(at + 4, bytes, len);
    tool->kept_size += len + 4;
    tool->kept_count++;
}

void record_add_stamp(struct record *record, record_stamp stamp)
{
    if (record->stamp_count == record->stamp_room) {
        record->stamp_room =
            record->stamp_room == 0 ? 64 : record->stamp_room * 2;
        record->stamps =
            grow(record->stamps, record->stamp_room * sizeof *record->stamps);
    }
    record->stamps[record->stamp_count++] = stamp;
}

void record_stop_before_send(record_tool *tool, int64_t t_ns)
{
    for (unsigned i = 0; i < tool->stop_count; i++) {
        if (tool->stops[i].from_ns == t_ns) {
            tool->stops[i].is_before_send = true;
        }
    }
}

/* --- Datagrams --- */

uint64_t record_hash(const void *bytes, size_t len)
{
    const uint8_t *at = bytes;
    uint64_t hash = UINT64_C(0xcbf29ce484222325) ^ len;
    for (; len >= 8; at += 8, len -= 8) {
        uint64_t eight;
        memcpy(&eight, at, 8);
        hash = (hash ^ eight) * UINT64_C(0x9e3779b97f4a7c15);
        hash ^= hash >> 29;
    }
    for (; len > 0; at++, len--) {
        hash = (hash ^ *at) * UINT64_C(0x100000001b3);
    }
    return hash ^ hash >> 29;
}

static uint32_t read_u32(const uint8_t *at)
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 |
           (uint32_t)at[3] << 24;
}

/* The first TLV, where it is a command (docs/protocol.md, section 4). */
static void look_for_command(record_datagram *out, const uint8_t *at,
                             size_t len)
{
    if (len >= 20 && at[16] == 1 && at[17] == 0) {
        const size_t size = (size_t)at[18] | (size_t)at[19] << 8;
        const size_t n = size < len - 20 ? size : len - 20;
        (void)snprintf(out->command, sizeof out->command, "%.*s", (int)n,
                       (const char *)at + 20);
    }
}

void record_look_at(record_datagram *out, const void *bytes, size_t len)
{
    static const uint8_t magic[8] = {0xed, 0xfe, 0xf3, 0xa1,
                                     0xef, 0xbe, 0x34, 0x12};
    static const record_packet kinds[] = {RECORD_IS_SET_IP, RECORD_IS_TIMESTAMP,
                                          RECORD_IS_TLV, RECORD_IS_DATA};
    const uint8_t *at = bytes;
    out->len = (uint32_t)len;
    out->hash = record_hash(bytes, len);
    out->packet = RECORD_IS_FOREIGN;
    if (len < 12 || memcmp(at, magic, sizeof magic) != 0 || at[8] < 5 ||
        at[8] > 8) {
        return;
    }
    out->packet =
        at[8] == 8 && len == 12 ? RECORD_IS_HEARTBEAT : kinds[at[8] - 5];
    if (len >= 16 && (at[8] == 6 || at[8] == 7)) {
        out->sequence = read_u32(at + 12);
    }
    if (len >= 20 && at[8] == 6) {
        out->clock_us = read_u32(at + 16);
    }
    if (at[8] == 7) {
        look_for_command(out, at, len);
    }
}

bool record_is_same(record_endpoint a, record_endpoint b)
{
    return a.address == b.address && a.port == b.port;
}

/* --- Words --- */

static bool is_between(char c)
{
    return c == '\0' || c == ' ' || c == '\n';
}

bool record_has_word(const char *text, const char *word)
{
    const size_t len = strlen(word);
    const char *at = text;
    while (at != NULL && (at = strstr(at, word)) != NULL) {
        if ((at == text || is_between(at[-1])) && is_between(at[len])) {
            return true;
        }
        at++;
    }
    return false;
}

bool record_was_done(const record_line *line, const char *command)
{
    const size_t len = strlen(command);
    const char *at = line->event == RECORD_TLV ? line->text : NULL;
    while (at != NULL) {
        if (strncmp(at, command, len) == 0 &&
            (at[len] == '\0' || at[len] == ';')) {
            return true;
        }
        at = strstr(at, "; ");
        at = at != NULL ? at + 2 : NULL;
    }
    return false;
}

static const char *find_key(const char *text, const char *key)
{
    char quoted[40];
    (void)snprintf(quoted, sizeof quoted, "\"%s\":", key);
    const char *at = text != NULL ? strstr(text, quoted) : NULL;
    if (at == NULL) {
        return NULL;
    }
    at += strlen(quoted);
    return at + strspn(at, " ");
}

bool record_json_number(const char *text, const char *key, uint64_t *out)
{
    const char *at = find_key(text, key);
    char *end = NULL;
    if (at == NULL) {
        return false;
    }
    *out = strtoull(at, &end, 10);
    return end != at;
}

bool record_json_bool(const char *text, const char *key, bool *out)
{
    const char *at = find_key(text, key);
    if (at == NULL ||
        (strncmp(at, "true", 4) != 0 && strncmp(at, "false", 5) != 0)) {
        return false;
    }
    *out = *at == 't';
    return true;
}
