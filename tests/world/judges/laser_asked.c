/* The laser is never switched on by anything but a `u` that its user asked for,
 * and that the user still wants. */
#include "judge.h"

#include <stdio.h>
#include <string.h>

static const char asked[] = "laser-asked";
static const char again[] = "laser-again";
static const char back[] = "laser-back";

/* After this time of its own a session gives up laser on: 5 s without an answer
 * (docs/man/lumdump.1, --laser), and the request that is under way then: its
 * five tries 0.4 s apart (docs/man/lumctl.1, --timeout, --retries). */
#define GIVES_UP_NS (7500 * RECORD_MS)

/* A program that was held up for 2 s does not send `u` (docs/safety.md). Stops
 * are counted a little longer, since the last look may have been just before.
 */
#define HELD_UP_NS (2300 * RECORD_MS)

/* A session looks at the status once a second, and its `d` may be under way
 * (docs/safety.md, "See every hazard"). */
#define SEEN_NS (2500 * RECORD_MS)

#define HEARTBEAT_TIMEOUT 0x0010u /* docs/protocol.md, section 5 */

/* --- What a user asked for --- */

/* A line typed in a shell, or a word of `send`, switches it on. */
static bool says_on(const char *text)
{
    return strstr(text, "laser on") != NULL || record_has_word(text, "u");
}

static bool typed_on(const record_tool *tool, int64_t until_ns)
{
    for (size_t i = 0; i < tool->typed_count; i++) {
        if (tool->typed[i].t_ns <= until_ns && says_on(tool->typed[i].text)) {
            return true;
        }
    }
    return false;
}

static bool is_for_on(const record_tool *tool, int64_t until_ns)
{
    if (record_is_program(tool, "lumctl")) {
        const char *command = record_word(tool, 0);
        const char *word = record_word(tool, 1);
        return (strcmp(command, "laser") == 0 && strcmp(word, "on") == 0) ||
               (strcmp(command, "send") == 0 && record_has_word(word, "u")) ||
               (strcmp(command, "tlv") == 0 && strcmp(word, "1:75") == 0) ||
               (strcmp(command, "shell") == 0 && typed_on(tool, until_ns)) ||
               record_option(tool, "--laser") != NULL;
    }
    return record_option(tool, "--laser") != NULL;
}

/* --- Each `u` that a tool sends --- */

static bool is_on(const record_datagram *d)
{
    return d->packet == RECORD_IS_TLV && record_has_word(d->command, "u");
}

static bool is_off(const record_datagram *d)
{
    return d->packet == RECORD_IS_TLV && strcmp(d->command, "d") == 0;
}

/* What a tool did until now. */
struct past {
    int64_t first_on_ns, first_off_ns;
    int64_t last_ns; /* of whatever it sent */
};

static void broken(const record_tool *tool, const record_datagram *d,
                   const char *rule, const char *why, struct verdict *out)
{
    verdict_broken(out, rule, d->sent_ns, "%s [%ld] sends laser on %s",
                   tool->arguments[0], tool->id, why);
}

void judge_on_sent(const struct record *record, const record_datagram *d,
                   struct verdict *out)
{
    if (d->sender != RECORD_NONE && !d->is_copy && is_on(d) &&
        !is_for_on(&record->tools[d->sender], d->sent_ns)) {
        broken(&record->tools[d->sender], d, asked, "and nobody asked it to",
               out);
    }
}

/* It has looked, and was stopped before it could send what it then sent first:
 * no program can tell. */
static bool is_unaware(const record_tool *tool, const record_datagram *d,
                       const struct past *past)
{
    for (unsigned i = 0; i < tool->stop_count; i++) {
        const record_span s = tool->stops[i];
        if (s.is_before_send && past->last_ns <= s.from_ns &&
            s.to_ns <= d->sent_ns) {
            return true;
        }
    }
    return false;
}

/* A repeat by the network is not the tool's. */
static void judge_on(const record_tool *tool, const record_datagram *d,
                     const struct past *past, struct verdict *out)
{
    const int64_t end_ns = record_asked_to_end(tool);
    const bool is_session = record_option(tool, "--laser") != NULL;
    verdict_asked(out, asked);
    verdict_asked(out, again);
    if (!is_for_on(tool, d->sent_ns)) {
        broken(tool, d, asked, "and nobody asked it to", out);
    } else if (is_unaware(tool, d, past)) {
        return;
    } else if (is_session && past->first_off_ns <= d->sent_ns) {
        broken(tool, d, again, "after it had switched it off", out);
    } else if (is_session && end_ns < d->sent_ns &&
               d->sent_ns - end_ns -
                       record_stopped_ns(tool, end_ns, d->sent_ns) >
                   RECORD_S) {
        broken(tool, d, again, "after it was told to end", out);
    }
    if (past->first_on_ns == RECORD_NEVER) {
        return;
    }
    const int64_t stopped_ns =
        record_stopped_ns(tool, past->first_on_ns, d->sent_ns);
    if (is_session &&
        d->sent_ns - past->first_on_ns - stopped_ns > GIVES_UP_NS) {
        broken(tool, d, again, "after it should have given up", out);
    }
    for (unsigned i = 0; i < tool->stop_count && tool->typed_count == 0; i++) {
        const record_span s = tool->stops[i];
        if (s.from_ns > past->first_on_ns && s.to_ns < d->sent_ns &&
            s.to_ns - s.from_ns > HELD_UP_NS) {
            broken(tool, d, again, "after it was held up", out);
            return;
        }
    }
}

