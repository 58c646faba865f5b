/* A type of DDS whose samples are bytes in CDR that are sent as they are: no
 * message is decoded. */
#ifndef LUMROS2_RAW_TYPE_H
#define LUMROS2_RAW_TYPE_H

#include <stddef.h>
#include <stdint.h>

struct ddsi_sertype;
struct ddsi_serdata;

/* For dds_create_topic_sertype(), which takes it over. It has no key, and tells
 * no type information to other participants. NULL without memory. */
struct ddsi_sertype *raw_type_new(const char *name);

/* A sample for dds_writecdr(), which takes it over.
 * cdr  four bytes that say which CDR it is, and the message; copied.
 * NULL without memory. */
struct ddsi_serdata *raw_type_sample(const struct ddsi_sertype *type,
                                     const uint8_t *cdr, size_t len);

#endif
