#include "internal.h"

#include "kernel/world.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define COMMANDS 64

/* --- the log --- */

/* Its events of one kind: a story that waits asks for them at each step, and a
 * log of an hour has a hundred thousand. */
typedef struct user_kind {
    struct user_kind *next;
    const user_event *first;
    user_event *last;
    size_t count;
} user_kind;

static user_kind *find_kind(const user_sensor *sensor, const char *name)
{
    user_kind *kind = sensor->kinds;
    while (kind != NULL && strcmp(kind->first->kind, name) != 0) {
        kind = kind->next;
    }
    return kind;
}

static void enter_kind(user_sensor *sensor, user_event *event)
{
    user_kind *kind = find_kind(sensor, event->kind);
    if (kind == NULL) {
        kind = user_keep(sizeof *kind);
        *kind = (user_kind){sensor->kinds, event, NULL, 0};
        sensor->kinds = kind;
    } else {
        kind->last->next_of_kind = event;
    }
    kind->last = event;
    kind->count++;
}

static void note_event(void *argument, const char *line)
{
    user_sensor *sensor = argument;
    user_event *event = user_keep(sizeof *event);
    const char *kind = user_value(line, "event");
    const char *t = user_value(line, "t");
    (void)snprintf(event->kind, sizeof event->kind, "%s",
                   kind != NULL ? kind : "");
    event->line = line;
    event->t_ns = world_host_true_ns(
        sensor->host, t != NULL ? (int64_t)(strtod(t, NULL) * 1e9) : 0);
    if (sensor->last != NULL) {
        ((user_event *)sensor->last)->next = event;
    } else {
        sensor->first = event;
    }
    sensor->last = event;
    enter_kind(sensor, event);
}

user_sensor *user_sensor_start(world_host *host, const char *format, ...)
{
    va_list arguments;
    char options[2048];
    va_start(arguments, format);
    (void)vsnprintf(options, sizeof options, format, arguments);
    va_end(arguments);
    user_sensor *sensor = user_sensor_power_on(host, options);
    const char *ready = user_has(options, "--replay") ? "start" : "frames";
    user_until(user_events(sensor, ready) > 0 || user_ended(sensor->tool));
    if (user_ended(sensor->tool)) {
        user_fail(USER_HERE, "the sensor ended: %s", user_err(sensor->tool));
    }
    return sensor;
}

user_sensor *user_sensor_power_on(world_host *host, const char *options)
{
    user_sensor *sensor = user_keep(sizeof *sensor);
    user_text *out = user_text_new();
    user_text *err = user_text_new();
    world_start start = {.host = host, .environment = user_environment};
    sensor->host = host;
    sensor->address = user_address_of(host);
    start.output = user_kept_file(out, note_event, sensor);
    start.error = user_kept_file(err, NULL, NULL);
    const bool is_said =
        user_has(options, "--frames") || user_has(options, "--replay");
    sensor->tool = user_tool_begin(
        &start, user_format("lumsim --address %s --log - %s%s", sensor->address,
                            is_said ? "" : "--frames 1 ", options));
    sensor->tool->out = out;
    sensor->tool->err = err;
    return sensor;
}

/* --- looking --- */

size_t user_events(const user_sensor *sensor, const char *kind)
{
    const user_kind *of = find_kind(sensor, kind);
    return of != NULL ? of->count : 0;
}

static const user_event *first_of(const user_sensor *sensor, const char *kind)
{
    const user_kind *of = find_kind(sensor, kind);
    return of != NULL ? of->first : NULL;
}

const user_event *user_event_at(const user_sensor *sensor, const char *kind,
                                size_t i)
{
    const user_event *event = first_of(sensor, kind);
    while (event != NULL && i-- > 0) {
        event = event->next_of_kind;
    }
    return event;
}

const user_event *user_last(const user_sensor *sensor, const char *kind)
{
    const user_kind *of = find_kind(sensor, kind);
    return of != NULL ? of->last : NULL;
}

static bool is_rise(const user_event *event)
{
    return user_has(event->line, "\"up\": true");
}

bool user_laser_is_on(const user_sensor *sensor)
{
    const user_event *last = user_last(sensor, "laser");
    return last != NULL && is_rise(last);
}

size_t user_laser_rises(const user_sensor *sensor)
{
    size_t count = 0;
    for (const user_event *e = first_of(sensor, "laser"); e != NULL;
         e = e->next_of_kind) {
        count += is_rise(e) ? 1 : 0;
    }
    return count;
}

/* A TLV packet with this note; one that came again has the sequence of before.
 */
size_t user_heard(const user_sensor *sensor, const char *command)
{
    const char *seen[COMMANDS];
    size_t count = 0;
    for (const user_event *e = first_of(sensor, "tlv"); e != NULL;
         e = e->next_of_kind) {
        const char *note = user_value(e->line, "note");
        if (note == NULL || strcmp(note, command) != 0) {
            continue;
        }
        const char *who = user_format("%s %s", user_value(e->line, "from"),
                                      user_value(e->line, "sequence"));
        bool is_new = count < COMMANDS;
        for (size_t i = 0; i < count; i++) {
            is_new = is_new && strcmp(seen[i], who) != 0;
        }
        if (is_new) {
            seen[count++] = who;
        }
    }
    return count;
}

/* Whether a word stands alone in a note, "u; 50p". */
static bool has_word(const char *note, const char *word)
{
    for (const char *at = strstr(note, word); at != NULL;
         at = strstr(at + 1, word)) {
        const char before = at == note ? ' ' : at[-1];
        const char after = at[strlen(word)];
        if (strchr(" ;", before) != NULL && strchr(" ;", after) != NULL) {
            return true; /* strchr() finds the 0 at the end too */
        }
    }
    return false;
}

size_t user_done(const user_sensor *sensor, const char *command)
{
    size_t count = 0;
    for (const user_event *e = first_of(sensor, "tlv"); e != NULL;
         e = e->next_of_kind) {
        const char *note = user_value(e->line, "note");
        count += note != NULL && has_word(note, command) ? 1 : 0;
    }
    return count;
}

void user_wait_for_beats(user_place at, const user_sensor *sensor, size_t count)
{
    const size_t enough = user_events(sensor, "heartbeat") + count;
    while (user_events(sensor, "heartbeat") < enough) {
        user_wait_for_more(at, "heartbeats");
    }
}
