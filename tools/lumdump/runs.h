/* The runs beside that on a capture. Each ends with its exit status. */
#ifndef LUMDUMP_RUNS_H
#define LUMDUMP_RUNS_H

#include "conclude.h"

/* Receive from the sensor until the duration is over, a signal comes, the
 * reader leaves or something fails; write and sum up as the options say. Uses
 * the pass up. */
enum exit_status live_run(struct pass *pass);

/* Read as much of the capture as is needed to find the layout of its data
 * packets, write the profile and tell what was found. */
enum exit_status infer_run(const struct options *options);

/* Print a table of what a cloud lacks for the program of a preset, which reads
 * it. EXIT_FAILED if it lacks a field. */
enum exit_status check_preset_run(const struct options *options);

#endif
