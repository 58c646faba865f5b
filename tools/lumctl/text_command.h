/* Command texts and their answers. */
#ifndef LUMCTL_TEXT_COMMAND_H
#define LUMCTL_TEXT_COMMAND_H

#include "ctl.h"
#include "laser_outcome.h"
#include "refusal.h"

/* Checks a text word by word and sends it. As ctl_request(). */
enum exit_status text_send(struct ctl *ctl, const char *text,
                           struct ctl_answer *answer, bool *was_sent);

/* A word with letters where digits belong, as the manual prints "Of" for 0f:
 * the command that was meant, and which letter was read for which digit. False:
 * there is none, also if the word already is a command. */
bool text_find_digits(const char *word, size_t len, char *out, size_t size,
                      const char **what);

/* Says what was refused, and the sensor's own words. typed: how the user said
 * it. Returns EXIT_FAILED. */
enum exit_status text_complain_refusal(const char *text, const char *typed,
                                       const struct refusal *refusal,
                                       const char *debug);

/* Prints a command's result for people. */
void text_print_answer(const struct ctl *ctl, const char *what,
                       const struct ctl_answer *answer);

/* How a command text ended. */
struct text_outcome {
    const char *text;
    bool is_done;
    const char *refused;    /* commands that the sensor named; may be empty */
    const lum_news *undone; /* how a laser on was taken back; NULL: it stands */
};

/* As JSON. outcome NULL: it was no command text. */
void text_print_json(const struct ctl *ctl, const struct text_outcome *outcome,
                     const struct ctl_answer *answer);

#endif
