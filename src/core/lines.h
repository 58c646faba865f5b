/* Open and closed lines of one eye (docs/protocol.md, section 6, Reassembly,
 * rules 3 and 5). */
#ifndef LUM_CORE_LINES_H
#define LUM_CORE_LINES_H

#include "lum/assembler.h"

/* Gives each eye its share of the storage, which is large enough. */
void lum_lines_init(lum_assembler *a, const lum_assembler_storage *storage);

/* Looks for the line of the packet at hand: its clock and this number.
 * found: the open line. Untouched where there is none; awaited.to_close then
 * says how many others close before it is opened. LUM_OK or LUM_E_LATE. */
lum_result lum_lines_find(lum_assembler *a, const lum_eye_state *eye,
                          uint32_t number, lum_line_slot **found);

/* Opens the line of the packet at hand; not all may be open. */
lum_line_slot *lum_lines_open(const lum_assembler *a, lum_eye_state *eye,
                              uint32_t number);

/* Takes note of the packet at hand, which an open line has accepted. The second
 * decides the line's frame. */
void lum_lines_take(lum_assembler *a, lum_eye_state *eye, lum_line_slot *slot);

/* Closes the line that was opened first; one is open. It stays as it is until
 * another line is opened. */
lum_line *lum_lines_close(const lum_assembler *a, lum_eye_state *eye);

/* Puts an open line whose last packet came before an arrival where the next
 * lum_lines_close() takes it; false: there is none. */
bool lum_lines_pull_idle(lum_eye_state *eye, int64_t before);

/* Forgets the lines that have closed; none is open. */
void lum_lines_forget(const lum_assembler *a, lum_eye_state *eye);

#endif
