/* The end of a run: its messages and its exit status. */
#ifndef LUMDUMP_CONCLUDE_H
#define LUMDUMP_CONCLUDE_H

#include "../common/misfit.h"
#include "convert.h"

enum exit_status {
    EXIT_DONE = 0,
    EXIT_FAILED = 1,
    EXIT_BAD = 2,
    EXIT_NO_ANSWER = 3
};

/* Print the error; returns status. */
enum exit_status conclude_error(const lum_error *error,
                                enum exit_status status);

/* Print a warning, unless the run is quiet; the format has no newline. */
LUM_PRINTF(2, 3)
void conclude_warn(const struct options *options, const char *format, ...);

/* The capture that can tell the layout, as a word of a shell, which out may
 * hold: of a sensor the recording of this run. NULL: there is none. */
const char *conclude_capture(const struct options *options,
                             char out[MISFIT_CAPTURE_BYTES]);

/* Print the messages about what the capture says of itself. */
void conclude_about(const struct options *options,
                    const struct provenance_source *about);

/* Print the messages of the outputs that were not printed yet. */
void conclude_notes(struct pass *pass);

/* Warn of what is odd about the records. demux: what took them, or NULL. */
void conclude_remarks(const struct options *options, const lum_capture *capture,
                      const lum_demux *demux);

/* Say how a pass ended, finish its outputs if it came to its end, print the
 * summary. */
enum exit_status conclude(struct pass *pass, enum pass_result result,
                          lum_error *error);

/* The same for a pass whose outputs are closed: only warnings and summary. */
enum exit_status conclude_summary(const struct pass *pass);

/* What was printed on standard output reaches it. */
enum exit_status conclude_stdout(void);

#endif
