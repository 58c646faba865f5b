/** @file
 * What was found out, as texts. Internal. */
#ifndef LUM_INFER_REPORT_H
#define LUM_INFER_REPORT_H

#include "infer/state.h"

/** The name of a key, such as "group.tag". */
const char *lum_infer_name(unsigned key);

/** Each key with its value and the evidence, of a result with a profile. */
void lum_infer_report(const lum_infer_state *state, lum_infer_result *out);

#endif
