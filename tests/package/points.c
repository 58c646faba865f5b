/* Links points of an installed copy. */
#include <lum/points.h>

#include <stdio.h>

int main(void)
{
    lum_calibration calibration;
    lum_layout layout;
    lum_projector projector;

    lum_calibration_default(&calibration);
    lum_layout_default(&layout);
    (void)puts("points");
    return lum_projector_init(&projector, &calibration, &layout) != LUM_OK;
}
