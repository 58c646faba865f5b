#include "lum/live/news.h"

#include "lum/host/laser_name.h"
#include "lum/laser.h"
#include "lum/wire.h"
#include "net/endpoint.h"

#include <stdio.h>
#include <string.h>

/* --- The table --- */

typedef struct entry {
    const char *name;
    lum_news_weight weight;
    const char *sentence; /* words in braces stand for values */
    const char *fix;
} entry;

#define TENTH_NS INT64_C(100000000)

#define INFO  LUM_NEWS_INFO
#define WARN  LUM_NEWS_WARNING
#define ERROR LUM_NEWS_ERROR

#define WHEN_SAFE                                                              \
    "it is not switched on again automatically: when it is safe, run {ctl} "   \
    "laser on"
#define BOOTS_AT "10.42.0.37"
#define LAST_HEARTBEAT                                                         \
    "it MAY BE ON or come on by itself; a working sensor switches it off "     \
    "{when}"
#define PROFILE "correct tlv.status in the profile: it says {tlv}"
#define POWER   "{fix}, or cut its power"

/* By number. */
static const entry entries[LUM_NEWS_END] = {
    {NULL, INFO, "", ""},
    {"laser-up", INFO, "the laser of {sensor} is on", ""},
    {"laser-fell", ERROR, "the laser of {sensor} went off ({bits}{cause})",
     WHEN_SAFE},
    {"laser-refused", ERROR, "the laser of {sensor} stays down ({bits}{cause})",
     WHEN_SAFE},
    {"laser-unseen", ERROR,
     "{sensor} answered to laser on without a status: whether it is on is not "
     "known, so it is being switched off",
     PROFILE},
    {"laser-unanswered", ERROR,
     "{sensor} did not answer to laser on in {tries} tries: it is being "
     "switched off",
     "look with {ctl} status"},
    {"laser-held-up", ERROR,
     "this program was held up for {seconds} s while it switched the laser of "
     "{sensor} on: it is being switched off",
     "when it is safe, run {ctl} laser on"},
    {"laser-came-up", WARN, "another program switched the laser of {sensor} on",
     ""},
    {"laser-left", WARN, "the laser of {sensor} is {left}", WHEN_SAFE},
    {"laser-is-off", INFO, "the laser of {sensor} {is}",
     "{ctl} laser on switches it on"},
    {"off-unanswered", ERROR,
     "{sensor} does not answer to laser off: until it does, its laser may be "
     "on, or come on by itself when a hazard ends",
     "stay out of the beam, or cut its power"},
    {"hazard", WARN, "{sensor} reports a hazard: {bits}",
     "{ctl} status says what to look at"},
    {"text", WARN, "{sensor} says: {text}", ""},
    {"no-answer-yet", WARN,
     "no data from {sensor} within {seconds} s, nor any answer",
     "is it on, connected and at this address? It boots at " BOOTS_AT
     "; look with {ctl} doctor"},
    {"no-data-yet", WARN,
     "no data from {sensor} within {seconds} s, though it answers",
     "is a profile needed, or does a firewall drop what is not an answer? look "
     "with {ctl} doctor"},
    {"unknown-layout", WARN,
     "{sensor} sends packets, and none of them fits the layout",
     "is a --profile needed?"},
    {"silent", WARN,
     "no data from {sensor} for {seconds} s; heartbeats continue",
     "{ctl} doctor finds out more; after a restart a sensor is at " BOOTS_AT},
    {"data-stopped", WARN,
     "no data from {sensor} for {seconds} s, though it answers; heartbeats "
     "continue",
     "another host may own it now; {ctl} doctor finds out more"},
    {"back", WARN, "data from {sensor} again, after {seconds} s without", ""},
    {"moved", ERROR,
     "the data comes from {to} now, not from {sensor}: the sensor now has that "
     "address, so its data is not used and ends within 3 s",
     "end this session, and begin one with {to}"},
    {"restarted", WARN, "{sensor} was restarted: its clock began again",
     "its settings are lost; when it is safe, run {ctl} laser on"},
    {"unheard", WARN,
     "{sensor} sends data, but does not answer when asked for its status",
     "{ctl} doctor finds out why"},
    {"no-answer", WARN, "{sensor} does not answer",
     "{ctl} doctor finds out why"},
    {"answers", INFO, "{sensor} answers again", ""},
    {"late-answers", WARN,
     "{sensor} answers so late that its answers cannot be used",
     "{ctl} doctor finds out how late"},
    {"no-status", WARN,
     "{sensor} answers without a status, so the state of its laser is unknown",
     PROFILE},
    {"link-down", WARN, "sending to {sensor} fails: {text}; it is retried",
     "{ctl} doctor finds out why"},
    {"link-up", WARN, "sending to {sensor} works again", ""},
    {"off-goes-on", WARN,
     "{sensor}: {state}: laser off is repeated for {seconds} s more", ""},
    {"ended-off", INFO, "{sensor}: the laser is off", ""},
    {"ended-unknown", ERROR,
     "{sensor}: laser off was not answered: " LAST_HEARTBEAT, POWER},
    {"ended-unseen", ERROR,
     "{sensor}: laser off was answered without a status TLV, so it is not "
     "confirmed off: " LAST_HEARTBEAT,
     PROFILE},
    {"ended-in-effect", ERROR,
     "{sensor}: LASER ON IS STILL IN EFFECT after laser off: the laser comes "
     "up by itself when what keeps it down ends (status: {bits})",
     POWER},
    {"ended-on", ERROR,
     "{sensor}: THE LASER IS STILL ON after laser off (status: {bits})", POWER},
};

