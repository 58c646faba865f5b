/* The arrays of a lum_column_work. */
#ifndef LUM_FRAME_COLUMN_WORK_H
#define LUM_FRAME_COLUMN_WORK_H

#include "points/columns.h"

#include <stdbool.h>
#include <stddef.h>

/* words: most of a line. False: there is no memory; what there is of it is to
 * be released, too. */
bool lum_column_work_allocate(lum_column_work *work, size_t words);

void lum_column_work_release(lum_column_work *work);

#endif
