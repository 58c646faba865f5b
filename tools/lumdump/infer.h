/* A run that finds the layout of a capture's data packets. */
#ifndef LUMDUMP_INFER_H
#define LUMDUMP_INFER_H

#include "conclude.h"
#include "options.h"

/* Reads as much of the capture as is needed, writes the profile and tells what
 * was found. */
enum exit_status infer_run(const struct options *options);

#endif
