/* Text that a process shows to the user: kept, and told in the trace by lines.
 */
#ifndef WORLD_SHOWN_H
#define WORLD_SHOWN_H

#include "task.h"

#include <stddef.h>

typedef struct shown {
    char name[32];
    char *text; /* NULL: nothing; else with a 0 behind it */
    size_t len, room;
    size_t told; /* of it in the trace */
    world_queue came;
} shown;

void shown_begin(shown *s, const char *name);
void shown_add(shown *s, const char *bytes, size_t size);
const char *shown_text(const shown *s, size_t *size);
void shown_end(shown *s);

#endif
