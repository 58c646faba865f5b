/* The offset that lumctl time prints is that of the two clocks, within the
 * error that it prints beside it (docs/man/lumctl.1, time). */
#include "judge.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char within[] = "time-true";

/* Clocks are promised to differ by 500 ppm at most, and not to change their
 * rate meanwhile (include/lum/host/clock_sync.h). */
#define DRIFT_MOST_PPB INT64_C(480000)

/* The sensor's clock returns to 0 then (docs/protocol.md, section 3). */
#define WRAP_NS (INT64_C(0x100000000) * RECORD_US)

/* It counts whole microseconds; the log of a datagram's reading and the reading
 * of a clock are calls of their own. */
#define CLOCK_NS (20 * RECORD_US)

/* What was printed, and when. */
struct said {
    int64_t offset_ns, error_ns;
    const record_print *print;
};

struct timing {
    const struct record *record;
    int index;
    const record_tool *tool;
    struct verdict *out;
};

/* --- What the world knows --- */

/* The exchange of an answer: between its two moments the sensor read its clock.
 */
struct exchange {
    const record_datagram *answer;
    const record_stamp *asked, *answered;
};

static const record_stamp *find_stamp(const struct record *record,
                                      uint64_t number)
{
    for (size_t i = record->stamp_count; i > 0; i--) {
        if (record->stamps[i - 1].number == number) {
            return &record->stamps[i - 1];
        }
    }
    return NULL;
}

/* The last time that the request was read before it was answered. */
static const record_stamp *find_asked(const struct timing *t,
                                      const record_datagram *answer)
{
    const record_stamp *last = NULL;
    for (size_t i = 0; i < t->record->datagram_count; i++) {
        const record_datagram *d = &t->record->datagrams[i];
        if (d->sent_ns > answer->sent_ns) {
            break;
        }
        if (d->sender == t->index && d->packet == RECORD_IS_TIMESTAMP &&
            d->sequence == answer->sequence && d->fate == RECORD_READ &&
            d->fate_ns <= answer->sent_ns) {
            last = find_stamp(t->record, d->number);
        }
    }
    return last;
}

static bool is_answer(const struct timing *t, const record_datagram *d)
{
    return d->reader == t->index && d->fate == RECORD_READ &&
           d->packet == RECORD_IS_TIMESTAMP;
}

/* Clocks of both hosts went as promised from its begin to a moment. */
static bool is_steady(const struct timing *t, const record_print *print)
{
    const int64_t drift_ppb = print->clock.drift_ppb;
    for (size_t i = 0; i < t->record->stamp_count; i++) {
        const record_stamp *s = &t->record->stamps[i];
        const int64_t apart_ppb = drift_ppb - s->sensor.drift_ppb;
        if (s->t_ns >= t->tool->began_ns && s->t_ns <= print->t_ns &&
            (s->asker.drift_ppb != drift_ppb || apart_ppb > DRIFT_MOST_PPB ||
             apart_ppb < -DRIFT_MOST_PPB)) {
            return false;
        }
    }
    return true;
}

/* --- Held against it --- */

/* How far it is out of what an exchange leaves possible. */
static int64_t outside_ns(const struct said *s, const struct exchange *e)
{
    const int64_t utc_ns = s->print->clock.utc_ns - s->print->clock.mono_ns;
    const int64_t clock_ns = (int64_t)e->answer->clock_us * RECORD_US;
    const int64_t low_ns = e->asked->asker.mono_ns + utc_ns - clock_ns;
    const int64_t high_ns = e->answered->asker.mono_ns + utc_ns - clock_ns;
    int64_t above_ns = (s->offset_ns - low_ns) % WRAP_NS;
    above_ns += above_ns < -WRAP_NS / 2 ? WRAP_NS : 0;
    above_ns -= above_ns > WRAP_NS / 2 ? WRAP_NS : 0;
    const int64_t width_ns = high_ns - low_ns;
    const int64_t most_ns = s->error_ns + CLOCK_NS;
    return above_ns < -most_ns             ? -most_ns - above_ns
           : above_ns > width_ns + most_ns ? above_ns - width_ns - most_ns
                                           : 0;
}

/* The last exchanges before it: the tool may not have taken the very last. */
#define LAST_EXCHANGES 3

static void judge_said(const struct timing *t, const struct said *s)
{
    unsigned count = 0;
    int64_t best_ns = INT64_MAX;
    if (!is_steady(t, s->print)) {
        return;
    }
    for (size_t i = t->record->datagram_count; i > 0 && count < LAST_EXCHANGES;
         i--) {
        const record_datagram *d = &t->record->datagrams[i - 1];
        if (!is_answer(t, d) || d->fate_ns > s->print->t_ns) {
            continue;
        }
        const struct exchange e = {d, find_asked(t, d),
                                   find_stamp(t->record, d->number)};
        if (e.asked == NULL || e.answered == NULL) {
            continue;
        }
        const int64_t outside = outside_ns(s, &e);
        best_ns = outside < best_ns ? outside : best_ns;
        count++;
    }
    if (count == 0) {
        return;
    }
    verdict_asked(t->out, within);
    if (best_ns > 0) {
        verdict_broken(t->out, within, s->print->t_ns,
                       "lumctl [%ld] says an offset of %.6f s +-%.6f s, and "
                       "that is %.6f s beyond",
                       t->tool->id, (double)s->offset_ns * 1e-9,
                       (double)s->error_ns * 1e-9, (double)best_ns * 1e-9);
    }
}

