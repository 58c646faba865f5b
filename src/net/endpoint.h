/* Endpoints as text, for messages. */
#ifndef LUM_NET_ENDPOINT_H
#define LUM_NET_ENDPOINT_H

#include "lum/net/socket.h"

/* "255.255.255.255:65535" and its NUL. */
#define LUM_ENDPOINT_TEXT_BYTES 22

/* An endpoint's text. */
typedef struct lum_endpoint_text {
    char text[LUM_ENDPOINT_TEXT_BYTES];
} lum_endpoint_text;

/* Such as "10.42.0.37:5517". */
lum_endpoint_text lum_endpoint_show(lum_endpoint endpoint);

/* The address alone. */
lum_endpoint_text lum_endpoint_show_address(uint32_t address);

#endif
