/** @file
 * Captures: pcap and pcapng files to datagrams and back (docs/protocol.md,
 * section 9). Files compressed by gzip, zstd, lz4 or bzip2 are read directly,
 * if the build has zlib, libzstd, liblz4 or libbz2.
 *
 * Only one thread at a time may use a capture or a writer; two of them share
 * nothing. Records are not allocated, except fragments: 66 KB for each of at
 * most 64 datagrams that wait for the rest of their fragments. */
#ifndef LUM_CAPTURE_CAPTURE_H
#define LUM_CAPTURE_CAPTURE_H

#include "lum/base/error.h"
#include "lum/capture/record.h"
#include "lum/capture/source.h"
#include "lum/result.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** An open capture. */
typedef struct lum_capture lum_capture;

/** Open a capture. Waits for its first interface that can be read, or for the
 * first packet of another interface. In a pcapng file, packets of other
 * interfaces are ::LUM_RECORD_OTHER. If none can be read by the end of the
 * file, lum_capture_next() fails there.
 * @param path  a file, or "-" for standard input.
 * @param out   gets a capture to be closed with lum_capture_close().
 * @param error gets the message on failure: missing, unreadable, a directory,
 *              not a capture, or no supported link type and no packet.
 * @return 0, or -1. */
LUM_MUST_CHECK int lum_capture_open(const char *path, lum_capture **out,
                                    lum_error *error);

/** As lum_capture_open(), of any source.
 * @param source taken over: closed with the capture, and on failure. */
LUM_MUST_CHECK int lum_capture_open_source(lum_source *source,
                                           lum_capture **out, lum_error *error);

/** Open several captures as one stream, for example the files of a rotated
 * recording, or a capture of each network interface. They are read in the order
 * of their first record; if their times overlap, records are ordered by time. A
 * datagram whose fragments are in two files is reassembled.
 *
 * The first record of each is read now. After that, a file is open only while
 * it is read, so there may be thousands; a pipe is open from the start. If a
 * file breaks off, is empty or ends within its headers, as the last of a
 * rotated recording may, the others are still read.
 * @param paths count of them, as for lum_capture_open(); not kept. Each must be
 *              a different file: records of a file named twice come twice.
 * @param count at least 1.
 * @param error as for lum_capture_open(), with the name of the file.
 * @return 0, or -1. */
LUM_MUST_CHECK int lum_capture_open_several(const char *const *paths,
                                            size_t count, lum_capture **out,
                                            lum_error *error);

/** The state of reading one source of a capture. */
typedef enum lum_capture_end {
    LUM_CAPTURE_UNDER_WAY, /**< it is not at its end yet */
    LUM_CAPTURE_WHOLE,     /**< it was read to its end, except for damaged
                                parts */
    LUM_CAPTURE_BROKEN,    /**< the rest could not be read */
    LUM_CAPTURE_UNREAD /**< it could not be opened when its turn came, has no
                            interface that can be read, or all of it is
                            damaged */
} lum_capture_end;

/** One source of a capture. */
typedef struct lum_capture_source {
    size_t struct_size;  /**< sizeof(lum_capture_source), set by the caller */
    const char *name;    /**< of its file; lives as long as the capture */
    uint64_t records;    /**< read from it so far; joined datagrams as one */
    int64_t first_ns;    /**< time of the first record; 0 without any */
    int64_t last_ns;     /**< the latest time of a record */
    lum_capture_end end; /**< its state */
    uint64_t damaged;    /**< parts skipped so far, as for
                              lum_capture_damaged() */
} lum_capture_source;

/** How many sources a capture has. */
size_t lum_capture_source_count(const lum_capture *capture);

/** A source, in the order of their first records.
 * @param i   below lum_capture_source_count().
 * @param out the caller sets struct_size; the members within that size are
 *            overwritten.
 * @return LUM_OK; LUM_E_VALUE if struct_size is not set: then nothing is
 *         written. */
lum_result lum_capture_get_source(const lum_capture *capture, size_t i,
                                  lum_capture_source *out);

/** Read the next record. If a receiving host joined several datagrams into one
 * packet (docs/protocol.md, section 9), each comes as its own record,
 * ::LUM_RECORD_JOINED.
 * @return 1 with a record; 0 at the end of the file; -1 if the rest of the file
 *         cannot be read, with the byte and the reason in error. Of several
 *         files, -1 comes after all the others were read to their end. After 0
 *         or -1, fragments of incomplete datagrams are given up: *out has only
 *         their number, in dropped_fragments. */
