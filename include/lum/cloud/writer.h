/** @file
 * Point clouds to files: CSV, PLY, PCD, LAS, XYZ, MCAP, and, with the format of
 * lum/picture/picture.h, a picture as PNG (docs/formats.md).
 *
 * Only one thread at a time may use a writer. The writer starts a thread, which
 * writes its 3 blocks of 1 MiB. */
#ifndef LUM_CLOUD_WRITER_H
#define LUM_CLOUD_WRITER_H

#include "lum/base/error.h"
#include "lum/points.h"
#include "lum/pose.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* --- Formats --- */

/** File formats. */
typedef enum lum_format {
    LUM_FORMAT_CSV, /**< text, a header line, all columns */
    LUM_FORMAT_PLY, /**< binary little-endian or ascii */
    LUM_FORMAT_PCD, /**< version 0.7, binary or ascii */
    LUM_FORMAT_LAS, /**< version 1.4, point format 6, extra bytes */
    LUM_FORMAT_XYZ, /**< text, only x y z */
    LUM_FORMAT_PNG, /**< a picture: a bird's-eye view and an image of both eyes;
                         needs lum_writer_options.picture */
    LUM_FORMAT_MCAP, /**< messages of ROS 2, a cloud for each frame */
    LUM_FORMATS      /**< how many there are */
} lum_format;

/** The format by the ending of a file name, in upper or lower case.
 * @return 0, or -1 if the ending is of no format. */
LUM_MUST_CHECK int lum_format_from_name(const char *name, lum_format *out);

/** Whether the format's header contains the number of points. Then the output
 * must be seekable, or a rehearsal must come first (lum_writer_rehearse()). */
bool lum_format_needs_count(lum_format format);

/** Whether a file of the format has a message for each frame. Then
 * lum_writer_begin_frame() gives its time, and lum_writer_end_frame() ends it,
 * even without points. */
bool lum_format_has_frames(lum_format format);

/** How a format is written, for formats that are libraries of their own. */
typedef struct lum_format_ops lum_format_ops;

/** The messages of an MCAP file: frames or lines, or datagrams, or datagrams
 * and one of the others. A preset needs frames. lum_writer_open() refuses any
 * other choice with EINVAL. */
typedef enum lum_mcap_content {
    LUM_MCAP_OF_FRAMES = 1,   /**< a cloud for each frame */
    LUM_MCAP_OF_LINES = 2,    /**< a cloud for each line of it, instead */
    LUM_MCAP_OF_DATAGRAMS = 4 /**< lum_writer_add_datagram() */
} lum_mcap_content;

/** Most bytes of lum_mcap_options.frame_id. */
#define LUM_MCAP_FRAME_ID_MAX 200u

/** Most lines of a frame that have rings, those of both eyes. */
#define LUM_MCAP_LINES_MAX 32767u

/** Most sensors of an MCAP file. */
#define LUM_MCAP_SENSORS_MAX 8u

/** One of several sensors of an MCAP file. It never grows, because it is used
 * in arrays. */
typedef struct lum_mcap_sensor {
    const char *topic;    /**< of its clouds, such as "/front/points"; not
                               copied: it must live as long as the writer and
                               what lum_writer_mcap_info() gave */
    const char *frame_id; /**< of its messages, such as "front"; as
                               lum_mcap_options.frame_id, and copied */
    const lum_pose *pose; /**< where frame_id is in that of the options, written
                               to /tf_static; NULL: not written */
    const lum_calibration *calibration; /**< its mounts are written there too;
                                             NULL: not written */
    const char *calibration_yaml; /**< an attachment, calibration-FRAME_ID.yaml;
                                       NULL or empty: none */
    const char *profile_yaml;     /**< likewise, profile-FRAME_ID.yaml */
} lum_mcap_sensor;

