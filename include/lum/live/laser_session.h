/** @file
 * The laser session: the one owner of a live sensor and its laser. It decides
 * what is sent when the laser is to go on, goes down, is refused or gets no
 * answer, and what is reported of a sensor that becomes silent, moves or
 * restarts (docs/safety.md; docs/protocol.md, sections 3 to 5).
 *
 * A laser session is used together with the session with a sensor
 * (lum/net/sensor.h). It has no thread, no callbacks and prints nothing: the
 * program hands it each event, lets it serve the sensor several times a second,
 * and takes its news.
 *
 * @code
 * lum_news news = {.struct_size = sizeof news};
 * lum_sensor_receive(sensor, deadline_ns, &event);
 * lum_laser_session_take(laser, &event, lum_time_monotonic_ns());
 * lum_laser_session_serve(laser, sensor, lum_time_monotonic_ns());
 * while (lum_laser_session_next(laser, &news)) {
 *     puts(lum_news_tell(&news, text, sizeof text));
 * }
 * @endcode
 *
 * examples/own_laser.c is a whole program. After LUM_SENSOR_FAILED another
 * session can be opened and handed to lum_laser_session_end(), or NULL.
 *
 * No other code of this project decides to send `u` or `d`. All times are those
 * of lum_time_monotonic_ns(). One thread at a time may use a laser session. */
#ifndef LUM_LIVE_LASER_SESSION_H
#define LUM_LIVE_LASER_SESSION_H

#include "lum/base/error.h"
#include "lum/live/news.h"
#include "lum/net/sensor.h"
#include "lum/profile.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** What is wanted of the laser. */
typedef enum lum_laser_want {
    LUM_WANT_LOOK,  /**< it stays as it is; only its status is read */
    LUM_WANT_GUARD, /**< it is not switched on; if another program does that and
                         it goes down, it is kept down */
    LUM_WANT_ON,    /**< switched on once; once it has gone down, it is kept
                         down */
    LUM_WANT_OFF    /**< switched off; if it comes up and goes down later, it is
                         kept down */
} lum_laser_want;

/** The state of the laser. */
typedef enum lum_laser_state {
    LUM_LASER_UNTOUCHED, /**< not requested here */
    LUM_LASER_ASKED,     /**< it is being switched on */
    LUM_LASER_UP,        /**< a status showed it up */
    LUM_LASER_LEFT       /**< off, or being switched off: only a person switches
                              it on again */
} lum_laser_state;

/** How long "on" may be without an answer before the laser is switched off. */
#define LUM_LASER_SESSION_GIVE_UP_MS 5000u

/** How often "on" is sent if no hazard refuses it: a sensor that has just got
 * its first heartbeat may still report that it misses one. */
#define LUM_LASER_SESSION_ATTEMPTS 20u

/** After this time without heartbeats the sensor has switched its laser off by
 * itself: do not end lum_laser_session_end() earlier. */
#define LUM_LASER_SESSION_ALONE_MS LUM_HEARTBEAT_TIMEOUT_MS

/** Most news that wait to be taken; the oldest are lost first. */
#define LUM_LASER_SESSION_NEWS 64u

/** Most texts of the sensor that a session reports. */
#define LUM_LASER_SESSION_TEXTS 20u

/** Options of a laser session; lum_laser_session_options_default() fills them
 * in. All but struct_size, sensor and layout may be 0. */
typedef struct lum_laser_session_options {
    size_t struct_size;         /**< sizeof(lum_laser_session_options) */
    lum_endpoint sensor;        /**< the session's */
    const char *interface_name; /**< the session's; named in fixes; copied */
    lum_layout layout;          /**< the session's */
    bool owns;                  /**< the session sends heartbeats */
    lum_laser_want laser;       /**< from the beginning */
    uint32_t give_up_ms; /**< LUM_LASER_SESSION_GIVE_UP_MS; 0: at the first
                              request without an answer */
    uint32_t attempts;   /**< LUM_LASER_SESSION_ATTEMPTS; 0 is 1 */
} lum_laser_session_options;

/** What a laser session knows now. */
typedef struct lum_laser_session_view {
    size_t struct_size;    /**< sizeof(lum_laser_session_view), set by the
                                caller */
    lum_laser_state laser; /**< its state */
    bool is_off_due;       /**< `d` must be sent, or has no answer yet */
    bool has_status;       /**< a status has come */
    uint16_t status;       /**< the last one that was answered */
    bool has_answered;     /**< an answer has come, even without a status */
    bool is_unheard;       /**< the last request had no answer */
    bool has_data;         /**< data has come */
    bool has_unknown;      /**< packets came that may be data of another layout,
                                before any data */
    bool is_silent;        /**< data has come, and none for
                                LUM_SENSOR_SILENCE_MS */
    int64_t first_data_ns; /**< when data came first */
    int64_t data_ns;       /**< and last */
} lum_laser_session_view;

/** A laser session. */
typedef struct lum_laser_session lum_laser_session;

/** Usual options for a session with these options: only the laser's status is
 * read. Cannot fail. */
