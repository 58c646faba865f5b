/** @file
 * Which sensors of a demultiplexer are known and wanted, and by which layout
 * each is decoded. Internal to it. */
#ifndef LUM_CAPTURE_DEMUX_MEMBERS_H
#define LUM_CAPTURE_DEMUX_MEMBERS_H

#include "base/pack.h"
#include "lum/base/error.h"
#include "lum/capture/demux.h"

/** No member. */
#define LUM_DEMUX_NO_MEMBER (-1)

/** A sensor that is known. */
typedef struct lum_demux_known {
    uint32_t address;
    char interface[LUM_INTERFACE_BYTES]; /* empty: the first of its address that
                                            is no other's */
    lum_layout layout;
    bool is_left_out;
    bool is_there; /* it is one of the sensors */
} lum_demux_known;

/** Those that are known. */
typedef struct lum_demux_members {
    size_t count; /* 0: all sensors */
    lum_demux_known of[LUM_DEMUX_MEMBERS_MAX];
} lum_demux_members;

/** Take those of the options: members, or one requested sensor.
 * @return 0, or -1 with the error set. */
int lum_demux_take_members(lum_demux_members *out,
                           const lum_demux_options *options, lum_error *error);

/** Which member an address on an interface is, or LUM_DEMUX_NO_MEMBER.
 * @param is_beside another sensor with this address, whose interface no member
 *                  has, came before. */
int lum_demux_find_member(const lum_demux_members *members, uint32_t address,
                          const char *interface, bool is_beside);

/** What the data of an address on an interface is decoded by, before it is
 * known whose it is: it may be that of a member on another interface. The same
 * layouts have the same address in memory.
 * @param usual where no member has the address. */
const lum_layout *lum_demux_layout_for(const lum_demux_members *members,
                                       uint32_t address, const char *interface,
                                       const lum_layout *usual);

/** Whether a member of an address names its interface. */
bool lum_demux_members_name(const lum_demux_members *members, uint32_t address);

/** Whether this one is a member that is wanted. */
bool lum_demux_members_want(const lum_demux_members *members, int member);

/** How many that are wanted have not come, without this one. */
size_t lum_demux_members_absent(const lum_demux_members *members, int but);

/** What decides which data of which members is taken: only to be compared. */
void lum_demux_pack_members(const lum_demux_members *members, lum_pack *pack);

/** What decides how data is decoded: only to be compared. */
void lum_demux_pack_profile(lum_profile profile, lum_pack *pack);

#endif
