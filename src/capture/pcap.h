/** @file
 * pcap, pcapng and MCAP files: bytes to records. Internal to the capture room.
 *
 * pcap of versions 2.0 to 2.4 and 543.0, of either byte order, in microseconds
 * or nanoseconds, and Kuznetzov's with its longer headers; pcapng of version 1
 * with any number of sections, each of its own byte order, and of interfaces,
 * each of its own link type, resolution and offset of time; MCAP with
 * datagrams in messages (docs/formats.md), each handed out as the IPv4 packet
 * that it was, of link type IPV4. What is no packet is skipped.
 *
 * A reader is one thread's at a time. Nothing is allocated for a record. */
#ifndef LUM_CAPTURE_PCAP_H
#define LUM_CAPTURE_PCAP_H

#include "base/pack.h"
#include "byte_order.h"
#include "lum/capture/record.h"
#include "source_internal.h"

/** Most bytes of a packet that a pcap file may hold, as libpcap has it. */
#define LUM_PCAP_BYTES_MAX 262144u

/** Most bytes of a pcapng block that has to be looked at. */
#define LUM_PCAPNG_BLOCK_MAX (16u * 1024u * 1024u)

/** Most interfaces of a pcapng section. */
#define LUM_PCAPNG_INTERFACES_MAX 65536u

/** A time that no clock shows is held at the limit, in seconds since 1970. */
#define LUM_PCAP_SECONDS_MAX INT64_C(4500000000)

/** A packet as a file has it. */
typedef struct lum_pcap_record {
    int64_t time_ns;      /**< since 1970, within +-LUM_PCAP_SECONDS_MAX; 0 for
                               a simple packet block */
    const uint8_t *bytes; /**< live until the next call */
    uint32_t len;         /**< those held */
    uint32_t whole;       /**< those there were, as the file says */
    uint32_t link_type;   /**< LINKTYPE_ value */
    uint32_t interface;   /**< index in its section; 0 in a pcap file */
    const char *name;     /**< of that interface, lives as bytes do; NULL: the
                               file names none */
} lum_pcap_record;

/** What an interface's description says. */
typedef struct lum_pcap_interface {
    uint64_t ticks;     /**< of its time in a second */
    int64_t offset_s;   /**< to be added */
    uint32_t snap;      /**< pcapng: most bytes of a packet that it captured */
    uint32_t link_type; /**< LINKTYPE_ value */
    bool is_lost;       /**< its description could not be read: nor can packets
                             of it */
    char name[LUM_INTERFACE_BYTES]; /**< pcapng: it, or its number */
} lum_pcap_interface;

/** What an option belongs to. */
typedef enum lum_pcap_place {
    LUM_PCAP_SECTION,   /**< a section's header */
    LUM_PCAP_INTERFACE, /**< an interface's description */
    LUM_PCAP_PACKET     /**< the packet that is handed out next */
} lum_pcap_place;

/** The code of an option that is a comment, in UTF-8 without a NUL. */
#define LUM_PCAP_COMMENT 1u

/** Takes an option of a pcapng file.
 * @param code  its number.
 * @param value live until it returns. */
typedef void lum_pcap_option_taker(void *context, lum_pcap_place place,
                                   unsigned code, const uint8_t *value,
                                   size_t len);

/** A reader. */
typedef struct lum_pcap lum_pcap;

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
    size_t interface_room;
    bool (*is_wanted)(uint32_t link_type); /* NULL: any is */
    bool has_wanted; /* an interface whose link type is was described */
    bool is_lost;    /* pcapng: the section's header could not be read */
    uint64_t damaged;
    uint64_t damaged_to; /* what begins before was counted */
    lum_error damage;    /* why the first was passed over */
    lum_pcap_option_taker *take_option;
    void *option_context;
};

/** Make a reader.
 * @param source borrowed; nothing of it was taken.
 * @return NULL without memory. */
LUM_MUST_CHECK lum_pcap *lum_pcap_new(lum_source *source);

/** Free it. NULL is allowed. */
void lum_pcap_free(lum_pcap *reader);

/** Hand out the options of a pcapng file while it is read.
 * @param take NULL: do not. */
void lum_pcap_take_options(lum_pcap *reader, lum_pcap_option_taker *take,
                           void *context);

/** Read up to the first interface whose link type is wanted: a pcap file's only
 * one, or a pcapng file's first such before its first packet. Once, before any
 * lum_pcap_next().
 * @param is_wanted   NULL: any is.
 * @param link_type   gets its link type; where none is wanted the first one's.
 * @return 1; 2 if packets of other interfaces come first, behind which one that
 *         is wanted may still be described; 0 if none is wanted; -1 if it is no
 *         capture, with the reason in error, without the source's name. */
LUM_MUST_CHECK int lum_pcap_begin(lum_pcap *reader,
                                  bool (*is_wanted)(uint32_t link_type),
                                  uint32_t *link_type, lum_error *error);

/** After lum_pcap_begin() failed: whether it is a capture, pcap or pcapng, that
 * ends before its first interface, as one that was just begun. */
bool lum_pcap_ends_early(const lum_pcap *reader);

/** Read the next record.
 * @return 1 with a record; 0 at the end; -1 where it cannot be read any
 *         further, with the byte of the stream and the reason in error. */
LUM_MUST_CHECK int lum_pcap_next(lum_pcap *reader, lum_pcap_record *out,
                                 lum_error *error);

/** How many parts of the file could not be read and were passed over, so far:
 * chunks, blocks, and messages or packets of their own. Where it is read again
 * from an earlier place, they count once.
 * @param first gets why the first was, with its byte; lives as long as the
 *              reader. "": there is none. */
uint64_t lum_pcap_damaged(const lum_pcap *reader, const char **first);

/** Say how many parts were passed over.
 * @param name of the file.
 * @param rest parts of other captures that are read with it.
 * @param first as lum_pcap_damaged() gives it. */
void lum_pcap_tell_damage(const char *name, uint64_t damaged, uint64_t rest,
                          const char *first, lum_error *out);

/** Whether damage is why nothing could be read, if nothing was. */
bool lum_pcap_is_spoilt(const lum_pcap *reader);

/** Say that nothing could be read of a file with damage, and why: the first
 * reason.
 * @return -1. */
int lum_pcap_fail_damaged(const lum_pcap *reader, lum_error *error);

/** Whether it can be read from another place: lum_pcap_pack() is for such. An
 * MCAP file cannot, since the channels before that place would be missing. */
bool lum_pcap_can_seek(const lum_pcap *reader);

/** The place of the next record and what was described before it, in either
 * direction; the source is at that place.
 * @return false if something failed. */
bool lum_pcap_pack(lum_pcap *reader, lum_pack *pack);

/* --- What its readers share --- */

/** What a step of a reader led to. */
enum lum_pcap_step {
    LUM_PCAP_FAILED = -1, /**< with the reason in error */
    LUM_PCAP_ENDED,
    LUM_PCAP_READ, /**< what was asked for is at hand */
    LUM_PCAP_GO_ON,
    LUM_PCAP_DAMAGED /**< and passed over, or can be; with the reason */
};

/* A number of a file, in its own byte order. */
static inline uint16_t file_u16(const lum_pcap *r, const uint8_t *p)
{
    return r->is_big ? load_big_u16(p) : load_u16(p);
}

static inline uint32_t file_u32(const lum_pcap *r, const uint8_t *p)
{
    return r->is_big ? load_big_u32(p) : load_u32(p);
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
