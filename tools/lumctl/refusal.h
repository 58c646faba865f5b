/* What a sensor refuses, read out of its answer's debug texts. */
#ifndef LUMCTL_REFUSAL_H
#define LUMCTL_REFUSAL_H

#include <stdbool.h>

#define TEXT_BYTES 1024 /* longest text of commands */

/* What an answer's debug texts refuse. */
struct refusal {
    char names[TEXT_BYTES + 1]; /* commands, parted by spaces; may be empty */
    bool has_unnamed;           /* something that is not named, too */
};

/* Reads debug texts, a line each, as an answer to a text of commands parted by
 * spaces. A line that names a command refuses it, since the sensor names what
 * it refuses in words that are not known, unless the line plainly confirms it
 * ("50p set"). A line that speaks of a refusal and names no command refuses
 * something unnamed. False: nothing was refused. */
bool refusal_find(const char *text, const char *debug, struct refusal *out);

#endif