LUM_MUST_CHECK int lum_capture_next(lum_capture *capture, lum_record *out,
                                    lum_error *error);

/** Number of damaged parts skipped so far, of all sources: chunks of MCAP files
 * and bags, blocks of pcapng files, and messages outside chunks. Their length
 * is known, so reading goes on after them and can end without an error. A part
 * counts once, even if it is read again after a seek.
 * @param error may be NULL; gets a message with the number, the file, and the
 *              byte and reason of the first. Unchanged if there are none. */
uint64_t lum_capture_damaged(const lum_capture *capture, lum_error *error);

/** The interface that the last record came from; only pcapng files name
 * interfaces. The same name in two files or sections means the same interface.
 * @return its name, or its number in its section if it has none of 1 to 63
 *         visible ASCII characters; NULL: not known. Lives until the next call
 *         of lum_capture_next(). */
const char *lum_capture_interface(const lum_capture *capture);

/** Most comments of a source. */
#define LUM_CAPTURE_COMMENTS_MAX 16u

/** Most bytes of a comment: no more fit in a pcapng file. */
#define LUM_CAPTURE_COMMENT_BYTES_MAX 65535u

/** Number of comments in the headers of a pcapng file's sections, as far as the
 * file was read; equal ones count once. Those of the first section of each
 * source are known once a capture is open. They may contain any bytes.
 * @param source below lum_capture_source_count(). */
size_t lum_capture_comment_count(const lum_capture *capture, size_t source);

/** A comment.
 * @param source below lum_capture_source_count().
 * @param i      below lum_capture_comment_count().
 * @param len    gets its length in bytes; a NUL follows them.
 * @return its text, which lives until the capture is closed. */
const char *lum_capture_comment(const lum_capture *capture, size_t source,
                                size_t i, size_t *len);

/** Number of comments left out of these: there are too many, or there is no
 * memory. */
uint64_t lum_capture_comments_left_out(const lum_capture *capture,
                                       size_t source);

/** The progress of the reading, in bytes of the file, compressed or not.
 * @param done  bytes read so far.
 * @param total bytes of the file; 0 if that is not known. */
void lum_capture_progress(const lum_capture *capture, uint64_t *done,
                          uint64_t *total);

/** Close. NULL is allowed. */
void lum_capture_close(lum_capture *capture);

/** Most interfaces of a capture writer. */
#define LUM_CAPTURE_INTERFACES_MAX 16u

/** Formats of captures. */
typedef enum lum_capture_format {
    LUM_CAPTURE_PCAP,  /**< pcap; has no comments */
    LUM_CAPTURE_PCAPNG /**< pcapng */
} lum_capture_format;

/** How a capture is written. All bytes 0 except struct_size are the defaults.
 */
typedef struct lum_capture_writer_options {
    size_t struct_size;          /**< sizeof(lum_capture_writer_options) */
    lum_capture_format format;   /**< which */
    bool is_whole;               /**< it gets its name when it is closed */
    const char *application;     /**< pcapng: the program that writes it, UTF-8;
                                      may be NULL */
    const char *const *comments; /**< pcapng: UTF-8, of the section's header;
                                      none NULL */
    size_t comment_count; /**< at most LUM_CAPTURE_COMMENTS_MAX, each of at most
                             LUM_CAPTURE_COMMENT_BYTES_MAX bytes */
    const char *const *interfaces; /**< pcapng: names of the interfaces that
                                        datagrams come from, UTF-8; none NULL;
                                        empty: without a name */
    size_t interface_count; /**< at most LUM_CAPTURE_INTERFACES_MAX, each of
                               fewer than LUM_INTERFACE_BYTES bytes; 0: one,
                               without a name */
} lum_capture_writer_options;

/** A capture being written: Ethernet, nanoseconds. */
typedef struct lum_capture_writer lum_capture_writer;

/** A datagram to be written. It never grows, since it is filled in for each
 * packet. */
typedef struct lum_datagram {
    int64_t time_ns;           /**< ns since 1970 UTC, 0 or above */
    const uint8_t *payload;    /**< UDP payload */
    size_t len;                /**< its bytes, at most 65,507 */
    uint32_t source;           /**< host order */
    uint32_t destination;      /**< host order */
    uint16_t source_port;      /**< UDP port */
    uint16_t destination_port; /**< UDP port */
} lum_datagram;

