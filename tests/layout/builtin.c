/* layout_fixed.c, and its layout as lumtable has it. */
#include "compare.h"

/* NOLINTNEXTLINE(bugprone-suspicious-include): it needs no line in a build */
#include "../unit/tables/typical.c"

DECLARE(fixed_);

const struct code codes[] = {CODE(fixed_, &typical_layout)};
const size_t code_count = sizeof codes / sizeof codes[0];
