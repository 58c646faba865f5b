#include "gateway.h"

#include "shared.h"

#include "lum/laser.h"
#include "lum/wire.h"

#include <string.h>

#define BEGUN      UINT32_C(0x6c756d67) /* hardly by chance */
#define US_PER_MS  1000u
#define NS_PER_US  1000u
#define CLOCK_BITS 32u /* of the sensor, in packets of data as in answers */

static bool is_zone(const zone *z)
{
    return z->min[0] <= z->max[0] && z->min[1] <= z->max[1] &&
           z->min[2] <= z->max[2] && z->range >= 0 && z->right <= z->left;
}

/* Other times would be safe too, but the machine would never move, or only in
 * jerks. No hold is long enough for 0 lines. */
static bool are_times(const gateway_config *c)
{
    const uint64_t lines = 2u * (uint64_t)c->lines + GATEWAY_OPEN_LINES;

    return c->frame_ms > 0 && c->silence_ms > c->frame_ms &&
           c->silence_ms <= AGE_MAX_MS &&
           (uint64_t)c->hold_ms * c->lines > c->frame_ms * lines;
}

static bool is_config(const gateway_config *c)
{
    return is_zone(&c->zone) && c->hits > 0 && are_times(c) && c->eyes != 0 &&
           c->eyes < 1u << LUM_EYES;
}

static bool has_clock(const lum_layout *layout)
{
    const lum_field *clock = &layout->profile.group[LUM_FIELD_TIMESTAMP];
    const unsigned bits = clock->bits > 0 ? clock->bits : 8u * clock->bytes;

    return bits == CLOCK_BITS && layout->profile.clock_unit_ns == NS_PER_US;
}

static bool is_begun(const gateway *g)
{
    return shared_load(&g->begun) == BEGUN;
}

/* A packet that is not old is not a stray: two strays would prove a jump of the
 * clock. */
static lum_result begin_assembly(gateway *g)
{
    const lum_assembler_storage storage =
        LUM_ASSEMBLER_STORAGE(g->slots, g->words, g->reach);
    const uint32_t gap_us = g->config.silence_ms * US_PER_MS;
    lum_assembler_config config;

    lum_assembler_config_default(&config);
    config.open_lines = GATEWAY_OPEN_LINES;
    config.reorder_lines = GATEWAY_REORDER_LINES;
    config.words_per_line = GATEWAY_LINE_WORDS;
    if (config.gap_us < gap_us) {
        config.gap_us = gap_us;
    }
    return lum_assembler_init(&g->assembler, &config, &g->layout, &storage);
}

static void begin_frames(gateway *g)
{
    for (uint32_t i = 0; i < GATEWAY_FRAMES; i++) {
        g->frames[i] = (gateway_frame){zone_empty(), i}; /* its place */
    }
}

static void fill(gateway *g, const gateway_config *config,
                 const gateway_output *output, const lum_layout *layout,
                 uint32_t now_ms)
{
    ring_init(&g->ring);
    heart_init(&g->heart, output->send, output->context, now_ms);
    g->config = *config;
    g->output = *output;
    g->layout = *layout;
    age_init(&g->age);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        look_init(&g->looks[eye]);
    }
    begin_frames(g);
}

