/* Samples of a packet into an open line (docs/protocol.md, section 6,
 * Reassembly, rule 4). */
#ifndef LUM_CORE_WORDS_H
#define LUM_CORE_WORDS_H

#include "lum/assembler.h"

/* LUM_OK, LUM_E_DUPLICATE or LUM_E_CONFLICT. */
lum_result lum_words_place_angles(lum_line_slot *slot, const lum_group *group,
                                  uint8_t angle_order);

/* The line's words stay ordered by pixel, then as in their packet.
 * LUM_OK, LUM_E_DUPLICATE, LUM_E_CONFLICT or LUM_E_NO_ROOM. */
lum_result lum_words_place_ranges(lum_assembler *a, lum_line_slot *slot,
                                  const lum_group *group);

/* Counts the words of an accepted packet, at most capacity for the line, and
 * records where they end within the line, for lost_words. An end beyond
 * capacity is ignored. */
void lum_words_count_sent(lum_line_slot *slot, const lum_group *group,
                          uint32_t capacity);

#endif
