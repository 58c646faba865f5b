/** @file
 * News about a live sensor: one table, with a number, a sentence, a fix and
 * a weight for each. lum_laser_session of lum/live/laser_session.h produces
 * them. */
#ifndef LUM_LIVE_NEWS_H
#define LUM_LIVE_NEWS_H

#include "lum/live/laser_off.h"
#include "lum/net/socket.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** What happened, or is true. The numbers never change; new ones follow the
 * last. */
typedef enum lum_news_kind {
    LUM_NEWS_LASER_UP = 1,     /**< requested, and a status shows it up */
    LUM_NEWS_LASER_FELL,       /**< it was up, and is down */
    LUM_NEWS_LASER_REFUSED,    /**< requested, and it stays down */
    LUM_NEWS_LASER_UNSEEN,     /**< the answer to "on" has no status */
    LUM_NEWS_LASER_UNANSWERED, /**< "on" has no answer */
    LUM_NEWS_LASER_HELD_UP,    /**< the program was held up while it asked */
    LUM_NEWS_LASER_CAME_UP,    /**< after it was left off, and not by us */
    LUM_NEWS_LASER_LEFT,       /**< it is left off, as was asked */
    LUM_NEWS_LASER_IS_OFF,     /**< it is off, and was not requested here */
    LUM_NEWS_OFF_UNANSWERED,   /**< "off" has no answer yet */
    LUM_NEWS_HAZARD,           /**< hazard bits that were not set before */
    LUM_NEWS_TEXT,             /**< the sensor's own words */
    LUM_NEWS_NO_ANSWER_YET,    /**< nothing has come since the beginning */
    LUM_NEWS_NO_DATA_YET,      /**< answers have come, but no data */
    LUM_NEWS_UNKNOWN_LAYOUT,   /**< packets that do not fit the profile */
    LUM_NEWS_SILENT,           /**< data has stopped, and answers too */
    LUM_NEWS_DATA_STOPPED,     /**< data has stopped, but it answers: another
                                    host may own it */
    LUM_NEWS_BACK,             /**< data comes again */
    LUM_NEWS_MOVED,            /**< data comes from another address */
    LUM_NEWS_RESTARTED,        /**< its clock was reset */
    LUM_NEWS_UNHEARD,          /**< data comes, but no answers */
    LUM_NEWS_NO_ANSWER,        /**< no answers, and no data either */
    LUM_NEWS_ANSWERS,          /**< answers come again */
    LUM_NEWS_LATE_ANSWERS,     /**< answers come after they were given up */
    LUM_NEWS_NO_STATUS,        /**< answers have no status */
    LUM_NEWS_LINK_DOWN,        /**< sending fails */
    LUM_NEWS_LINK_UP,          /**< sending works again */
    LUM_NEWS_OFF_GOES_ON,      /**< laser off takes long, and is repeated */
    LUM_NEWS_ENDED_OFF,        /**< the end: the laser was seen down */
    LUM_NEWS_ENDED_UNKNOWN,    /**< the end: laser off had no answer */
    LUM_NEWS_ENDED_UNSEEN,     /**< the end: answers without a status */
    LUM_NEWS_ENDED_IN_EFFECT,  /**< the end: it is down, but "on" is in
                                    effect */
    LUM_NEWS_ENDED_ON,         /**< the end: the laser is on */
    LUM_NEWS_END               /**< one more than the last */
} lum_news_kind;

/** How important it is. */
typedef enum lum_news_weight {
    LUM_NEWS_INFO,    /**< as it should be */
    LUM_NEWS_WARNING, /**< a person should know */
    LUM_NEWS_ERROR    /**< the laser is not as it was asked to be, or is not
                           known to be off */
} lum_news_weight;

#define LUM_NEWS_TEXT_BYTES 256u /**< of a text of the sensor, with its NUL */

/** One piece of news. Members that its kind does not use have no meaning. */
typedef struct lum_news {
    size_t struct_size;         /**< sizeof(lum_news), set by the caller */
    lum_news_kind kind;         /**< what it is */
    lum_endpoint sensor;        /**< whose */
    const char *interface_name; /**< the interface to reach it; NULL: by the
                                     routes; lives as long as the laser
                                     session */
    lum_endpoint to;            /**< MOVED: its new address */
    uint16_t status;            /**< the laser's, or the hazards' bits */
    uint16_t tlv_status;        /**< the profile's number of a status TLV */
    unsigned tries;             /**< LASER_UNANSWERED: datagrams sent;
                                     OFF_GOES_ON: 0 without an answer */
    bool was_away;              /**< LASER_FELL: data had stopped before;
                                     LASER_LEFT: laser off is under way */
    bool is_owner;              /**< the session sent its heartbeats */
    int64_t ns;                 /**< how long; LASER_FELL: how long the program
                                     was held up before; 0: it was not */
    char text[LUM_NEWS_TEXT_BYTES]; /**< TEXT: printable; LINK_DOWN: why */
} lum_news;

/** Its name for programs, such as "laser-fell"; NULL: there is none with this
 * number. */
const char *lum_news_name(lum_news_kind kind);

/** Its weight; INFO if there is none with this number. */
lum_news_weight lum_news_weigh(lum_news_kind kind);

/** Whether it explains why lines have no ranges: the laser is down. */
bool lum_news_is_dark(lum_news_kind kind);

/** Why the laser is down, to be put after the names of the bits: ": ..." if no
 * hazard is set but TLV_CMD_OFF, which a sensor also sets after a time without
 * heartbeats; else "".
 * @param was_away data had stopped before. */
const char *lum_laser_cause(uint16_t status, bool was_away);

/** The beginning of a command for a session's sensor, for a person to copy:
 * "lumctl --host 10.42.0.37 --interface eth0".
 * @param interface_name the session's; NULL: none was given.
 * @param room           at least 1; LUM_ERROR_BYTES holds it.
 * @return out. */
const char *lum_news_ctl(lum_endpoint sensor, const char *interface_name,
                         char *out, size_t room);

/** What to say: a sentence without a full stop, for example "the laser of
 * 10.42.0.37 went off (HW_SAFETY_BAD)". No line breaks; bytes of the sensor are
 * printable ASCII.
 * @param out  always ends with a NUL; the text is cut to room - 1 bytes.
 * @param room at least 1; LUM_ERROR_BYTES holds each.
 * @return out. */
const char *lum_news_sentence(const lum_news *news, char *out, size_t room);

/** What a person can do about it, for example "when it is safe, run lumctl
 * --host 10.42.0.37 laser on"; "": nothing. As lum_news_sentence(). */
const char *lum_news_fix(const lum_news *news, char *out, size_t room);

/** Both, with "; " between them. As lum_news_sentence(). */
const char *lum_news_tell(const lum_news *news, char *out, size_t room);

#ifdef __cplusplus
}
#endif

#endif
