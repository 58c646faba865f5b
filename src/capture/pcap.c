#include "pcap_internal.h"

#include <stdlib.h>

lum_pcap *lum_pcap_new(lum_source *source)
{
    lum_pcap *r = calloc(1, sizeof *r);
    if (r != NULL) {
        r->source = source;
    }
    return r;
}

void lum_pcap_free(lum_pcap *reader)
{
    if (reader != NULL) {
        lum_mcap_reader_free(reader->mcap);
        lum_bag_reader_free(reader->bag);
        free(reader->interfaces);
        free(reader);
    }
}

void lum_pcap_take_options(lum_pcap *reader, lum_pcap_option_taker *take,
                           void *context)
{
    reader->take_option = take;
    reader->option_context = context;
}

const lum_pcap_interface *lum_pcap_interface_at(const lum_pcap *reader,
                                                uint32_t index)
{
    return &reader->interfaces[index];
}

int lum_pcap_next(lum_pcap *reader, lum_pcap_record *out, lum_error *error)
{
    return reader->next(reader, out, error);
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

bool lum_pcap_ends_early(const lum_pcap *reader)
{
    lum_source *s = reader->source;
    const bool is_begun = reader->header != 0 || reader->next != NULL;
    return is_begun && reader->mcap == NULL && reader->bag == NULL &&
           !s->has_failed && !lum_source_has(s, s->left + 1u) && !s->has_failed;
}

bool lum_pcap_can_seek(const lum_pcap *reader)
{
    return reader->mcap == NULL && reader->bag == NULL &&
           lum_source_can_seek(reader->source);
}

bool lum_pcap_has_wanted(const lum_pcap *reader)
{
    return reader->has_wanted;
}
