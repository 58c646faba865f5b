/* For processors with AVX-512. */
#include "../kernels.h"

#if defined(LUM_HAS_WIDE)

#include <string.h>

#if defined(__clang__)
#pragma clang attribute push(                                                  \
    __attribute__((target("avx512f,avx512bw,avx512dq,avx512vl"))),             \
    apply_to = function)
#else
#pragma GCC target("avx512f,avx512bw,avx512dq,avx512vl")
#endif

#define LUM_LANES 16
#include "kernel_loops.h"

const lum_kernels lum_kernels_16 = LUM_KERNELS("avx512");

#if defined(__clang__)
#pragma clang attribute pop
#endif

#endif
