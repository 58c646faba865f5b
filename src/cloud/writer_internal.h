/** @file
 * An open writer, and what formats write with. Internal to cloud and
 * picture. */
#ifndef LUM_CLOUD_WRITER_INTERNAL_H
#define LUM_CLOUD_WRITER_INTERNAL_H

#include "formats.h"
#include "presets.h"
#include "sink.h"
#include "text_columns.h"

/** What a writer is for. */
typedef enum lum_writer_use {
    LUM_WRITER_FILE,      /**< to write one */
    LUM_WRITER_REHEARSAL, /**< to count, before the same is written */
    LUM_WRITER_PART       /**< of a file, in memory: part.h */
} lum_writer_use;

/** A writer; the formats read it and set state alone. */
struct lum_writer {
    lum_writer_use use;         /**< what it is for */
    const lum_format_ops *ops;  /**< the format */
    lum_writer_options options; /**< its pointers, but comment, are valid only
                                     in begin() */
    char *comment;              /**< the same; NULL: none */
    lum_sink *sink;             /**< where bytes go */
    lum_column_list columns;    /**< of the file */
    lum_extras extras;          /**< columns of the caller's own */
    bool has_chosen;            /**< whether other columns than the format's
                                     are asked for, extras behind them aside */
    const lum_preset *preset;   /**< of points; NULL: columns are */
    bool has_rows;              /**< organised: rows are known */
    uint32_t rows;              /**< organised: lines to come in all */
    uint64_t points;            /**< added so far */
    uint64_t rehearsed;         /**< points that the rehearsal took */
    bool was_rehearsed;         /**< whether there was one */
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
 * @param room bytes that a row may take at most, up to LUM_FILE_ROW_ROOM.
 * @return 0, or -1 with the reason in error and in errno. */
LUM_MUST_CHECK int lum_writer_put(lum_writer *writer,
                                  const lum_line_samples *line, size_t room,
                                  lum_put_rows *put, void *context,
                                  lum_error *error);

/** A line's columns as text, and those of the caller's own. */
typedef struct lum_writer_text {
    lum_text_line line;                         /**< what rows share */
    char tail[LUM_EXTRAS_ROOM + LUM_TAIL_COPY]; /**< as lum_text_line.tail */
} lum_writer_text;

/** Begin a line of the format's columns, with the extras behind them.
 * @return false if other columns are asked for, or extras differ from row to
 *         row: lum_writer_put_chosen() writes such lines, more slowly. */
bool lum_writer_text_begin(lum_writer_text *out, const lum_writer *writer,
                           const lum_line_samples *line, char separator);

/** Bytes that a row of lum_writer_text may take. */
#define LUM_WRITER_TEXT_ROOM (LUM_TEXT_ROW_ROOM + LUM_EXTRAS_ROOM)

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
