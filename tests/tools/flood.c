/* flood ADDRESS PORT RATE SECONDS: foreign and malformed datagrams at an even
 * pace, from many ports; prints how many were sent. */
#define _POSIX_C_SOURCE 200809L
#include <arpa/inet.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#define SOCKETS 16u
#define KINDS   5u

static int64_t now_ns(void)
{
    struct timespec t = {0};
    (void)clock_gettime(CLOCK_MONOTONIC, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

/* Noise, only our magic, unknown types, data that contradicts itself, and a
 * full-sized packet of zeros. */
static size_t make(unsigned kind, uint32_t number, uint8_t out[1472])
{
    static const uint8_t magic[] = {0xed, 0xfe, 0xf3, 0xa1,
                                    0xef, 0xbe, 0x34, 0x12};
    memset(out, 0, 1472);
    memcpy(out, magic, sizeof magic);
    switch (kind) {
    case 0:
        memset(out, (int)(number & 0xffu), 64);
        return 64;
    case 1:
        return 8;
    case 2:
        out[8] = (uint8_t)(number | 0x80u);
        return 200;
    case 3:
        out[8] = 8;
        out[12] = 3;
        out[16] = 0xff;
        return 100;
    default:
        memset(out, 0, sizeof magic);
        return 1472;
    }
}

static int open_all(int sockets[SOCKETS])
{
    for (unsigned i = 0; i < SOCKETS; i++) {
        sockets[i] = socket(AF_INET, SOCK_DGRAM, 0);
        if (sockets[i] < 0) {
            perror("flood: socket");
            return -1;
        }
    }
    return 0;
}

int main(int argc, char **argv)
{
    int sockets[SOCKETS];
    uint8_t bytes[1472];
    struct sockaddr_in to = {.sin_family = AF_INET};
    uint64_t sent = 0;
    if (argc != 5 || inet_pton(AF_INET, argv[1], &to.sin_addr) != 1 ||
        open_all(sockets) != 0) {
        (void)fputs("usage: flood ADDRESS PORT RATE SECONDS\n", stderr);
        return 2;
    }
    to.sin_port = htons((uint16_t)strtoul(argv[2], NULL, 10));
    const int64_t rate = strtoll(argv[3], NULL, 10);
    const int64_t total = rate * strtoll(argv[4], NULL, 10);
    const int64_t begin = now_ns();
    for (int64_t i = 0; i < total; i++) {
        const int64_t wait = begin + i * 1000000000 / rate - now_ns();
        if (wait > 0) {
            const struct timespec pause = {.tv_nsec = (long)wait};
            (void)nanosleep(&pause, NULL);
        }
        const size_t len = make((unsigned)i % KINDS, (uint32_t)i, bytes);
        if (sendto(sockets[(unsigned)i % SOCKETS], bytes, len, 0,
                   (const struct sockaddr *)&to, sizeof to) < 0) {
            perror("flood: sendto");
            return 1;
        }
        sent++;
    }
    (void)printf("%" PRIu64 "\n", sent);
    for (unsigned i = 0; i < SOCKETS; i++) {
        (void)close(sockets[i]);
    }
    return 0;
}
