#include "index.h"

#include "base/crc32.h"
#include "base/grow.h"
#include "capture/byte_order.h"
#include "lum/frame/frame.h"
#include "lum/version.h"

#include <stdlib.h>
#include <string.h>

/* --- Entries --- */

void lum_index_entry_free(lum_index_entry *entry)
{
    if (entry != NULL) {
        free(entry->capture);
        free(entry->state);
        free(entry);
    }
}

void lum_index_clear(lum_index *index)
{
    for (size_t i = 0; i < index->count; i++) {
        lum_index_entry_free(index->entries[i]);
    }
    for (size_t i = 0; i < index->birth_count; i++) {
        free(index->births[i].capture);
    }
    free((void *)index->entries);
    *index = (lum_index){.stride = 1};
}

static size_t bytes_of(const lum_index_entry *entry)
{
    return sizeof *entry + sizeof(void *) + entry->capture_len +
           entry->state_len;
}

/* Every other entry of each sensor goes. */
static void thin_out(lum_index *index)
{
    uint64_t seen[LUM_DEMUX_SENSORS_MAX] = {0};
    size_t kept = 0;
    for (size_t i = 0; i < index->count; i++) {
        lum_index_entry *entry = index->entries[i];
        if (seen[entry->sensor]++ % 2u == 0) {
            index->entries[kept++] = entry;
        } else {
            index->bytes -= bytes_of(entry);
            lum_index_entry_free(entry);
        }
    }
    index->count = kept;
    index->stride *= index->stride < UINT32_MAX / 2u ? 2u : 1u;
}

/* One of each sensor is left, and they are too long. */
static void drop_last(lum_index *index)
{
    lum_index_entry *entry = index->entries[--index->count];
    index->bytes -= bytes_of(entry);
    lum_index_entry_free(entry);
}

void lum_index_add(lum_index *index, lum_index_entry *entry)
{
    lum_index_entry **entries = lum_grown((void *)index->entries, index->count,
                                          1, sizeof(void *), &index->room);
    if (entries == NULL) {
        lum_index_entry_free(entry);
        return;
    }
    index->entries = entries;
    index->entries[index->count++] = entry;
    index->bytes += bytes_of(entry);
    while (index->count > 0 && index->bytes > LUM_INDEX_BYTES_MAX) {
        const size_t before = index->count;
        thin_out(index);
        if (index->count == before) {
            drop_last(index);
        }
    }
}

/* --- Finding --- */

const lum_index_entry *lum_index_of(const lum_index *index, uint32_t sensor,
                                    uint64_t order)
{
    for (size_t i = index->count; i-- > 0;) {
        const lum_index_entry *entry = index->entries[i];
        if ((entry->sensor == sensor || sensor == LUM_DEMUX_SENSORS_MAX) &&
            entry->order <= order) {
            return entry;
        }
    }
    return NULL;
}

const lum_index_entry *lum_index_at_number(const lum_index *index,
                                           uint32_t sensor, int64_t number)
{
    for (size_t i = index->count; i-- > 0;) {
        const lum_index_entry *entry = index->entries[i];
        if (entry->sensor == sensor &&
            !lum_frame_is_before(number, entry->number)) {
            return entry;
        }
    }
    return NULL;
}

const lum_index_entry *lum_index_at_time(const lum_index *index,
                                         int64_t time_ns)
{
    for (size_t i = index->count; i-- > 0;) {
        if (index->entries[i]->highest_ns < time_ns) {
            return index->entries[i];
        }
    }
    return NULL;
}

bool lum_index_is_certain(const lum_index *index, uint64_t after)
{
    bool is_certain = true;
    for (size_t i = 0; i < index->origin_count; i++) {
        const lum_index_origin *o = &index->origins[i];
        is_certain &= after < o->is.since || after >= o->known;
    }
    return is_certain;
}

static void take_later(const lum_index *index, lum_index_place *best,
                       lum_index_place place, uint64_t limit)
{
    if (place.after > best->after && place.after <= limit &&
        lum_index_is_certain(index, place.after)) {
        *best = place;
    }
}

