/* Any calibration, with any bytes; and for one that passes its check, the
 * smallest time of flight. */
#include "lum/calibration.h"
#include "unknown.h"

static lum_calibration calibration;

void main(void)
{
    lum_calibration_fault fault;
    unsigned index;
    any_bytes(&calibration, sizeof calibration);
    (void)lum_calibration_check(&calibration, &fault, &index);
    const uint32_t eye = any_u32(0, LUM_EYES - 1);
    //@ split eye;
    calibration.tof_lsb_fs = any_u32(1, 1000000);
    calibration.eye[eye].tof_offset_fs = any_i64(-10000000000, 10000000000);
    (void)lum_calibration_min_tof(&calibration, eye);
}
