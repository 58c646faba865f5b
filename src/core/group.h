/* What is asked of a data packet that is read, written or pushed. */
#ifndef LUM_CORE_GROUP_H
#define LUM_CORE_GROUP_H

#include "lum/group.h"

/* n: num_samples; first: first_sample_index.
 * LUM_OK, LUM_E_MALFORMED or LUM_E_UNKNOWN_TAG. */
lum_result lum_group_check(uint32_t tag, uint32_t n, uint32_t first);

#endif
