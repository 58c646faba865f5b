/* The files of an output with --rotate and --keep: which of them are its own,
 * also of earlier runs, and which of those are to go.
 *
 * They are listed in `.NAME.EXT.kept.lumsdk` beside them (ledger.h). A number
 * is in the list, on the disk, before a file of this number is begun, and no
 * file is begun under a name that exists. Numbers go on from the highest in the
 * list, or from 1, over names that exist: no file is replaced, also after the
 * list was lost. Only what is listed is removed, and only while it has the size
 * that was written; another file of the same size under the same name is not
 * told apart.
 *
 * The names belong to the recorder: after a kill, a regular file under a number
 * that was listed as begun is taken for the one that the killed run wrote,
 * unless that is still unfinished. It is not known who made it. The caller has
 * the right to the output's name (base/claim.h), so nobody else changes the
 * list.
 *
 * One thread begins files, another may finish them and wait for the disk. */
#ifndef LUMDUMP_RETENTION_H
#define LUMDUMP_RETENTION_H

#include "options.h"

#include "lum/base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define RETENTION_NOTES 3u

struct retention;

struct retention_counts {
    bool is_used;     /* the output has --keep */
    uint64_t removed; /* files */
    uint64_t stuck;   /* that were to go at last, and could not be removed */
};

/* Read the list of an output NAME.EXT, remove what is over the limit and what a
 * killed run has left unfinished, and list the number of the first file.
 * limit: bytes or ns; the other is 0. 0, or -1 with the reason in error and
 * errno. */
int retention_open(const char *name, const struct rotation *limit,
                   struct retention **out, lum_error *error);

/* List the number of the next file, unless that was done. Waits for the disk.
 * 0, or -1 with the reason in error and errno. */
int retention_plan(struct retention *retention, lum_error *error);

/* Whether that was done. Does not wait for it. */
bool retention_is_planned(struct retention *retention);

/* The number of a file to be begun now. One that is planned is taken at once,
 * also while another thread waits for the disk. Only if none is, or if others
 * have made a file of its name, is one planned here. 0, or -1 with the reason
 * in error and errno. */
int retention_begin(struct retention *retention, unsigned *number,
                    lum_error *error);

/* A file was finished: list its size, and remove what is over the limit. Waits
 * for the disk.
 * last_ns: the time of its last data, since 1970. 0, or -1 with the reason in
 * error and errno, which is not ENOENT. */
int retention_finish(struct retention *retention, unsigned number,
                     int64_t last_ns, lum_error *error);

/* What happened to files, each kind once. Does not wait. False: nothing more.
 */
bool retention_take_note(struct retention *retention, lum_error *out);

/* Does not wait. */
void retention_count(struct retention *retention, struct retention_counts *out);

/* Free it. Numbers without a file are taken from the list. NULL is allowed. */
void retention_close(struct retention *retention);

#endif
