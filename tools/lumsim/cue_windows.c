#include "cue.h"

bool cue_is_possible(void)
{
    return false;
}

void cue_catch(enum cue cue)
{
    (void)cue;
}

bool cue_take(enum cue cue)
{
    (void)cue;
    return false;
}
