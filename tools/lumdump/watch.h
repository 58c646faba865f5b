/* What a live run says about its sensor, and the laser's part of its summary:
 * lum_keeper for the terminal. */
#ifndef LUMDUMP_WATCH_H
#define LUMDUMP_WATCH_H

#include "say.h"

#include "lum/live/keeper.h"

#include <stdbool.h>
#include <stddef.h>

/* Say what is new. */
void watch_tell(lum_keeper *keeper, struct say *say);

/* Why lines have no ranges; out does not change where nothing shows that. */
void watch_darkness(const lum_keeper *keeper, char *out, size_t room);

/* What is known. */
lum_keeper_view watch_look(const lum_keeper *keeper);

#endif
