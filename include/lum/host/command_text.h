/** @file
 * Commands from text, as a person types them and a sensor reads them
 * (docs/protocol.md, section 4). */
#ifndef LUM_HOST_COMMAND_TEXT_H
#define LUM_HOST_COMMAND_TEXT_H

#include "lum/command.h"
#include "lum/result.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/** Read the first command of a text; step over it and the one space before the
 * next.
 * @param text  at *text begin *len characters; both move past the command on
 *              LUM_OK, and stay otherwise.
 * @return LUM_OK; LUM_END if *len is 0; LUM_E_MALFORMED if there is no command
 *         (a sign, a leading zero, an extra space, an unknown letter);
 *         LUM_E_VALUE if its value is outside the table. */
LUM_MUST_CHECK lum_result lum_command_parse(const char **text, size_t *len,
                                            lum_command *out);

#ifdef __cplusplus
}
#endif

#endif
