/* Command texts and their answers. */
#ifndef LUMCTL_TEXT_H
#define LUMCTL_TEXT_H

#include "ctl.h"
#include "laser.h"

/* Checks a text word by word and sends it. As ctl_request(). */
enum exit_status text_send(struct ctl *ctl, const char *text,
                           struct ctl_answer *answer, bool *was_sent);

#define TEXT_BYTES 1024 /* longest text of commands */

/* A word with letters where digits belong, as the manual prints "Of" for 0f:
 * the command that was meant, and which letter was read for which digit. False:
 * there is none, also if the word already is a command. */
bool text_find_digits(const char *word, size_t len, char *out, size_t size,
                      const char **what);

/* What an answer's debug texts refuse. */
struct text_refusal {
    char names[TEXT_BYTES + 1]; /* commands, parted by spaces; may be empty */
    bool has_unnamed;           /* something that is not named, too */
};

/* Reads debug texts, a line each, as an answer to commands separated by spaces.
 * A line that names a command refuses it, unless it clearly confirms it ("50p
 * set"): the sensor names a refused command, but its other words are not known.
 * A line that speaks of a refusal and names no command refuses something
 * unnamed. False: nothing was refused. */
bool text_find_refusal(const char *text, const char *debug,
                       struct text_refusal *out);

/* Prints what was refused, and the sensor's own words. typed: as the user typed
 * it. Returns EXIT_FAILED. */
enum exit_status text_complain_refusal(const char *text, const char *typed,
                                       const struct text_refusal *refusal,
                                       const char *debug);

/* Prints a command's result for people. */
void text_print_answer(const struct ctl *ctl, const char *what,
                       const struct ctl_answer *answer);

/* How a command text ended. */
struct text_outcome {
    const char *text;
    bool is_done;
    const char *refused; /* commands that the sensor named; may be empty */
    enum laser_undo undo;
};

/* As JSON. outcome NULL: it was no command text. */
void text_print_json(const struct ctl *ctl, const struct text_outcome *outcome,
                     const struct ctl_answer *answer);

#endif
