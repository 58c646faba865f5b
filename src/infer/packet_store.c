/* Packets that are looked at, by sensor. */
#include "state.h"

#include "lum/wire.h"

#include <stdlib.h>
#include <string.h>

#define BLOCK_BYTES ((size_t)1 << 20)
#define PAYLOAD_MAX 4096u

int lum_infer_store_init(lum_infer_store *store, uint32_t max)
{
    *store = (lum_infer_store){.max = max};
    store->packets = calloc(max, sizeof *store->packets);
    return store->packets == NULL ? -1 : 0;
}

void lum_infer_store_free(lum_infer_store *store)
{
    for (size_t i = 0; i < store->block_count; i++) {
        free(store->blocks[i]);
    }
    free(store->packets);
    memset(store, 0, sizeof *store);
}

/* @return room for bytes, NULL without memory. */
static uint8_t *bytes_of(lum_infer_store *store, size_t bytes)
{
    if (store->block_count == 0 || BLOCK_BYTES - store->used < bytes) {
        uint8_t *block = store->block_count == LUM_INFER_BLOCKS_MAX
                             ? NULL
                             : malloc(BLOCK_BYTES);
        if (block == NULL) {
            return NULL;
        }
        store->blocks[store->block_count++] = block;
        store->used = 0;
    }
    uint8_t *out = store->blocks[store->block_count - 1] + store->used;
    store->used += bytes;
    return out;
}

bool lum_infer_store_is_full(const lum_infer_store *store)
{
    return store->count >= store->max ||
           (store->block_count == LUM_INFER_BLOCKS_MAX &&
            BLOCK_BYTES - store->used < PAYLOAD_MAX);
}

/* The packet's sensor; LUM_INFER_SENSORS_MAX: there are too many. */
static unsigned sensor_of(lum_infer_store *store, uint32_t address)
{
    for (unsigned i = 0; i < store->counts.sensors; i++) {
        if (store->sensors[i] == address) {
            return i;
        }
    }
    if (store->counts.sensors < LUM_INFER_SENSORS_MAX) {
        store->sensors[store->counts.sensors] = address;
        return store->counts.sensors++;
    }
    return LUM_INFER_SENSORS_MAX;
}

/* Commands, answers and heartbeats: the types that the manual states. */
static bool is_control(const lum_record *record)
{
    const uint8_t *p = record->payload;
    const bool is_reserved_0 = p[9] == 0 && p[10] == 0 && p[11] == 0;
    return record->len == LUM_HEADER_BYTES ||
           (is_reserved_0 && p[8] >= 5 && p[8] <= 7);
}

static int keep(lum_infer_store *store, const lum_record *record,
                unsigned sensor)
{
    const size_t kept = record->len < PAYLOAD_MAX ? record->len : PAYLOAD_MAX;
    const size_t bytes =
        kept < LUM_INFER_HEAD_BYTES ? LUM_INFER_HEAD_BYTES : kept;
    uint8_t *copy = bytes_of(store, bytes);
    if (copy == NULL) {
        return -1;
    }
    memcpy(copy, record->payload, kept);
    memset(copy + kept, 0, bytes - kept);
    store->packets[store->count++] = (lum_infer_packet){
        .bytes = copy,
        .time_ns = record->time_ns,
        .len = (uint32_t)record->len,
        .kept = (uint32_t)kept,
        .sensor = (uint8_t)sensor,
        .is_reserved_0 = copy[9] == 0 && copy[10] == 0 && copy[11] == 0};
    return lum_infer_store_is_full(store) ? 0 : 1;
}

int lum_infer_store_add(lum_infer_store *store, const lum_record *record,
                        uint32_t sensor)
{
    static const uint8_t magic[] = {0xed, 0xfe, 0xf3, 0xa1,
                                    0xef, 0xbe, 0x34, 0x12};
    if (lum_infer_store_is_full(store)) {
        store->counts.left_out++;
        return 0;
    }
    store->counts.joined += record->kind == LUM_RECORD_JOINED;
    if (record->len < LUM_HEADER_BYTES ||
        memcmp(record->payload, magic, sizeof magic) != 0) {
        store->counts.foreign++;
        return 1;
    }
    if (is_control(record)) {
        store->counts.control++;
        return 1;
    }
    const unsigned index = sensor_of(store, sensor);
    if (index == LUM_INFER_SENSORS_MAX) {
        store->counts.left_out++;
        return 1;
    }
    return keep(store, record, index);
}
