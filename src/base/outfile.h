/** @file
 * Where an output's bytes go: to a file that gets its name when it is complete
 * or when it begins, or directly to an output that is not a regular file.
 * Internal.
 *
 * Until a file has its name it is `NAME.0123456789ab.part` beside that name,
 * with a number that no other file has, and is locked. While an output is open
 * nobody else may write one of its name (base/claim.h). */
#ifndef LUM_BASE_OUTFILE_H
#define LUM_BASE_OUTFILE_H

#include "base/claim.h"
#include "lum/base/error.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

/** When a file gets its name. */
typedef enum lum_outfile_kind {
    LUM_OUTFILE_WHOLE, /**< by lum_outfile_finish() */
    LUM_OUTFILE_GROWS  /**< by lum_outfile_show(), and then it stays */
} lum_outfile_kind;

/** An output that is open. */
typedef struct lum_outfile {
    char *name;       /**< as the caller gave it, for messages */
    char *path;       /**< its final name; NULL: written in place */
    char *part;       /**< its present name, while it is another */
    int fd;           /**< to write to */
    bool seekable;    /**< a regular file, not opened to append */
    bool may_block;   /**< not a regular file: its reader may be slow */
    bool never_waits; /**< a write to it takes what there is room for */
    int64_t base;     /**< offset of our first byte; 0 if not seekable */
    dev_t device;     /**< of the file made, to know it again */
    ino_t inode;      /**< likewise */
    size_t unstarted; /**< bytes not yet on their way to the disk */
    int64_t written;  /**< bytes, as lum_outfile_wrote() was told */
    int64_t reserved; /**< places on the disk end there; 0: there are none */
    bool takes_none;  /**< places cannot be had, or no more of them */
    bool grows;       /**< it was made as a LUM_OUTFILE_GROWS */
    bool owes_name;   /**< it has its name, perhaps not yet on the disk */
    bool is_older;    /**< a file that was there, to be emptied when shown */
    lum_claim claim;  /**< to its name */
} lum_outfile;

/** Open an output. An existing file does not change until it is replaced. The
 * new file gets its mode and, if this process may set it, its owner; links to
 * files are followed. If no growing file can be made because its directory is
 * not writable, lum_outfile_show() empties the existing one, and until then
 * nothing may be written.
 * @param path its name, or "-" for standard output, which is duplicated.
 * @param out  written only on success.
 * @return 0, or -1 with the reason in error and in errno: EBUSY if another
 *         process, or another output of this one, writes it. */
LUM_MUST_CHECK int lum_outfile_open(const char *path, lum_outfile_kind kind,
                                    lum_outfile *out, lum_error *error);

/** Give it its name before it is complete, if it has another. From then on the
 * file stays, even if the rest fails. Does not wait for the disk; only
 * lum_outfile_finish() makes sure that the name is there.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_outfile_show(lum_outfile *file, lum_error *error);

/** Whether its file still has the name that it was given: others may remove or
 * rename it, or its directory, while it is written. Not while another thread
 * uses the output. On a system without /proc a removed file cannot be told from
 * a renamed one; on Windows nothing is looked at.
 * @return 0, also for what is written directly; -1 with what became of it in
 *         error, and ENOENT in errno: then writing goes on. */
LUM_MUST_CHECK int lum_outfile_check(const lum_outfile *file, lum_error *error);

/** Report that n more bytes were written, so that the disk can begin with them
 * while the caller makes more. */
void lum_outfile_wrote(lum_outfile *file, size_t n);

/** Close it, give it its name when its bytes are on the disk, and wait until
 * the name is there too. Outputs that are written directly are only closed.
 *
 * A file that was renamed meanwhile stays where it is. One that was removed, or
 * replaced, is put back where Linux can do that: a file that is not wanted is
 * soon removed again, and bytes that are gone do not come back. It gets its
 * name if that is free, else NAME.recovered, and replaces no other file. If it
 * has another link, it gets one more; else its bytes are copied, with 64 KiB of
 * memory, for as long as that takes. A copy whose names are both taken, or that
 * cannot be linked, keeps NAME.0123456789ab.part. Where nothing can be put
 * back, because the directory is gone or the disk is full, the bytes are lost
 * when this returns, and nothing else is left. All of this is a failure.
 *
 * Call lum_outfile_discard() after it.
 * @return 0, or -1 with the reason in error and in errno; ENOENT if the file
 *         was removed or renamed: error says where its bytes are now, or that
 *         they are lost, and why. */
LUM_MUST_CHECK int lum_outfile_finish(lum_outfile *file, lum_error *error);

/** Free it; a file without its name is removed. errno stays. */
void lum_outfile_discard(lum_outfile *file);

/** Write bytes to a file that stands under its name only when it is whole.
 * @param path as for lum_outfile_open().
 * @return 0, or -1 with the reason in error and in errno: EPIPE if its reader
 *         has left. */
int lum_outfile_save(const char *path, const void *bytes, size_t n,
                     lum_error *error);

/** The same, but its name waits for lum_outfile_finish(); call
 * lum_outfile_discard() after it. On -1 nothing is left to do. */
int lum_outfile_begin(const char *path, const void *bytes, size_t n,
                      lum_outfile *out, lum_error *error);

/** Make the message what failed, and why; leave code in errno.
 * @param code an errno.
 * @return -1. */
int lum_outfile_fail(const lum_outfile *file, int code, const char *doing,
                     lum_error *error);

#endif
