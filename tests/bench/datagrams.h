/* What the benches share: datagrams in memory, clocks, medians. */
#ifndef LUM_BENCH_DATAGRAMS_H
#define LUM_BENCH_DATAGRAMS_H

#include "lum/packet.h"

#include <stddef.h>
#include <stdint.h>

#define ROUNDS 9u
#define LINES  64u        /* of a frame and eye */
#define POINTS (4u << 20) /* 64 MiB of points, beyond any cache */

struct datagram {
    size_t at;
    size_t len;
    int64_t arrival_ns; /* after the first */
};

struct stream {
    uint8_t *bytes;
    size_t used;
    struct datagram *datagrams;
    size_t count;
};

/* Lines of both eyes in turn, with a total number and a number of words a
 * pixel. */
struct stream stream_make(const lum_layout *layout, uint32_t words_a_pixel,
                          uint32_t lines);
void stream_free(struct stream *stream);

double now_s(void);

/* Time of this process only, for ratios on a machine with other work. */
double processor_s(void);

/* Ends the program. */
__attribute__((noreturn)) void stop(const char *why);

/* Stops where there is none. */
void *allocate(size_t size);

/* Of ROUNDS values, which are sorted. */
double median(double *values);

#endif
