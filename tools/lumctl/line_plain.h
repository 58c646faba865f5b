/* Input without editing: a pipe, a file, or a terminal where there is no
 * libedit. */
#ifndef LUMCTL_LINE_PLAIN_H
#define LUMCTL_LINE_PLAIN_H

#include "line.h"

#define LINE_BYTES 2048u

struct line_plain {
    char bytes[LINE_BYTES]; /* read, not yet taken */
    size_t len;
    size_t taken; /* bytes of the line that was handed out */
    bool is_cut;  /* a line too long: the rest of it is thrown away */
    bool has_ended;
};

/* A line, when a whole one is there; the last one need not end. */
enum line_event line_plain_take(struct line_plain *plain, const char **out);

#endif
