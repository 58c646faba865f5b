/* For processors with AVX2. */
#include "../kernels.h"

#if defined(LUM_HAS_WIDE)

#include <string.h>

#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2"))),                  \
                             apply_to = function)
#else
#pragma GCC target("avx2")
#endif

#define LUM_LANES 8
#include "kernel_loops.h"

const lum_kernels lum_kernels_8 = LUM_KERNELS("avx2");

#if defined(__clang__)
#pragma clang attribute pop
#endif

#endif
