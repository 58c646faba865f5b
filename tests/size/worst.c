/* The most instructions that one datagram can cost, found by a search: from
 * some bad ones it goes on by small changes of the datagram and of the line
 * that it comes to, and keeps each that costs no less. Any argument makes it
 * short. For one target, with what was found:
 *
 *     python3 tests/size/size.py build/worst --worst "M4F -O2" */
#include "count.h"

#include "lum/assembler.h"
#include "lum/packet.h"
#include "lum/receiver.h"
#include "port/port.h"
#include "port/text.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define OPEN_LINES    4u
#define LINE          2u /* the last that is open; one slot is free */
#define REORDER_LINES 8u
#define LINE_WORDS    4000u
#define MOST          363u /* words of a datagram, behind the shorter of both heads */
#define PIXEL_WORDS   300u /* most of a pixel */
#define CLOCK_STEP    200u /* microseconds between lines */
#define BAD           LUM_WORD_ZERO
#define STARTS        5u
#define TRIES         800u  /* from each start */
#define TRIES_ON      2400u /* from the best of these */
#define SHORTER       50u

/* What a datagram costs most as. */
enum target {
    ACCEPTED,
    DROPPED,
    RECEIVED,
    TARGETS
};

static const char *const names[2][TARGETS] = {
    {"worst", "worst_dropped", "worst_received"},
    {"wide", "wide_dropped", "wide_received"},
};

/* A line and a datagram. A receiver only remembers which pixels of its line had
 * words. */
struct scene {
    uint16_t line[LUM_LINE_PIXELS]; /* words of each pixel */
    uint16_t places[MOST];          /* of the datagram's words: pixels, BAD */
    uint16_t count;
    bool opens; /* the datagram is of a new line */
};

static lum_layout layout;
static uint32_t most; /* words of a datagram with this layout */
static struct datagram packet;
static lum_assembler assembler;
static lum_line_slot slots[LUM_ASSEMBLER_SLOTS(OPEN_LINES)];
static uint32_t words[LUM_ASSEMBLER_WORDS(OPEN_LINES, LINE_WORDS)];
static lum_reach reach[LUM_ASSEMBLER_REACH(REORDER_LINES)];
static lum_receiver receiver;
static uint32_t received[MOST];
static bool is_wrong;

/* The state before the datagram, and of which line. */
static struct {
    bool is_there;
    bool is_receivers;
    uint16_t line[LUM_LINE_PIXELS];
    lum_assembler assembler;
    lum_line_slot slot;
    uint32_t words[LINE_WORDS];
    lum_receiver receiver;
} before;

static uint32_t chance = 1; /* the same each time */

static uint32_t below(uint32_t n)
{
    chance ^= chance << 13;
    chance ^= chance >> 17;
    chance ^= chance << 5;
    return (uint32_t)((uint64_t)chance * n >> 32);
}

/* Short ones are as frequent as long ones. */
static uint32_t some(uint32_t n)
{
    const uint32_t at_most = n >> below(10);
    return 1u + below(at_most > 0 ? at_most : 1u);
}

static uint16_t any_place(void)
{
    return (uint16_t)(below(16) == 0 ? BAD : below(LUM_LINE_PIXELS));
}

static void make_packet(uint32_t line, const uint16_t *places, uint32_t count)
{
    const lum_group group = {.line = line,
                             .num_samples = count,
                             .clock_raw = (uint64_t)line * CLOCK_STEP,
                             .eye = LUM_EYE_BLUE,
                             .tag = LUM_TAG_RANGES};
    if (!datagram_begin(&packet, &layout, &group)) {
        is_wrong = true;
        return;
    }
    for (uint32_t i = 0; i < count; i++) {
        lum_group_word_encode(
            &layout, lum_word_make(9, true, places[i]) | (places[i] & BAD),
            datagram_sample(&packet, count, i));
    }
}

