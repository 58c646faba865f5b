/* What a wait on a cancel has to know. */
#ifndef LUM_NET_CANCEL_HANDLE_H
#define LUM_NET_CANCEL_HANDLE_H

#include "lum/net/cancel.h"

#include <stdint.h>

/* A descriptor (POSIX) or a socket (Windows) that is readable while the cancel
 * is raised; never NULL. */
intptr_t lum_cancel_handle(const lum_cancel *cancel);

#endif