/* --- What is printed --- */

static bool read_json(const char *line, struct said *out)
{
    static const char key[] = "\"offset_ns\": ";
    uint64_t error = 0;
    const char *at = strstr(line, key);
    if (at == NULL || !record_json_number(line, "error_ns", &error)) {
        return false;
    }
    out->offset_ns = strtoll(at + sizeof key - 1, NULL, 10);
    out->error_ns = (int64_t)error;
    return true;
}

/* "+-182 us", "+-12.30 ms"; as it is rounded. */
static bool read_error(const char *line, int64_t *out)
{
    const char *at = strstr(line, "+-");
    char *unit = NULL;
    if (at == NULL) {
        return false;
    }
    const double value = strtod(at + 2, &unit);
    const bool is_ms = strncmp(unit, " ms", 3) == 0;
    *out = is_ms ? (int64_t)((value + 0.006) * 1e6)
                 : (int64_t)((value + 0.6) * 1e3);
    return true;
}

/* A line of a watch: "offset 1767225595.000123 s +-182 us". */
static bool read_line(const char *line, struct said *out)
{
    static const char key[] = "  offset ";
    const char *at = strstr(line, key);
    char *point = NULL;
    if (at == NULL || !read_error(at, &out->error_ns)) {
        return false;
    }
    const int64_t s = strtoll(at + sizeof key - 1, &point, 10);
    const int64_t us = *point == '.' ? strtoll(point + 1, NULL, 10) : 0;
    out->offset_ns = s * RECORD_S + us * RECORD_US;
    return true;
}

/* Days since 1970 of a date. */
static int64_t days_of(int64_t year, int64_t month, int64_t day)
{
    static const int before[] = {0,   31,  59,  90,  120, 151,
                                 181, 212, 243, 273, 304, 334};
    const int64_t y = month > 2 ? year : year - 1;
    const int64_t leaps = y / 4 - y / 100 + y / 400 - 477;
    return (year - 1970) * 365 + leaps + before[(month + 11) % 12] + day - 1;
}

/* "was 0 at    2026-01-01T00:00:00.015Z", which has whole milliseconds. */
static bool read_utc(const char *line, struct said *out)
{
    static const char key[] = "  was 0 at";
    static const char behind[] = "--T::.Z";
    int64_t parts[7] = {0};
    if (strncmp(line, key, sizeof key - 1) != 0 ||
        !read_error(line, &out->error_ns)) {
        return false;
    }
    const char *at = line + sizeof key - 1;
    for (unsigned i = 0; i < 7; i++) {
        char *end = NULL;
        parts[i] = strtol(at, &end, 10);
        if (end == at || *end != behind[i]) {
            return false;
        }
        at = end + 1;
    }
    const int64_t day = days_of(parts[0], parts[1], parts[2]);
    out->offset_ns =
        (((day * 24 + parts[3]) * 60 + parts[4]) * 60 + parts[5]) * RECORD_S +
        parts[6] * RECORD_MS;
    out->error_ns += RECORD_MS;
    return true;
}

static const record_print *find_print(const record_tool *tool, size_t place)
{
    for (size_t i = 0; i < tool->print_count; i++) {
        if (tool->prints[i].out >= place) {
            return &tool->prints[i];
        }
    }
    return NULL;
}

static void judge_tool(const struct timing *t)
{
    const char *at = t->tool->out;
    while (*at != '\0') {
        char line[512];
        struct said s = {0, 0, NULL};
        const size_t len = strcspn(at, "\n");
        (void)snprintf(line, sizeof line, "%.*s", (int)len, at);
        at += len + (at[len] == '\n' ? 1 : 0);
        s.print = find_print(t->tool, (size_t)(at - t->tool->out));
        if (s.print != NULL && (read_json(line, &s) || read_line(line, &s) ||
                                read_utc(line, &s))) {
            judge_said(t, &s);
        }
    }
}

void judge_times(const struct record *record, struct verdict *out)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        const record_tool *tool = &record->tools[i];
        const struct timing t = {record, (int)i, tool, out};
        if (record_is_program(tool, "lumctl") && tool->out != NULL &&
            !tool->met_others &&
            record_is_undamaged(record, tool->began_ns, tool->ended_ns)) {
            judge_tool(&t);
        }
    }
}