/* Pushes words of these places; cost is the push alone. */
static lum_result push(bool is_receivers, uint32_t line, const uint16_t *places,
                       uint32_t count, struct count *cost)
{
    lum_group group;
    lum_result r = LUM_E_TYPE;
    make_packet(line, places, count);
    const uint32_t begin = port_ticks();
    if (lum_packet_decode(&layout, packet.bytes, packet.len, &group) ==
        LUM_PACKET_DATA) {
        r = is_receivers ? lum_receiver_push(&receiver, &group)
                         : lum_assembler_push(&assembler, &group, 0);
    }
    count_add(cost, port_ticks() - begin, 1);
    return r;
}

/* Of the line before the datagram. */
static void prepare(bool is_receivers, uint32_t line, const uint16_t *places,
                    uint32_t count)
{
    struct count cost = {0, 0, 0};
    if (push(is_receivers, line, places, count, &cost) != LUM_OK) {
        is_wrong = true;
    }
}

/* Opens all lines but the last, of which the datagram is. */
static void begin_assembler(void)
{
    static const lum_assembler_storage storage =
        LUM_ASSEMBLER_STORAGE(slots, words, reach);
    const uint16_t first = 0;
    lum_assembler_config config;
    lum_assembler_config_default(&config);
    config.open_lines = OPEN_LINES;
    config.reorder_lines = REORDER_LINES;
    config.words_per_line = LINE_WORDS;
    if (lum_assembler_init(&assembler, &config, &layout, &storage) != LUM_OK) {
        is_wrong = true;
    }
    for (uint32_t n = 0; n < LINE; n++) {
        prepare(false, n, &first, 1);
    }
}

/* Pushes words to the line of the datagram, in order of pixels. A pixel's words
 * have to be in one packet. */
static void fill_line(const uint16_t *line, bool is_receivers)
{
    uint16_t places[MOST];
    uint32_t n = 0;
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
        const uint32_t has = is_receivers && line[p] > 1u ? 1u : line[p];
        if (n + has > most) {
            prepare(is_receivers, LINE, places, n);
            n = 0;
        }
        for (uint32_t i = 0; i < has; i++) {
            places[n++] = (uint16_t)p;
        }
    }
    prepare(is_receivers, LINE, places, n);
}

/* Makes the state before the datagram, or takes it out again. */
static void restore(const struct scene *s, bool is_receivers)
{
    lum_line_slot *slot = &slots[LINE];
    uint32_t *line_words = words + (size_t)LINE * LINE_WORDS;
    if (before.is_there && before.is_receivers == is_receivers &&
        memcmp(before.line, s->line, sizeof before.line) == 0) {
        if (is_receivers) {
            receiver = before.receiver;
        } else {
            assembler = before.assembler;
            *slot = before.slot;
            memcpy(line_words, before.words, sizeof before.words);
        }
        return;
    }
    if (is_receivers) {
        if (lum_receiver_init(&receiver, &layout, LUM_RECEIVER_GAP_US, received,
                              MOST) != LUM_OK) {
            is_wrong = true;
        }
    } else {
        begin_assembler();
    }
    fill_line(s->line, is_receivers);
    before.is_there = true;
    before.is_receivers = is_receivers;
    memcpy(before.line, s->line, sizeof before.line);
    before.receiver = receiver;
    before.assembler = assembler;
    before.slot = *slot;
    memcpy(before.words, line_words, sizeof before.words);
}

/* Of the push, if it ends as it is meant to. */
static struct count measure(const struct scene *s, enum target target)
{
    struct count cost = {0, 0, 0};
    restore(s, target == RECEIVED);
    const lum_result r = push(target == RECEIVED, LINE + (s->opens ? 1u : 0),
                              s->places, s->count, &cost);
    is_wrong = is_wrong || r > 0 || (target == ACCEPTED && r != LUM_OK);
    if (target == DROPPED && r == LUM_OK) {
        cost.ticks = 0;
    }
    return cost;
}

