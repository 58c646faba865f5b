#include "bench.h"

#include <string.h>

/* Keys of a summary that count what came, in any run. */
static const char *const counted[] = {
    "records",    "data",          "tlv",
    "lines",      "words",         "points",
    "lost_words", "lines_skipped", "malformed",
    "foreign",    "late",          "stray",
    "conflict",   "frames",        "lines_missing_angles"};

void until_data(const user_bench *b, const char *name, int64_t least)
{
    user_until(user_size_of(b->host, name) > least);
}

void until_more(const user_bench *b, const char *name, int64_t more)
{
    until_data(b, name, user_size_of(b->host, name) + more);
}

const char *summary_of(const user_bench *b, const char *name)
{
    user_tool *look = user_run(b->host, "lumdump %s --json", name);
    user_expect_status(look, 0);
    return user_out(look);
}

void expect_same_summary(const char *live, const char *recorded)
{
    for (size_t i = 0; i < sizeof counted / sizeof *counted; i++) {
        const char *wanted = user_value(recorded, counted[i]);
        if (wanted != NULL) {
            const char *got = user_value(live, counted[i]);
            user_expect_same(
                user_format("%s %s", counted[i], got != NULL ? got : ""),
                user_format("%s %s", counted[i], wanted));
        }
    }
}

void expect_whole(const user_bench *b, const char *live, unsigned i,
                  const char *name)
{
    const char *recorded = summary_of(b, name);
    user_expect_equal(user_number(live, "recording_drops"), 0);
    user_expect_same(user_value(live, user_format("outputs.%u.end", i)),
                     "done");
    user_expect_equal(user_number(live, user_format("outputs.%u.dropped", i)),
                      0);
    user_expect_equal(user_number(live, user_format("outputs.%u.datagrams", i)),
                      user_number(live, "received"));
    user_expect_equal(user_number(recorded, "records"),
                      user_number(live, "received"));
    expect_same_summary(live, recorded);
}

void expect_no_parts(const user_bench *b)
{
    user_expect_equal(user_files(b->host, "", ".part"), 0);
}

void expect_laser_on_and_off(const user_sensor *s)
{
    user_expect_equal(user_laser_rises(s), 1);
    user_expect(!user_laser_is_on(s));
    user_expect_at_least(user_heard(s, "d"), 1);
}

int64_t rows_of(const user_bench *b, const char *name)
{
    return (int64_t)user_count(user_file(b->host, name), "\n") - 1;
}
