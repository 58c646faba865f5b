#include "arrival.h"

#define AGE_MAX_NS INT64_C(10000000000)

int64_t arrival_ns(int64_t utc_ns, int64_t now_ns, int64_t now_utc_ns)
{
    const int64_t age_ns = now_utc_ns - utc_ns;
    return age_ns >= 0 && age_ns <= AGE_MAX_NS ? now_ns - age_ns : now_ns;
}
