/* --check-preset: what a cloud lacks for a program that reads it. */
#ifndef LUMDUMP_CHECK_PRESET_H
#define LUMDUMP_CHECK_PRESET_H

#include "conclude.h"
#include "options.h"

/* Prints a table of the preset's fields. EXIT_FAILED if the cloud lacks one. */
enum exit_status check_preset_run(const struct options *options);

#endif
