/* Names of other programs, for messages. */
#ifndef LUM_NET_PROGRAM_H
#define LUM_NET_PROGRAM_H

#include "lum/net/socket.h"

/* "lumctl (process 1234)", or less if the system gives less. */
typedef struct lum_program_text {
    char text[64];
} lum_program_text;

/* A process; 0: not known which. */
lum_program_text lum_program_show(long process);

/* The process that has a local UDP port; 0: not known. */
long lum_program_of_port(lum_endpoint local);

/* The process that listens at a local TCP port; 0: not known. */
long lum_program_of_tcp_port(lum_endpoint local);

#endif
