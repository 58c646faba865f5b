/* What stories of a recording share. */
#ifndef STORIES_BENCH_H
#define STORIES_BENCH_H

#include "user.h"

#define LIVE   "lumdump udp://10.42.0.37"
#define RECORD LIVE " --laser"

/* Until a file that is written holds so much, whether it has its name yet or
 * not. */
void until_data(const user_bench *b, const char *name, int64_t least);

/* What came later than now. */
void until_more(const user_bench *b, const char *name, int64_t more);

/* lumdump's JSON of a recording. */
const char *summary_of(const user_bench *b, const char *name);

/* All that came is in the recording, which is output number i of a summary. */
void expect_whole(const user_bench *b, const char *live, unsigned i,
                  const char *name);

/* Each number and text of the recording's summary is that of the live run, but
 * for those that only one of them can have. */
void expect_same_summary(const char *live, const char *recorded);

/* No file that was begun is left. */
void expect_no_parts(const user_bench *b);

/* It came up, and went down by a command. */
void expect_laser_on_and_off(const user_sensor *s);

/* Rows of a CSV. */
int64_t rows_of(const user_bench *b, const char *name);

#endif
