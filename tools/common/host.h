/* Hosts of a command line, by address or by name. */
#ifndef LUM_TOOLS_HOST_H
#define LUM_TOOLS_HOST_H

#include "interfaces.h"

#include "lum/capture/record.h"
#include "lum/net/socket.h"

#include <stdbool.h>
#include <stdint.h>

/* HOST: a.b.c.d, or a name that is looked up now, once. False: why has the
 * reason. */
bool host_parse(const char *text, uint32_t *out, lum_error *why);

/* HOST or HOST%INTERFACE: one of several sensors of a capture. interface is
 * empty where none is named. */
bool host_parse_sensor(const char *text, uint32_t *out,
                       char interface[LUM_INTERFACE_BYTES], lum_error *why);

/* Whether HOST or HOST:PORT would have to be looked up; that waits for the
 * network, seconds where it does not answer. */
bool host_is_name(const char *text);

/* HOST or HOST:PORT; without a port that of *out stays. *out is written on
 * success. */
bool host_parse_endpoint(const char *text, lum_endpoint *out, lum_error *why);

/* Whether this host has an interface of this name, or cannot say; otherwise why
 * lists those that it has. */
bool host_has_interface(const char *name, lum_error *why);

/* The same of interfaces that were listed before. */
bool host_lists_interface(const struct host_interface *all, size_t count,
                          const char *name, lum_error *why);

#endif
