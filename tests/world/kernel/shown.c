#define _GNU_SOURCE
#include "shown.h"

#include "trace.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINE_TOLD 160 /* more of a line is not in the trace */

void shown_begin(shown *s, const char *name)
{
    *s = (struct shown){.text = NULL};
    (void)snprintf(s->name, sizeof s->name, "%s", name);
}

static void make_room(shown *s, size_t size)
{
    size_t room = s->room == 0 ? 256 : s->room;
    while (room <= s->len + size) {
        room *= 2;
    }
    if (room != s->room) {
        s->text = realloc(s->text, room);
        s->room = room;
    }
    if (s->text == NULL) {
        abort();
    }
}

static void tell_lines(shown *s)
{
    const char *end = NULL;
    while ((end = memchr(s->text + s->told, '\n', s->len - s->told)) != NULL) {
        const char *line = s->text + s->told;
        const size_t len = (size_t)(end - line);
        WORLD_TRACE("%s: %.*s", s->name,
                    (int)(len < LINE_TOLD ? len : LINE_TOLD), line);
        s->told += len + 1u;
    }
}

void shown_add(shown *s, const char *bytes, size_t size)
{
    make_room(s, size);
    memcpy(s->text + s->len, bytes, size);
    s->len += size;
    s->text[s->len] = '\0';
    if (world_traces) {
        tell_lines(s);
    }
    world_wake_all(&s->came);
}

const char *shown_text(const shown *s, size_t *size)
{
    if (size != NULL) {
        *size = s->len;
    }
    return s->text != NULL ? s->text : "";
}

void shown_end(shown *s)
{
    free(s->text);
    s->text = NULL;
}
