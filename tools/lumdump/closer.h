/* Finishes the files of a live output in a separate thread. That thread waits
 * for the disk for any time, and the thread that fills the files does not wait.
 * Files are finished one after another, in the order of arrival. One that
 * others removed or renamed is told, and is a failure only at the end. */
#ifndef LUMDUMP_CLOSER_H
#define LUMDUMP_CLOSER_H

#include "output_file.h"
#include "retention.h"

#include <stdbool.h>
#include <stddef.h>

#define CLOSER_ROOM_MAX 16u

struct closer;

/* What is to be finished. */
struct closing {
    struct output_file file;
    struct retention *retention; /* to be told of it; NULL: nobody is */
    int64_t last_ns;             /* for that: the time of its end */
};

/* Finish it here. 0, or -1 with the reason in error and errno. */
int closing_finish(const struct closing *closing, lum_error *error);

/* room: files that may wait, from 1 to CLOSER_ROOM_MAX. NULL with the reason in
 * error. */
struct closer *closer_new(size_t room, lum_error *error);

/* Whether closer_put() would not have to wait. */
bool closer_has_room(struct closer *closer);

/* Have it finished, once there is room. 0, or -1 with the reason in error and
 * errno of the first failure so far, which may be another file's; it is the
 * closer's either way. */
int closer_put(struct closer *closer, const struct closing *file,
               lum_error *error);

/* Have the beginning of a file brought to the disk, before what waits. copy: of
 * lum_capture_writer_copy(), and the closer's from then on; -1: nothing. name:
 * for a failure, which is as that of closer_put(). Does not wait. */
void closer_sync(struct closer *closer, int copy, const char *name);

/* Have retention_plan() called, before what waits. A failure is as that of
 * closer_put(). Does not wait. False: there is no thread for it. */
bool closer_plan(struct closer *closer, struct retention *retention);

/* The first failure so far: 0, or -1 with the reason in error and errno. */
int closer_check(struct closer *closer, lum_error *error);

/* What became of the next file that others removed or renamed. Any thread's.
 * False: none now, or somebody is in closer_wait(), which gives the first. */
bool closer_take_lost(struct closer *closer, lum_error *out);

/* Wait until all is finished; then as closer_check(), or -1 with ENOENT in
 * errno and what became of the first file that was lost. */
int closer_wait(struct closer *closer, lum_error *error);

/* Whether somebody waits for it now. Any thread's. */
bool closer_is_waited_for(struct closer *closer);

/* Waits until its files are finished. NULL is allowed. */
void closer_free(struct closer *closer);

#endif
