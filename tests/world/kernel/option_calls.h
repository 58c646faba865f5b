/* getopt_long() and its variables, of each process its own. */
#ifndef WORLD_OPTION_CALLS_H
#define WORLD_OPTION_CALLS_H

#include "process.h"

#include <getopt.h>

WORLD_CALL(getopt_long);
extern char *world_call_optarg;
extern int world_call_optind;
extern int world_call_opterr;
extern int world_call_optopt;

#endif