/* Adds words to a line or takes some away, at pixels by chance that are not
 * taken. */
static void resize_line(struct scene *s, const bool *is_taken, uint32_t has,
                        uint32_t wanted)
{
    uint32_t p = below(LUM_LINE_PIXELS);
    for (; has != wanted; p = p + 1u < LUM_LINE_PIXELS ? p + 1u : 0) {
        if (is_taken[p]) {
            continue;
        }
        const uint32_t all = has + PIXEL_WORDS - s->line[p];
        const uint32_t none = has - s->line[p];
        const uint32_t here = all < wanted    ? all
                              : none > wanted ? none
                                              : wanted;
        s->line[p] = (uint16_t)(s->line[p] + here - has);
        has = here;
    }
}

/* Makes the line full, and without the pixels of a datagram that has to be
 * taken. */
static void fit(struct scene *s, enum target target)
{
    bool is_taken[LUM_LINE_PIXELS] = {false};
    const bool is_apart = target != DROPPED && !s->opens;
    uint32_t good = 0;
    uint32_t has = 0;
    for (uint32_t i = 0; is_apart && i < s->count; i++) {
        if (s->places[i] < LUM_LINE_PIXELS) {
            good++;
            is_taken[s->places[i]] = true;
            s->line[s->places[i]] = 0;
        }
    }
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
        if (s->line[p] > PIXEL_WORDS) {
            s->line[p] = PIXEL_WORDS;
        }
        has += s->line[p];
    }
    resize_line(s, is_taken, has, LINE_WORDS - (target == ACCEPTED ? good : 0));
}

/* The datagram's pixels go down by twos, the line's words are between. */
static void start_between(struct scene *s)
{
    for (uint32_t p = 1; p < LUM_LINE_PIXELS; p += 2) {
        s->line[p] = 7;
    }
    s->count = (uint16_t)most;
    for (uint32_t i = 0; i < most; i++) {
        s->places[i] = (uint16_t)(2u * (most - 1u - i));
    }
}

/* The same, but a word above the line comes first: it looks in order. */
static void start_above(struct scene *s)
{
    start_between(s);
    s->places[0] = LUM_LINE_PIXELS - 1u;
    memset(&s->line[2u * most], 0,
           (LUM_LINE_PIXELS - 2u * most) * sizeof s->line[0]);
}

/* Each pixel of the datagram has a word in the line already. */
static void start_within(struct scene *s)
{
    start_between(s);
    for (uint32_t p = 0; p < 2u * most; p++) {
        s->line[p] = p % 2u == 0 ? 1u : 6u;
    }
}

static void start_by_chance(struct scene *s)
{
    for (uint32_t i = 0; i < LINE_WORDS; i++) {
        s->line[below(LUM_LINE_PIXELS)]++;
    }
    s->count = (uint16_t)most;
    for (uint32_t i = 0; i < most; i++) {
        s->places[i] = any_place();
    }
}

/* A new line. */
static void start_open(struct scene *s)
{
    start_by_chance(s);
    s->opens = true;
    for (uint32_t i = 0; i < most; i++) {
        s->places[i] = (uint16_t)(most - 1u - i);
    }
}

static void reverse(uint16_t *from, uint32_t n)
{
    for (uint32_t i = 0; i < n / 2u; i++) {
        const uint16_t first = from[i];
        from[i] = from[n - 1u - i];
        from[n - 1u - i] = first;
    }
}

static uint16_t moved(uint32_t place, int32_t by)
{
    const int32_t p = (int32_t)place + by;
    return place < LUM_LINE_PIXELS && p >= 0 && p < (int32_t)LUM_LINE_PIXELS
               ? (uint16_t)p
               : (uint16_t)place;
}

static void change_count(struct scene *s)
{
    const uint32_t n = some(s->count);
    if (below(2) == 0 && n < s->count) {
        s->count = (uint16_t)(s->count - n);
        return;
    }
    for (uint32_t i = 0; i < n && s->count < most; i++) {
        s->places[s->count++] = any_place();
    }
}

