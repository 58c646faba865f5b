/* Which of its formats a capture has, so who reads it. */

#include "pcap.h"

#include <stdlib.h>

void lum_pcap_free(lum_pcap *reader)
{
    if (reader != NULL) {
        lum_mcap_reader_free(reader->mcap);
        lum_bag_reader_free(reader->bag);
        free(reader->interfaces);
        free(reader);
    }
}

int lum_pcap_begin(lum_pcap *reader, bool (*is_wanted)(uint32_t link_type),
                   uint32_t *link_type, lum_error *error)
{
    reader->is_wanted = is_wanted;
    if (lum_pcapng_is(reader->source)) {
        return lum_pcapng_begin(reader, link_type, error);
    }
    if (lum_mcap_is(reader->source)) {
        return lum_mcap_reader_begin(reader, link_type, error);
    }
    if (lum_bag_is(reader->source)) {
        return lum_bag_reader_begin(reader, link_type, error);
    }
    if (lum_pcap_records_begin(reader, error) != 0) {
        return -1;
    }
    *link_type = reader->interfaces[0].link_type;
    return reader->has_wanted;
}