/** Options of an MCAP file. All bytes 0 except struct_size are the defaults. */
typedef struct lum_mcap_options {
    size_t struct_size;   /**< sizeof(lum_mcap_options) */
    const char *frame_id; /**< of all messages, 1 to LUM_MCAP_FRAME_ID_MAX
                               bytes; NULL: "luminar" */
    const lum_calibration *calibration; /**< its mounts are written to
                                             /tf_static; NULL: not written */
    const char *calibration_yaml; /**< an attachment, calibration.yaml; NULL or
                                       empty: none */
    const char *profile_yaml;     /**< likewise, profile.yaml */
    bool is_plain;   /**< chunks are not compressed, even if this build could */
    bool is_growing; /**< a recording: the file has its name from its first
                          chunk on, and stays even if the rest fails */
    unsigned contents; /**< some of ::lum_mcap_content; 0: frames */
    uint32_t lines;    /**< of a frame: the green eye's rings begin at this
                            number, and lines beyond have no ring; at most
                            LUM_MCAP_LINES_MAX; 0: taken from the frames */
    const lum_mcap_sensor *sensors; /**< sensor_count of them: each has a topic
                            and a frame of its own, and calibration above is not
                            read; NULL: one sensor, with the topic /points */
    size_t sensor_count;            /**< at most LUM_MCAP_SENSORS_MAX */
} lum_mcap_options;

/** Most columns of lum_writer_options.extra. */
#define LUM_WRITER_EXTRA_MAX 32u

/** Most bytes of the name of one. */
#define LUM_WRITER_EXTRA_NAME_MAX 31u

/** Types of numbers. */
typedef enum lum_number_type {
    LUM_NUMBER_U8,   /**< uint8_t */
    LUM_NUMBER_U16,  /**< uint16_t */
    LUM_NUMBER_U32,  /**< uint32_t */
    LUM_NUMBER_U64,  /**< uint64_t; CSV and LAS */
    LUM_NUMBER_I8,   /**< int8_t */
    LUM_NUMBER_I16,  /**< int16_t */
    LUM_NUMBER_I32,  /**< int32_t */
    LUM_NUMBER_I64,  /**< int64_t; CSV and LAS */
    LUM_NUMBER_F32,  /**< float */
    LUM_NUMBER_F64,  /**< double */
    LUM_NUMBER_TYPES /**< how many there are */
} lum_number_type;

/** A column of the caller's own. It never grows, because it is used in
 * arrays. */
typedef struct lum_writer_extra {
    const char *name;     /**< 1 to LUM_WRITER_EXTRA_NAME_MAX bytes: letters,
                               digits and _, no digit first; not the name of
                               another column or extra */
    lum_number_type type; /**< of its values */
} lum_writer_extra;

/** Most rows of an organised file. */
#define LUM_WRITER_ROWS_MAX 1000000u

/** Most bytes of lum_writer_options.comment. */
#define LUM_WRITER_COMMENT_BYTES_MAX 60000u

/** Most bytes of a line of it. */
#define LUM_WRITER_COMMENT_LINE_MAX 400u

/* --- Options and lines --- */

/** Options of a writer. All bytes 0 except struct_size are the defaults. */
typedef struct lum_writer_options {
    size_t struct_size; /**< sizeof(lum_writer_options) */
    lum_format format;  /**< which */
    bool ascii;         /**< PLY, PCD: text instead of binary */
    bool utc;           /**< timestamps are microseconds since 1970 UTC instead
                             of the sensor clock */
    const struct lum_writer *rehearsal; /**< NULL, or a writer of
                                             lum_writer_rehearse() that has
                                             taken the same lines. Only
                                             lum_writer_open() reads it */
    const lum_projector *projector;     /**< unused */
    const lum_format_ops *picture;      /**< PNG: lum_picture_format(); other
                                             formats ignore it */
    const char *comment; /**< NULL, or more text for the header, for example
                              where the points come from: lines of printable
                              ASCII; copied. They become comments of PLY and
                              PCD, a record of LAS, and lines that begin with #
                              in CSV and XYZ, which many readers of these
                              formats do not skip. PNG has no place for it */
    const char *columns; /**< CSV, PLY, PCD: the columns in their order, by
                              their names in CSV with commas between them, such
                              as "x,y,z,time"; NULL: those of the format. Read
                              by lum_writer_open() and lum_writer_rehearse() */
    bool organized; /**< PCD: one frame as an image of LUM_LINE_PIXELS columns;
                         see lum_writer_set_rows() */
    const lum_mcap_options *mcap; /**< MCAP; NULL: the defaults. Read by
                                       lum_writer_open() and
                                       lum_writer_rehearse() */
    const char *preset; /**< CSV, PLY, PCD, MCAP: the fields of points that a
                             consumer reads, such as "autoware"
                             (docs/consumers.md), instead of columns; NULL:
                             none. Read as columns is */
    double origin[3];   /**< LAS: the origin of the samples' coordinates, which
                             becomes the file's offset; with voxels, PLY and PCD
                             name it in a comment. 0 for all other files, whose
                             comment may name it */
    bool voxels;        /**< CSV, PLY, PCD, LAS: samples are those of a map
                             (lum/map/map.h), with counts and times_ns, and the
                             columns are x, y, z, intensity, timestamp and
                             points, or what LAS has of these */
    const lum_writer_extra *extra; /**< CSV, PLY, PCD, LAS, MCAP: extra_count
                                        more columns, whose values
                                        lum_line_samples.extra has; copied. PNG
                                        reads one that is named label. They
                                        follow those of the format, or have the
                                        places that columns gives them; if
                                        columns does not name them, they are
                                        left out. Not with a preset or voxels */
    size_t extra_count;            /**< at most LUM_WRITER_EXTRA_MAX; 0: none */
    const struct lum_picture_options *drawing; /**< PNG: how it is drawn
                             (lum/picture/picture.h); NULL: the defaults. Read
                             by lum_writer_open() */
} lum_writer_options;

