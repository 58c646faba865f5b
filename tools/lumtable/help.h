/* What lumtable --help says. */
#ifndef LUMTABLE_HELP_H
#define LUMTABLE_HELP_H

extern const char help_text[];

#endif
