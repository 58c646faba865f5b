#include "inputs.h"

#include "base/text.h"

#include <stdlib.h>

static struct inputs inputs;
static lum_error last_error;
static char *text;

const struct inputs *inputs_look(void)
{
    return &inputs;
}

lum_error *inputs_error(void)
{
    return &last_error;
}

const char *inputs_text(void)
{
    return text;
}

/* Room for a text of so many bytes, which ends with a 0; NULL: no memory. */
EXPORTED(engine_text) char *engine_text(size_t bytes);
char *engine_text(size_t bytes)
{
    free(text);
    text = calloc(bytes + 1u, 1);
    return text;
}

EXPORTED(engine_error) const char *engine_error(void);
const char *engine_error(void)
{
    return last_error.text;
}

static int keep(char **to)
{
    free(*to);
    *to = lum_text_copy(text);
    return *to != NULL ? 0 : lum_error_set(&last_error, "out of memory");
}

/* The text names one more capture. 0, or -1 with an error. */
EXPORTED(engine_add_capture) int engine_add_capture(void);
int engine_add_capture(void)
{
    if (inputs.capture_count == INPUTS_CAPTURES_MAX) {
        return lum_error_set(&last_error, "at most %u captures are read as one",
                             INPUTS_CAPTURES_MAX);
    }
    return keep(&inputs.captures[inputs.capture_count++]);
}

/* The text names another file, of which there is one: an ::input. 0, or -1 with
 * an error. */
EXPORTED(engine_set) int engine_set(unsigned what);
int engine_set(unsigned what)
{
    return what < INPUTS ? keep(&inputs.names[what])
                         : lum_error_set(&last_error, "no such input");
}
