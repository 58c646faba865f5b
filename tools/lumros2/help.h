/* What lumros2 --help says. */
#ifndef LUMROS2_HELP_H
#define LUMROS2_HELP_H

extern const char help_text[];

#endif
