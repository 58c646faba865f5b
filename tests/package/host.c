/* Links host of an installed copy, and no third-party library. */
#include <lum/host/clock_sync.h>
#include <lum/host/keys.h>
#include <lum/host/yscan_plan.h>

#include <stdio.h>

int main(void)
{
    lum_clock_sync sync;
    lum_clock_estimate estimate;
    int32_t udeg[2] = {0, 0};
    lum_keys keys;

    lum_keys_of_profile(&keys, NULL);
    lum_clock_sync_init(&sync);
    (void)puts("host");
    return lum_keys_set(&keys, "group.line.at", "14", 1, NULL) != LUM_OK ||
           lum_clock_sync_estimate(&sync, &estimate) != LUM_END ||
           lum_yscan_gaussian(-17000000, 3000000, 0, 2000000, udeg, 2) !=
               LUM_OK;
}
