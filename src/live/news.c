#include "lum/live/news.h"

#include "lum/host/laser_name.h"
#include "lum/laser.h"
#include "lum/wire.h"
#include "net/endpoint.h"

#include <stdio.h>
#include <string.h>

#define SECOND_NS 1e9

typedef struct entry {
    const char *name;
    lum_news_weight weight;
    const char *sentence; /* words in braces stand for values */
    const char *remedy;
} entry;

#define WHEN_SAFE                                                              \
    "it is not switched on again automatically: when it is safe, run {ctl} "   \
    "laser on"
#define BOOTS_AT "10.42.0.37"
#define LAST_HEARTBEAT                                                         \
    "it MAY BE ON; a sensor that lives switches it off 3 s after the last "    \
    "heartbeat{sent}"

static const entry entries[LUM_NEWS_END] = {
    [LUM_NEWS_LASER_UP] = {"laser-up", LUM_NEWS_INFO,
                           "the laser of {sensor} is on", ""},
    [LUM_NEWS_LASER_FELL] = {"laser-fell", LUM_NEWS_ERROR,
                             "the laser of {sensor} went off ({bits}{cause})",
                             WHEN_SAFE},
    [LUM_NEWS_LASER_REFUSED] = {"laser-refused", LUM_NEWS_ERROR,
                                "the laser of {sensor} stays down "
                                "({bits}{cause})",
                                WHEN_SAFE},
    [LUM_NEWS_LASER_UNSEEN] = {"laser-unseen", LUM_NEWS_ERROR,
                               "{sensor} answered to laser on without a "
                               "status: whether it is on is not known, so it "
                               "is switched off",
                               "tlv.status of the profile says {tlv}"},
    [LUM_NEWS_LASER_UNANSWERED] = {"laser-unanswered", LUM_NEWS_ERROR,
                                   "{sensor} did not answer to laser on (sent "
                                   "{tries} times): it is switched off",
                                   "look with {ctl} status"},
    [LUM_NEWS_LASER_HELD_UP] = {"laser-held-up", LUM_NEWS_ERROR,
                                "this program was held up for {seconds} s "
                                "while it switched the laser of {sensor} on: "
                                "it is switched off",
                                "when it is safe, run {ctl} laser on"},
    [LUM_NEWS_LASER_CAME_UP] = {"laser-came-up", LUM_NEWS_WARNING,
                                "the laser of {sensor} {up}, by another "
                                "program",
                                ""},
    [LUM_NEWS_LASER_LEFT] = {"laser-left", LUM_NEWS_WARNING,
                             "the laser of {sensor} is {left}", WHEN_SAFE},
    [LUM_NEWS_LASER_IS_OFF] = {"laser-is-off", LUM_NEWS_INFO,
                               "the laser is off",
                               "begin with --laser, or run {ctl} laser on"},
    [LUM_NEWS_OFF_UNANSWERED] = {"off-unanswered", LUM_NEWS_ERROR,
                                 "{sensor} does not answer to laser off: until "
                                 "it does, its laser may be on, or come on by "
                                 "itself when a hazard ends",
                                 ""},
    [LUM_NEWS_HAZARD] = {"hazard", LUM_NEWS_WARNING,
                         "{sensor} reports a hazard: {bits}", ""},
    [LUM_NEWS_TEXT] = {"text", LUM_NEWS_WARNING, "{sensor} says: {text}", ""},
    [LUM_NEWS_NO_ANSWER_YET] =
        {"no-answer-yet", LUM_NEWS_WARNING,
         "no data from {sensor} within {seconds} s, nor any answer",
         "is it on, connected and at this address? It boots at " BOOTS_AT
         "; look with {ctl} doctor"},
    [LUM_NEWS_NO_DATA_YET] = {"no-data-yet", LUM_NEWS_WARNING,
                              "no data from {sensor} within {seconds} s, "
                              "though it answers",
                              "is a profile needed, or does a firewall drop "
                              "what is not an answer? look with {ctl} doctor"},
    [LUM_NEWS_UNKNOWN_LAYOUT] = {"unknown-layout", LUM_NEWS_WARNING,
                                 "{sensor} sends packets, and none of them "
                                 "fits the layout",
                                 "is a --profile needed?"},
    [LUM_NEWS_SILENT] = {"silent", LUM_NEWS_WARNING,
                         "no data from {sensor} for {seconds} s; heartbeats go "
                         "on, waiting",
                         "a sensor that was restarted is at " BOOTS_AT
                         " again; {ctl} doctor finds out more"},
    [LUM_NEWS_DATA_STOPPED] = {"data-stopped", LUM_NEWS_WARNING,
                               "no data from {sensor} for {seconds} s, though "
                               "it answers; heartbeats go on, waiting",
                               "another host may own it now; {ctl} doctor "
                               "finds out more"},
    [LUM_NEWS_BACK] = {"back", LUM_NEWS_WARNING,
                       "data from {sensor} again, after {seconds} s without",
                       ""},
    [LUM_NEWS_MOVED] = {"moved", LUM_NEWS_ERROR,
                        "the data comes from {to} now, not from {sensor}: the "
                        "sensor has got that address. It is not taken, and "
                        "ends in 3 s, since the heartbeats go to {sensor}",
                        "end this session, and begin one with udp://{to}"},
    [LUM_NEWS_RESTARTED] = {"restarted", LUM_NEWS_WARNING,
                            "{sensor} was restarted: its clock began anew",
                            "its laser and its settings are as after power-up"},
    [LUM_NEWS_UNHEARD] = {"unheard", LUM_NEWS_WARNING,
                          "{sensor} sends data, but does not answer when asked "
                          "for its status",
                          ""},
    [LUM_NEWS_NO_ANSWER] = {"no-answer", LUM_NEWS_WARNING,
                            "{sensor} does not answer",
                            "{ctl} doctor finds out why"},
    [LUM_NEWS_ANSWERS] = {"answers", LUM_NEWS_INFO, "{sensor} answers again",
                          ""},
    [LUM_NEWS_LATE_ANSWERS] = {"late-answers", LUM_NEWS_WARNING,
                               "{sensor} answers so late that its answers "
                               "cannot be used",
                               "use a longer timeout, or look with {ctl} "
                               "doctor"},
    [LUM_NEWS_NO_STATUS] = {"no-status", LUM_NEWS_WARNING,
                            "{sensor} answers without a status, so nothing "
                            "shows its laser",
                            "tlv.status of the profile says {tlv}"},
    [LUM_NEWS_LINK_DOWN] = {"link-down", LUM_NEWS_WARNING,
                            "sending to {sensor} fails: {text}; it is tried "
                            "again and again",
                            ""},
    [LUM_NEWS_LINK_UP] = {"link-up", LUM_NEWS_WARNING,
                          "sending to {sensor} works again", ""},
    [LUM_NEWS_OFF_GOES_ON] = {"off-goes-on", LUM_NEWS_WARNING,
                              "{sensor}: {state}: laser off is repeated for "
                              "{seconds} s more",
                              ""},
    [LUM_NEWS_ENDED_OFF] = {"ended-off", LUM_NEWS_INFO,
                            "{sensor}: the laser is off", ""},
    [LUM_NEWS_ENDED_UNKNOWN] = {"ended-unknown", LUM_NEWS_ERROR,
                                "{sensor}: laser off was not "
                                "answered: " LAST_HEARTBEAT,
                                "{mend}"},
    [LUM_NEWS_ENDED_UNSEEN] =
        {"ended-unseen", LUM_NEWS_ERROR,
         "{sensor}: laser off was answered without a status TLV, so nothing "
         "shows it off: " LAST_HEARTBEAT,
         "tlv.status of the profile says {tlv}"},
    [LUM_NEWS_ENDED_IN_EFFECT] = {"ended-in-effect", LUM_NEWS_ERROR,
                                  "{sensor}: LASER ON IS STILL IN EFFECT after "
                                  "laser off: the laser comes up by itself "
                                  "when what keeps it down ends (status: "
                                  "{bits})",
                                  "{mend}, or cut its power"},
    [LUM_NEWS_ENDED_ON] = {"ended-on", LUM_NEWS_ERROR,
                           "{sensor}: THE LASER IS STILL ON after laser off "
                           "(status: {bits})",
                           "{mend}, or cut its power"},
};

