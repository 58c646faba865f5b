/* Tools send what their user asked for, and no more: only what is about the
 * laser sends `d`, only set-ip moves a sensor, and none floods it. */
#include "judge.h"

#include <string.h>

static const char off[] = "off-asked";
static const char move[] = "move-asked";
static const char flood[] = "no-flood";

/* find asks 256 addresses a second (docs/man/lumctl.1); a session sends up to
 * 100 heartbeats (--rate), and a command 20 times a second. */
#define MOST_A_SECOND 300u

static bool is_word(const record_tool *tool, const char *word)
{
    return record_is_program(tool, "lumctl") &&
           strcmp(record_word(tool, 0), word) == 0;
}

static bool may_move(const record_tool *tool)
{
    return is_word(tool, "set-ip") || is_word(tool, "shell");
}

static bool may_switch_off(const record_tool *tool)
{
    return is_word(tool, "laser") || is_word(tool, "send") ||
           is_word(tool, "tlv") || is_word(tool, "shell") ||
           record_option(tool, "--laser") != NULL;
}

struct pace {
    int64_t from_ns;
    unsigned count;
    bool is_told;
};

static void judge_pace(const record_tool *tool, const record_datagram *d,
                       struct pace *p, struct verdict *out)
{
    if (p->count == 0 || d->sent_ns - p->from_ns >= RECORD_S) {
        *p = (struct pace){.from_ns = d->sent_ns, .is_told = p->is_told};
    }
    if (++p->count > MOST_A_SECOND && !p->is_told) {
        p->is_told = true;
        verdict_broken(out, flood, d->sent_ns,
                       "%s %s [%ld] sent %u datagrams within a second",
                       tool->arguments[0], record_word(tool, 0), tool->id,
                       p->count);
    }
}

static void judge_sent(const record_tool *tool, const record_datagram *d,
                       struct verdict *out)
{
    if (d->packet == RECORD_IS_SET_IP && !may_move(tool)) {
        verdict_broken(out, move, d->sent_ns,
                       "%s %s [%ld] gives the sensor another address",
                       tool->arguments[0], record_word(tool, 0), tool->id);
    }
    if (d->packet == RECORD_IS_TLV && strcmp(d->command, "d") == 0 &&
        !may_switch_off(tool)) {
        verdict_broken(out, off, d->sent_ns,
                       "%s %s [%ld] switches the laser off, unasked",
                       tool->arguments[0], record_word(tool, 0), tool->id);
    }
}

static void judge_tool(const struct record *record, int index,
                       struct verdict *out)
{
    const record_tool *tool = &record->tools[index];
    struct pace pace = {0};
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        if (d->sender == index && !d->is_copy) {
            judge_pace(tool, d, &pace, out);
            judge_sent(tool, d, out);
        }
    }
    verdict_asked(out, off);
    verdict_asked(out, move);
    verdict_asked(out, flood);
}

void judge_manners(const struct record *record, struct verdict *out)
{
    for (size_t i = 0; i < record->tool_count; i++) {
        if (!record_is_program(&record->tools[i], "lumsim")) {
            judge_tool(record, (int)i, out);
        }
    }
}
