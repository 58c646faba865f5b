/* layout_fixed.c, and its layout as lumtable has it. */
#include "compare.h"

/* NOLINTNEXTLINE(bugprone-suspicious-include): it needs no line in a build */
#include "../unit/tables/typical.c"

DECLARE(0);

const struct code codes[] = {CODE(0, &typical_layout)};
const size_t code_count = sizeof codes / sizeof codes[0];
