#include "pcap.h"

#include "base/grow.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

lum_pcap *lum_pcap_new(lum_source *source)
{
    lum_pcap *r = calloc(1, sizeof *r);
    if (r != NULL) {
        r->source = source;
    }
    return r;
}

void lum_pcap_take_options(lum_pcap *reader, lum_pcap_option_taker *take,
                           void *context)
{
    reader->take_option = take;
    reader->option_context = context;
}

int lum_pcap_next(lum_pcap *reader, lum_pcap_record *out, lum_error *error)
{
    return reader->next(reader, out, error);
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

/* --- What could not be read --- */

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

int lum_pcap_fail_cut(const lum_pcap *reader, const char *what, uint64_t all,
                      lum_error *error)
{
    const lum_source *s = reader->source;
    const uint64_t held = s->end - reader->at;
    const char *gap = s->has_failed ? "; " : "";
    const char *why = s->has_failed ? s->error.text : "";
    if (held == 0) {
        return lum_pcap_fail(reader, error, "%s", s->error.text);
    }
    if (all == 0) {
        return lum_pcap_fail(
            reader, error, "a %s is cut short: %llu bytes of it are there%s%s",
            what, (unsigned long long)held, gap, why);
    }
    return lum_pcap_fail(
        reader, error,
        "a %s is cut short: %llu of its %llu bytes are there%s%s", what,
        (unsigned long long)held, (unsigned long long)all, gap, why);
}

void lum_pcap_note_damage(lum_pcap *reader, const lum_error *reason)
{
    if (reader->at < reader->damaged_to) {
        return;
    }
    if (reader->damaged == 0) {
        reader->damage = *reason;
    }
    reader->damaged++;
}

bool lum_pcap_is_spoilt(const lum_pcap *reader)
{
    return reader->damaged != 0 && !reader->source->has_failed;
}

int lum_pcap_fail_damaged(const lum_pcap *reader, lum_error *error)
{
    return lum_error_set(
        error, "nothing of it can be read: %s%s", reader->damage.text,
        lum_source_can_seek(reader->source)
            ? ""
            : "; unpack it to a file: some of it may then be readable");
}

uint64_t lum_pcap_damaged(const lum_pcap *reader, const char **first)
{
    *first = reader->damage.text;
    return reader->damaged;
}

void lum_pcap_tell_damage(const char *name, uint64_t damaged, uint64_t rest,
                          const char *first, lum_error *out)
{
    char others[64] = "";
    if (rest != 0) {
        (void)snprintf(others, sizeof others,
                       ", and %llu of the other captures",
                       (unsigned long long)rest);
    }
    (void)lum_error_set(
        out, "%s: %llu part%s of it%s could not be read and %s passed over%s%s",
        name, (unsigned long long)damaged, damaged == 1u ? "" : "s", others,
        damaged + rest == 1u ? "was" : "were",
        damaged == 1u ? ": " : "; the first is at ", first);
}

/* --- Interfaces, and the place --- */

/* What a description can say, without more interfaces than there is memory
 * for. */
static void pack_interface(lum_pack *pack, lum_pcap_interface *interface)
{
    lum_pack_text(pack, interface->name, sizeof interface->name);
    lum_pack_u64(pack, &interface->ticks);
    lum_pack_i64(pack, &interface->offset_s);
    lum_pack_u32(pack, &interface->snap);
    lum_pack_u32(pack, &interface->link_type);
    lum_pack_bool(pack, &interface->is_lost);
}

static void read_interfaces(lum_pcap *r, lum_pack *pack, uint32_t count,
                            bool is_pcapng)
{
    lum_pcap_interface interface = {.ticks = 0};
    r->interface_count = 0;
    for (uint32_t i = 0; i < count && !pack->has_failed; i++) {
        pack_interface(pack, &interface);
        if (!lum_pack_check(pack, interface.ticks != 0 || !is_pcapng) ||
            lum_pcap_add_interface(r, &interface, NULL) != 0) {
            pack->has_failed = true;
        }
    }
}

bool lum_pcap_pack(lum_pcap *reader, lum_pack *pack)
{
    const bool is_pcapng = reader->scale == 0;
    uint32_t count = reader->interface_count;
    bool has_wanted = reader->has_wanted;
    lum_pack_bool(pack, &reader->is_big);
    lum_pack_bool(pack, &reader->is_lost);
    lum_pack_bool(pack, &has_wanted);
    lum_pack_u32(pack, &count);
    if (!lum_pack_check(pack, is_pcapng || count == 1u)) {
        return false;
    }
    if (lum_pack_is_reading(pack)) {
        read_interfaces(reader, pack, count, is_pcapng);
        reader->has_wanted = has_wanted;
    }
    for (uint32_t i = 0; i < count && !lum_pack_is_reading(pack); i++) {
        pack_interface(pack, &reader->interfaces[i]);
    }
    return !pack->has_failed;
}

int lum_pcap_add_interface(lum_pcap *reader,
                           const lum_pcap_interface *interface,
                           lum_error *error)
{
    if (reader->interface_count == LUM_PCAPNG_INTERFACES_MAX) {
        return lum_pcap_fail(reader, error, "more than %u interfaces",
                             LUM_PCAPNG_INTERFACES_MAX);
    }
    lum_pcap_interface *more =
        lum_grown(reader->interfaces, reader->interface_count, 1, sizeof *more,
                  &reader->interface_room);
    if (more == NULL) {
        return lum_pcap_fail(reader, error,
                             "not enough memory for its interfaces");
    }
    reader->interfaces = more;
    reader->interfaces[reader->interface_count++] = *interface;
    reader->has_wanted =
        reader->has_wanted ||
        (!interface->is_lost && (reader->is_wanted == NULL ||
                                 reader->is_wanted(interface->link_type)));
    return 0;
}
