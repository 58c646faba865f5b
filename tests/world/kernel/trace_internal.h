/* A new record. */
#ifndef WORLD_TRACE_INTERNAL_H
#define WORLD_TRACE_INTERNAL_H

void world_trace_reset(void);

#endif
