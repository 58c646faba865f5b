/* layout_fixed.c, and its layout as lumtable has it. */
#define LAYOUT_NUMBER 0
#include "compare.h"

/* NOLINTBEGIN(bugprone-suspicious-include): they are built under other names */
#include "../unit/tables/typical.c"
#include "core/layout_fixed.c"
/* NOLINTEND(bugprone-suspicious-include) */

const struct code codes[] = {CODE(0, &typical_layout)};
const size_t code_count = sizeof codes / sizeof codes[0];
