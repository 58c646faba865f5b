/* The command line of lumdump. */
#ifndef LUMDUMP_COMMAND_LINE_H
#define LUMDUMP_COMMAND_LINE_H

#include "options.h"

enum parsed {
    PARSED_RUN,  /* go on */
    PARSED_DONE, /* help or version was printed */
    PARSED_BAD   /* a message was printed */
};

/* The options point into argv. To be freed by command_line_free() whatever the
 * result. */
enum parsed command_line_read(int argc, char **argv, struct options *out);

void command_line_free(struct options *options);

#endif