/** Whether this build can compress the chunks of an MCAP file. */
bool lum_mcap_can_compress(void);

/** Whether lum_writer_options.columns can choose the columns of a format. */
bool lum_format_has_columns(lum_format format);

/** Whether a format supports lum_writer_options.preset. */
bool lum_format_has_presets(lum_format format);

/** Whether a format supports lum_writer_options.voxels. */
bool lum_format_has_voxels(lum_format format);

/** Check names for lum_writer_options.columns.
 * @return 0, or -1 with the wrong name and the list of names in error; then
 *         errno is EINVAL. */
LUM_MUST_CHECK int lum_writer_check_columns(const char *names,
                                            lum_error *error);

/** Check lum_writer_options.extra together with columns.
 * @param format  of the file; LUM_FORMATS: check only the rules of all formats.
 * @param columns as in the options; may be NULL.
 * @return 0, or -1 with what is wrong, and the fix, in error: a name that is
 *         not allowed, repeated, or of another column; a type that the format
 *         cannot hold; a format that has no such columns; too many of them; a
 *         wrong name in columns. Then errno is EINVAL. */
LUM_MUST_CHECK int lum_writer_check_extra(lum_format format,
                                          const char *columns,
                                          const lum_writer_extra *extra,
                                          size_t count, lum_error *error);

/** The timestamp of a line that did not come; NaN in a PCD. */
#define LUM_TIMESTAMP_NONE INT64_MIN

/** The samples of one line. */
typedef struct lum_line_samples {
    size_t struct_size;        /**< sizeof(lum_line_samples) */
    const lum_sample *samples; /**< in order */
    size_t count;              /**< how many, may be 0 */
    int64_t frame;             /**< frame number */
    int64_t timestamp_us;      /**< of the line */
    uint32_t line;             /**< line number */
    uint8_t eye;               /**< an ::lum_eye */
    const float *times;        /**< of each sample, seconds from the beginning
                                    of its frame, as ::LUM_COLUMN_TIME; only for
                                    files with a column "time", else NULL */
    const uint32_t *counts;    /**< of voxels: points in each; EINVAL if NULL */
    const int64_t *times_ns;   /**< of voxels: the time of each, as
                                    timestamp_us, but nanoseconds; EINVAL if
                                    NULL */
    const void *const *extra;  /**< of each of lum_writer_options.extra: its
                                    values, one a sample, in the host's byte
                                    order and at any alignment; EINVAL if
                                    NULL */
} lum_line_samples;

/** A file being written. */
typedef struct lum_writer lum_writer;

/* --- Writing --- */

/** Begin a rehearsal: a writer that takes lines and writes nothing, so that a
 * second pass over them knows the values of its header. End it with
 * lum_writer_abort().
 * @param options copied; the same as those for writing the file.
 * @return 0, or -1 with the reason in error. */
LUM_MUST_CHECK int lum_writer_rehearse(const lum_writer_options *options,
                                       lum_writer **out, lum_error *error);

