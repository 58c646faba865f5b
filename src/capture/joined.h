/** @file
 * Datagrams that a receiving host joined into one (docs/protocol.md, section
 * 9). Internal. */
#ifndef LUM_CAPTURE_JOINED_H
#define LUM_CAPTURE_JOINED_H

#include "lum/capture/record.h"

#include <stdbool.h>
#include <stddef.h>

/** How far a record was taken apart. All bytes 0: it has not begun. */
typedef struct lum_joined {
    size_t each; /**< bytes of each datagram, the last has at most as many; 0:
                      it has not begun */
    size_t at;   /**< where the next one begins */
} lum_joined;

/** The next datagram of a record. A record that is not several joined ones is
 * given as it is, once.
 * @param record the same until false was returned.
 * @param out    of several: ::LUM_RECORD_JOINED, within the record's payload;
 *               the first has the record's dropped_fragments.
 * @return false: there are no more; joined is as before the first. */
bool lum_joined_next(lum_joined *joined, const lum_record *record,
                     lum_record *out);

/** Whether lum_joined_next() has more of this record. */
static inline bool lum_joined_has_more(const lum_joined *joined,
                                       const lum_record *record)
{
    return joined->each != 0 && joined->at < record->len;
}

#endif