lum_index_place lum_index_place_at(const lum_index *index, uint64_t after)
{
    lum_index_place best = {.after = 0};
    for (size_t i = 0; i < index->birth_count; i++) {
        const lum_index_birth *b = &index->births[i];
        take_later(index, &best,
                   (lum_index_place){b->after, b->capture, b->capture_len},
                   after);
    }
    for (size_t i = 0; i < index->count; i++) {
        const lum_index_entry *e = index->entries[i];
        take_later(index, &best,
                   (lum_index_place){e->after, e->capture, e->capture_len},
                   after);
    }
    return best;
}

/* --- As a file --- */

/* docs/formats.md, Index. */
static const char magic[8] = {'l', 'u', 'm', 'i', 'n', 'd', 'e', 'x'};

enum {
    FORMAT = 3,
    FORMAT_AT = sizeof magic,
    SUM_AT = FORMAT_AT + 2,
    BODY_AT = SUM_AT + 4
};

uint32_t lum_index_sum(uint32_t sum, const void *bytes, size_t len)
{
    lum_crc32 crc;
    lum_crc32_init(&crc);
    return lum_crc32_add(&crc, sum, bytes, len);
}

/* Bytes that are allocated where they are read. */
static void pack_blob(lum_pack *p, uint8_t **bytes, size_t *len)
{
    uint64_t count = *len;
    lum_pack_u64(p, &count);
    if (lum_pack_is_reading(p)) {
        *len = 0;
        if (!lum_pack_check(p, count <= (uint64_t)(p->end - p->at))) {
            return;
        }
        *bytes = malloc((size_t)count + 1u);
        *len = (size_t)count;
        p->has_failed = *bytes == NULL;
    }
    lum_pack_bytes(p, *bytes, *len);
}

static void pack_entry(lum_pack *p, lum_index_entry *e, const lum_index *index)
{
    lum_pack_u32(p, &e->sensor);
    lum_pack_u32(p, &e->from);
    lum_pack_u64(p, &e->after);
    lum_pack_u64(p, &e->order);
    lum_pack_i64(p, &e->number);
    lum_pack_i64(p, &e->highest_ns);
    lum_pack_u32(p, &e->lines[LUM_EYE_BLUE]);
    lum_pack_u32(p, &e->lines[LUM_EYE_GREEN]);
    for (size_t i = 0; i < index->birth_count; i++) {
        lum_pack_u64(p, &e->active[i]);
    }
    pack_blob(p, &e->capture, &e->capture_len);
    pack_blob(p, &e->state, &e->state_len);
    (void)lum_pack_check(p, e->sensor < index->birth_count &&
                                e->after <= index->known &&
                                e->order < index->frames);
}

static void pack_births(lum_pack *p, lum_index *index)
{
    uint32_t count = (uint32_t)index->birth_count;
    lum_pack_u32(p, &count);
    if (!lum_pack_check(p, count <= LUM_DEMUX_SENSORS_MAX)) {
        return;
    }
    index->birth_count = count;
    for (uint32_t i = 0; i < count; i++) {
        lum_index_birth *b = &index->births[i];
        lum_pack_u64(p, &b->after);
        pack_blob(p, &b->capture, &b->capture_len);
    }
}

static void pack_origins(lum_pack *p, lum_index *index)
{
    uint32_t count = (uint32_t)index->origin_count;
    uint32_t sensors = 0;
    lum_pack_u32(p, &count);
    if (!lum_pack_check(p, count <= LUM_DEMUX_ORIGINS_MAX)) {
        return;
    }
    index->origin_count = count;
    for (uint32_t i = 0; i < count; i++) {
        lum_index_origin *o = &index->origins[i];
        lum_pack_u32(p, &o->is.address);
        lum_pack_text(p, o->is.interface, sizeof o->is.interface);
        lum_pack_u32(p, &o->is.sensor);
        lum_pack_u64(p, &o->is.since);
        lum_pack_u64(p, &o->known);
        (void)lum_pack_check(p, o->is.sensor <= sensors ||
                                    o->is.sensor == LUM_DEMUX_SENSORS_MAX);
        sensors += o->is.sensor == sensors;
    }
    (void)lum_pack_check(p, sensors == index->birth_count);
}

static void read_entries(lum_pack *p, lum_index *index, uint32_t count)
{
    for (uint32_t i = 0; i < count && !p->has_failed; i++) {
        lum_index_entry *entry = calloc(1, sizeof *entry);
        if (entry == NULL) {
            p->has_failed = true;
            return;
        }
        pack_entry(p, entry, index);
        const bool rises =
            index->count == 0 ||
            index->entries[index->count - 1u]->order < entry->order;
        if (lum_pack_check(p, rises)) {
            lum_index_add(index, entry);
        } else {
            lum_index_entry_free(entry);
        }
    }
}

