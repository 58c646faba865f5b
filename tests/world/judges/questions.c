/* What judges ask of a record. */
#include "record.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

/* Options with a value, of all tools (docs/man). */
static const char *const valued[] = {
    "--host",        "--port",         "--interface",
    "--timeout",     "--retries",      "--profile",
    "--calibration", "--set",          "--sequence",
    "--subnet",      "--rate",         "--duration",
    "--shape",       "--lines",        "-o",
    "--output",      "--format",       "--rotate",
    "--buffer",      "--columns",      "--eye",
    "--edge",        "--return",       "--frames",
    "--range",       "--time",         "--log",
    "--fault",       "--address",      "--clock",
    "--jitter",      "--answer-delay", "--answer-loss",
    "--loss",        "--seed",         "--receive-buffer",
    "--for",         "--every",        "--until",
    "--csv",         "--prometheus"};

/* --- What a user asked for --- */

static bool takes_value(const char *argument)
{
    for (size_t i = 0; i < sizeof valued / sizeof valued[0]; i++) {
        if (strcmp(argument, valued[i]) == 0) {
            return true;
        }
    }
    return false;
}

const char *record_option(const record_tool *tool, const char *name)
{
    const size_t len = strlen(name);
    for (unsigned i = 1; i < tool->count; i++) {
        const char *a = tool->arguments[i];
        if (strncmp(a, name, len) == 0 && a[len] == '=') {
            return a + len + 1;
        }
        if (strcmp(a, name) == 0) {
            return takes_value(name) && i + 1 < tool->count
                       ? tool->arguments[i + 1]
                       : "";
        }
    }
    return NULL;
}

double record_number(const record_tool *tool, const char *name, double usual)
{
    const char *text = record_option(tool, name);
    return text != NULL ? strtod(text, NULL) : usual;
}

bool record_is_program(const record_tool *tool, const char *name)
{
    return tool->count > 0 && strcmp(tool->arguments[0], name) == 0;
}

const char *record_word(const record_tool *tool, unsigned n)
{
    unsigned words = 0;
    for (unsigned i = 1; i < tool->count; i++) {
        const char *a = tool->arguments[i];
        if (takes_value(a)) {
            i++;
        } else if (a[0] != '-' && words++ == n) {
            return a;
        }
    }
    return "";
}

uint32_t record_address(const char *text, const char **behind)
{
    uint32_t address = 0;
    for (unsigned i = 0; i < 4; i++) {
        char *end = NULL;
        address = address << 8 | (uint32_t)(strtoul(text, &end, 10) & 0xffu);
        if (end == text || (i < 3 && *end != '.')) {
            return 0;
        }
        text = i < 3 ? end + 1 : end;
    }
    if (behind != NULL) {
        *behind = text;
    }
    return address;
}

/* "10.42.0.37:5517", as it was said; NULL: it was not. */
static const char *said_host(const record_tool *tool)
{
    static const char scheme[] = "udp://";
    const char *host = record_option(tool, "--host");
    for (unsigned i = 1; i < tool->count && host == NULL; i++) {
        if (strncmp(tool->arguments[i], scheme, sizeof scheme - 1) == 0) {
            host = tool->arguments[i] + sizeof scheme - 1;
        }
    }
    return host;
}

uint32_t record_host_of(const record_tool *tool)
{
    const char *host = said_host(tool);
    if (host == NULL && tool->usual != 0) {
        return tool->usual;
    }
    if (host == NULL) {
        host = record_is_program(tool, "lumctl") ? "10.42.0.37" : "";
    }
    return record_address(host, NULL);
}

unsigned record_port_of(const record_tool *tool)
{
    const char *host = said_host(tool);
    const char *behind = NULL;
    if (host != NULL && record_address(host, &behind) != 0 && *behind == ':') {
        return (unsigned)strtoul(behind + 1, NULL, 10);
    }
    return (unsigned)record_number(tool, "--port", RECORD_PORT);
}

bool record_owns(const record_tool *tool)
{
    if (record_is_program(tool, "lumctl")) {
        return strcmp(record_word(tool, 0), "heartbeat") == 0 ||
               strcmp(record_word(tool, 0), "sweep") == 0 ||
               (strcmp(record_word(tool, 0), "shell") == 0 &&
                record_option(tool, "--heartbeat") != NULL);
    }
    return (record_is_program(tool, "lumdump") ||
            record_is_program(tool, "lumview")) &&
           record_host_of(tool) != 0;
}

bool record_watches(const record_tool *tool)
{
    return record_option(tool, "--watch") != NULL ||
           record_option(tool, "--every") != NULL;
}

bool record_is_shared(const struct record *record, const record_tool *tool)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        const record_tool *other = &record->tools[i];
        if (other->host != tool->host && record_owns(other) &&
            record_host_of(other) == record_host_of(tool) &&
            other->began_ns <= tool->ended_ns &&
            other->ended_ns >= tool->began_ns) {
            return true;
        }
    }
    return false;
}

/* --- Its life --- */

bool record_is_running(const record_tool *tool, int64_t t_ns)
{
    return tool->began_ns <= t_ns && t_ns < tool->ended_ns;
}

int64_t record_stopped_ns(const record_tool *tool, int64_t from_ns,
                          int64_t to_ns)
{
    int64_t sum_ns = 0;
    for (unsigned i = 0; i < tool->stop_count; i++) {
        const record_span s = tool->stops[i];
        const int64_t from = s.from_ns > from_ns ? s.from_ns : from_ns;
        const int64_t to = s.to_ns < to_ns ? s.to_ns : to_ns;
        sum_ns += to > from ? to - from : 0;
    }
    return sum_ns;
}

