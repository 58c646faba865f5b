/* Chooses the vectors that the processor can run, or those that LUM_CPU
 * names. */
#include "../kernels.h"

static const lum_kernels plain = {
    "plain",           lum_plain_directions, lum_plain_count_below,
    lum_plain_choose,  lum_plain_points,     lum_plain_ranges,
    lum_plain_columns, lum_plain_numbers,    lum_plain_times,
    lum_plain_count,   lum_plain_move,       lum_plain_pixels};

#if defined(LUM_HAS_KERNELS)

#include <stdlib.h>
#include <string.h>

size_t lum_kernels_list(const lum_kernels *out[LUM_KERNELS_MAX])
{
    size_t n = 0;
#if defined(LUM_HAS_WIDE)
    if (__builtin_cpu_supports("avx512f") &&
        __builtin_cpu_supports("avx512bw") &&
        __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl")) {
        out[n++] = &lum_kernels_16;
    }
    if (__builtin_cpu_supports("avx2")) {
        out[n++] = &lum_kernels_8;
    }
#endif
    out[n++] = &lum_kernels_4;
    out[n++] = &plain;
    return n;
}

static const lum_kernels *choose(void)
{
    const lum_kernels *list[LUM_KERNELS_MAX];
    const size_t n = lum_kernels_list(list);
    const char *name = getenv("LUM_CPU");
    for (size_t i = 0; name != NULL && i < n; i++) {
        if (strcmp(name, list[i]->name) == 0) {
            return list[i];
        }
    }
    return list[0];
}

/* Threads that choose at the same time choose the same. */
const lum_kernels *lum_kernels_choose(void)
{
    static const lum_kernels *chosen;
    const lum_kernels *kernels = __atomic_load_n(&chosen, __ATOMIC_RELAXED);
    if (kernels == NULL) {
        kernels = choose();
        __atomic_store_n(&chosen, kernels, __ATOMIC_RELAXED);
    }
    return kernels;
}

const char *lum_points_vectors(void)
{
    return lum_kernels_choose()->name;
}

#else

size_t lum_kernels_list(const lum_kernels *out[LUM_KERNELS_MAX])
{
    out[0] = &plain;
    return 1;
}

const char *lum_points_vectors(void)
{
    return plain.name;
}

#endif
