/* Command texts and their answers. */
#ifndef LUMCTL_TEXT_H
#define LUMCTL_TEXT_H

#include "ctl.h"

/* Checks a text word by word and sends it. As ctl_request(). */
enum exit_status text_send(struct ctl *ctl, const char *text,
                           struct ctl_answer *answer, bool *was_sent);

/* The commands of a text that the answer's debug text names, parted by spaces,
 * which means that the sensor refused them. False if there are none. */
bool text_find_refused(const char *text, const char *debug, char *out,
                       size_t size);

/* Prints a command's outcome for people: what has become of it. */
void text_print_answer(const struct ctl *ctl, const char *what,
                       const struct ctl_answer *answer);

/* As JSON. text NULL: it was no command text. refused "": nothing was. */
void text_print_json(const struct ctl *ctl, const char *text,
                     const char *refused, const struct ctl_answer *answer);

#endif
