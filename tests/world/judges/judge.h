/* The judges: each looks at a record and says where its rules are broken. None
 * knows how the tools work inside. Where a number comes from stands beside it.
 */
#ifndef WORLD_JUDGE_H
#define WORLD_JUDGE_H

#include "record.h"
#include "verdict.h"

/* At the end of a run, or at any time before: what goes on is not judged. */
void judge_laser_late(const struct record *record, struct verdict *out);
void judge_laser_asked(const struct record *record, struct verdict *out);
void judge_done(const struct record *record, struct verdict *out);
void judge_limits(const struct record *record, struct verdict *out);
void judge_fates(const struct record *record, struct verdict *out);
void judge_counts(const struct record *record, struct verdict *out);
void judge_status(const struct record *record, struct verdict *out);
void judge_owners(const struct record *record, struct verdict *out);
void judge_requests(const struct record *record, struct verdict *out);
void judge_lines(const struct record *record, struct verdict *out);
void judge_times(const struct record *record, struct verdict *out);
void judge_found(const struct record *record, struct verdict *out);
void judge_ends(const struct record *record, struct verdict *out);
void judge_points(const struct record *record, struct verdict *out);
void judge_manners(const struct record *record, struct verdict *out);

/* The laser of one device as it goes. Until a moment: what was not said by then
 * did not happen. Due: when it is late if nothing comes. */
typedef struct judge_watch {
    int64_t beat_ns;
    bool has_beat, is_up, is_told;
} judge_watch;
void judge_watch_line(judge_watch *watch, const record_line *line,
                      struct verdict *out);
void judge_watch_until(judge_watch *watch, int64_t t_ns, struct verdict *out);
int64_t judge_watch_due(const judge_watch *watch);
/* The laser has come on, at a line of its log. */
void judge_rise(const record_device *device, size_t line, struct verdict *out);
/* A datagram was sent, or has come to its end. */
void judge_on_sent(const struct record *record, const record_datagram *datagram,
                   struct verdict *out);
void judge_fate(const record_datagram *datagram, struct verdict *out);

/* All of them. Then, at the very end, whether they had ground to stand on. */
void judge_ground(const struct record *record, struct verdict *out);
void judge_all(const struct record *record, struct verdict *out);

/* What stands under a file's name, at a moment. is_final: the program that
 * writes it has ended by itself; if not, a recording may break off. */
typedef struct judge_file {
    const char *name;
    const uint8_t *bytes;
    size_t size;
    int64_t t_ns;
    bool is_final;
} judge_file;

/* At the end: the names in a host's folder, NULL behind the last. */
void judge_left(const struct record *record, unsigned host,
                const char *const *names, struct verdict *out);

void judge_whole(const judge_file *file, struct verdict *out);

/* What a recording holds against what its program read. writer: an index of the
 * record's tools. cut: what was not on the disk yet is lost. */
void judge_recording(const struct record *record, size_t writer,
                     const judge_file *file, struct verdict *out);

/* The points of a file against what its program read. A 0 stands behind the
 * bytes. */
void judge_cloud(const struct record *record, size_t writer,
                 const judge_file *file, struct verdict *out);

#endif