/* --- The table --- */

static bool is_known(lum_news_kind kind)
{
    return kind >= LUM_NEWS_LASER_UP && kind < LUM_NEWS_END;
}

const char *lum_news_name(lum_news_kind kind)
{
    return is_known(kind) ? entries[kind].name : NULL;
}

lum_news_weight lum_news_weigh(lum_news_kind kind)
{
    return is_known(kind) ? entries[kind].weight : LUM_NEWS_INFO;
}

bool lum_news_is_dark(lum_news_kind kind)
{
    return (kind >= LUM_NEWS_LASER_FELL && kind <= LUM_NEWS_LASER_HELD_UP) ||
           kind == LUM_NEWS_LASER_IS_OFF;
}

/* --- Values in a sentence --- */

typedef struct value {
    char text[LUM_NEWS_TEXT_BYTES + 128u];
} value;

/* The port stands where it is not that of all sensors. */
static lum_endpoint_text show(lum_endpoint endpoint)
{
    return endpoint.port == LUM_PORT || endpoint.port == 0
               ? lum_endpoint_show_address(endpoint.address)
               : lum_endpoint_show(endpoint);
}

static uint16_t shown_bits(const lum_news *news)
{
    const bool has_ended = news->kind >= LUM_NEWS_ENDED_OFF;
    return has_ended ? news->status
                     : (uint16_t)(news->status & LUM_LASER_ALL_DOWN);
}

