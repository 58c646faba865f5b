/* How many cores this process may use. */
#ifndef LUMDUMP_CORES_H
#define LUMDUMP_CORES_H

/* At least 1. */
unsigned cores_count(void);

#endif
