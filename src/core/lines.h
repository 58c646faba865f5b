/* Open and closed lines of one eye (docs/protocol.md, section 6, Reassembly,
 * rules 3 and 5). */
#ifndef LUM_CORE_LINES_H
#define LUM_CORE_LINES_H

#include "lum/assembler.h"

/* Looks for the line of the packet at hand. LUM_OK: it is found; or found stays
 * as it is, and the line has to be opened once to_close others have closed.
 * LUM_E_LATE. */
lum_result lum_lines_find(lum_assembler *a, const lum_eye_state *eye,
                          uint32_t number, lum_line_slot **found);

/* Opens a line at the clock of the packet at hand; not all may be open. */
lum_line_slot *lum_lines_open(const lum_assembler *a, lum_eye_state *eye,
                              uint32_t number);

/* Closes the line that was opened first. It stays as it is until another line
 * is opened. */
lum_line *lum_lines_close(const lum_assembler *a, lum_eye_state *eye);

/* Whether the eye is past the next frame to announce: a reach of lines of later
 * ones has been decided, and no open line is of this or one before it. */
bool lum_lines_are_past(const lum_assembler *a, const lum_eye_state *eye);

#endif
