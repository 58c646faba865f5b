/* A session that is made up from its seed. */
#ifndef WORLD_DICE_H
#define WORLD_DICE_H

#include "../user.h"

#include <stdbool.h>
#include <stdint.h>

user_result dice_run(uint64_t seed);

/* From now on only some steps of each session are told, by the numbers that a
 * script has before them ("1,5,7"; "none"), and it ends at a moment (0: as it
 * was drawn). False: this is no list of steps. */
bool dice_only(const char *steps, int64_t end_ms);

/* Makes a session that fails as small as it gets, and prints it with the
 * command that tells it again. kills: it takes the process with it. */
void dice_print_smallest(uint64_t seed, bool kills);

#endif
