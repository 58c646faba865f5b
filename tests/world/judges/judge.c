#include "judge.h"

void judge_all(const struct record *record, struct verdict *out)
{
    judge_laser_late(record, out);
    judge_laser_asked(record, out);
    judge_done(record, out);
    judge_limits(record, out);
    judge_fates(record, out);
    judge_counts(record, out);
    judge_status(record, out);
    judge_owners(record, out);
    judge_requests(record, out);
    judge_lines(record, out);
    judge_times(record, out);
    judge_found(record, out);
    judge_ends(record, out);
    judge_points(record, out);
    judge_manners(record, out);
}
