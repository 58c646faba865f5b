/* Which options go together. False: a message was printed. */
#ifndef LUMDUMP_RULES_H
#define LUMDUMP_RULES_H

#include "../common/option_table.h"
#include "options.h"

/* Print why, and return false. */
LUM_PRINTF(1, 2)
bool rules_refuse(const char *format, ...);

/* Of a run whose outputs have their formats. */
bool rules_allow(const struct options *options);

/* Of --infer. */
bool rules_allow_infer(const struct options *options,
                       const struct option_table *table,
                       const struct option_result *given);

/* Of --check-preset. */
bool rules_allow_check(const struct option_table *table,
                       const struct option_result *given);

#endif
