/* What all processors of an architecture have: SSE2, or NEON. */
#include "../kernels.h"

#if defined(LUM_HAS_KERNELS)

#define LUM_LANES 4
#include "kernel_loops.h"

#if defined(LUM_HAS_NEON)
const lum_kernels lum_kernels_4 = LUM_KERNELS("neon");
#else
const lum_kernels lum_kernels_4 = LUM_KERNELS("sse2");
#endif

#endif
