/* What find, show and doctor print is what was there. */
#include "judge.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char there[] = "found-true";
static const char all[] = "found-all";
static const char calm[] = "found-in-calm";
static const char none[] = "status-of-find";
static const char answers[] = "show-true";
static const char doctor[] = "doctor-true";

struct look {
    const struct record *record;
    int index;
    const record_tool *tool;
    struct verdict *out;
};

static bool has_asked(const struct look *l, const record_datagram *answer)
{
    for (size_t i = 0; i < l->record->datagram_count; i++) {
        const record_datagram *d = &l->record->datagrams[i];
        if (d->sender == l->index && d->packet == RECORD_IS_TIMESTAMP &&
            d->sequence == answer->sequence &&
            d->to.address == answer->from.address &&
            d->sent_ns <= answer->fate_ns) {
            return true;
        }
    }
    return false;
}

/* An answer to a time stamp that the tool read until a moment; address 0: of
 * anybody. From the n-th datagram on; the count: there is none. */
static size_t find_answer(const struct look *l, uint32_t address,
                          int64_t until_ns, size_t n)
{
    for (; n < l->record->datagram_count; n++) {
        const record_datagram *d = &l->record->datagrams[n];
        if (d->reader == l->index && d->fate == RECORD_READ &&
            d->packet == RECORD_IS_TIMESTAMP && d->fate_ns <= until_ns &&
            (address == 0 || d->from.address == address) && has_asked(l, d)) {
            return n;
        }
    }
    return n;
}

static bool is_answered(const struct look *l, uint32_t address,
                        int64_t until_ns)
{
    return find_answer(l, address, until_ns, 0) < l->record->datagram_count;
}

static bool is_calm(const struct look *l)
{
    const int64_t from_ns = l->tool->began_ns - 2 * RECORD_S;
    return record_answers(l->record, record_host_of(l->tool), from_ns,
                          l->tool->ended_ns) &&
           record_is_calm(l->record, NULL, from_ns, l->tool->ended_ns);
}

/* --- find --- */

/* What is read in the last moment may come too late to be told. */
#define LAST_NS (20 * RECORD_MS)

/* The sensors of its list that answered, one after the other; NULL: no more. */
static const char *next_found(const char *text, uint32_t *address)
{
    static const char sensor[] = "{\"sensor\": \"";
    static const char how[] = "\"how\": \"answers\"";
    while (text != NULL && (text = strstr(text, sensor)) != NULL) {
        const char *end = strchr(text, '}');
        const char *at = strstr(text, how);
        *address = record_address(text + sizeof sensor - 1, NULL);
        text += sizeof sensor - 1;
        if (at != NULL && end != NULL && at < end) {
            return text;
        }
    }
    return NULL;
}

static bool is_listed(const struct look *l, uint32_t address)
{
    const char *at = l->tool->out;
    uint32_t listed = 0;
    while ((at = next_found(at, &listed)) != NULL) {
        if (listed == address) {
            return true;
        }
    }
    return false;
}

/* The device was there, if its log is known, and it answered. */
static void judge_listed(const struct look *l)
{
    const char *at = l->tool->out;
    uint32_t address = 0;
    while ((at = next_found(at, &address)) != NULL) {
        verdict_asked(l->out, there);
        if (!is_answered(l, address, l->tool->ended_ns)) {
            verdict_broken(l->out, there, l->tool->ended_ns,
                           "find [%ld] says that %u.%u.%u.%u answers, and "
                           "nothing came from there",
                           l->tool->id, address >> 24, address >> 16 & 0xffu,
                           address >> 8 & 0xffu, address & 0xffu);
        }
    }
}

static void judge_unlisted(const struct look *l)
{
    const int64_t until_ns = l->tool->ended_ns - LAST_NS;
    size_t n = 0;
    while ((n = find_answer(l, 0, until_ns, n)) < l->record->datagram_count) {
        const record_datagram *d = &l->record->datagrams[n++];
        verdict_asked(l->out, all);
        if (!is_listed(l, d->from.address)) {
            verdict_broken(l->out, all, d->fate_ns,
                           "find [%ld] read an answer of %u.%u.%u.%u, and does "
                           "not list it",
                           l->tool->id, d->from.address >> 24,
                           d->from.address >> 16 & 0xffu,
                           d->from.address >> 8 & 0xffu,
                           d->from.address & 0xffu);
            return;
        }
    }
}

static bool is_in_subnet(uint32_t address, const char *subnet)
{
    const char *behind = NULL;
    const uint32_t of = record_address(subnet, &behind);
    const unsigned bits = behind != NULL && *behind == '/'
                              ? (unsigned)strtoul(behind + 1, NULL, 10)
                              : 32u;
    const uint32_t mask = bits == 0 ? 0 : ~UINT32_C(0) << (32 - bits);
    return of != 0 && (address & mask) == (of & mask);
}

static uint32_t address_of(const record_device *device)
{
    return device->count > 0 && device->lines[0].event == RECORD_START
               ? device->lines[0].peer.address
               : 0;
}

