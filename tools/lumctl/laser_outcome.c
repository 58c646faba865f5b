#include "laser_outcome.h"

#include "../common/interrupt.h"
#include "../common/laser_end.h"
#include "ctl_session.h"
#include "status_report.h"

#include "lum/laser.h"

/* What keeps the laser down, and what to do. */
static enum exit_status complain_down(const struct ctl *ctl,
                                      const struct ctl_answer *answer)
{
    const uint16_t status = answer->status;
    const bool is_owned = session_is_owned(ctl, status);
    if (report_has_hazard(status, is_owned)) {
        (void)ctl_complain(EXIT_HAZARD,
                           "the laser stays down during a hazard:");
        report_status(stderr, status, is_owned, report_may_colour(stderr));
        return EXIT_HAZARD;
    }
    if (report_is_idle(status, is_owned)) {
        return ctl_complain(
            EXIT_FAILED,
            "the laser stays down: nobody sends heartbeats. Start a lumdump "
            "with --laser, or %s heartbeat, then run laser on again",
            session_ctl(ctl, session_host(ctl)).text);
    }
    return ctl_complain(EXIT_FAILED, "the laser did not come up: %s",
                        report_line(status, is_owned).text);
}

bool laser_is_as(const struct ctl *ctl, lum_laser_want want)
{
    lum_laser_session_view view = {.struct_size = sizeof view};
    (void)lum_laser_session_look(ctl->laser, &view);
    return want == LUM_WANT_LOOK ||
           (want == LUM_WANT_ON ? view.laser == LUM_LASER_UP
                                : view.has_status && !view.is_off_due);
}

lum_laser_off laser_switch_down(struct ctl *ctl, lum_news *end)
{
    interrupt_hold();
    const lum_laser_off result =
        laser_end(ctl->laser, ctl->sensor, "lumctl", end);
    interrupt_release();
    if (result == LUM_LASER_OFF_SEEN || result == LUM_LASER_OFF_REFUSED) {
        ctl->has_status = true;
        ctl->status = end->status;
    }
    return result;
}

/* A socket that broke is no reason to leave a laser on. */
static void open_again(struct ctl *ctl)
{
    lum_sensor *anew = NULL;
    lum_error error = {""};
    lum_sensor_event event;
    lum_sensor_receive(ctl->sensor, 0, &event);
    if (event.kind == LUM_SENSOR_FAILED) {
        (void)!session_try(ctl, session_host(ctl), false, &anew, &error);
        lum_sensor_close(ctl->sensor);
        ctl->sensor = anew;
    }
}

enum exit_status laser_leave(struct ctl *ctl)
{
    lum_news end = {.struct_size = sizeof end};
    char text[LUM_ERROR_BYTES];
    open_again(ctl);
    const lum_laser_off off = laser_switch_down(ctl, &end);
    if (off == LUM_LASER_OFF_SEEN) {
        ctl_note(ctl, "%s", lum_news_tell(&end, text, sizeof text));
        return EXIT_DONE;
    }
    return ctl_complain(EXIT_FAILED, "%s",
                        lum_news_tell(&end, text, sizeof text));
}

bool laser_is_undone(const lum_news *end)
{
    return end->kind == LUM_NEWS_ENDED_OFF &&
           (end->status & LUM_LASER_TLV_CMD_ON) == 0;
}

void laser_tell_undo(lum_laser_want want, const lum_news *end)
{
    char text[LUM_ERROR_BYTES];
    if (!laser_is_undone(end)) {
        (void)ctl_complain(EXIT_FAILED, "%s%s",
                           want == LUM_WANT_ON ? "NOT cancelled: " : "",
                           lum_news_tell(end, text, sizeof text));
    } else {
        (void)ctl_complain(EXIT_FAILED,
                           want == LUM_WANT_ON
                               ? "cancelled: it will not come up by itself"
                               : "the laser is off; whether the rest of the "
                                 "text was done is not known");
    }
}

enum exit_status laser_complain(const struct ctl *ctl, lum_laser_want want,
                                const struct ctl_answer *answer,
                                const lum_news *end)
{
    enum exit_status status = EXIT_FAILED;
    if (!answer->has_status) {
        (void)ctl_complain(
            EXIT_FAILED,
            "no status confirms it %s: the answer has no TLV %u, the status's "
            "number in the profile (tlv.status)",
            want == LUM_WANT_ON ? "on" : "off",
            (unsigned)ctl->layout.profile.tlv[LUM_TLV_STATUS]);
    } else if (want == LUM_WANT_ON) {
        status = complain_down(ctl, answer);
    }
    laser_tell_undo(want, end);
    return status;
}