static const entry *entry_of(lum_news_kind kind)
{
    return &entries[(unsigned)kind < LUM_NEWS_END ? kind : 0];
}

const char *lum_news_name(lum_news_kind kind)
{
    return entry_of(kind)->name;
}

lum_news_weight lum_news_weigh(lum_news_kind kind)
{
    return entry_of(kind)->weight;
}

bool lum_news_is_dark(lum_news_kind kind)
{
    return (kind >= LUM_NEWS_LASER_FELL && kind <= LUM_NEWS_LASER_HELD_UP) ||
           kind == LUM_NEWS_LASER_LEFT || kind == LUM_NEWS_LASER_IS_OFF;
}

/* --- Values in a sentence --- */

#define VALUES      14u
#define VALUE_BYTES (LUM_NEWS_TEXT_BYTES + 64u)

/* What stands for a word in braces. */
typedef struct value {
    const char *word;
    char text[VALUE_BYTES];
} value;

#define SET(out, name, ...)                                                    \
    ((out)->word = (name),                                                     \
     (void)snprintf((out)->text, VALUE_BYTES, __VA_ARGS__))

/* The port stands where it is not that of all sensors. */
static lum_endpoint_text show(lum_endpoint endpoint)
{
    if (endpoint.port == LUM_PORT || endpoint.port == 0) {
        return lum_endpoint_show_address(endpoint.address);
    }
    return lum_endpoint_show(endpoint);
}

static size_t add(char *out, size_t room, size_t at, const char *text,
                  size_t len)
{
    const size_t left = room - 1u - at;
    const size_t count = len < left ? len : left;
    memcpy(out + at, text, count);
    out[at + count] = '\0';
    return at + count;
}

const char *lum_laser_cause(uint16_t status, bool was_away)
{
    const unsigned off = LUM_LASER_TLV_CMD_OFF;
    if ((status & (LUM_LASER_HAZARDS | off)) != off) {
        return "";
    }
    return was_away ? ": the sensor was restarted, or got no heartbeat for 3 s"
                    : ": switched off by another program's command, or when no "
                      "heartbeat came for 3 s";
}

const char *lum_news_ctl(lum_endpoint sensor, const char *interface_name,
                         char *out, size_t room)
{
    const char *name = interface_name != NULL ? interface_name : "";
    const char *quote = strchr(name, ' ') != NULL ? "\"" : "";
    (void)snprintf(out, room, "lumctl --host %s%s%s%.200s%s", show(sensor).text,
                   *name != '\0' ? " --interface " : "", quote, name, quote);
    return out;
}

