#include "pcap_internal.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

int lum_pcap_fail(const lum_pcap *reader, lum_error *error, const char *format,
                  ...)
{
    char text[LUM_ERROR_BYTES];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return lum_error_set(
        error, "byte %llu%s: %s", (unsigned long long)reader->at,
        reader->source->packed != NULL ? " of what it unpacks to" : "", text);
}

int lum_pcap_fail_cut(const lum_pcap *reader, const char *what, uint64_t held,
                      uint64_t all, lum_error *error)
{
    const lum_source *s = reader->source;
    if (held == 0) {
        return lum_pcap_fail(reader, error, "%s", s->error.text);
    }
    if (all == 0) {
        return lum_pcap_fail(
            reader, error, "a %s is cut short: %llu bytes of it are there%s%s",
            what, (unsigned long long)held, s->has_failed ? "; " : "",
            s->has_failed ? s->error.text : "");
    }
    return lum_pcap_fail(reader, error,
                         "a %s is cut short: %llu of its %llu bytes are "
                         "there%s%s",
                         what, (unsigned long long)held,
                         (unsigned long long)all, s->has_failed ? "; " : "",
                         s->has_failed ? s->error.text : "");
}

int lum_pcap_add_interface(lum_pcap *reader,
                           const lum_pcap_interface *interface,
                           lum_error *error)
{
    if (reader->interface_count == LUM_PCAPNG_INTERFACES_MAX) {
        return lum_pcap_fail(reader, error, "more than %u interfaces",
                             LUM_PCAPNG_INTERFACES_MAX);
    }
    if (reader->interface_count == reader->interface_room) {
        const uint32_t room =
            reader->interface_room != 0 ? 2u * reader->interface_room : 4u;
        lum_pcap_interface *more =
            realloc(reader->interfaces, room * sizeof *more);
        if (more == NULL) {
            return lum_pcap_fail(reader, error,
                                 "not enough memory for %u interfaces",
                                 (unsigned)room);
        }
        reader->interfaces = more;
        reader->interface_room = room;
    }
    reader->interfaces[reader->interface_count++] = *interface;
    reader->has_wanted = reader->has_wanted || reader->is_wanted == NULL ||
                         reader->is_wanted(interface->link_type);
    return 0;
}
