#include "crew.h"

#include <stdlib.h>

bool lum_column_work_allocate(lum_column_work *work, size_t words)
{
    work->samples.returns = malloc(words * sizeof *work->samples.returns);
    work->sample = malloc(words * sizeof *work->sample);
    work->strongest = malloc(words * sizeof *work->strongest);
    work->pixel = malloc(words * sizeof *work->pixel);
    return work->samples.returns != NULL && work->sample != NULL &&
           work->strongest != NULL && work->pixel != NULL;
}

void lum_column_work_release(lum_column_work *work)
{
    free(work->samples.returns);
    free(work->sample);
    free(work->strongest);
    free(work->pixel);
}
