#include "demux_members.h"

#include <stdio.h>
#include <string.h>

static void take(lum_demux_known *out, const lum_demux_member *member,
                 const lum_layout *usual)
{
    out->address = member->address;
    (void)snprintf(out->interface, sizeof out->interface, "%s",
                   member->interface != NULL ? member->interface : "");
    out->layout = member->layout != NULL ? *member->layout : *usual;
    out->is_left_out = member->is_left_out;
}

static bool is_same(const lum_demux_known *a, const lum_demux_known *b)
{
    return a->address == b->address && strcmp(a->interface, b->interface) == 0;
}

static int check(const lum_demux_members *members, lum_error *error)
{
    for (size_t i = 0; i < members->count; i++) {
        for (size_t k = 0; k < i; k++) {
            if (is_same(&members->of[k], &members->of[i])) {
                return lum_error_set(
                    error,
                    "members %zu and %zu are the same sensor; members with one "
                    "address need different interfaces",
                    k, i);
            }
        }
    }
    return 0;
}

int lum_demux_take_members(lum_demux_members *out,
                           const lum_demux_options *options, lum_error *error)
{
    const lum_demux_member requested = {.address = options->sensor,
                                        .interface = options->sensor_interface};
    const lum_demux_member *members =
        options->has_sensor ? &requested : options->members;
    const size_t count = options->has_sensor ? 1u : options->member_count;
    if (options->has_sensor && options->member_count != 0) {
        return lum_error_set(error, "a requested sensor and members are given; "
                                    "give one of them");
    }
    if (options->member_count > LUM_DEMUX_MEMBERS_MAX) {
        return lum_error_set(error, "%zu members; at most %u are accepted",
                             options->member_count, LUM_DEMUX_MEMBERS_MAX);
    }
    if (count != 0 && members == NULL) {
        return lum_error_set(error,
                             "members is NULL, but %zu members are announced; "
                             "give members, or 0 as their number",
                             count);
    }
    *out = (lum_demux_members){.count = count};
    for (size_t i = 0; i < count; i++) {
        take(&out->of[i], &members[i], &options->layout);
    }
    return check(out, error);
}

int lum_demux_find_member(const lum_demux_members *members, uint32_t address,
                          const char *interface, bool is_beside)
{
    int found = LUM_DEMUX_NO_MEMBER;
    for (size_t i = 0; i < members->count; i++) {
        const lum_demux_known *m = &members->of[i];
        const bool is_any = *m->interface == '\0';
        if (m->address == address && !is_any &&
            strcmp(m->interface, interface) == 0) {
            return (int)i;
        }
        if (m->address == address && is_any && !is_beside) {
            found = (int)i;
        }
    }
    return found;
}

static bool is_same_layout(const lum_layout *a, const lum_layout *b)
{
    lum_pack of_a = {.written = NULL};
    lum_pack of_b = {.written = NULL};
    lum_demux_pack_profile(a->profile, &of_a);
    lum_demux_pack_profile(b->profile, &of_b);
    const bool is_same = !of_a.has_failed && !of_b.has_failed &&
                         of_a.len == of_b.len &&
                         memcmp(of_a.written, of_b.written, of_a.len) == 0;
    lum_pack_reset(&of_a);
    lum_pack_reset(&of_b);
    return is_same;
}

/* The first with the same one. */
static const lum_layout *first_like(const lum_demux_members *members,
                                    const lum_layout *layout,
                                    const lum_layout *usual)
{
    if (is_same_layout(layout, usual)) {
        return usual;
    }
    const lum_demux_known *m = members->of;
    while (&m->layout != layout && !is_same_layout(&m->layout, layout)) {
        m++;
    }
    return &m->layout;
}

const lum_layout *lum_demux_layout_for(const lum_demux_members *members,
                                       uint32_t address, const char *interface,
                                       const lum_layout *usual)
{
    const lum_layout *other = NULL;
    const int member =
        lum_demux_find_member(members, address, interface, false);
    for (size_t i = members->count; i-- > 0;) {
        if (members->of[i].address == address) {
            other = &members->of[i].layout;
        }
    }
    if (member != LUM_DEMUX_NO_MEMBER) {
        other = &members->of[member].layout;
    }
    return other != NULL ? first_like(members, other, usual) : usual;
}

bool lum_demux_members_name(const lum_demux_members *members, uint32_t address)
{
    for (size_t i = 0; i < members->count; i++) {
        const lum_demux_known *m = &members->of[i];
        if (m->address == address && *m->interface != '\0') {
            return true;
        }
    }
    return false;
}

bool lum_demux_members_want(const lum_demux_members *members, int member)
{
    return member != LUM_DEMUX_NO_MEMBER && !members->of[member].is_left_out;
}

size_t lum_demux_members_absent(const lum_demux_members *members, int but)
{
    size_t absent = 0;
    for (size_t i = 0; i < members->count; i++) {
        absent += lum_demux_members_want(members, (int)i) &&
                  !members->of[i].is_there && (int)i != but;
    }
    return absent;
}

void lum_demux_pack_profile(lum_profile p, lum_pack *pack)
{
    lum_pack_u32(pack, &p.data_packet_type);
    for (unsigned i = 0; i < LUM_GROUP_FIELDS; i++) {
        lum_pack_u8(pack, &p.group[i].at);
        lum_pack_u8(pack, &p.group[i].bytes);
        lum_pack_u8(pack, &p.group[i].order);
        lum_pack_u8(pack, &p.group[i].low);
        lum_pack_u8(pack, &p.group[i].bits);
    }
    lum_pack_u8(pack, &p.samples_at);
    lum_pack_u8(pack, &p.angle_order);
    lum_pack_u8(pack, &p.sample_order);
    lum_pack_u32(pack, &p.eye_values[LUM_EYE_BLUE]);
    lum_pack_u32(pack, &p.eye_values[LUM_EYE_GREEN]);
    lum_pack_u32(pack, &p.line_span_us);
    lum_pack_u32(pack, &p.clock_unit_ns);
}

void lum_demux_pack_members(const lum_demux_members *members, lum_pack *pack)
{
    for (size_t i = 0; i < members->count; i++) {
        lum_demux_known m = members->of[i];
        lum_pack_u32(pack, &m.address);
        lum_pack_text(pack, m.interface, sizeof m.interface);
        lum_demux_pack_profile(m.layout.profile, pack);
        lum_pack_bool(pack, &m.is_left_out);
    }
}
