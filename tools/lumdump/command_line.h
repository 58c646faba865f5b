/* The command line of lumdump. */
#ifndef LUMDUMP_COMMAND_LINE_H
#define LUMDUMP_COMMAND_LINE_H

#include "../common/option_table.h"
#include "options.h"

/* The options point into argv. To be freed by command_line_free() whatever the
 * result. */
enum option_end command_line_read(int argc, char **argv, struct options *out);

void command_line_free(struct options *options);

#endif
