/** @file
 * What writer.c and the formats share. Internal to cloud and picture. */
#ifndef LUM_CLOUD_WRITER_INTERNAL_H
#define LUM_CLOUD_WRITER_INTERNAL_H

#include "sink.h"

#include "lum/cloud/writer.h"

/** One file format. */
struct lum_format_ops {
    const char *name;     /**< for messages */
    const char *ending;   /**< of file names, with its dot, in lower case */
    bool count_in_header; /**< known beforehand, or patched at the end */
    /** Write the header. May set lum_writer.state. */
    int (*begin)(lum_writer *writer, lum_error *error);
    /** Write a line's rows; never called for none. */
    int (*add)(lum_writer *writer, const lum_line_samples *line,
               lum_error *error);
    /** Write what comes last, patch the header; may be NULL. */
    int (*finish)(lum_writer *writer, lum_error *error);
    /** Free what state holds, then state is freed; may be NULL. */
    void (*release)(lum_writer *writer);
};

extern const lum_format_ops lum_csv_ops; /**< csv.c */
extern const lum_format_ops lum_ply_ops; /**< ply.c */
extern const lum_format_ops lum_pcd_ops; /**< pcd.c */
extern const lum_format_ops lum_las_ops; /**< las.c */
extern const lum_format_ops lum_xyz_ops; /**< xyz.c */

/** A writer; the formats read it and set state alone. */
struct lum_writer {
    const lum_format_ops *ops;  /**< the format */
    lum_writer_options options; /**< its pointers, but comment, are valid only
                                     in begin() */
    char *comment;              /**< the same; NULL: none */
    lum_sink *sink;             /**< where bytes go */
    uint64_t points;            /**< added so far */
    uint64_t rehearsed;         /**< points that the rehearsal took */
    bool was_rehearsed;         /**< whether there was one */
    bool rehearses;             /**< whether this is one */
    void *state;                /**< the format's, from malloc(), or NULL */
    bool failed;                /**< a call has failed; nothing may follow */
    int failure_code;           /**< errno of that */
    lum_error failure;          /**< text of that */
};

/** Write rows of n samples at p, which has room for them.
 * @return the end of what was written. */
typedef char *lum_put_rows(char *p, void *context, const lum_sample *samples,
                           size_t n);

/** Put a line's rows into the sink, a batch at a time.
 * @param room bytes that a row may take at most, up to 1024.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_writer_put(lum_writer *writer,
                                  const lum_line_samples *line, size_t room,
                                  lum_put_rows *put, void *context,
                                  lum_error *error);

/** Write the lines of the comment, if there is one, each behind a "# ". */
LUM_MUST_CHECK int lum_writer_put_comment(lum_writer *writer, lum_error *error);

/** Allocate lum_writer.state, zeroed.
 * @return it, or NULL with the reason in error and in errno. */
LUM_MUST_CHECK void *lum_writer_new_state(lum_writer *writer, size_t n,
                                          lum_error *error);

#endif
