/* Made-up runs, for tests of the judges. */
#ifndef WORLD_TEST_RUN_H
#define WORLD_TEST_RUN_H

#include "judges/judge.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define MS       RECORD_MS
#define S        RECORD_S
#define SENSOR   0x0a2a0025u /* 10.42.0.37 */
#define SOMEBODY 0x0a2a0001u
#define LONGEST  2048

/* --- Making a run --- */

struct run {
    struct record record;
    struct verdict verdict;
    uint64_t numbers;
};

static inline int setup(void **state)
{
    struct run *run = calloc(1, sizeof *run);
    assert_non_null(run);
    run->record.now_ns = 600 * S;
    *state = run;
    return 0;
}

static inline int teardown(void **state)
{
    struct run *run = *state;
    record_free(&run->record);
    free(run);
    return 0;
}

static inline char *copy(const char *text)
{
    const size_t size = strlen(text) + 1;
    char *out = malloc(size);
    assert_non_null(out);
    return memcpy(out, text, size);
}

/* Words between blanks, and between '...'. */
static inline record_tool *tool(struct run *run, const char *command,
                                int64_t began_ns, int64_t ended_ns, int status)
{
    char text[400];
    const char *arguments[RECORD_ARGUMENTS + 1] = {0};
    unsigned n = 0;
    (void)snprintf(text, sizeof text, "%s", command);
    for (char *at = text; *at != '\0';) {
        const bool is_quoted = *at == '\'';
        at += is_quoted ? 1 : 0;
        arguments[n++] = at;
        at += strcspn(at, is_quoted ? "'" : " ");
        if (*at != '\0') {
            *at++ = '\0';
        }
        at += strspn(at, " ");
    }
    const size_t index = record_add_tool(&run->record, arguments, 1, began_ns);
    record_tool *t = &run->record.tools[index];
    t->ended_ns = ended_ns;
    t->status = status << 8;
    t->id = (long)run->record.tool_count + 100;
    return t;
}

static inline void say(struct run *run, const char *log)
{
    if (run->record.device_count == 0) {
        (void)record_add_device(&run->record, 2, 0);
    }
    record_device *d = &run->record.devices[0];
    d->read = 0;
    record_read_log(&run->record, 0, log, strlen(log), NULL, NULL);
}

#define BOOT                                                                   \
    "{\"t\": 0.000000, \"event\": \"start\", \"address\": "                    \
    "\"10.42.0.37:5517\"}\n"

static inline record_endpoint port_of(unsigned index)
{
    return (record_endpoint){SOMEBODY, (uint16_t)(40000 + index)};
}

/* A datagram between a tool and the sensor, that is read at once. */
static inline record_datagram *mail(struct run *run, int index, int64_t t_ns,
                                    bool is_from_sensor)
{
    record_datagram *d = record_add_datagram(&run->record);
    const record_endpoint sensor = {SENSOR, 5517};
    const record_endpoint own = port_of((unsigned)index);
    d->number = ++run->numbers;
    d->sent_ns = t_ns;
    d->fate_ns = t_ns + MS;
    d->fate = RECORD_READ;
    d->fates = 1;
    d->from = is_from_sensor ? sensor : own;
    d->to = is_from_sensor ? own : sensor;
    d->sender = is_from_sensor ? RECORD_NONE : index;
    d->reader = is_from_sensor ? index : RECORD_NONE;
    return d;
}

static inline void beat(struct run *run, int index, int64_t t_ns)
{
    mail(run, index, t_ns, false)->packet = RECORD_IS_HEARTBEAT;
}

static inline void beats(struct run *run, int index, int64_t from_ns,
                         int64_t to_ns)
{
    for (int64_t t_ns = from_ns; t_ns <= to_ns; t_ns += 200 * MS) {
        beat(run, index, t_ns);
    }
}

static inline void command(struct run *run, int index, int64_t t_ns,
                           uint32_t sequence, const char *text)
{
    record_datagram *d = mail(run, index, t_ns, false);
    d->packet = RECORD_IS_TLV;
    d->sequence = sequence;
    (void)snprintf(d->command, sizeof d->command, "%s", text);
}

static inline void data(struct run *run, int index, int64_t t_ns,
                        const char *bytes)
{
    record_datagram *d = mail(run, index, t_ns, true);
    d->packet = RECORD_IS_DATA;
    d->len = (uint32_t)strlen(bytes);
    d->hash = record_hash(bytes, strlen(bytes));
}

static inline void judge(struct run *run)
{
    judge_all(&run->record, &run->verdict);
}

static inline void assert_fine(struct run *run)
{
    judge(run);
    if (run->verdict.count > 0) {
        fail_msg("%s: %s", run->verdict.findings[0].rule,
                 run->verdict.findings[0].text);
    }
}

static inline bool was_asked(const struct run *run, const char *rule)
{
    for (unsigned i = 0; i < run->verdict.rule_count; i++) {
        if (strcmp(run->verdict.rules[i].rule, rule) == 0) {
            return true;
        }
    }
    return false;
}

/* Only this rule is broken. */
static inline void assert_breaks(struct run *run, const char *rule)
{
    judge(run);
    for (unsigned i = 0; i < run->verdict.count; i++) {
        assert_string_equal(run->verdict.findings[i].rule, rule);
    }
    assert_true(verdict_has(&run->verdict, rule));
}

/* --- Lines of a log --- */

#define BEAT(t)                                                                \
    "{\"t\": " t ", \"event\": \"heartbeat\", \"from\": "                      \
    "\"10.42.0.1:40000\"}\n"
#define TLV(t, seq, note)                                                      \
    "{\"t\": " t                                                               \
    ", \"event\": \"tlv\", \"from\": \"10.42.0.1:40000\", \"sequence\": " seq  \
    ", \"note\": \"" note "\"}\n"
#define LASER(t, up) "{\"t\": " t ", \"event\": \"laser\", \"up\": " up "}\n"
#define STATUS(t, bits)                                                        \
    "{\"t\": " t ", \"event\": \"status\", \"status\": " bits "}\n"
#define FAULT(t, name, ends)                                                   \
    "{\"t\": " t ", \"event\": \"fault\", \"name\": \"" name                   \
    "\", \"ends\": " ends "}\n"

#define FACT(name) cmocka_unit_test_setup_teardown(name, setup, teardown)

#endif