/* In calm each that can answer is found. */
static void judge_missing(const struct look *l)
{
    const int64_t from_ns = l->tool->began_ns - 2 * RECORD_S;
    const char *subnet = record_option(l->tool, "--subnet");
    if (subnet == NULL || l->tool->signal_count > 0 ||
        l->tool->stop_count > 0 ||
        !record_is_calm(l->record, NULL, from_ns, l->tool->ended_ns)) {
        return;
    }
    for (size_t i = 0; i < l->record->device_count; i++) {
        const uint32_t address = address_of(&l->record->devices[i]);
        if (address == 0 || !is_in_subnet(address, subnet) ||
            !record_answers(l->record, address, from_ns, l->tool->ended_ns)) {
            continue;
        }
        verdict_asked(l->out, calm);
        if (!is_listed(l, address)) {
            verdict_broken(l->out, calm, l->tool->ended_ns,
                           "find [%ld] does not find the sensor, and nothing "
                           "is wrong",
                           l->tool->id);
        }
    }
}

static void judge_find(const struct look *l)
{
    const int status = record_exit_status(l->tool);
    if (record_option(l->tool, "--json") == NULL ||
        strstr(l->tool->out, "\"sensors\"") == NULL) {
        return;
    }
    judge_listed(l);
    judge_unlisted(l);
    judge_missing(l);
    verdict_asked(l->out, none);
    if (status == 3 && strstr(l->tool->out, "\"how\": \"answers\"") != NULL) {
        verdict_broken(l->out, none, l->tool->ended_ns,
                       "find [%ld] lists a sensor, and ends with 3",
                       l->tool->id);
    }
}

/* --- show --- */

static void judge_show(const struct look *l)
{
    const uint32_t host = record_host_of(l->tool);
    const int status = record_exit_status(l->tool);
    bool says = false;
    const bool has_said = record_json_bool(l->tool->out, "answers", &says);
    if (status != 3 && !has_said) {
        return;
    }
    const bool is = is_answered(l, host, l->tool->ended_ns);
    verdict_asked(l->out, answers);
    if ((status == 3 && is) || (has_said && says != is)) {
        verdict_broken(l->out, answers, l->tool->ended_ns,
                       "show [%ld] says that the sensor %s, and %s",
                       l->tool->id, is ? "does not answer" : "answers",
                       is ? "it did" : "it did not");
    }
}

/* --- doctor --- */

/* The result of one of its checks; "": it has none. */
static void find_result(const char *text, const char *name, char out[16])
{
    static const char result[] = "\"result\": \"";
    char key[40];
    out[0] = '\0';
    (void)snprintf(key, sizeof key, "{\"name\": \"%s\",", name);
    const char *at = strstr(text, key);
    at = at != NULL ? strstr(at, result) : NULL;
    if (at != NULL) {
        at += sizeof result - 1;
        (void)snprintf(out, 16, "%.*s", (int)strcspn(at, "\""), at);
    }
}

/* Also of another layout. */
static bool has_data(const struct look *l)
{
    for (size_t i = 0; i < l->record->datagram_count; i++) {
        const record_datagram *d = &l->record->datagrams[i];
        if (d->reader == l->index && d->fate == RECORD_READ &&
            d->from.address == record_host_of(l->tool) &&
            d->packet != RECORD_IS_TLV && d->packet != RECORD_IS_TIMESTAMP) {
            return true;
        }
    }
    return false;
}

static void judge_check(const struct look *l, const char *name, bool is_there)
{
    char result[16];
    find_result(l->tool->out, name, result);
    if (strcmp(result, "fine") != 0) {
        return;
    }
    verdict_asked(l->out, doctor);
    if (!is_there) {
        verdict_broken(l->out, doctor, l->tool->ended_ns,
                       "doctor [%ld] says that '%s' is fine, and nothing came",
                       l->tool->id, name);
    }
}

static void judge_doctor(const struct look *l)
{
    const bool is = is_answered(l, record_host_of(l->tool), l->tool->ended_ns);
    judge_check(l, "answer", is);
    judge_check(l, "data", has_data(l));
    /* Of several looks some may be lost. */
    if (is && is_calm(l)) {
        verdict_asked(l->out, doctor);
        if (strstr(l->tool->out, "no answer to ") != NULL) {
            verdict_broken(l->out, doctor, l->tool->ended_ns,
                           "doctor [%ld] says that nothing answers, and read "
                           "an answer",
                           l->tool->id);
        }
    }
}

/* --- */

void judge_found(const struct record *record, struct verdict *out)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        const record_tool *tool = &record->tools[i];
        const struct look l = {record, (int)i, tool, out};
        if (!record_is_program(tool, "lumctl") || tool->out == NULL ||
            record_exit_status(tool) < 0 ||
            !record_is_undamaged(record, tool->began_ns, tool->ended_ns)) {
            continue;
        }
        if (strcmp(record_word(tool, 0), "find") == 0) {
            judge_find(&l);
        } else if (strcmp(record_word(tool, 0), "show") == 0) {
            judge_show(&l);
        } else if (strcmp(record_word(tool, 0), "doctor") == 0) {
            judge_doctor(&l);
        }
    }
}
