/** @file
 * What the readers of pcap, pcapng and MCAP share. Internal to them. */
#ifndef LUM_CAPTURE_PCAP_INTERNAL_H
#define LUM_CAPTURE_PCAP_INTERNAL_H

#include "byte_order.h"
#include "pcap.h"

/** What a step of a reader led to. */
enum lum_pcap_step {
    LUM_PCAP_FAILED = -1, /**< with the reason in error */
    LUM_PCAP_ENDED,
    LUM_PCAP_READ, /**< what was asked for is at hand */
    LUM_PCAP_GO_ON,
    LUM_PCAP_DAMAGED /**< and passed over, or can be; with the reason */
};

/** What is read of an MCAP file. */
typedef struct lum_mcap_reader lum_mcap_reader;
typedef struct lum_bag_reader lum_bag_reader;

struct lum_pcap {
    lum_source *source;
    int (*next)(lum_pcap *reader, lum_pcap_record *out, lum_error *error);
    uint64_t at;           /* where the record or block being read begins */
    bool is_big;           /* the byte order of the file, or of the section */
    uint32_t scale;        /* pcap: nanoseconds of a fraction's unit */
    size_t header;         /* pcap: bytes of a record's */
    int lengths;           /* pcap: enum length_order */
    lum_mcap_reader *mcap; /* NULL: it is none */
    lum_bag_reader *bag;   /* NULL: it is none */
    lum_pcap_interface *interfaces;
    uint32_t interface_count;
    uint32_t interface_room;
    bool (*is_wanted)(uint32_t link_type); /* NULL: any is */
    bool has_wanted; /* an interface whose link type is was described */
    bool is_lost;    /* pcapng: the section's header could not be read */
    uint64_t damaged;
    uint64_t damaged_to; /* what begins before was counted */
    lum_error damage;    /* why the first was passed over */
    lum_pcap_option_taker *take_option;
    void *option_context;
};

static inline uint16_t load_u16(const lum_pcap *r, const uint8_t *p)
{
    return r->is_big ? load_be16(p) : load_le16(p);
}

static inline uint32_t load_u32(const lum_pcap *r, const uint8_t *p)
{
    return r->is_big ? load_be32(p) : load_le32(p);
}

/** The meaning of a limit of 0 and of impossible limits. */
static inline uint32_t lum_pcap_snap(uint32_t snap)
{
    return snap == 0 || snap > INT32_MAX ? LUM_PCAP_BYTES_MAX : snap;
}

/** Say where reading ended and why.
 * @return -1. */
LUM_PRINTF(3, 4)
int lum_pcap_fail(const lum_pcap *reader, lum_error *error, const char *format,
                  ...);

/** Say that the stream ended, or failed, within what begins at reader->at, or
 * failed before it.
 * @param what "record", "block" or "chunk".
 * @param all  its bytes; 0: not known.
 * @return -1. */
int lum_pcap_fail_cut(const lum_pcap *reader, const char *what, uint64_t all,
                      lum_error *error);

/** Count a part that is passed over since it cannot be read, and keep the
 * reason if it is the first.
 * @param reason as lum_pcap_fail() makes it. */
void lum_pcap_note_damage(lum_pcap *reader, const lum_error *reason);

/** Add an interface.
 * @return 0, or -1 with the reason in error. */
LUM_MUST_CHECK int lum_pcap_add_interface(lum_pcap *reader,
                                          const lum_pcap_interface *interface,
                                          lum_error *error);

/** Read a pcap file's header, which describes its only interface.
 * @return 0, or -1 with the reason in error. */
LUM_MUST_CHECK int lum_pcap_records_begin(lum_pcap *reader, lum_error *error);

/** Whether the source begins as a pcapng file does. */
bool lum_pcapng_is(lum_source *source);

/** lum_pcap_begin() of a pcapng file. */
LUM_MUST_CHECK int lum_pcapng_begin(lum_pcap *reader, uint32_t *link_type,
                                    lum_error *error);

/** Whether the source begins as an MCAP file does. */
bool lum_mcap_is(lum_source *source);

/** lum_pcap_begin() of an MCAP file: reads up to the first channel that has
 * datagrams. */
LUM_MUST_CHECK int lum_mcap_reader_begin(lum_pcap *reader, uint32_t *link_type,
                                         lum_error *error);

/** Free it. NULL is allowed. */
void lum_mcap_reader_free(lum_mcap_reader *reader);

/** Whether the source begins as a bag of ROS 1 does. */
bool lum_bag_is(lum_source *source);

/** lum_pcap_begin() of such a bag: reads up to the first connection that has
 * packets. */
LUM_MUST_CHECK int lum_bag_reader_begin(lum_pcap *reader, uint32_t *link_type,
                                        lum_error *error);

/** Free it. NULL is allowed. */
void lum_bag_reader_free(lum_bag_reader *reader);

#endif
