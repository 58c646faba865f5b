/** @file
 * What a file format does, and the table of all. Internal to cloud and
 * picture. */
#ifndef LUM_CLOUD_FORMATS_H
#define LUM_CLOUD_FORMATS_H

#include "file_columns.h"

#include "lum/cloud/writer.h"

/** The text of a header. */
typedef struct lum_cloud_text {
    char *at;    /**< its NUL included */
    size_t len;  /**< bytes without it */
    size_t room; /**< bytes with it */
} lum_cloud_text;

/** One file format. */
struct lum_format_ops {
    const char *name;     /**< for messages */
    const char *ending;   /**< of file names, with its dot, in lower case */
    bool count_in_header; /**< known beforehand, or patched at the end */
    const lum_column_list *columns; /**< those of its own; NULL: not to be
                                         chosen */
    bool can_organize;              /**< takes rows of a frame */
    bool has_parts; /**< a line's rows depend on nothing else: part.h */
    /** Append a header that lum_cloud_begin() and lum_cloud_finish() write.
     * @param padding characters that some comment has to be longer. */
    void (*header)(lum_cloud_text *out, const lum_writer *writer,
                   uint64_t count, int padding);
    unsigned mentions; /**< how many times that holds the count */
    /** Write the header. May set lum_writer.state. Of an organised file, when
     * its rows are known. */
    int (*begin)(lum_writer *writer, lum_error *error);
    /** Write a line's rows; never called for none. */
    int (*add)(lum_writer *writer, const lum_line_samples *line,
               lum_error *error);
    /** A frame begins, ends; the next are of this sensor; a status or a
     * datagram comes; what was added is to
     * be shown to readers, by lum_sink_flush() at the end. Each may be NULL. */
    int (*begin_frame)(lum_writer *writer, int64_t utc_ns, lum_error *error);
    int (*end_frame)(lum_writer *writer, lum_error *error); /**< see above */
    int (*set_sensor)(lum_writer *writer, size_t sensor,
                      lum_error *error); /**< see above */
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
extern const lum_format_ops lum_ply_ops;  /**< ply_pcd.c */
extern const lum_format_ops lum_pcd_ops;  /**< ply_pcd.c */
extern const lum_format_ops lum_las_ops;  /**< las.c */
extern const lum_format_ops lum_xyz_ops;  /**< xyz.c */
extern const lum_format_ops lum_mcap_ops; /**< mcap.c */

/** The format of a file; NULL: no format has that number. */
const lum_format_ops *lum_format_find(const lum_writer_options *options);

#endif
