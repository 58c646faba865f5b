#include "gateway.h"

#include "shared.h"

#include "lum/laser.h"
#include "lum/wire.h"

#include <string.h>

#define BEGUN       UINT32_C(0x6c756d67) /* hardly by chance */
#define FRAME_LINES 64u                  /* a frame has as many or more */

static bool is_zone(const zone *z)
{
    return z->min[0] <= z->max[0] && z->min[1] <= z->max[1] &&
           z->min[2] <= z->max[2] && z->range >= 0 && z->right <= z->left;
}

/* A hold of less would let the machine move between two looks at a thing. */
static bool are_times(const gateway_config *c)
{
    const uint64_t lines = 2u * FRAME_LINES + GATEWAY_OPEN_LINES;

    return c->frame_ms > 0 && c->silence_ms > c->frame_ms &&
           (uint64_t)c->hold_ms * FRAME_LINES > c->frame_ms * lines;
}

static bool is_config(const gateway_config *c)
{
    return is_zone(&c->zone) && c->hits > 0 && are_times(c) && c->eyes != 0 &&
           c->eyes < 1u << LUM_EYES;
}

static bool is_begun(const gateway *g)
{
    return shared_load(&g->begun) == BEGUN;
}

static lum_result begin_assembly(gateway *g)
{
    const lum_assembler_storage storage =
        LUM_ASSEMBLER_STORAGE(g->slots, g->words, g->reach);
    lum_assembler_config config;

    lum_assembler_config_default(&config);
    config.open_lines = GATEWAY_OPEN_LINES;
    config.reorder_lines = GATEWAY_REORDER_LINES;
    config.words_per_line = GATEWAY_LINE_WORDS;
    return lum_assembler_init(&g->assembler, &config, &g->layout, &storage);
}

static void fill(gateway *g, const gateway_config *config,
                 const gateway_output *output, const lum_layout *layout,
                 uint32_t now_ms)
{
    ring_init(&g->ring);
    heart_init(&g->heart, output->send, output->context, config->silence_ms,
               now_ms);
    g->stalls_seen = heart_stalls(&g->heart);
    g->config = *config;
    g->output = *output;
    g->layout = *layout;
    g->silent = config->eyes;
    for (unsigned i = 0; i < GATEWAY_FRAMES; i++) {
        g->frames[i] = (gateway_frame){INT64_MIN, zone_empty()};
    }
}

lum_result gateway_init(gateway *g, const gateway_config *config,
                        const gateway_output *output,
                        const lum_calibration *calibration,
                        const lum_layout *layout, uint32_t now_ms)
{
    lum_result r;

    memset(g, 0, sizeof *g);
    g->reasons = GATEWAY_SILENT;
    if (!is_config(config) || output->send == NULL ||
        lum_fixed_projector_init(&g->projector, calibration, layout) !=
            LUM_OK) {
        return LUM_E_VALUE;
    }
    fill(g, config, output, layout, now_ms);
    r = begin_assembly(g);
    if (r == LUM_OK) {
        shared_store(&g->begun, BEGUN);
    }
    return r;
}

static gateway_frame *place_of(gateway *g, int64_t frame)
{
    return &g->frames[(uint64_t)frame % GATEWAY_FRAMES];
}

/* Lines of a few frames come mixed, since packets are reordered. A line that is
 * later than that counts for the newer frame, rather than for none. */
static zone_sight *sight_of(gateway *g, int64_t frame)
{
    gateway_frame *const f = place_of(g, frame);

    if (f->number < frame) {
        *f = (gateway_frame){frame, zone_empty()};
    }
    return &f->sight;
}

static void look(gateway *g, const lum_line *line, zone_sight *sight)
{
    for (uint32_t i = 0; i < line->word_count; i += GATEWAY_BLOCK) {
        const size_t n = lum_points_fixed_compute(
            &g->projector, line, i, GATEWAY_BLOCK, g->block, &g->losses);
        if (n > 0) {
            g->heard = (uint8_t)(g->heard | 1u << line->eye);
        }
        zone_look(&g->config.zone, sight, g->block, n);
        if (g->output.points != NULL) {
            g->output.points(g->output.context, g->block, n);
        }
    }
}

static void take_line(gateway *g, const lum_line *line)
{
    zone_sight *const sight = sight_of(g, line->frame);
    const uint32_t before = sight->hits;

    if (g->output.line != NULL) {
        g->output.line(g->output.context, line);
    }
    look(g, line, sight);
    if (sight->hits > before && sight->hits >= g->config.hits) {
        g->object = true;
    }
}

static void take_frame(gateway *g, int64_t frame)
{
    const gateway_frame *const f = place_of(g, frame);
    const zone_sight sight = f->number == frame ? f->sight : zone_empty();

    if (g->output.frame != NULL) {
        g->output.frame(g->output.context, frame, &sight);
    }
}

static void take_event(gateway *g, lum_result event)
{
    switch (event) {
    case LUM_LINE_READY:
        take_line(g, lum_assembler_line(&g->assembler));
        break;
    case LUM_FRAME_READY:
        take_frame(g, lum_assembler_frame(&g->assembler));
        break;
    case LUM_OK:
    case LUM_END:
    case LUM_E_SHORT:
    case LUM_E_SPACE:
    case LUM_E_VALUE:
    case LUM_E_FOREIGN:
    case LUM_E_TYPE:
    case LUM_E_MALFORMED:
    case LUM_E_UNKNOWN_TAG:
    case LUM_E_STRAY:
    case LUM_E_LATE:
    case LUM_E_DUPLICATE:
    case LUM_E_CONFLICT:
    case LUM_E_NO_ROOM:
    case LUM_E_ORDER:
    default: /* no event */
        break;
    }
}

