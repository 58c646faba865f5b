/** @file
 * The messages of an MCAP file, of whatever type, in the order in which they
 * were written. A message is handed out when it is there, so a live file may
 * come through a pipe. Internal to the capture room and to tools.
 *
 * A reader is one thread's at a time. */
#ifndef LUM_CAPTURE_MCAP_MESSAGES_H
#define LUM_CAPTURE_MCAP_MESSAGES_H

#include "lum/capture/source.h"

/** Most schemas, and most channels, of a file. */
#define LUM_MCAP_CHANNELS_KEPT_MAX 256u

/** Most bytes of a name: of a topic, a type or an encoding. */
#define LUM_MCAP_NAME_MAX 255u

/** A channel. */
typedef struct lum_mcap_messages_topic {
    char name[LUM_MCAP_NAME_MAX + 1u];
    char type[LUM_MCAP_NAME_MAX + 1u];       /**< "": it has no schema */
    char definition[LUM_MCAP_NAME_MAX + 1u]; /**< how that is described, such as
                                                  ros2msg */
    char encoding[LUM_MCAP_NAME_MAX + 1u];   /**< of messages, such as cdr */
} lum_mcap_messages_topic;

/** A message. */
typedef struct lum_mcap_message {
    const lum_mcap_messages_topic *topic; /**< live until the reader is freed */
    size_t index;                         /**< of the topic, from 0 */
    uint64_t log_ns;                      /**< since 1970 */
    const uint8_t *bytes;                 /**< live until the next message */
    size_t len;
} lum_mcap_message;

/** What came. */
typedef enum lum_mcap_event {
    LUM_MCAP_FAILED = -1, /**< with the byte and the reason in error */
    LUM_MCAP_ENDED,       /**< the file was read to its end */
    LUM_MCAP_HAS_TOPIC,   /**< a channel: its topic and index alone are set */
    LUM_MCAP_HAS_MESSAGE
} lum_mcap_event;

/** What is read of a file. */
typedef struct lum_mcap_messages lum_mcap_messages;

/** Begin.
 * @param source borrowed; nothing of it was taken. It is read until it shows
 *               what it is.
 * @return NULL if it is no MCAP file or without memory, with the reason. */
LUM_MUST_CHECK lum_mcap_messages *lum_mcap_messages_new(lum_source *source,
                                                        lum_error *error);

/** Free it. NULL is allowed. */
void lum_mcap_messages_free(lum_mcap_messages *messages);

/** What comes next. A channel that is described again is not handed out
 * again. */
LUM_MUST_CHECK lum_mcap_event lum_mcap_messages_next(
    lum_mcap_messages *messages, lum_mcap_message *out, lum_error *error);

/** How many chunks and messages could not be read and were passed over so far.
 * @param error may be NULL; unless there are none, it gets the file, how many,
 *              and why the first was. */
uint64_t lum_mcap_messages_damaged(const lum_mcap_messages *messages,
                                   lum_error *error);

#endif
