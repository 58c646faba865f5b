#include "laser_end.h"

#include "interrupt.h"
#include "terminal.h"

#include <stdbool.h>
#include <stdio.h>

#define REST_MS (LUM_SENSOR_OFF_MS - LUM_LASER_SESSION_ALONE_MS)

/* How a person ends it from now on: the signals that came before count. */
static const char *way_out(void)
{
    if (interrupt_second() == NULL) {
        return "";
    }
    return interrupt_signal() != 0 ? "; Ctrl-C gives up"
                                   : "; Ctrl-C twice gives up";
}

static bool is_given_up(void)
{
    const lum_cancel *second = interrupt_second();
    return second != NULL && lum_cancel_is_raised(second);
}

/* The last news, which is that of the end. */
static lum_news take_last(lum_laser_session *session)
{
    lum_news news = {.struct_size = sizeof news};
    while (lum_laser_session_next(session, &news)) {
    }
    return news;
}

lum_laser_off laser_end(lum_laser_session *session, lum_sensor *sensor,
                        const char *program, lum_news *out)
{
    lum_laser_off off =
        lum_laser_session_end(session, sensor, LUM_LASER_SESSION_ALONE_MS,
                              sensor != NULL ? REST_MS : 0, NULL);
    lum_news news = take_last(session);
    if (news.kind == LUM_NEWS_OFF_GOES_ON) {
        char text[LUM_ERROR_BYTES];
        if (!is_given_up() && writable(stderr, 0)) {
            (void)fprintf(stderr, "%s: %s%s\n", program,
                          lum_news_tell(&news, text, sizeof text), way_out());
        }
        off = lum_laser_session_end(session, sensor, REST_MS, 0,
                                    interrupt_second());
        news = take_last(session);
    }
    if (out != NULL) {
        *out = news;
    }
    return off;
}