static void judge_tool(const struct record *record, int index,
                       struct verdict *out)
{
    const record_tool *tool = &record->tools[index];
    struct past past = {RECORD_NEVER, RECORD_NEVER, 0};
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->sender != index || d->is_copy) {
            continue;
        }
        if (is_on(d)) {
            judge_on(tool, d, &past, out);
            past.first_on_ns =
                d->sent_ns < past.first_on_ns ? d->sent_ns : past.first_on_ns;
        } else if (is_off(d) && d->sent_ns < past.first_off_ns) {
            past.first_off_ns = d->sent_ns;
        }
        past.last_ns = d->sent_ns;
    }
}

/* --- Each time that the laser comes on --- */

/* After it the laser waits for another `u`: power-up, or 3 s without a
 * heartbeat (docs/safety.md). */
static bool ends_orders(const record_line *line)
{
    return line->event == RECORD_START ||
           (line->event == RECORD_FAULT && strcmp(line->text, "reboot") == 0) ||
           (line->event == RECORD_STATUS &&
            (line->status & HEARTBEAT_TIMEOUT) != 0);
}

/* The last `u` or `d` in effect that the device carried out, before a moment or
 * at it; NULL: none. */
static const record_line *last_order(const record_device *device, size_t before)
{
    for (size_t i = before; i > 0; i--) {
        const record_line *l = &device->lines[i - 1];
        if (record_was_done(l, "u") || record_was_done(l, "d")) {
            return l;
        }
        if (ends_orders(l)) {
            return NULL;
        }
    }
    return NULL;
}

void judge_rise(const record_device *device, size_t at, struct verdict *out)
{
    const record_line *line = &device->lines[at];
    const record_line *order = last_order(device, at);
    verdict_asked(out, asked);
    if (order == NULL || !record_was_done(order, "u")) {
        verdict_broken(out, asked, line->t_ns,
                       "the laser comes on, and no laser on is in effect");
    }
}

/* --- A hazard that ends --- */

/* A laser session that could see it all the time: it has switched it off. */
static bool is_kept(const struct record *record, uint32_t address,
                    int64_t from_ns, int64_t to_ns)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        const record_tool *tool = &record->tools[i];
        if (record_option(tool, "--laser") != NULL &&
            record_host_of(tool) == address &&
            tool->began_ns + SEEN_NS < from_ns && tool->ended_ns > to_ns &&
            record_asked_to_end(tool) > to_ns &&
            record_stopped_ns(tool, from_ns, to_ns) == 0) {
            return true;
        }
    }
    return false;
}

static bool is_hazard(const record_line *line)
{
    return line->event == RECORD_FAULT && strcmp(line->text, "reboot") != 0 &&
           strcmp(line->text, "silence") != 0;
}

/* When the hazard began that ends at a line; RECORD_NEVER: it is not known. */
static int64_t hazard_from(const record_device *device, size_t end)
{
    for (size_t i = end; i > 0; i--) {
        const record_line *l = &device->lines[i - 1];
        if (is_hazard(l) && !l->is_yes &&
            strcmp(l->text, device->lines[end].text) == 0) {
            return l->t_ns;
        }
    }
    return RECORD_NEVER;
}

static uint32_t address_of(const record_device *device, size_t before)
{
    uint32_t address = 0;
    for (size_t i = 0; i < before; i++) {
        const record_line *l = &device->lines[i];
        if (l->event == RECORD_START ||
            (l->event == RECORD_MOVE && l->is_yes)) {
            address = l->peer.address;
        }
    }
    return address;
}

/* Somebody else's `u` during the hazard, or silence, is no fault of a laser
 * session.
 */
static bool is_disturbed(const record_device *device, int64_t from_ns,
                         int64_t to_ns)
{
    for (size_t i = 0; i < device->count; i++) {
        const record_line *l = &device->lines[i];
        const bool is_near =
            l->t_ns >= from_ns - SEEN_NS && l->t_ns <= to_ns + RECORD_MS;
        if (is_near && ((l->t_ns > from_ns && record_was_done(l, "u")) ||
                        (l->event == RECORD_FAULT && !is_hazard(l)) ||
                        l->event == RECORD_MOVE)) {
            return true;
        }
    }
    return false;
}

static void judge_hazard_end(const struct record *record,
                             const record_device *device, size_t end,
                             struct verdict *out)
{
    const int64_t to_ns = device->lines[end].t_ns;
    const int64_t from_ns = hazard_from(device, end);
    if (from_ns == RECORD_NEVER || to_ns - from_ns < SEEN_NS ||
        !record_is_calm(record, NULL, from_ns - SEEN_NS, to_ns) ||
        !is_kept(record, address_of(device, end), from_ns, to_ns) ||
        is_disturbed(device, from_ns, to_ns)) {
        return;
    }
    verdict_asked(out, back);
    if (record_laser_is_up(device, to_ns + RECORD_MS)) {
        verdict_broken(out, back, to_ns,
                       "the laser comes back when a hazard of %.3f s ends, "
                       "though a session with --laser saw it",
                       (double)(to_ns - from_ns) * 1e-9);
    }
}

/* --- */

static void judge_device(const struct record *record,
                         const record_device *device, struct verdict *out)
{
    for (size_t i = 0; i < device->count; i++) {
        const record_line *l = &device->lines[i];
        if (l->event == RECORD_LASER && l->is_yes) {
            judge_rise(device, i, out);
        } else if (is_hazard(l) && l->is_yes) {
            judge_hazard_end(record, device, i, out);
        }
    }
}

void judge_laser_asked(const struct record *record, struct verdict *out)
{
    for (size_t i = 0; i < record->device_count; i++) {
        judge_device(record, &record->devices[i], out);
    }
    for (size_t i = 0; i < record->tool_count; i++) {
        judge_tool(record, (int)i, out);
    }
}