lum_result gateway_init(gateway *g, const gateway_config *config,
                        const gateway_output *output,
                        const lum_calibration *calibration,
                        const lum_layout *layout, uint32_t now_ms)
{
    lum_result r;

    memset(g, 0, sizeof *g);
    g->reasons = GATEWAY_SILENT;
    if (!is_config(config) || !has_clock(layout) || output->send == NULL ||
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

static gateway_frame *place_of(gateway *g, uint32_t frame)
{
    return &g->frames[frame % GATEWAY_FRAMES];
}

/* Lines of a few frames come mixed, because packets are reordered. A line that
 * is later than that counts for the newer frame instead of none. Frame numbers
 * wrap after 2^32. */
static zone_sight *sight_of(gateway *g, uint32_t frame)
{
    gateway_frame *const f = place_of(g, frame);

    if (frame - f->number <= UINT32_MAX / 2u && frame != f->number) {
        *f = (gateway_frame){zone_empty(), frame};
    }
    return &f->sight;
}

/* Returns whether the line has points. */
static bool look_through(gateway *g, const lum_line *line, zone_sight *sight)
{
    bool has_points = false;

    for (uint32_t i = 0; i < line->word_count; i += GATEWAY_BLOCK) {
        const size_t n = lum_points_fixed_compute(
            &g->projector, line, i, GATEWAY_BLOCK, g->block, &g->losses);
        has_points = has_points || n > 0;
        zone_look(&g->config.zone, sight, g->block, n);
        if (g->output.points != NULL) {
            g->output.points(g->output.context, g->block, n);
        }
    }
    return has_points;
}

static void take_fresh(gateway *g, const lum_line *line, int64_t measured_ms)
{
    look *const eye = &g->looks[line->eye];
    zone_sight *const sight = sight_of(g, (uint32_t)line->frame);
    const uint32_t before = sight->hits;

    if (g->output.line != NULL) {
        g->output.line(g->output.context, line);
    }
    if (look_through(g, line, sight)) {
        look_see(eye, measured_ms);
    }
    look_take(eye, line, measured_ms, g->config.lines);
    if (sight->hits > before && sight->hits >= g->config.hits) {
        g->object = true;
    }
}

/* Its packets were fresh when they came; it may have waited since. */
static void take_line(gateway *g, const lum_line *line)
{
    const uint32_t age_ms =
        age_of(&g->age, (uint32_t)((uint64_t)line->clock_us), g->now_ms);

    if (age_ms < g->config.silence_ms) {
        take_fresh(g, line, g->now_ms - (int64_t)age_ms);
    } else {
        g->old_lines++;
    }
}

static void take_frame(gateway *g, int64_t frame)
{
    const gateway_frame *const f = place_of(g, (uint32_t)frame);
    const zone_sight sight =
        f->number == (uint32_t)frame ? f->sight : zone_empty();

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

/* The end of the stream: all open lines. */
static void flush(gateway *g)
{
    lum_result r;

    while ((r = lum_assembler_flush(&g->assembler)) > 0) {
        take_event(g, r);
    }
}

static lum_result push(gateway *g, const lum_group *group)
{
    lum_result r;

    while ((r = lum_assembler_push(&g->assembler, group, g->now_ms)) > 0) {
        take_event(g, r);
    }
    return r;
}

/* A packet dropped because of no room or a conflict may have been the end of
 * its line; the line does not show this. */
static void take_fresh_data(gateway *g, const lum_group *group)
{
    lum_result r = push(g, group);

    if (r == LUM_E_ORDER) { /* an event of another's push waits */
        look_spoil(&g->looks[LUM_EYE_BLUE], g->now_ms);
        look_spoil(&g->looks[LUM_EYE_GREEN], g->now_ms);
        flush(g);
        r = push(g, group);
    }
    if (r == LUM_E_NO_ROOM || r == LUM_E_CONFLICT) {
        look_spoil(&g->looks[group->eye], g->now_ms);
    }
}

/* While now_ms stands still nothing grows old, and no reason ends or begins by
 * time. Only the sensor's clock shows it. */
static bool shows_lag(const gateway *g, uint32_t clock_us)
{
    const uint32_t hold_ms = g->config.hold_ms;

    return age_is_ahead(&g->age, clock_us, g->now_ms,
                        hold_ms > AGE_AHEAD_MS ? AGE_AHEAD_MS : hold_ms - 1u);
}

/* The assembler does not get old packets: they would look like a jump of the
 * clock. */
static void take_data(gateway *g, const lum_group *group)
{
    const uint32_t clock_us = (uint32_t)group->clock_raw;

    if (shows_lag(g, clock_us)) {
        g->has_lagged = true;
    }
    if (age_of(&g->age, clock_us, g->now_ms) < g->config.silence_ms) {
        take_fresh_data(g, group);
    } else {
        g->old_packets++;
    }
}

static void take_answer(gateway *g, const uint8_t *bytes, size_t len)
{
    lum_timestamp answer;

    if (lum_timestamp_decode(bytes, len, &answer) == LUM_OK) {
        age_answer(&g->age, &answer, g->now_ms, g->config.silence_ms);
    }
}

/* Whether a status answers a recent poll: the sequence number of a poll is the
 * time. */
static bool is_lately(const gateway *g, uint32_t sequence)
{
    return (uint32_t)g->now_ms - sequence < g->config.silence_ms;
}

/* A packet with several statuses shows a hazard if one of them does. Only an
 * answer to a recent poll can show that the laser is up. */
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
    if (down) {
        g->laser_down = true;
        g->laser_was_down = true;
    } else if (told && is_lately(g, sequence)) {
        g->laser_down = false;
    }
}

/* Time only advances: if now_ms falls, it has wrapped. */
static void pass_time(gateway *g, uint32_t now_ms)
{
    g->now_ms += (int64_t)(now_ms - (uint32_t)g->now_ms);
}

static void take_datagram(gateway *g, const uint8_t *bytes, size_t len)
{
    lum_group group;
    const lum_packet_kind kind =
        lum_packet_decode(&g->layout, bytes, len, &group);

    g->kinds[kind]++;
    if (kind == LUM_PACKET_DATA) {
        take_data(g, &group);
    } else if (kind == LUM_PACKET_TIMESTAMP) {
        take_answer(g, bytes, len);
    } else if (kind == LUM_PACKET_TLV) {
        take_status(g, bytes, len);
    }
}

void gateway_datagram(gateway *g, const uint8_t *bytes, size_t len,
                      uint32_t now_ms)
{
    if (is_begun(g)) {
        pass_time(g, now_ms);
        take_datagram(g, bytes, len);
    }
}

/* Lengths are the driver's, and may come from the network. */
static void take_slot(gateway *g, const ring_slot *slot)
{
    if (slot->begin > RING_SLOT_BYTES ||
        slot->len > RING_SLOT_BYTES - slot->begin) {
        g->kinds[LUM_PACKET_MALFORMED]++;
    } else {
        take_datagram(g, slot->bytes + slot->begin, slot->len);
    }
}

static void close_idle_lines(gateway *g)
{
    const int64_t before = g->now_ms - (int64_t)g->config.silence_ms;
    lum_result r;

    while ((r = lum_assembler_close_idle(&g->assembler, before)) > 0) {
        take_event(g, r);
    }
}

/* A datagram that the ring dropped is missing in some line. Checked before each
 * datagram, because later ones may close that line in the same round. */
static void look_for_drops(gateway *g)
{
    const uint32_t dropped = ring_dropped(&g->ring);

    if (dropped != g->dropped_seen) {
        g->dropped_seen = dropped;
        look_spoil(&g->looks[LUM_EYE_BLUE], g->now_ms);
        look_spoil(&g->looks[LUM_EYE_GREEN], g->now_ms);
    }
}

/* How long the looks of the eyes are valid. */
static uint32_t lasts(const gateway *g)
{
    uint32_t shortest = UINT32_MAX;

    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        const uint32_t ms = look_lasts(&g->looks[eye], g->config.silence_ms,
                                       g->config.hold_ms, g->now_ms);
        if ((g->config.eyes >> eye & 1u) != 0 && ms < shortest) {
            shortest = ms;
        }
    }
    return shortest;
}

/* Also a stall that began and ended between two decisions. */
static bool has_stalled(uint32_t stalls, uint32_t seen)
{
    return stalls % 2u != 0 || stalls != seen;
}

static uint32_t find_causes(gateway *g, uint32_t stalls, bool is_blind)
{
    uint32_t causes = g->object ? GATEWAY_OBJECT : 0u;

    g->object = false;
    if (is_blind) {
        causes |= GATEWAY_SILENT;
    }
    if (g->laser_down || g->laser_was_down) {
        causes |= GATEWAY_LASER;
    }
    g->laser_was_down = false;
    if (has_stalled(stalls, g->stalls_seen) || g->has_lagged) {
        causes |= GATEWAY_STALLED;
    }
    g->has_lagged = false;
    return causes;
}

/* A stall counts as seen only after its reason is set, so that there is always
 * one of the two that shows it. */
static void decide(gateway *g, bool is_blind)
{
    const uint32_t stalls = heart_stalls(&g->heart);
    const uint32_t causes = find_causes(g, stalls, is_blind);
    uint32_t reasons = g->reasons | causes;

    for (unsigned i = 0; i < GATEWAY_REASONS; i++) {
        const uint32_t bit = UINT32_C(1) << i;
        if ((causes & bit) != 0) {
            g->since_ms[i] = g->now_ms;
        } else if (g->now_ms - g->since_ms[i] >= (int64_t)g->config.hold_ms) {
            reasons &= ~bit;
        }
    }
    shared_store(&g->reasons, reasons);
    shared_store(&g->stalls_seen, stalls);
}

/* A stopped machine only needs a sign of life. */
static void take_turn(gateway *g)
{
    const uint32_t lasts_ms = lasts(g);

    decide(g, lasts_ms == 0);
    heart_beat(&g->heart, lasts_ms == 0 ? g->config.silence_ms : lasts_ms);
}

unsigned gateway_receive(gateway *g, uint32_t now_ms)
{
    const ring_slot *slot;
    unsigned taken = 0;

    if (!is_begun(g)) {
        return 0;
    }
    pass_time(g, now_ms);
    while (taken < RING_SLOTS && (slot = ring_front(&g->ring)) != NULL) {
        look_for_drops(g);
        take_slot(g, slot);
        ring_release(&g->ring);
        taken++;
    }
    look_for_drops(g);
    close_idle_lines(g);
    take_turn(g);
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
    if (is_begun(g)) {
        flush(g);
    }
}
