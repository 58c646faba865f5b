/** @file
 * A datagram in a message of lumsdk_msgs/msg/Datagram, in CDR. Internal to the
 * capture room. */
#ifndef LUM_CAPTURE_MCAP_DATAGRAM_H
#define LUM_CAPTURE_MCAP_DATAGRAM_H

#include "lum/capture/record.h"

/** Read a message.
 * @param message its bytes, with the header of CDR; either byte order.
 * @param out     gets the datagram; its payload lies in the message. Cut short
 *                if the message has less of it than was sent.
 * @param whole   gets the bytes that were sent, as the message says.
 * @return false if it is no such message; out is as it was. */
bool lum_mcap_datagram_read(const uint8_t *message, size_t len, lum_record *out,
                            uint32_t *whole);

#endif
