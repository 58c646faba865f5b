/* The normal distribution in integers, from a table: its error is below 2e-7 in
 * probability, a hundredth of a line of the longest Y-scan table. */
#ifndef LUM_HOST_NORMAL_H
#define LUM_HOST_NORMAL_H

#include <stdint.h>

#define LUM_NORMAL_ONE    (INT64_C(1) << 30) /* one sigma */
#define LUM_NORMAL_SIGMAS 6                  /* beyond is nothing */

/* Probability of a value between 0 and x sigma, in units of 2^-33; negative
 * below. Any x. */
int64_t lum_normal_cumulative(int64_t x);

/* The inverse, within +-6 sigma. As u rises it may fall by a unit, no more. */
int64_t lum_normal_quantile(int64_t u);

#endif
