/** @file
 * What writer.c and the formats share. Internal to cloud and picture. */
#ifndef LUM_CLOUD_WRITER_INTERNAL_H
#define LUM_CLOUD_WRITER_INTERNAL_H

#include "file_columns.h"
#include "presets.h"
#include "sink.h"

#include "lum/cloud/writer.h"

/** One file format. */
struct lum_format_ops {
    const char *name;     /**< for messages */
    const char *ending;   /**< of file names, with its dot, in lower case */
    bool count_in_header; /**< known beforehand, or patched at the end */
    const lum_column_list *columns; /**< those of its own; NULL: not to be
                                         chosen */
    bool can_organize;              /**< takes rows of a frame */
    bool has_parts; /**< a line's rows depend on nothing else: part.h */
    /** Write the header. May set lum_writer.state. Of an organised file, when
     * its rows are known. */
    int (*begin)(lum_writer *writer, lum_error *error);
    /** Write a line's rows; never called for none. */
    int (*add)(lum_writer *writer, const lum_line_samples *line,
               lum_error *error);
    /** A frame begins, ends; a status or a datagram comes; what was added is to
     * be shown to readers, by lum_sink_flush() at the end. Each may be NULL. */
    int (*begin_frame)(lum_writer *writer, int64_t utc_ns, lum_error *error);
    int (*end_frame)(lum_writer *writer, lum_error *error); /**< see above */
    int (*add_status)(lum_writer *writer, const lum_writer_status *status,
                      lum_error *error); /**< see above */
    int (*add_datagram)(lum_writer *writer, const lum_writer_datagram *datagram,
                        lum_error *error);              /**< see above */
    int (*flush)(lum_writer *writer, lum_error *error); /**< see above */
    /** Write what comes last, patch the header; may be NULL. */
    int (*finish)(lum_writer *writer, lum_error *error);
    /** Free what state holds, then state is freed; may be NULL. */
    void (*release)(lum_writer *writer);
};

extern const lum_format_ops lum_csv_ops;  /**< csv.c */
extern const lum_format_ops lum_ply_ops;  /**< ply.c */
extern const lum_format_ops lum_pcd_ops;  /**< pcd.c */
extern const lum_format_ops lum_las_ops;  /**< las.c */
extern const lum_format_ops lum_xyz_ops;  /**< xyz.c */
extern const lum_format_ops lum_mcap_ops; /**< mcap.c */

/** A writer; the formats read it and set state alone. */
struct lum_writer {
    const lum_format_ops *ops;  /**< the format */
    lum_writer_options options; /**< its pointers, but comment, are valid only
                                     in begin() */
    char *comment;              /**< the same; NULL: none */
    lum_sink *sink;             /**< where bytes go */
    lum_column_list columns;    /**< of the file */
    bool has_chosen;            /**< whether these were asked for */
    const lum_preset *preset;   /**< of points; NULL: columns are */
    bool has_rows;              /**< organised: rows are known */
    uint32_t rows;              /**< organised: lines to come in all */
    uint64_t points;            /**< added so far */
    uint64_t rehearsed;         /**< points that the rehearsal took */
    bool was_rehearsed;         /**< whether there was one */
    bool rehearses;             /**< whether this is one */
    bool is_part;               /**< of a file, in memory: part.h */
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

/** Put a line's rows into the sink, of columns that were asked for. */
LUM_MUST_CHECK int lum_writer_put_chosen(lum_writer *writer,
                                         const lum_line_samples *line,
                                         bool is_text, char separator,
                                         lum_error *error);

/** How many columns the file has, of the list or of the preset. */
unsigned lum_writer_column_count(const lum_writer *writer);

/** One of them. */
lum_file_column_spec lum_writer_column(const lum_writer *writer, unsigned i);

/** Write the lines of the comment, if there is one, each behind a "# ". */
LUM_MUST_CHECK int lum_writer_put_comment(lum_writer *writer, lum_error *error);

/** Allocate lum_writer.state, zeroed.
 * @return it, or NULL with the reason in error and in errno. */
LUM_MUST_CHECK void *lum_writer_new_state(lum_writer *writer, size_t n,
                                          lum_error *error);

#endif
