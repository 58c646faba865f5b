/* Network interfaces of Windows by their names, such as "Ethernet 2". */
#ifndef LUM_NET_ADAPTER_H
#define LUM_NET_ADAPTER_H

#include "net/winsock.h"

#include <iphlpapi.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Longest name, its NUL included. */
#define LUM_ADAPTER_NAME_BYTES 256

/* An interface with IPv4. */
typedef struct lum_adapter {
    char name[LUM_ADAPTER_NAME_BYTES];
    unsigned long index;
    uint32_t address; /* the one wanted, or the first; 0: it has none */
} lum_adapter;

/* By its name; wanted: an address that comes first. */
bool lum_adapter_find(const char *name, uint32_t wanted, lum_adapter *out);

/* By its index. */
bool lum_adapter_at(unsigned long index, lum_adapter *out);

/* All with IPv4, to be freed; NULL: none, or the reason in code. */
IP_ADAPTER_ADDRESSES *lum_adapter_all(unsigned long *code);

/* The name of one, in the code page that arguments of programs have. */
void lum_adapter_name(const IP_ADAPTER_ADDRESSES *entry,
                      char out[LUM_ADAPTER_NAME_BYTES]);

/* "Ethernet, Ethernet 2" */
void lum_adapter_list(char *out, size_t room);

#endif