static void pack_body(lum_pack *p, lum_index *index)
{
    uint32_t count = (uint32_t)index->count;
    uint32_t stride = index->stride;
    lum_pack_u64(p, &index->known);
    lum_pack_u64(p, &index->frames);
    lum_pack_bool(p, &index->is_whole);
    lum_pack_u32(p, &stride);
    pack_births(p, index);
    pack_origins(p, index);
    lum_pack_u32(p, &count);
    (void)lum_pack_check(p, stride != 0);
    if (lum_pack_is_reading(p)) {
        index->stride = stride;
        read_entries(p, index, count);
        (void)lum_pack_check(p, p->at == p->end);
    }
    for (size_t i = 0; i < count && !lum_pack_is_reading(p); i++) {
        pack_entry(p, index->entries[i], index);
    }
}

static void pack_key(lum_pack *p, lum_index_key *key)
{
    lum_pack_u64(p, &key->bytes);
    lum_pack_u32(p, &key->ends);
    lum_pack_u32(p, &key->options);
}

/* The states are those of one version alone. */
static void pack_version(lum_pack *p, char version[32])
{
    uint8_t len = (uint8_t)strlen(version);
    lum_pack_u8(p, &len);
    if (lum_pack_check(p, len < 32u)) {
        version[len] = '\0';
        lum_pack_bytes(p, version, len);
    }
}

bool lum_index_write(lum_index *index, const lum_index_key *key, lum_pack *pack)
{
    uint8_t head[BODY_AT] = {0};
    char version[32] = LUM_VERSION;
    lum_index_key k = *key;
    memcpy(head, magic, sizeof magic);
    store_u16(head + FORMAT_AT, FORMAT);
    lum_pack_bytes(pack, head, sizeof head);
    pack_version(pack, version);
    pack_key(pack, &k);
    pack_body(pack, index);
    if (pack->has_failed) {
        return false;
    }
    store_u32(pack->written + SUM_AT,
              lum_index_sum(0, pack->written + BODY_AT, pack->len - BODY_AT));
    return true;
}

static int check_head(const uint8_t *bytes, size_t len, lum_error *error)
{
    if (len < BODY_AT || memcmp(bytes, magic, sizeof magic) != 0) {
        return lum_error_set(error, "it is not an index");
    }
    const uint32_t format = load_u16(bytes + FORMAT_AT);
    if (format != FORMAT) {
        return lum_error_set(error, "its format is %u; %d can be read",
                             (unsigned)format, (int)FORMAT);
    }
    return load_u32(bytes + SUM_AT) ==
                   lum_index_sum(0, bytes + BODY_AT, len - BODY_AT)
               ? 0
               : lum_error_set(error, "it is damaged or cut short");
}

static int check_key(const lum_index_key *is, const lum_index_key *key,
                     lum_error *error)
{
    if (is->bytes != key->bytes || is->ends != key->ends) {
        return lum_error_set(error, "it is of another capture, or the capture "
                                    "has changed since");
    }
    return is->options == key->options
               ? 0
               : lum_error_set(error, "it was made with other options");
}

bool lum_index_read_body(lum_index *out, lum_pack *pack)
{
    pack_body(pack, out);
    if (pack->has_failed) {
        lum_index_clear(out);
    }
    return !pack->has_failed;
}

int lum_index_read(lum_index *out, const lum_index_key *key, const void *bytes,
                   size_t len, lum_error *error)
{
    const uint8_t *at = bytes;
    char version[32] = "";
    lum_index_key is = {0, 0, 0};
    if (check_head(at, len, error) != 0) {
        return -1;
    }
    lum_pack p = lum_pack_of(at + BODY_AT, len - BODY_AT);
    pack_version(&p, version);
    if (!p.has_failed && strcmp(version, LUM_VERSION) != 0) {
        return lum_error_set(error, "it was made by another version");
    }
    pack_key(&p, &is);
    if (!p.has_failed && check_key(&is, key, error) != 0) {
        return -1;
    }
    return !p.has_failed && lum_index_read_body(out, &p)
               ? 0
               : lum_error_set(error, "it is damaged");
}
