/* Values that a proof holds for, whichever they are. No program defines these
 * functions: Eva takes what their contracts say. */
#ifndef LUM_PROVE_UNKNOWN_H
#define LUM_PROVE_UNKNOWN_H

#include <stddef.h>
#include <stdint.h>

/*@ ghost extern volatile int unknown; */

/*@ assigns ((char *)p)[0 .. n - 1] \from unknown;
    ensures \initialized((char *)p + (0 .. n - 1)); */
void any_bytes(void *p, size_t n);

/*@ assigns \result \from unknown;
    ensures least <= \result <= most; */
uint32_t any_u32(uint32_t least, uint32_t most);

/*@ assigns \result \from unknown;
    ensures least <= \result <= most; */
int64_t any_i64(int64_t least, int64_t most);

/*@ assigns \result \from unknown;
    ensures least <= \result <= most; */
uint64_t any_u64(uint64_t least, uint64_t most);

#endif
