/* What is asked of a data packet that is read, written or pushed. */
#ifndef LUM_CORE_GROUP_H
#define LUM_CORE_GROUP_H

#include "lum/group.h"

/* LUM_OK, LUM_E_MALFORMED or LUM_E_UNKNOWN_TAG. */
lum_result lum_group_check(const lum_group *group);

#endif
