/* What inputs of fuzz_assembler.c have to meet. */
#ifndef LUM_TESTS_FUZZ_ASSEMBLER_H
#define LUM_TESTS_FUZZ_ASSEMBLER_H

#include "calls.h"

/* What a fuzzer that has lost its way would not come to any more. */
enum sight {
    MET_OK,
    MET_FRAME,
    MET_STRAY,
    MET_JUMP,
    MET_LATE,
    MET_DUPLICATE,
    MET_CONFLICT,
    MET_NO_ROOM,
    MET_BAD_WORDS,
    MET_BEFORE,
    MET_BETWEEN,
    MET_DATAGRAM,
    MET_ALL_ANGLES,
    MET_FULL,
    MET_LONG,
    MET_LONGEST,
    MET_LOST,
    MET_OTHER_PACKET,
    MET_OTHER_SAMPLES,
    MET_IDLE,
    MET_IDLE_WAITS,
    MET_FLUSH_WAITS,
    MET_FLUSH_LEFT,
    MET_AFTER_FLUSH,
    MET_NONSENSE,
    MET_MOST_OPEN,
    SIGHTS
};

#endif
