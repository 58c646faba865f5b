/* What words.c promises the assembler. words.c here shows that the promises are
 * kept, assembler.c takes them in place of the code. */
#ifndef LUM_PROVE_WORDS_CONTRACT_H
#define LUM_PROVE_WORDS_CONTRACT_H

#include "unknown.h"
#include "words.h"

/*@ assigns \result, slot->line.angle_count, slot->angle_marks[0 .. 31],
      slot->angles[0 .. 999] \from indirect:*slot, indirect:*group, unknown;
    ensures \result \in {LUM_OK, LUM_E_DUPLICATE, LUM_E_CONFLICT};
    ensures slot->line.angle_count <= 65535; */
lum_result lum_words_place_angles(lum_line_slot *slot, const lum_group *group,
                                  uint8_t angle_order);

/*@ assigns \result, slot->line.word_count, a->counters.bad_words,
      a->placement[0 .. 999], slot->words_seen, slot->words_end
      \from indirect:*slot, indirect:*group, unknown;
    assigns slot->words[0 .. a->config.words_per_line - 1]
      \from indirect:*slot, indirect:*group, unknown;
    ensures \result \in
      {LUM_OK, LUM_E_DUPLICATE, LUM_E_CONFLICT, LUM_E_NO_ROOM};
    ensures slot->line.word_count <= a->config.words_per_line;
    ensures slot->words_seen <= a->config.words_per_line;
    ensures slot->words_end <= a->config.words_per_line; */
lum_result lum_words_place_ranges(lum_assembler *a, lum_line_slot *slot,
                                  const lum_group *group);

#endif
