/** @file
 * Blocks of a pcapng file as it is written: little-endian, one section, its
 * interfaces of Ethernet in nanoseconds. Internal to the capture room. */
#ifndef LUM_CAPTURE_PCAPNG_WRITER_H
#define LUM_CAPTURE_PCAPNG_WRITER_H

#include "lum/capture/capture.h"

/** Bytes of a packet's block before the packet. */
#define LUM_PCAPNG_HEAD_BYTES 28u

/** Most bytes of it behind the packet. */
#define LUM_PCAPNG_TAIL_BYTES 7u

/** Bytes of what stands before the first packet.
 * @return 0 if a text does not fit its option. */
size_t lum_pcapng_start_bytes(const lum_capture_writer_options *options);

/** Write what stands before the first packet.
 * @param out has room for lum_pcapng_start_bytes().
 * @param snap most bytes of a packet. */
void lum_pcapng_put_start(uint8_t *out,
                          const lum_capture_writer_options *options,
                          uint32_t snap);

/** Write the block about a packet that is in its place already.
 * @param block     has room for the head, len bytes and the tail.
 * @param interface that it came from.
 * @return bytes of the block. */
size_t lum_pcapng_put_around(uint8_t *block, uint32_t interface,
                             int64_t time_ns, uint32_t len);

#endif