static void name_bits(uint16_t bits, value *out)
{
    size_t len = 0;
    (void)snprintf(out->text, sizeof out->text, "none");
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        if (((unsigned)bits >> bit & 1u) != 0 && len < sizeof out->text) {
            const int n =
                snprintf(out->text + len, sizeof out->text - len, "%s%s",
                         len > 0 ? " " : "", lum_laser_bit_name(bit));
            len += n > 0 ? (size_t)n : 0;
        }
    }
}

/* What put the laser down where that is no hazard but a command to be off,
 * which a sensor also shows after a time without heartbeats. */
static const char *cause_of(const lum_news *news)
{
    if ((news->status & LUM_LASER_TLV_CMD_OFF) == 0 ||
        lum_laser_has_hazard(news->status)) {
        return "";
    }
    return news->was_away
               ? ": the sensor was restarted, or got no heartbeat for 3 s"
               : ": switched off by another program's command, or when no "
                 "heartbeat came for 3 s";
}

/* Before the end of laser off. */
static const char *state_of(const lum_news *news)
{
    if (news->status == 0 && news->tries == 0) {
        return "no answer yet";
    }
    return lum_laser_is_down(news->status) ? "laser on is still in effect"
                                           : "the laser is still on";
}

static void show_ctl(const lum_news *news, value *out)
{
    const bool has_name = news->interface_name != NULL;
    const lum_endpoint at =
        news->to.address != 0 && news->kind >= LUM_NEWS_ENDED_OFF
            ? news->to
            : news->sensor;
    (void)snprintf(out->text, sizeof out->text, "lumctl --host %s%s%.64s",
                   show(at).text, has_name ? " --interface " : "",
                   has_name ? news->interface_name : "");
}

static void show_sensor(const lum_news *news, value *out)
{
    (void)snprintf(out->text, sizeof out->text, "%s", show(news->sensor).text);
}

static void show_new(const lum_news *news, value *out)
{
    (void)snprintf(out->text, sizeof out->text, "%s", show(news->to).text);
}

static void show_bits(const lum_news *news, value *out)
{
    name_bits(shown_bits(news), out);
}

static void show_cause(const lum_news *news, value *out)
{
    (void)snprintf(out->text, sizeof out->text, "%s", cause_of(news));
}

static void show_state(const lum_news *news, value *out)
{
    (void)snprintf(out->text, sizeof out->text, "%s", state_of(news));
}

/* Without the command's bit a status shows no more than that nothing keeps it
 * down. */