void lum_laser_session_options_default(lum_laser_session_options *out,
                                       const lum_sensor_options *session);

/** Begin. Nothing is sent yet.
 * @param options copied, the interface's name too.
 * @param out     gets it on success; to be ended with lum_laser_session_free().
 * @param error   gets the message on failure: struct_size is not set, or there
 *                is no memory.
 * @return 0, or -1. */
LUM_MUST_CHECK int lum_laser_session_new(
    const lum_laser_session_options *options, int64_t now_ns,
    lum_laser_session **out, lum_error *error);

/** End it. The laser is not touched: lum_laser_session_end() first. NULL is
 * allowed. */
void lum_laser_session_free(lum_laser_session *session);

/** Set what is wanted of the laser from now on. ON comes from a person, so it
 * is also obeyed after the laser went down. */
void lum_laser_session_want(lum_laser_session *session, lum_laser_want want,
                            int64_t now_ns);

/** What a text of commands, such as "50p u", wants of the laser: the last `u`
 * or `d` in it decides.
 * @return LUM_WANT_ON, LUM_WANT_OFF, or LUM_WANT_LOOK without any. */
lum_laser_want lum_laser_session_want_of(const char *text);

/** If the session sends no heartbeats, say whether another program does
 * (lum_sensor_is_owned()). If none does, a laser that is refused for lack of
 * heartbeats is given up at once, and their lack is no hazard. */
void lum_laser_session_note_owner(lum_laser_session *session, bool is_owned);

/** Send a text of commands, such as "50p u", for its user: the last `u` or `d`
 * in it is what is wanted of the laser. The session's event brings the answer,
 * or says that there is none. If laser off becomes due meanwhile
 * (lum_laser_session_view), the next lum_laser_session_serve() gives the
 * request up, and the next answer is that of laser off.
 * @return LUM_OK; as lum_sensor_command() otherwise: then nothing was sent, and
 *         what is wanted is unchanged. */
LUM_MUST_CHECK lum_result lum_laser_session_command(lum_laser_session *session,
                                                    lum_sensor *sensor,
                                                    const char *text,
                                                    int64_t now_ns);

/** Report that the program itself has begun a request, such as for the time or
 * with other TLVs: its answer does not count as one to the laser session. Laser
 * off gives it up as lum_laser_session_command() says. */
void lum_laser_session_lend(lum_laser_session *session, int64_t now_ns);

/** Hand over an event of the session, of any kind. Constant time, except for
 * the datagrams before the first data. */
void lum_laser_session_take(lum_laser_session *session,
                            const lum_sensor_event *event, int64_t now_ns);

/** Send what is due now: `u`, `d`, or a poll of the status once a second. Laser
 * off gives up a request that is under way, which would be sent again. Call
 * this several times a second; it does not wait. If no call comes for
 * LUM_SENSOR_STALE_MS while the laser is being switched on, the program was
 * held up, and the laser is switched off (LASER_HELD_UP). */
void lum_laser_session_serve(lum_laser_session *session, lum_sensor *sensor,
                             int64_t now_ns);

/** The next piece of news.
 * @param out struct_size is set by the caller.
 * @return false: there is none. */
bool lum_laser_session_next(lum_laser_session *session, lum_news *out);

/** What is true now, the most important first: about data, about the laser, and
 * hazards. For a display; all but LASER_IS_OFF and LASER_LEFT were news once.
 * Times are whole seconds.
 * @param out  room of them; the caller sets struct_size of the first, which is
 *             used for all.
 * @param room 3 holds all.
 * @return how many. */
size_t lum_laser_session_standing(const lum_laser_session *session,
                                  int64_t now_ns, lum_news *out, size_t room);

/** Why lines have no ranges, if the last status shows it: HAZARD, or news for
 * which lum_news_is_dark() is true.
 * @param out struct_size is set by the caller.
 * @return false: the status shows the laser up, or none came. */
bool lum_laser_session_darkness(const lum_laser_session *session,
                                lum_news *out);

/** What is known now.
 * @return LUM_OK; LUM_E_VALUE if struct_size of out is not set. */
lum_result lum_laser_session_look(const lum_laser_session *session,
                                  lum_laser_session_view *out);

/** The end: switch the laser off and verify that it is down, as
 * lum_sensor_laser_off(), and report one of the ENDED news, or OFF_GOES_ON if
 * goes_on_ms says that the caller will try again. The session may be a new one
 * if the socket of the old one broke. Blocks for ms and up to 3 s more, and
 * sends no heartbeats meanwhile. The last status is in the news.
 * @param sensor     NULL: there is none, so the laser's state is unknown.
 * @param ms         of this try.
 * @param goes_on_ms of the next; 0: this is the last.
 * @param cancel     ends it between two sends; may be NULL.
 * @return as lum_sensor_laser_off(). */
lum_laser_off lum_laser_session_end(lum_laser_session *session,
                                    lum_sensor *sensor, uint32_t ms,
                                    uint32_t goes_on_ms,
                                    const lum_cancel *cancel);

#ifdef __cplusplus
}
#endif

#endif
