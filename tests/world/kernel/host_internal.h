/* The end of all hosts. */
#ifndef WORLD_HOST_INTERNAL_H
#define WORLD_HOST_INTERNAL_H

void world_host_reset(void);

#endif