static void change_datagram(struct scene *s)
{
    const uint32_t i = below(s->count);
    const uint32_t n = some(s->count - i);
    uint16_t *run = &s->places[i];
    const int32_t step = (int32_t)below(9) - 4;
    const uint16_t first = any_place();
    const uint32_t turn = below(n);
    switch (below(7)) {
    case 0:
        run[0] = first;
        break;
    case 1: { /* two change places */
        uint16_t *other = &s->places[below(s->count)];
        const uint16_t place = *other;
        *other = run[0];
        run[0] = place;
        break;
    }
    case 2:
        reverse(run, n);
        break;
    case 3: /* a part of a run moves behind the rest of it */
        reverse(run, turn);
        reverse(run + turn, n - turn);
        reverse(run, n);
        break;
    case 4: /* in steps */
        for (uint32_t k = 0; k < n; k++) {
            run[k] = moved(first, step * (int32_t)k);
        }
        break;
    case 5:
        for (uint32_t k = 0; k < n; k++) {
            run[k] = moved(run[k], step);
        }
        break;
    default:
        change_count(s);
        break;
    }
}

/* Words move from a pixel to another, or those of a stretch to some of its
 * pixels, evenly. */
static void change_line(struct scene *s)
{
    const uint32_t p = below(LUM_LINE_PIXELS);
    if (below(2) == 0) {
        const uint32_t n = s->line[p] > 0 ? some(s->line[p]) : 0;
        const uint32_t other = below(LUM_LINE_PIXELS);
        s->line[p] = (uint16_t)(s->line[p] - n);
        s->line[other] = (uint16_t)(s->line[other] + n);
        return;
    }
    const uint32_t n = some(LUM_LINE_PIXELS - p);
    const uint32_t step = some(n);
    uint32_t sum = 0;
    for (uint32_t i = 0; i < n; i++) {
        sum += s->line[p + i];
        s->line[p + i] = 0;
    }
    for (uint32_t i = 0; sum > 0; i = i + step < n ? i + step : 0) {
        const uint32_t each = some(sum < 8 ? sum : 8);
        s->line[p + i] = (uint16_t)(s->line[p + i] + each);
        sum -= each;
    }
}

static void change(struct scene *s)
{
    do {
        switch (below(8)) {
        case 0:
        case 1:
            change_line(s);
            break;
        case 2:
            s->opens = !s->opens;
            break;
        default:
            change_datagram(s);
            break;
        }
    } while (below(3) == 0);
}

/* The clock's interrupt falls into some pushes; hardly twice into the same. */
static uint32_t climb(struct scene *best, enum target target, uint32_t tries)
{
    static struct scene trial;
    fit(best, target);
    uint32_t cost = measure(best, target).ticks;
    for (uint32_t i = 0; i < tries; i++) {
        trial = *best;
        change(&trial);
        fit(&trial, target);
        const uint32_t here = measure(&trial, target).ticks;
        const uint32_t again =
            here > cost ? measure(&trial, target).ticks : here;
        if (here >= cost && again >= cost) {
            *best = trial;
            cost = again < here ? again : here;
        }
    }
    return cost;
}

static void search(struct scene *best, enum target target, uint32_t divisor)
{
    static void (*const starts[STARTS])(struct scene *) = {
        start_between, start_above, start_within, start_by_chance, start_open};
    static struct scene scene;
    uint32_t cost = 0;
    for (unsigned i = 0; i < STARTS; i++) {
        memset(&scene, 0, sizeof scene);
        starts[i](&scene);
        const uint32_t here = climb(&scene, target, TRIES / divisor);
        if (i == 0 || here > cost) {
            cost = here;
            *best = scene;
        }
    }
    (void)climb(best, target, TRIES_ON / divisor);
}

