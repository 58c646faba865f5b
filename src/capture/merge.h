/** @file
 * The records of several capture files as one stream, by their time. Internal
 * to the capture room.
 *
 * Files are taken in the order of their first record, which is read beforehand.
 * A file is open only while its records are wanted: of files that follow each
 * other, as a rotated recording's, one at a time. What cannot be opened twice,
 * such as a pipe, stays open. */
#ifndef LUM_CAPTURE_MERGE_H
#define LUM_CAPTURE_MERGE_H

#include "input.h"

#include "lum/capture/capture.h"

/** The files. */
typedef struct lum_merge lum_merge;

/** One file; no record is read beforehand.
 * @param source taken over: closed with the files, and on failure.
 * @param go_on  kept; as for lum_capture_open_from().
 * @return 0, or -1 with the reason in error. */
LUM_MUST_CHECK int lum_merge_one(lum_source *source, lum_go_on *go_on,
                                 lum_merge **out, lum_error *error);

/** Open all, read the first record of each, close them again.
 * @return 0, or -1 with the reason in error, which names the file. */
LUM_MUST_CHECK int lum_merge_open(const char *const *paths, size_t count,
                                  lum_go_on *go_on, lum_merge **out,
                                  lum_error *error);

/** Close. NULL is allowed. */
void lum_merge_close(lum_merge *merge);

/** Read the next record. A file that breaks off ends alone; the others go on.
 * @return 1 with a record; 0 at the end of all; -1 there if some broke off,
 * with the first of them in error. */
LUM_MUST_CHECK int lum_merge_next(lum_merge *merge, lum_pcap_record *out,
                                  lum_error *error);

/** As lum_capture_can_seek() and lum_capture_pack(), without fragments. */
bool lum_merge_can_seek(const lum_merge *merge);
LUM_MUST_CHECK int lum_merge_pack(lum_merge *merge, lum_pack *pack,
                                  lum_error *error);

/** As lum_capture_source_count() and lum_capture_get_source(). */
size_t lum_merge_count(const lum_merge *merge);
void lum_merge_get(const lum_merge *merge, size_t i, lum_capture_source *out);

/** As lum_capture_damaged(). */
uint64_t lum_merge_damaged(const lum_merge *merge, lum_error *error);

/** Of a file, by its place as for lum_merge_get(). */
const lum_comments *lum_merge_comments(const lum_merge *merge, size_t i);

/** As lum_capture_progress(). */
void lum_merge_progress(const lum_merge *merge, uint64_t *done,
                        uint64_t *total);

#endif
