/* Words to ranges. */
#include "kernels.h"

/* Computed in double, for columns and samples. */
void lum_plain_ranges(const lum_eye_projector *eye, const uint32_t *words,
                      uint32_t n, float *restrict out)
{
    const double lsb = eye->range_lsb;
    const double offset = eye->range_offset;
    for (uint32_t i = 0; i < n; i++) {
        out[i] = (float)(lum_word_tof(words[i]) * lsb + offset);
    }
}
