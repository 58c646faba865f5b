/* random_calls RUNS SEED: this many random programs that misuse an assembler,
 * or a receiver, each of up to 300 calls. The calls and the checks are those of
 * the fuzzers, tests/fuzz/fuzz_assembler.c and fuzz_receiver.c; here it needs
 * no fuzzer, so that it runs wherever the other tests do, under sanitizers too.
 * Fails if all of them together have not reached the required situations. */
#include "../fuzz/calls.h"

#include <stdlib.h>

static uint32_t next_random(uint64_t *state)
{
    *state =
        *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)(*state >> 33);
}

/* Lines and clocks of pure chance would all be strays: most calls go on from
 * the one before, with the next line or the same. */
static void make_call(uint8_t *b, uint64_t *state, uint8_t *line)
{
    for (unsigned i = 0; i < CALL_BYTES; i++) {
        b[i] = (uint8_t)next_random(state);
    }
    if (next_random(state) % 8u != 0) {
        *line = (uint8_t)((*line + next_random(state) % 4u / 3u) % 80u);
        b[1] = *line;
        b[2] = next_random(state) % 16u == 0 ? b[2] : 3;
    }
}

int main(int argc, char **argv)
{
    static uint8_t input[CONFIG_BYTES + CALLS_MAX * CALL_BYTES];
    if (argc != 3) {
        (void)fprintf(stderr, "usage: random_calls RUNS SEED\n");
        return 2;
    }
    const unsigned long runs = strtoul(argv[1], NULL, 10);
    uint64_t state = strtoul(argv[2], NULL, 10);
    for (unsigned long run = 0; run < runs; run++) {
        const size_t calls = 1u + next_random(&state) % CALLS_MAX;
        uint8_t line = 0;
        for (unsigned i = 0; i < CONFIG_BYTES; i++) {
            input[i] = (uint8_t)next_random(&state);
        }
        for (size_t i = 0; i < calls; i++) {
            make_call(&input[CONFIG_BYTES + i * CALL_BYTES], &state, &line);
        }
        (void)LLVMFuzzerTestOneInput(input, CONFIG_BYTES + calls * CALL_BYTES);
    }
    return fuzz_missed(stdout) == 0 ? 0 : 1;
}
