/* What --help prints. */
#ifndef LUMDUMP_HELP_H
#define LUMDUMP_HELP_H

extern const char help_text[];

#endif