/** Begin a file.
 * @param path    its name, or "-" for standard output. A file is written under
 *                another name and renamed by lum_writer_close(), so that a file
 *                of this name is always complete.
 * @param options copied.
 * @return 0, or -1 with the reason in error: the directory is missing, no
 *         permission, another run is writing a file of that name (then errno is
 *         EBUSY), the header needs a count and there is neither a rehearsal nor
 *         an output that can seek, a PNG without lum_writer_options.picture,
 *         a comment that is not allowed, columns or an organised file that the
 *         format does not have, or a struct_size that is not set (then errno is
 *         EINVAL). */
LUM_MUST_CHECK int lum_writer_open(const char *path,
                                   const lum_writer_options *options,
                                   lum_writer **out, lum_error *error);

/** Begin the only frame of an organised file, before its first line. This
 * number of lines must follow, each with LUM_LINE_PIXELS samples, the i-th of
 * pixel i. x, y and z of a pixel without a point are NaN.
 * @param rows lines; at most LUM_WRITER_ROWS_MAX. A file that is closed without
 *             this call has none.
 * @return 0, or -1 with the reason in error: the file is not organised, or has
 *         begun, or there are too many rows (then errno is EINVAL), or as
 *         lum_writer_add(). */
LUM_MUST_CHECK int lum_writer_set_rows(lum_writer *writer, uint32_t rows,
                                       lum_error *error);

/** Append a line's samples; they are copied.
 * @return 0, or -1 with the reason in error (the disk is full, the reader of
 *         the pipe has left: then errno is EPIPE; the line lacks times, is not
 *         a row of an organised file, or its struct_size is not set: then errno
 *         is EINVAL). */
LUM_MUST_CHECK int lum_writer_add(lum_writer *writer,
                                  const lum_line_samples *line,
                                  lum_error *error);

/** Set which of lum_mcap_options.sensors the following frames are of; at first
 * it is sensor 0. Ends the current frame. Formats without frames ignore it.
 * @param sensor below their number; 0 if there are none.
 * @return as lum_writer_add(); EINVAL in errno if there is no such sensor. */
LUM_MUST_CHECK int lum_writer_set_sensor(lum_writer *writer, size_t sensor,
                                         lum_error *error);

/** Begin a frame, whose lines follow; ends the current frame. Formats without
 * frames ignore it. Without it a frame of an MCAP file begins with its first
 * line, and its time is that line's timestamp.
 * @param utc_ns its time, nanoseconds since 1970: that of points whose time is
 *               0.
 * @return as lum_writer_add(). */
LUM_MUST_CHECK int lum_writer_begin_frame(lum_writer *writer, int64_t utc_ns,
                                          lum_error *error);

/** End the frame that was begun: it becomes a message, also without points.
 * Ignored by formats without frames, and if no frame has begun. Without it a
 * frame ends with a line of another frame, or the file.
 * @return as lum_writer_add(). */
LUM_MUST_CHECK int lum_writer_end_frame(lum_writer *writer, lum_error *error);

/** The level of a status, as in diagnostic_msgs. */
typedef enum lum_status_level {
    LUM_STATUS_OK,    /**< as it should be */
    LUM_STATUS_WARN,  /**< something needs attention */
    LUM_STATUS_ERROR, /**< it does not work */
    LUM_STATUS_STALE  /**< nothing is known */
} lum_status_level;

/** A name and its value. It never grows, because it is used in arrays. */
typedef struct lum_status_value {
    const char *key;   /**< such as "lost_words" */
    const char *value; /**< such as "0" */
} lum_status_value;

/** The status of something at one time. */
typedef struct lum_writer_status {
    size_t struct_size;             /**< sizeof(lum_writer_status) */
    int64_t time_ns;                /**< since 1970 UTC */
    lum_status_level level;         /**< in short */
    const char *name;               /**< of what */
    const char *message;            /**< in words */
    const char *hardware_id;        /**< such as an address */
    const lum_status_value *values; /**< count of them */
    size_t count;                   /**< may be 0 */
} lum_writer_status;

/** Add a status, if the format is MCAP; the others ignore it.
 * @param status copied; its texts are not NULL.
 * @return as lum_writer_add(). */
LUM_MUST_CHECK int lum_writer_add_status(lum_writer *writer,
                                         const lum_writer_status *status,
                                         lum_error *error);

/** Most topics of an MCAP file. */
#define LUM_MCAP_TOPICS_MAX (LUM_MCAP_SENSORS_MAX + 3u)

