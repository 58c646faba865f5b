/* The command wait: until the sensor is as it should be. */
#include "ctl.h"

#include "ctl_session.h"
#include "status_report.h"
#include "watch.h"

#include "lum/laser.h"

#include <string.h>

#define PERIOD_NS INT64_C(500000000)

struct goal {
    const char *word;
    const char *what; /* is said where it is not so in time */
};

enum {
    ANSWERS,
    UP,
    DOWN,
    CLEAR,
    GOALS
};

static const struct goal goals[GOALS] = {
    [ANSWERS] = {"answers", "it does not answer"},
    [UP] = {"up", "its laser is not up"},
    [DOWN] = {"down", "its laser is not down"},
    [CLEAR] = {"clear", "a hazard is not over"},
};

/* What is known of the sensor now, and not from before its last silence. */
struct waiting {
    struct ctl *ctl;
    unsigned goal;
    bool answers;
    bool has_status;
    uint16_t status;
};

static bool has_hazard(const struct waiting *w)
{
    return w->has_status &&
           report_has_hazard(w->status, session_is_owned(w->ctl, w->status));
}

static bool is_met(const struct waiting *w)
{
    switch (w->goal) {
    case UP:
        return w->has_status && lum_laser_is_on(w->status);
    case DOWN:
        return w->has_status && lum_laser_is_down(w->status);
    case CLEAR:
        return w->has_status && !has_hazard(w);
    default:
        return w->answers;
    }
}

static lum_result ask(struct ctl *ctl, void *context)
{
    (void)context;
    return session_request(ctl, NULL, 0);
}

static bool take(void *context, const lum_sensor_event *event)
{
    struct waiting *w = context;
    if (event->kind == LUM_SENSOR_NO_ANSWER) {
        w->answers = false;
        w->has_status = false;
    }
    if (event->kind == LUM_SENSOR_ANSWER || event->kind == LUM_SENSOR_ALERT) {
        w->answers = true;
    }
    if (event->has_status) {
        w->has_status = true;
        w->status = event->status;
    }
    return !is_met(w);
}

static enum exit_status complain(const struct waiting *w)
{
    const struct ctl *ctl = w->ctl;
    const struct session_name name = session_name(session_host(ctl));
    if (!w->answers) {
        return session_complain_silence(ctl, 0);
    }
    if (!w->has_status) {
        return ctl_complain(EXIT_NO_ANSWER,
                            "%s: its answers contain no status; set tlv.status "
                            "in a profile to the sensor's number",
                            name.text);
    }
    const bool is_owned = session_is_owned(ctl, w->status);
    return ctl_complain(
        has_hazard(w) ? EXIT_HAZARD : EXIT_NO_ANSWER,
        "%s: %s after %.6g s: %s%s", name.text, goals[w->goal].what,
        ctl->options.repeat.duration_s, report_line(w->status, is_owned).text,
        w->goal == UP && report_is_idle(w->status, is_owned)
            ? "; nobody sends heartbeats, as lumctl heartbeat --laser does"
            : "");
}

enum exit_status command_wait(struct ctl *ctl, int count, char **words)
{
    struct waiting w = {.ctl = ctl, .goal = ANSWERS};
    const struct watch watch = {
        .period_ns = PERIOD_NS, .ask = ask, .take = take, .context = &w};
    while (count > 1 && w.goal < GOALS &&
           strcmp(words[1], goals[w.goal].word) != 0) {
        w.goal++;
    }
    if (count > 2 || w.goal == GOALS) {
        return ctl_complain(EXIT_BAD,
                            "wait: '%s': use answers, up, down or clear",
                            words[count > 2 ? 2 : 1]);
    }
    enum exit_status status = ctl_open(ctl, false);
    if (status == EXIT_DONE) {
        status = watch_run(ctl, &watch);
    }
    if (status != EXIT_DONE || is_met(&w)) {
        return status;
    }
    return lum_cancel_is_raised(ctl->cancel)
               ? ctl_complain(EXIT_FAILED, "interrupted: %s",
                              goals[w.goal].what)
               : complain(&w);
}