/* Without the session's heartbeats somebody else's keep the laser on. */
static void fill(const lum_news *news, value out[VALUES])
{
    const bool may_be_on = news->kind >= LUM_NEWS_ENDED_UNKNOWN;
    const bool has_moved = may_be_on && news->to.address != 0;
    const bool is_held = news->kind == LUM_NEWS_LASER_FELL && news->ns != 0;
    const uint16_t shown =
        news->status & (may_be_on ? UINT16_MAX : LUM_LASER_ALL_DOWN);
    char ctl[VALUE_BYTES];
    const char *state = news->tries == 0 ? "no answer yet"
                        : lum_laser_is_down(news->status)
                            ? "laser on is still in effect"
                            : "the laser is still on";
    const int64_t tenths = (news->ns + TENTH_NS / 2) / TENTH_NS;
    SET(&out[0], "sensor", "%s", show(news->sensor).text);
    SET(&out[1], "to", "%s", show(news->to).text);
    SET(&out[2], "ctl", "%s",
        lum_news_ctl(has_moved ? news->to : news->sensor, news->interface_name,
                     ctl, sizeof ctl));
    out[3].word = "bits";
    (void)lum_laser_bits_name(shown, " ", out[3].text, sizeof out[3].text);
    if (news->kind == LUM_NEWS_LASER_FELL && news->status == 0) {
        SET(&out[3], "bits",
            "TLV_CMD_ON is gone, as after a restart of the sensor");
    }
    SET(&out[4], "seconds", tenths < 100 ? "%.2g" : "%.0f",
        (double)tenths / 10);
    SET(&out[5], "cause",
        is_held ? ": this program sent no heartbeats for %s s" : "%s",
        is_held ? out[4].text : lum_laser_cause(news->status, news->was_away));
    SET(&out[6], "state", "%s", state);
    SET(&out[7], "is",
        lum_laser_is_down(news->status) ? "is off" : "is not confirmed on");
    SET(&out[8], "left", news->was_away ? "being switched off" : "off");
    SET(&out[9], "when",
        news->is_owner ? "within 3 s, because the heartbeats have ended"
                       : "3 s after the last heartbeat");
    SET(&out[10], "fix",
        news->is_owner ? "make sure by %.250s laser off"
                       : "end the programs that send heartbeats",
        out[2].text);
    SET(&out[11], "tries", "%u", news->tries);
    SET(&out[12], "tlv", "%u", (unsigned)news->tlv_status);
    SET(&out[13], "text", "%s", news->text);
}

static const char *find(const value values[VALUES], const char *word,
                        size_t len)
{
    size_t i = VALUES - 1u;
    while (i > 0 && (strlen(values[i].word) != len ||
                     strncmp(values[i].word, word, len) != 0)) {
        i--;
    }
    return values[i].text;
}

/* --- Sentences --- */

/* Forms of the table, one after the other, with their values. */
static const char *write(const lum_news *news, const char *first,
                         const char *second, char *out, size_t room)
{
    const char *forms[] = {
        first, second[0] != '\0' && first[0] != '\0' ? "; " : "", second};
    value values[VALUES];
    size_t at = 0;
    out[0] = '\0';
    fill(news, values);
    for (size_t i = 0; i < 3; i++) {
        const char *form = forms[i];
        while (*form != '\0') {
            const size_t plain = strcspn(form, "{");
            at = add(out, room, at, form, plain);
            form += plain;
            if (*form == '{') {
                const size_t len = strcspn(form + 1, "}");
                const char *text = find(values, form + 1, len);
                at = add(out, room, at, text, strlen(text));
                form += len + 2u;
            }
        }
    }
    return out;
}

const char *lum_news_sentence(const lum_news *news, char *out, size_t room)
{
    return write(news, entry_of(news->kind)->sentence, "", out, room);
}

const char *lum_news_fix(const lum_news *news, char *out, size_t room)
{
    return write(news, "", entry_of(news->kind)->fix, out, room);
}

const char *lum_news_tell(const lum_news *news, char *out, size_t room)
{
    return write(news, entry_of(news->kind)->sentence,
                 entry_of(news->kind)->fix, out, room);
}
