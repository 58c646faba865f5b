/* What --help prints: a literal of C99 has no more than 4095 bytes. */
#ifndef LUMDUMP_HELP_H
#define LUMDUMP_HELP_H

extern const char help_output[];
extern const char help_rest[];
extern const char help_examples[];

#endif
