/* What all processors of an architecture have: SSE2, or NEON. */
#include "kernels.h"

#if defined(LUM_HAS_KERNELS)

#define LUM_LANES 4
#define KERNELS   lum_kernels_4
#if defined(LUM_HAS_NEON)
#define NAME "neon"
#else
#define NAME "sse2"
#endif
#include "kernel_loops.h"

#endif
