#define _POSIX_C_SOURCE 200809L
#include "timeline.h"

#include "../common/number.h"
#include "base/text.h"
#include "lum/laser.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>

#define SECONDS_MAX 1e6
#define TIME_BYTES  32

static const struct {
    const char *name;
    enum fault_kind kind;
    uint16_t bits;
} known[] = {
    {"galvo-bx", FAULT_HAZARD, LUM_LASER_GALVO_AMP_BX_BAD},
    {"galvo-by", FAULT_HAZARD, LUM_LASER_GALVO_AMP_BY_BAD},
    {"galvo-gx", FAULT_HAZARD, LUM_LASER_GALVO_AMP_GX_BAD},
    {"galvo-gy", FAULT_HAZARD, LUM_LASER_GALVO_AMP_GY_BAD},
    {"board", FAULT_HAZARD, LUM_LASER_BOARD_OVER_105},
    {"fan", FAULT_HAZARD, LUM_LASER_FAN_PWM_BAD},
    {"interlock", FAULT_HAZARD, LUM_LASER_HW_SAFETY_BAD},
    {"switch", FAULT_HAZARD, LUM_LASER_SYS_ON_SW_OFF},
    {"reboot", FAULT_REBOOT, 0},
    {"silence", FAULT_SILENCE, 0},
};

/* --- Signals --- */

#if defined(_WIN32)
#define HAS_CUES false

void cue_catch(enum cue cue)
{
    (void)cue;
}

bool cue_take(enum cue cue)
{
    (void)cue;
    return false;
}
#else
#define HAS_CUES true

static volatile sig_atomic_t came[CUE_USR2 + 1];

static void note(int signal_number)
{
    came[signal_number == SIGUSR1 ? CUE_USR1 : CUE_USR2] = 1;
}

void cue_catch(enum cue cue)
{
    struct sigaction action = {.sa_handler = note};
    (void)sigemptyset(&action.sa_mask);
    (void)sigaction(cue == CUE_USR1 ? SIGUSR1 : SIGUSR2, &action, NULL);
}

bool cue_take(enum cue cue)
{
    if (came[cue] == 0) {
        return false;
    }
    came[cue] = 0;
    return true;
}
#endif

/* --- The text of a fault --- */

#define HOW_BYTES 512

/* What an event may be, with the names of all. */
static const char *tell_how(void)
{
    static char how[HOW_BYTES];
    (void)snprintf(how, sizeof how,
                   "NAME@SECONDS or NAME@SECONDS-SECONDS, such as fan@10 or "
                   "silence@5-8, or at signals NAME@USR1 or NAME@USR1-USR2; "
                   "NAME is one of");
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        lum_text_add(how, sizeof how, "%s %s", i == 0 ? "" : ",",
                     known[i].name);
    }
    return how;
}

/* Before those that happen later; after those of the same time. */
static void insert(struct timeline *timeline, struct timeline_event event)
{
    size_t i = timeline->count++;
    while (i > 0 && timeline->events[i - 1].at_ns > event.at_ns) {
        timeline->events[i] = timeline->events[i - 1];
        i--;
    }
    timeline->events[i] = event;
}

static enum cue find_cue(const char *text, size_t len)
{
    static const char *const names[] = {
        [CUE_USR1] = "USR1", [CUE_USR2] = "USR2"};
    for (enum cue c = CUE_USR1; c <= CUE_USR2; c++) {
        if (strlen(names[c]) == len && strncmp(names[c], text, len) == 0) {
            return c;
        }
    }
    return CUE_NONE;
}

/* Seconds, with or without their unit. */
static bool parse_seconds(const char *text, size_t len, int64_t *out_ns)
{
    char digits[TIME_BYTES];
    double seconds = 0.0;
    if (len > 0 && text[len - 1] == 's') {
        len--;
    }
    if (len >= sizeof digits) {
        return false;
    }
    memcpy(digits, text, len);
    digits[len] = '\0';
    if (!number_parse_real(digits, 0.0, SECONDS_MAX, &seconds)) {
        return false;
    }
    *out_ns = (int64_t)(seconds * 1e9);
    return true;
}

static bool parse_time(const char *text, size_t len, struct timeline_event *out)
{
    out->cue = find_cue(text, len);
    if (out->cue != CUE_NONE) {
        out->at_ns = INT64_MAX;
        return HAS_CUES;
    }
    return parse_seconds(text, len, &out->at_ns);
}

static bool find(const char *name, size_t len, struct timeline_event *out)
{
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        if (strlen(known[i].name) == len &&
            strncmp(known[i].name, name, len) == 0) {
            out->name = known[i].name;
            out->kind = known[i].kind;
            out->bits = known[i].bits;
            return true;
        }
    }
    return false;
}

/* The second time, if there is one. */
static bool parse_end(const char *text, struct timeline_event *end,
                      const struct timeline_event *begin)
{
    end->ends = *text == '-';
    if (!end->ends) {
        return true;
    }
    if (!parse_time(text + 1, strlen(text + 1), end)) {
        return false;
    }
    return begin->cue == CUE_NONE
               ? end->cue == CUE_NONE && end->at_ns > begin->at_ns
               : end->cue != CUE_NONE && end->cue != begin->cue;
}

bool timeline_add(struct timeline *timeline, const char *text, const char **why)
{
    struct timeline_event begin = {0};
    const size_t name_len = strcspn(text, "@");
    const char *times = text + name_len + (text[name_len] == '@' ? 1 : 0);
    const size_t first = strcspn(times, "-");
    *why = tell_how();
    if (!find(text, name_len, &begin) || !parse_time(times, first, &begin)) {
        return false;
    }
    struct timeline_event end = begin;
    if (!parse_end(times + first, &end, &begin) ||
        (end.ends && begin.kind == FAULT_REBOOT)) {
        *why = "two times, the second one later, or two signals; a reboot has "
               "only one";
        return false;
    }
    if (timeline->count + 2 > TIMELINE_MAX) {
        *why = "one of at most 32";
        return false;
    }
    insert(timeline, begin);
    if (end.ends) {
        insert(timeline, end);
    }
    return true;
}

/* --- What happens --- */

int64_t timeline_next_ns(const struct timeline *timeline)
{
    return timeline->next < timeline->count
               ? timeline->events[timeline->next].at_ns
               : INT64_MAX;
}

static bool waits_for(const struct timeline_event *event, enum cue cue)
{
    return event->cue == cue && event->at_ns == INT64_MAX;
}

bool timeline_awaits(const struct timeline *timeline, enum cue cue)
{
    for (size_t i = timeline->next; i < timeline->count; i++) {
        if (waits_for(&timeline->events[i], cue)) {
            return true;
        }
    }
    return false;
}

void timeline_cue(struct timeline *timeline, enum cue cue, int64_t now_ns)
{
    const size_t count = timeline->count;
    timeline->count = timeline->next;
    for (size_t i = timeline->next; i < count; i++) {
        struct timeline_event event = timeline->events[i];
        if (waits_for(&event, cue)) {
            event.at_ns = now_ns;
        }
        insert(timeline, event);
    }
}

const struct timeline_event *timeline_take(struct timeline *timeline,
                                           int64_t now_ns)
{
    return timeline_next_ns(timeline) <= now_ns
               ? &timeline->events[timeline->next++]
               : NULL;
}