static bool asks_to_end(const record_tool *tool, int number)
{
    const bool is_shell = record_is_program(tool, "lumctl") &&
                          strcmp(record_word(tool, 0), "shell") == 0;
    return number == SIGTERM || number == SIGQUIT || number == SIGHUP ||
           number == SIGKILL || (number == SIGINT && !is_shell);
}

int64_t record_asked_to_end(const record_tool *tool)
{
    for (unsigned i = 0; i < tool->signal_count; i++) {
        if (asks_to_end(tool, tool->signals[i].number)) {
            return tool->signals[i].t_ns;
        }
    }
    return RECORD_NEVER;
}

bool record_was_signalled(const record_tool *tool, int number)
{
    for (unsigned i = 0; i < tool->signal_count; i++) {
        if (tool->signals[i].number == number) {
            return true;
        }
    }
    return false;
}

int record_exit_status(const record_tool *tool)
{
    return tool->ended_ns != RECORD_NEVER && WIFEXITED(tool->status)
               ? WEXITSTATUS(tool->status)
               : -1;
}

/* Datagrams stand in the order in which they were sent: how many until a
 * moment. */
static size_t sent_until(const struct record *record, int64_t t_ns)
{
    size_t low = 0;
    size_t high = record->datagram_count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (record->datagrams[middle].sent_ns <= t_ns) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return low;
}

/* A device's log tells the time of a datagram from two clocks, which it reads
 * one after the other. */
#define LOG_ERROR_NS (200 * RECORD_US)

const record_tool *record_sender(const struct record *record,
                                 record_endpoint from, int64_t t_ns)
{
    for (size_t i = sent_until(record, t_ns + LOG_ERROR_NS); i > 0; i--) {
        const record_datagram *d = &record->datagrams[i - 1];
        if (record_is_same(d->from, from)) {
            return d->sender == RECORD_NONE ? NULL : &record->tools[d->sender];
        }
    }
    return NULL;
}

bool record_is_calm(const struct record *record, const char *name,
                    int64_t from_ns, int64_t to_ns)
{
    for (size_t i = 0; i < record->fault_count; i++) {
        const record_fault *f = &record->faults[i];
        if ((name == NULL || strcmp(f->name, name) == 0) &&
            f->from_ns <= to_ns && f->to_ns >= from_ns) {
            return false;
        }
    }
    return true;
}

bool record_is_undamaged(const struct record *record, int64_t from_ns,
                         int64_t to_ns)
{
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->is_damaged && d->fate == RECORD_READ && d->fate_ns >= from_ns &&
            d->fate_ns <= to_ns) {
            return false;
        }
    }
    return true;
}

/* --- Devices --- */

static bool is_at(const record_device *device, uint32_t address, int64_t t_ns)
{
    bool is_there = false;
    for (size_t i = 0; i < device->count; i++) {
        const record_line *l = &device->lines[i];
        if (l->t_ns > t_ns) {
            break;
        }
        if (l->event == RECORD_START ||
            (l->event == RECORD_MOVE && l->is_yes)) {
            is_there = l->peer.address == address;
        }
    }
    return is_there;
}

const record_device *record_device_at(const struct record *record,
                                      uint32_t address, int64_t t_ns)
{
    for (size_t i = 0; i < record->device_count; i++) {
        const record_device *d = &record->devices[i];
        if (d->began_ns <= t_ns && t_ns < d->ended_ns &&
            is_at(d, address, t_ns)) {
            return d;
        }
    }
    return NULL;
}

bool record_laser_is_up(const record_device *device, int64_t t_ns)
{
    bool is_up = false;
    for (size_t i = 0; i < device->count && device->lines[i].t_ns <= t_ns;
         i++) {
        if (device->lines[i].event == RECORD_LASER) {
            is_up = device->lines[i].is_yes;
        }
    }
    return is_up && t_ns < device->ended_ns;
}

unsigned record_status_at(const record_device *device, int64_t t_ns)
{
    /* HEARTBEAT_TIMEOUT, at boot (docs/protocol.md, 10). */
    unsigned status = 0x0010;
    for (size_t i = 0; i < device->count && device->lines[i].t_ns <= t_ns;
         i++) {
        if (device->lines[i].event == RECORD_STATUS) {
            status = device->lines[i].status;
        }
    }
    return status;
}

bool record_laser_was(const record_device *device, bool is_up, int64_t from_ns,
                      int64_t to_ns)
{
    if (record_laser_is_up(device, from_ns) == is_up) {
        return true;
    }
    for (size_t i = 0; i < device->count; i++) {
        const record_line *l = &device->lines[i];
        if (l->event == RECORD_LASER && l->is_yes == is_up &&
            l->t_ns >= from_ns && l->t_ns <= to_ns) {
            return true;
        }
    }
    return false;
}

/* Answers that are not lost, and come before the shortest timeout. */
static bool is_willing(const struct record *record, const record_device *device)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        const record_tool *t = &record->tools[i];
        if (record_is_program(t, "lumsim") && t->host == device->host &&
            t->began_ns == device->began_ns) {
            return record_option(t, "--answer-loss") == NULL &&
                   record_number(t, "--answer-delay", 0) < 50;
        }
    }
    return false;
}

static bool has_mishap(const record_device *device, int64_t to_ns)
{
    for (size_t i = 0; i < device->count; i++) {
        const record_line *l = &device->lines[i];
        if ((l->event == RECORD_FAULT || l->event == RECORD_MOVE) &&
            l->t_ns <= to_ns) {
            return true;
        }
    }
    return false;
}

bool record_answers(const struct record *record, uint32_t address,
                    int64_t from_ns, int64_t to_ns)
{
    const record_device *device = record_device_at(record, address, from_ns);
    return device != NULL && device->ended_ns > to_ns &&
           is_willing(record, device) && !has_mishap(device, to_ns);
}
