/* A network and a clock that a test moves by hand, in the place of the real
 * ones: sessions run on them without sockets and without waiting. */
#ifndef LUM_TEST_FAKE_NET_H
#define LUM_TEST_FAKE_NET_H

#include "lum/net/socket.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FAKE_BYTES   1500u /* at most EXACT_BYTES */
#define FAKE_SENT    512u
#define FAKE_ARRIVAL 512u

struct fake_sent {
    int64_t ns;
    lum_endpoint to;
    size_t len;
    uint8_t bytes[FAKE_BYTES];
};

struct fake_net {
    int64_t now_ns;       /* both clocks; waiting moves it */
    int64_t receive_ns;   /* what one receive takes */
    lum_net_result send;  /* what sending answers */
    bool receive_breaks;  /* a receive fails */
    bool wait_breaks;     /* a wait fails */
    bool is_raised;       /* every cancel */
    uint32_t floods;      /* so many receives are filled by one sender */
    lum_endpoint flooder; /* who that is */
    uint64_t drops;       /* lum_socket_drops() */
    void (*on_send)(const struct fake_sent *sent); /* may be NULL */
    size_t sent_count;                /* all; the first FAKE_SENT are kept */
    struct fake_sent sent[FAKE_SENT]; /* last; not reset */
};

extern struct fake_net fake;

/* Nothing was sent, nothing arrives, time is a second. */
void fake_reset(void);

/* A datagram arrives at a time, at every socket. What exceeds FAKE_ARRIVAL
 * waiting ones, or FAKE_BYTES, is lost. */
void fake_arrive(int64_t ns, lum_endpoint from, const void *bytes, size_t len);

/* Of the datagrams sent, those with this packet type. */
size_t fake_count_sent(uint8_t type);

#endif
