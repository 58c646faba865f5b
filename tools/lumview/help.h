/* What lumview --help prints. */
#ifndef LUMVIEW_HELP_H
#define LUMVIEW_HELP_H

extern const char help_text[];

#endif
