/** @file
 * The commands of the manual's table, as text in a command TLV
 * (docs/protocol.md, section 4). */
#ifndef LUM_COMMAND_H
#define LUM_COMMAND_H

#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** The commands, in the order of lum_command_specs. */
typedef enum lum_command_id {
    LUM_COMMAND_LASER_ON,        /**< u */
    LUM_COMMAND_LASER_OFF,       /**< d */
    LUM_COMMAND_POWER,           /**< 0..100 p */
    LUM_COMMAND_THRESHOLD_GREEN, /**< 0..100 g */
    LUM_COMMAND_THRESHOLD_BLUE,  /**< 0..100 b */
    LUM_COMMAND_LINE_MODE,       /**< 0 f: 640 lines, 1 f: 64 lines */
    LUM_COMMAND_YSCAN,           /**< 11..30 y, degrees of view */
    LUM_COMMAND_HOLDOFF,         /**< 150..250 h, in steps of 10 */
    LUM_COMMAND_OFFSET_GREEN,    /**< 0..30 G */
    LUM_COMMAND_OFFSET_BLUE,     /**< 0..30 B */
    LUM_COMMANDS                 /**< how many there are */
} lum_command_id;

/** How a command is written and what it takes. */
typedef struct lum_command_spec {
    char letter;    /**< the last character of the text */
    bool has_value; /**< whether a decimal number precedes it */
    uint16_t min;   /**< smallest value */
    uint16_t max;   /**< largest value */
    uint16_t step;  /**< values are min, min + step, ... */
} lum_command_spec;

/** The manual's table, indexed by ::lum_command_id. */
extern const lum_command_spec lum_command_specs[LUM_COMMANDS];

/** One command. */
typedef struct lum_command {
    lum_command_id id; /**< which */
    uint16_t value;    /**< 0 where the command takes none */
} lum_command;

/** Room for the text of any command; it is not terminated. */
#define LUM_COMMAND_TEXT_BYTES 6u

/** Write a command's text.
 * @param out gets at most LUM_COMMAND_TEXT_BYTES characters, no NUL.
 * @param len gets how many.
 * @return LUM_OK; LUM_E_VALUE if the id is unknown or the value is not one
 *         that the table allows. */
LUM_MUST_CHECK lum_result lum_command_format(const lum_command *command,
                                             char out[LUM_COMMAND_TEXT_BYTES],
                                             size_t *len);

#ifdef __cplusplus
}
#endif

#endif