static void take_data(gateway *g, const lum_group *group, int64_t time)
{
    lum_result r;

    while ((r = lum_assembler_push(&g->assembler, group, time)) > 0) {
        take_event(g, r);
    }
}

/* A packet with several statuses tells of a hazard if one of them does. */
static void take_status(gateway *g, const uint8_t *bytes, size_t len)
{
    lum_tlv_reader reader;
    lum_tlv tlv;
    uint32_t sequence;
    uint16_t status;
    bool told = false;
    bool down = false;

    if (lum_tlv_open(bytes, len, &sequence, &reader) != LUM_OK) {
        return;
    }
    while (lum_tlv_next(&reader, &tlv) == LUM_OK) {
        if (tlv.type == g->layout.profile.tlv[LUM_TLV_STATUS] &&
            lum_tlv_u16(&tlv, &status) == LUM_OK) {
            told = true;
            down = down || lum_laser_is_down(status);
        }
    }
    if (told) {
        g->laser_down = down;
        g->laser_was_down = g->laser_was_down || down;
    }
}

void gateway_datagram(gateway *g, const uint8_t *bytes, size_t len,
                      int64_t time)
{
    lum_group group;
    lum_packet_kind kind;

    if (!is_begun(g)) {
        return;
    }
    kind = lum_packet_decode(&g->layout, bytes, len, &group);
    g->kinds[kind]++;
    if (kind == LUM_PACKET_DATA) {
        take_data(g, &group, time);
    } else if (kind == LUM_PACKET_TLV) {
        take_status(g, bytes, len);
    }
}

/* An eye stays silent until it is heard, however long that takes. */
static void listen(gateway *g, uint32_t now_ms)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        const unsigned bit = 1u << eye;
        if ((g->heard & bit) != 0) {
            g->heard_ms[eye] = now_ms;
            g->silent = (uint8_t)(g->silent & ~bit);
        } else if (now_ms - g->heard_ms[eye] >= g->config.silence_ms) {
            g->silent = (uint8_t)(g->silent | (bit & g->config.eyes));
        }
    }
    g->heard = 0;
}

/* Also one that came and went between two decisions. */
static bool has_stalled(uint32_t stalls, uint32_t seen)
{
    return stalls % 2u != 0 || stalls != seen;
}

static uint32_t find_causes(gateway *g, uint32_t stalls)
{
    uint32_t causes = g->object ? GATEWAY_OBJECT : 0u;

    g->object = false;
    if (g->silent != 0) {
        causes |= GATEWAY_SILENT;
    }
    if (g->laser_down || g->laser_was_down) {
        causes |= GATEWAY_LASER;
    }
    g->laser_was_down = false;
    if (has_stalled(stalls, g->stalls_seen)) {
        causes |= GATEWAY_STALLED;
    }
    return causes;
}

/* A stall counts as seen once its reason stands, so that at no moment neither
 * tells of it. */
static void decide(gateway *g, uint32_t now_ms)
{
    const uint32_t stalls = heart_stalls(&g->heart);
    const uint32_t causes = find_causes(g, stalls);
    uint32_t reasons = g->reasons | causes;

    for (unsigned i = 0; i < GATEWAY_REASONS; i++) {
        const uint32_t bit = UINT32_C(1) << i;
        if ((causes & bit) != 0) {
            g->since_ms[i] = now_ms;
        } else if (now_ms - g->since_ms[i] >= g->config.hold_ms) {
            reasons &= ~bit;
        }
    }
    shared_store(&g->reasons, reasons);
    shared_store(&g->stalls_seen, stalls);
}

unsigned gateway_receive(gateway *g, uint32_t now_ms)
{
    const ring_slot *slot;
    unsigned taken = 0;

    if (!is_begun(g)) {
        return 0;
    }
    while (taken < RING_SLOTS && (slot = ring_front(&g->ring)) != NULL) {
        gateway_datagram(g, slot->bytes + slot->begin, slot->len, slot->time);
        ring_release(&g->ring);
        taken++;
    }
    listen(g, now_ms);
    decide(g, now_ms);
    heart_beat(&g->heart);
    return taken;
}

void gateway_tick(gateway *g, uint32_t now_ms)
{
    if (is_begun(g)) {
        heart_tick(&g->heart, now_ms);
    }
}

bool gateway_may_kick(gateway *g)
{
    return is_begun(g) && heart_has_ticked(&g->heart);
}

uint32_t gateway_reasons(const gateway *g)
{
    uint32_t seen;
    uint32_t stalls;
    uint32_t reasons;

    if (!is_begun(g)) {
        return GATEWAY_SILENT;
    }
    seen = shared_load(&g->stalls_seen);
    stalls = heart_stalls(&g->heart);
    reasons = shared_load(&g->reasons);
    return has_stalled(stalls, seen) ? reasons | GATEWAY_STALLED : reasons;
}

void gateway_finish(gateway *g)
{
    lum_result r;

    if (!is_begun(g)) {
        return;
    }
    while ((r = lum_assembler_flush(&g->assembler)) > 0) {
        take_event(g, r);
    }
}