/** A topic of an MCAP file. It never grows, because it is used in arrays. */
typedef struct lum_mcap_topic {
    const char *name;  /**< such as "/points"; static, except for
                            lum_mcap_sensor.topic */
    const char *type;  /**< such as "sensor_msgs/msg/PointCloud2" */
    const char *qos;   /**< its offered_qos_profiles, YAML */
    uint64_t messages; /**< so far */
} lum_mcap_topic;

/** What an MCAP file has so far. */
typedef struct lum_mcap_info {
    size_t struct_size; /**< sizeof(lum_mcap_info) */
    int64_t begin_ns;   /**< its earliest message, since 1970; 0: none */
    int64_t end_ns;     /**< its latest */
    uint64_t messages;  /**< of all topics */
    size_t topic_count; /**< of these: */
    lum_mcap_topic topics[LUM_MCAP_TOPICS_MAX]; /**< in the file's order */
} lum_mcap_info;

/** What an MCAP file has so far, as its index will say, with the frame that
 * ended last and all other messages. Do not call it during another call with
 * this writer.
 * @param out its struct_size is set by the caller.
 * @return 0, or -1 if it is of another format, or its struct_size is not
 *         set. */
LUM_MUST_CHECK int lum_writer_mcap_info(const lum_writer *writer,
                                        lum_mcap_info *out);

/** Most bytes of a datagram over IPv4. */
#define LUM_WRITER_DATAGRAM_BYTES_MAX 65507u

/** A datagram as it came. It never grows, since it is filled in for each
 * datagram. */
typedef struct lum_writer_datagram {
    int64_t time_ns;           /**< since 1970 UTC */
    const uint8_t *payload;    /**< its bytes */
    size_t len;                /**< how many; at most
                                    LUM_WRITER_DATAGRAM_BYTES_MAX */
    uint32_t source;           /**< address, host order */
    uint32_t destination;      /**< address, host order */
    uint16_t source_port;      /**< of it */
    uint16_t destination_port; /**< of it */
} lum_writer_datagram;

/** Add a datagram, if the file is an MCAP file of ::LUM_MCAP_OF_DATAGRAMS;
 * others ignore it. It becomes a message at once, also between the lines of a
 * frame (docs/formats.md, "MCAP").
 * @param datagram copied.
 * @return as lum_writer_add(); if it is too long, -1 with EINVAL in errno, and
 *         nothing can be added any more. */
LUM_MUST_CHECK int lum_writer_add_datagram(lum_writer *writer,
                                           const lum_writer_datagram *datagram,
                                           lum_error *error);

/** Bytes that were given to the output so far, without those that a format
 * keeps until its end. */
uint64_t lum_writer_bytes(const lum_writer *writer);

/** Begin to write what was added, for an output that is read while it is
 * written; does not wait. A chunk of an MCAP file ends with it. If a slow
 * reader has not yet taken earlier data, the rest stays: call again later. If
 * the reader has left, this is reported even if there is nothing to write.
 * @return as lum_writer_add(). */
LUM_MUST_CHECK int lum_writer_flush(lum_writer *writer, lum_error *error);

/** Check whether the file still has its name: others may remove or rename it,
 * or its directory, while it is written. Call this twice a second. If the name
 * is lost, writing goes on, and lum_writer_close() fails, too. On Windows
 * nothing is checked. While the file's thread is writing a block, this returns
 * what the thread saw after the previous block; it looks only from the first
 * call on.
 * @return 0, or -1; error says what happened to the file and where its data
 *         is. */
LUM_MUST_CHECK int lum_writer_check(lum_writer *writer, lum_error *error);

/** Finish the file, wait until it is on the disk, give it its name, free the
 * writer. A file that others removed while it was written is restored as by
 * lum_capture_writer_close(), which is a failure too.
 * @return 0, or -1 with the reason in error, for example that the lines differ
 *         from those of the rehearsal, or are fewer than the rows of an
 *         organised file; then no file is left. ENOENT in errno if the file was
 *         removed or renamed: error says where its data is. */
LUM_MUST_CHECK int lum_writer_close(lum_writer *writer, lum_error *error);

/** Remove what was written and free the writer. NULL is allowed. */
void lum_writer_abort(lum_writer *writer);

#ifdef __cplusplus
}
#endif

#endif
