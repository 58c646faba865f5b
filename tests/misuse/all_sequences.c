/* all_sequences LENGTH: a small assembler, of two open lines of three words an
 * eye, and every sequence of so many calls out of an alphabet that leads to all
 * that lines can come to. Each is an input of the fuzzer, tests/fuzz/
 * fuzz_assembler.c, which holds the assembler against a model of its own; the
 * flush that ends each is one more call. No chance: what the alphabet can say
 * in that many calls is tried. */
#include "../fuzz/fuzz_assembler.h"

#include <stdlib.h>
#include <string.h>

#define LENGTH_MAX 10u

/* Limits of two open lines, a reach of two and three words, a gap of 100 ms. */
static const uint8_t config[CONFIG_BYTES] = {0, 0, 1, 1, 2, 0, 2};

enum {
    BLUE,
    GREEN,
    RANGES = 0,
    ANGLES = 2
};
enum {
    SAME = 0,
    LATER = 4,
    AHEAD = 8,
    BACK = 0x88,
    FAR = 12
};
enum {
    FLUSH = 0x40,
    IDLE,
    OTHER = 0x43,
    ONCE = 0x44,
    PUSH = 0x4f
};

/* n samples from a pixel on; the rest makes them good and in order. */
#define PACKET(kind, n, line, clock, pixel, call)                              \
    {                                                                          \
        (kind) | ((n)-1) << 2, line, clock, pixel, 0, 90, 1, 28, call          \
    }

static const uint8_t alphabet[][CALL_BYTES] = {
    PACKET(BLUE | RANGES, 2, 1, SAME, 4, PUSH),
    PACKET(BLUE | ANGLES, 2, 1, SAME, 0, PUSH),
    PACKET(BLUE | RANGES, 2, 2, LATER, 2, PUSH),
    PACKET(BLUE | RANGES, 1, 2, SAME, 1, PUSH),
    PACKET(BLUE | RANGES, 1, 3, SAME, 3, PUSH),
    PACKET(BLUE | ANGLES, 3, 3, SAME, 1, ONCE),
    PACKET(BLUE | RANGES, 2, 2, AHEAD, 0, ONCE),
    PACKET(BLUE | ANGLES, 2, 2, BACK, 2, PUSH),
    PACKET(BLUE | ANGLES, 1, 1, FAR, 5, ONCE),
    PACKET(BLUE | RANGES, 3, 1, SAME, 5, ONCE),
    PACKET(GREEN | RANGES, 2, 2, SAME, 0, PUSH),
    PACKET(GREEN | ANGLES, 1, 9, LATER, 0, PUSH),
    PACKET(BLUE, 1, 0, SAME, 0, FLUSH),  /* one call, then left */
    PACKET(GREEN, 1, 0, SAME, 0, FLUSH), /* to its end */
    PACKET(BLUE, 1, 1, SAME, 0, IDLE),   /* of before this call */
    PACKET(BLUE, 2, 0, SAME, 0, IDLE),   /* of four calls before */
    PACKET(GREEN, 1, 0, SAME, 0, OTHER), /* what waits, other samples */
};

#define LETTERS (sizeof alphabet / sizeof alphabet[0])

/* Counts up the letters like digits; false after the last sequence. */
static int next_sequence(unsigned *letters, size_t length)
{
    for (size_t i = 0; i < length; i++) {
        letters[i]++;
        if (letters[i] < LETTERS) {
            return 1;
        }
        letters[i] = 0;
    }
    return 0;
}

int main(int argc, char **argv)
{
    static uint8_t input[CONFIG_BYTES + LENGTH_MAX * CALL_BYTES];
    unsigned letters[LENGTH_MAX] = {0};
    unsigned long count = 0;
    const size_t length = argc == 2 ? strtoul(argv[1], NULL, 10) : 0;
    if (length == 0 || length > LENGTH_MAX) {
        (void)fprintf(stderr, "usage: all_sequences LENGTH, 1 to %u\n",
                      LENGTH_MAX);
        return 2;
    }
    memcpy(input, config, CONFIG_BYTES);
    do {
        for (size_t i = 0; i < length; i++) {
            memcpy(&input[CONFIG_BYTES + i * CALL_BYTES], alphabet[letters[i]],
                   CALL_BYTES);
        }
        (void)LLVMFuzzerTestOneInput(input, CONFIG_BYTES + length * CALL_BYTES);
        count++;
    } while (next_sequence(letters, length));
    (void)printf("%lu sequences of %zu calls\n", count, length);
    return 0;
}
