/** @file
 * One open capture file: unpacked where it is compressed, read up to its first
 * interface. Internal to the capture room. */
#ifndef LUM_CAPTURE_INPUT_H
#define LUM_CAPTURE_INPUT_H

#include "comments.h"
#include "pcap.h"

/** An open capture file. */
typedef struct lum_input {
    lum_source *source;
    lum_pcap *reader;
    uint64_t records;
    uint32_t link_type; /* of the first interface that is supported; else of the
                           first one */
    /* Without an interface that is read: */
    size_t hidden_at;     /* lum_link_find_hidden() of a packet; 0: of none */
    uint32_t hidden_link; /* the link type of that */
} lum_input;

/** Open. Waits for the first interface that can be read, or a packet of
 * another.
 * @param source   taken over: closed with the input, and on failure.
 * @param comments gets those of the sections, as they are read; kept until the
 *                 input is closed.
 * @return 0; -1 with the reason in error; 1 with it, if nothing is wrong but
 * that it has no bytes, or ends within its headers, as a recording that was
 *         just begun: then it is not open either. */
LUM_MUST_CHECK int lum_input_open(lum_source *source, lum_comments *comments,
                                  lum_input **out, lum_error *error);

/** Close. NULL is allowed. */
void lum_input_close(lum_input *input);

/** Read the next record.
 * @return as lum_pcap_next(); the error names the file too. At the end of a
 * file without an interface that can be read, -1. */
LUM_MUST_CHECK int lum_input_next(lum_input *input, lum_pcap_record *out,
                                  lum_error *error);

/** Its place, in either direction; as lum_capture_pack(). */
LUM_MUST_CHECK int lum_input_pack(lum_input *input, lum_pack *pack,
                                  lum_error *error);

/** Whether nothing of it could be read: no interface that can be was described,
 * or all was damaged. */
bool lum_input_is_unread(const lum_input *input);

#endif