static void show_up(const lum_news *news, value *out)
{
    const bool is_on = (news->status & LUM_LASER_TLV_CMD_ON) != 0;
    (void)snprintf(out->text, sizeof out->text, is_on ? "is on" : "may be on");
}

static void show_left(const lum_news *news, value *out)
{
    (void)snprintf(out->text, sizeof out->text,
                   news->was_away ? "being switched off" : "off");
}

static void show_sent(const lum_news *news, value *out)
{
    (void)snprintf(out->text, sizeof out->text,
                   news->is_owner ? ", which has been sent" : "");
}

/* Without the session's heartbeats somebody else's keep it on. */
static void show_mend(const lum_news *news, value *out)
{
    value ctl;
    show_ctl(news, &ctl);
    if (news->is_owner) {
        (void)snprintf(out->text, sizeof out->text,
                       "make sure by %.200s laser off", ctl.text);
    } else {
        (void)snprintf(out->text, sizeof out->text,
                       "end the programs that send heartbeats");
    }
}

static void show_seconds(const lum_news *news, value *out)
{
    (void)snprintf(out->text, sizeof out->text, "%.3g",
                   (double)news->ns / SECOND_NS);
}

static void show_tries(const lum_news *news, value *out)
{
    (void)snprintf(out->text, sizeof out->text, "%u", news->tries);
}

static void show_tlv(const lum_news *news, value *out)
{
    (void)snprintf(out->text, sizeof out->text, "%u",
                   (unsigned)news->tlv_status);
}

static void show_text(const lum_news *news, value *out)
{
    (void)snprintf(out->text, sizeof out->text, "%s", news->text);
}

/* The words in braces. */
static const struct {
    const char *word;
    void (*show)(const lum_news *news, value *out);
} values[] = {
    {"sensor", show_sensor}, {"to", show_new},          {"ctl", show_ctl},
    {"bits", show_bits},     {"cause", show_cause},     {"state", show_state},
    {"up", show_up},         {"left", show_left},       {"sent", show_sent},
    {"mend", show_mend},     {"seconds", show_seconds}, {"tries", show_tries},
    {"tlv", show_tlv},       {"text", show_text}};

static void fill(const lum_news *news, const char *word, size_t len, value *out)
{
    out->text[0] = '\0';
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
        if (strlen(values[i].word) == len &&
            strncmp(values[i].word, word, len) == 0) {
            values[i].show(news, out);
        }
    }
}

/* --- Sentences --- */

static size_t add(char *out, size_t room, size_t at, const char *text,
                  size_t len)
{
    const size_t left = room - 1u - at;
    const size_t count = len < left ? len : left;
    memcpy(out + at, text, count);
    out[at + count] = '\0';
    return at + count;
}

/* A sentence of the table with its values. */
static size_t write(const lum_news *news, const char *form, char *out,
                    size_t room, size_t at)
{
    while (*form != '\0') {
        const size_t plain = strcspn(form, "{");
        at = add(out, room, at, form, plain);
        form += plain;
        if (*form == '{') {
            value word;
            const size_t len = strcspn(form + 1, "}");
            fill(news, form + 1, len, &word);
            at = add(out, room, at, word.text, strlen(word.text));
            form += len + 2u;
        }
    }
    return at;
}

const char *lum_news_sentence(const lum_news *news, char *out, size_t room)
{
    out[0] = '\0';
    if (is_known(news->kind)) {
        (void)write(news, entries[news->kind].sentence, out, room, 0);
    }
    return out;
}

const char *lum_news_remedy(const lum_news *news, char *out, size_t room)
{
    out[0] = '\0';
    if (is_known(news->kind)) {
        (void)write(news, entries[news->kind].remedy, out, room, 0);
    }
    return out;
}

const char *lum_news_tell(const lum_news *news, char *out, size_t room)
{
    out[0] = '\0';
    if (is_known(news->kind)) {
        const entry *e = &entries[news->kind];
        size_t at = write(news, e->sentence, out, room, 0);
        at = add(out, room, at, "; ", e->remedy[0] != '\0' ? 2u : 0);
        (void)write(news, e->remedy, out, room, at);
    }
    return out;
}
