/* How long a command of lumctl may take. */
#ifndef WORLD_LIMITS_H
#define WORLD_LIMITS_H

#include "record.h"

/* In its own time; RECORD_NEVER: until it is told. */
int64_t limits_of_lumctl(const record_tool *tool);

/* Start, output and end of a process that waits for nothing. */
#define LIMITS_GRACE_NS (600 * RECORD_MS)

/* Beyond its limit: clocks of hosts drift by less than a hundredth. */
int64_t limits_with_grace(int64_t limit_ns);

/* For another lumctl of its host that is stopped. */
int64_t limits_of_lock(const struct record *record, const record_tool *tool);

#endif