/* The first runs of the datagram's pixels, with their steps and lengths. */
static void show(const struct scene *s)
{
    text line = {{0}, 0};
    text_put(&line, s->opens ? "a new line:" : "an open line:");
    for (uint32_t i = 0; i < s->count && line.len < TEXT_MAX - 40u;) {
        uint32_t end = i + 1u;
        const int32_t step = end < s->count ? s->places[end] - s->places[i] : 0;
        while (end < s->count && s->places[end] - s->places[end - 1u] == step) {
            end++;
        }
        text_put(&line, " ");
        text_put_number(&line, s->places[i]);
        if (end > i + 1u) {
            text_put(&line, step < 0 ? "" : "+");
            text_put_signed(&line, step);
            text_put(&line, "x");
            text_put_number(&line, end - i);
        }
        i = end;
    }
    text_put(&line, " of ");
    text_put_number(&line, s->count);
    text_end(&line);
}

static void report(const struct scene *s, enum target target, bool is_wide)
{
    const struct count cost = measure(s, target);
    is_wrong = is_wrong || cost.readings != 1;
    show(s);
    count_print(names[is_wide][target], &cost);
}

static void use_layout(const lum_profile *profile)
{
    lum_profile_fault fault;
    unsigned index = 0;
    if (lum_layout_init(&layout, profile, &fault, &index) != LUM_OK) {
        is_wrong = true;
    }
    most = (DATAGRAM_BYTES - profile->samples_at) / LUM_SAMPLE_BYTES;
    before.is_there = false;
}

/* What a profile can say that costs most: every field is some bits of the same
 * eight bytes, in the other order and high among them. */
static void make_wide(lum_profile *p)
{
    static const uint8_t bits[LUM_GROUP_FIELDS] = {2, 1, 4, 9, 1, 12};
    unsigned low = 64;
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        low -= bits[f];
        p->group[f] = (lum_field){12, 8, LUM_ORDER_BIG, (uint8_t)low, bits[f]};
    }
    p->samples_at = 20;
    p->angle_order = LUM_ELEVATION_AZIMUTH;
    p->clock_unit_ns = 1001;
}

/* From what was found for the usual profile on, with samples of either order;
 * the layout is then the worse. */
static void search_wide(struct scene *best, enum target target,
                        uint32_t divisor, lum_profile *profile)
{
    static struct scene other;
    other = *best;
    profile->sample_order = LUM_ORDER_LITTLE;
    use_layout(profile);
    const uint32_t cost = climb(best, target, TRIES / divisor);
    profile->sample_order = LUM_ORDER_BIG;
    use_layout(profile);
    if (climb(&other, target, TRIES / divisor) > cost) {
        *best = other;
        return;
    }
    profile->sample_order = LUM_ORDER_LITTLE;
    use_layout(profile);
}

/* A line without angles closes to make room for another. */
static void count_closing(void)
{
    struct count cost = {0, 0, 0};
    const uint16_t place = 0;
    begin_assembler();
    prepare(false, LINE, &place, 1);
    prepare(false, LINE + 1u, &place, 1);
    if (push(false, LINE + 2u, &place, 1, &cost) != LUM_LINE_READY) {
        is_wrong = true;
    }
    count_print("closing", &cost);
}

int main(int argc, char **argv)
{
    static struct scene best[TARGETS];
    const uint32_t divisor = argc > 1 ? SHORTER : 1u;
    lum_profile profile;
    (void)argv;
    count_print_scale();
    lum_profile_default(&profile);
    use_layout(&profile);
    for (unsigned t = 0; t < TARGETS; t++) {
        search(&best[t], (enum target)t, divisor);
        report(&best[t], (enum target)t, false);
    }
    count_closing();
    make_wide(&profile);
    for (unsigned t = 0; t < TARGETS; t++) {
        search_wide(&best[t], (enum target)t, divisor, &profile);
        report(&best[t], (enum target)t, true);
    }
    return is_wrong ? 1 : 0;
}
