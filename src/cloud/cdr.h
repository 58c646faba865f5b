/** @file
 * CDR as ROS 2 has it in files and on the wire: plain CDR version 1 (XCDR1),
 * little-endian. Numbers are aligned to their size, counted from behind the
 * four bytes that a message begins with. Internal to cloud. */
#ifndef LUM_CLOUD_CDR_H
#define LUM_CLOUD_CDR_H

#include "buffer.h"

#include <stdbool.h>

/** A message in the making. */
typedef struct lum_cdr {
    lum_bytes *out; /**< what it is appended to */
    size_t base;    /**< from where alignment counts */
} lum_cdr;

/** Begin a message. */
lum_cdr lum_cdr_begin(lum_bytes *out);

/** Append a bool or a byte. */
void lum_cdr_put_u8(lum_cdr *cdr, uint8_t v);
/** Append a number of 16 bits. */
void lum_cdr_put_u16(lum_cdr *cdr, uint16_t v);
/** Append a number of 32 bits, or the length of a sequence. */
void lum_cdr_put_u32(lum_cdr *cdr, uint32_t v);
/** Append a double. */
void lum_cdr_put_f64(lum_cdr *cdr, double v);

/** Append bytes as they are; those of a sequence come behind its length. */
void lum_cdr_put_bytes(lum_cdr *cdr, const void *bytes, size_t n);

/** Append a string; its length counts the NUL that ends it. */
void lum_cdr_put_string(lum_cdr *cdr, const char *text);

#endif
