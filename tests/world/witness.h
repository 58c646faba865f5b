/* Looks at a world from outside, and has the judges say what they think of it:
 * logs of sensors, datagrams, what tools print, names of files. */
#ifndef WORLD_WITNESS_H
#define WORLD_WITNESS_H

#include "user.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct verdict;

/* From now on each telling has a witness. What the judges find fails it, at its
 * end. */
void witness_install(void);

/* The user will tell all that follows; without it the witness guesses that from
 * what befell: where a story disturbs anything, no time of it is calm. */
void witness_knows_all(void);

/* name: as "cable". */
void witness_fault(const char *name, int64_t from_ns, int64_t to_ns);
/* What a tool writes to stands still, or is slow, or fails. */
void witness_stalls(const user_tool *tool);
/* It is about to be stopped, right before a call that sends. */
void witness_held(const user_tool *tool);
/* Its user asked for what has to be refused. */
void witness_wrong(const user_tool *tool);
/* What its user typed, also later. */
void witness_typed(const user_tool *tool, const char *text);
/* It ended with the power of its host. */
void witness_cut(const user_tool *tool);
/* The power of a host was just cut: what has its own name is whole, but for a
 * recording that was not finished. */
void witness_blackout(world_host *host);

/* Of the last telling. The rule that it broke first; "": none. */
const char *witness_rule(void);
const struct verdict *witness_verdict(void);
size_t witness_programs(void); /* that were run */

#endif