/** Begin a pcap file that records live data: it gets its name with the first
 * datagram, and then stays even if the recording fails later. An existing file
 * of that name is unchanged until then; then it is replaced, or emptied if its
 * directory cannot be written.
 * @param path a file, or "-" for standard output.
 * @return 0, or -1 with the reason in error; errno is EBUSY if another run is
 *         writing a file of that name. */
LUM_MUST_CHECK int lum_capture_writer_open(const char *path,
                                           lum_capture_writer **out,
                                           lum_error *error);

/** Begin a pcap file that gets its name when it is closed, so that a file of
 * this name is always complete. An existing file of that name is unchanged
 * until then.
 * @param path as for lum_capture_writer_open().
 * @return as lum_capture_writer_open(). */
LUM_MUST_CHECK int lum_capture_writer_open_whole(const char *path,
                                                 lum_capture_writer **out,
                                                 lum_error *error);

/** Begin a capture, as lum_capture_writer_open() or
 * lum_capture_writer_open_whole().
 * @param options read, with all that it points to, and not kept.
 * @return as lum_capture_writer_open(); errno is EINVAL for an unknown format,
 *         for comments, an application or interfaces in a pcap file, and for
 *         too many or too long ones. */
LUM_MUST_CHECK int lum_capture_writer_open_as(
    const char *path, const lum_capture_writer_options *options,
    lum_capture_writer **out, lum_error *error);

/** Append a datagram, with new Ethernet, IPv4 and UDP headers and correct
 * checksums; above 1500 bytes as one jumbo packet.
 * @return 0, or -1 with the reason in error. */
LUM_MUST_CHECK int lum_capture_writer_add(lum_capture_writer *writer,
                                          const lum_datagram *datagram,
                                          lum_error *error);

/** As lum_capture_writer_add(), with the interface that the datagram came from;
 * lum_capture_writer_add() takes the first.
 * @param interface its place in lum_capture_writer_options.interfaces; 0 if
 *                  there are none.
 * @return 0, or -1 with the reason in error: also if there is no such
 *         interface. */
LUM_MUST_CHECK int lum_capture_writer_add_from(lum_capture_writer *writer,
                                               size_t interface,
                                               const lum_datagram *datagram,
                                               lum_error *error);

/** Bytes of the file so far, including those that are still buffered. */
uint64_t lum_capture_writer_bytes(const lum_capture_writer *writer);

/** Write what is buffered, so that others can read it even if this process
 * dies. If the reader of a pipe has left, this fails even if there is nothing
 * to write: then errno is EPIPE.
 * @return 0, or -1 with the reason in error. */
LUM_MUST_CHECK int lum_capture_writer_flush(lum_capture_writer *writer,
                                            lum_error *error);

/** Check whether the file still has its name: others may remove or rename it,
 * or its directory, while it is written. Call this twice a second. If the name
 * is lost, writing goes on, and lum_capture_writer_close() fails, too. On
 * Windows nothing is checked.
 * @return 0, or -1; error says what happened to the file and where its data
 *         is. */
LUM_MUST_CHECK int lum_capture_writer_check(const lum_capture_writer *writer,
                                            lum_error *error);

/** Write what is buffered, wait until it is on the disk, give the file its name
 * if it has none yet, and close. A file of lum_capture_writer_open() without a
 * datagram gets no name: it is removed, and an existing file of that name
 * stays. NULL is allowed. On Linux, a file that others removed while it was
 * written is restored: under its name; as NAME.recovered if that name is taken
 * or another run writes it; as NAME.*.part if both are taken or the file system
 * has no links. If it has no other link it is copied, however long that takes.
 * That is a failure too; error has the new name, or says that the data is lost.
 * @return 0, or -1 with the reason in error, ENOENT in errno if the file was
 *         removed or renamed; closed either way. A file that still has no name
 *         is removed. */
LUM_MUST_CHECK int lum_capture_writer_close(lum_capture_writer *writer,
                                            lum_error *error);

/** Close. A file that has no name yet is removed; one that has its name stays,
 * as far as it was written. NULL is allowed. Does not wait for a reader that
 * has stopped reading. */
void lum_capture_writer_abort(lum_capture_writer *writer);

#ifdef __cplusplus
}
#endif

#endif
