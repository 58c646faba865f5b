#include "model.h"

#include "lum/clock.h"

#include <string.h>

void model_init(struct model *m, const lum_assembler_config *config,
                const lum_layout *layout)
{
    m->config = *config;
    m->line_span_us = layout->profile.line_span_us;
    const lum_field *clock = &layout->profile.group[LUM_FIELD_TIMESTAMP];
    m->clock_bits = clock->bits > 0 ? clock->bits : 8u * clock->bytes;
    m->clock_bits = m->clock_bits < 64u ? m->clock_bits : 63u;
    m->unit_ns = layout->profile.clock_unit_ns;
    m->ticks = m->clock_bits == 0 ? 0 : UINT64_C(1) << (m->clock_bits - 1u);
    for (unsigned e = 0; e < LUM_EYES; e++) {
        m->eye[e].open_count = 0;
    }
    model_end(m);
}

static bool is_within(int64_t a_us, int64_t b_us, uint32_t limit_us)
{
    return a_us >= b_us - limit_us && a_us <= b_us + limit_us;
}

static bool is_stray(struct model *m, struct model_eye *eye)
{
    const int64_t us = m->packet_us;
    m->place = MODEL_NEW;
    if (!eye->has_newest || is_within(us, eye->newest_us, m->config.gap_us)) {
        if (!eye->has_newest || us > eye->newest_us) {
            eye->newest_us = us;
        }
    } else if (eye->has_candidate &&
               is_within(us, eye->candidate_us, m->config.gap_us)) {
        m->place = MODEL_BREAK;
        eye->newest_us = us;
    } else {
        m->place = MODEL_STRAY;
        eye->has_candidate = true;
        eye->candidate_us = us;
        return true;
    }
    eye->has_newest = true;
    eye->has_candidate = false;
    m->ticks = m->packet_ticks;
    return false;
}

static bool is_late(const struct model *m, const struct model_eye *eye,
                    uint32_t number)
{
    for (unsigned i = 0; i < eye->closed_count; i++) {
        if (eye->closed[i].number == number &&
            is_within(m->packet_us, eye->closed[i].clock_us, m->line_span_us)) {
            return true;
        }
    }
    return eye->has_low && m->packet_us < eye->low_clock_us;
}

static void find_line(struct model *m, const struct model_eye *eye,
                      uint32_t number)
{
    for (unsigned i = 0; i < eye->open_count; i++) {
        const struct model_line *line = &eye->open[i];
        if (line->number == number) {
            m->target = i;
            if (is_within(m->packet_us, line->clock_us, m->line_span_us)) {
                m->place = MODEL_OPEN;
            } else if (m->packet_us < line->clock_us) {
                m->place = MODEL_LATE;
            } else {
                m->to_close = i + 1u;
            }
            return;
        }
    }
    if (is_late(m, eye, number)) {
        m->place = MODEL_LATE;
    } else if (eye->open_count == m->config.open_lines) {
        m->to_close = 1;
    }
}

void model_judge(struct model *m, const lum_group *group)
{
    struct model_eye *eye = &m->eye[group->eye];
    m->packet_ticks =
        lum_clock_extend(m->ticks, group->clock_raw, m->clock_bits);
    m->packet_us = lum_clock_us(m->packet_ticks, m->unit_ns);
    m->to_close = 0;
    if (is_stray(m, eye)) {
        return;
    }
    if (m->place == MODEL_BREAK) {
        m->to_close = eye->open_count;
    } else {
        find_line(m, eye, group->line);
    }
}

struct model_line model_close(struct model *m, unsigned eye, unsigned index)
{
    struct model_eye *e = &m->eye[eye];
    const struct model_line line = e->open[index];
    const unsigned r = m->config.reorder_lines;
    const unsigned kept = e->closed_count < r ? e->closed_count : r - 1u;
    e->open_count--;
    memmove(&e->open[index], &e->open[index + 1u],
            (e->open_count - index) * sizeof e->open[0]);
    memmove(&e->closed[1], &e->closed[0], kept * sizeof e->closed[0]);
    e->closed[0] = (struct model_closed){line.clock_us, line.number};
    e->closed_count = kept + 1u;
    if (line.accepted >= 2 &&
        (!e->has_low || line.low_clock_us > e->low_clock_us)) {
        e->has_low = true;
        e->low_clock_us = line.low_clock_us;
    }
    return line;
}

static void forget(struct model_eye *eye)
{
    eye->closed_count = 0;
    eye->has_low = false;
}

static struct model_line *open_line(const struct model *m,
                                    struct model_eye *eye, uint32_t number,
                                    int64_t arrival)
{
    struct model_line *line = &eye->open[eye->open_count++];
    *line = (struct model_line){.number = number,
                                .clock_us = m->packet_us,
                                .low_clock_us = INT64_MAX,
                                .arrival = arrival,
                                .last_arrival = arrival};
    return line;
}

/* Two that differ in a bit differ in many. */
static uint64_t mixed(uint64_t x)
{
    x *= UINT64_C(0x9e3779b97f4a7c15);
    return x ^ (x >> 29);
}

static uint64_t mixed_angle(uint32_t pixel, lum_angle angle)
{
    return mixed((uint64_t)pixel << 32 |
                 (uint32_t)(uint16_t)angle.azimuth << 16 |
                 (uint16_t)angle.elevation);
}

static bool is_marked(const uint32_t *marks, uint32_t pixel)
{
    return (marks[pixel / 32u] >> (pixel % 32u) & 1u) != 0;
}

static void mark(uint32_t *marks, uint32_t pixel)
{
    marks[pixel / 32u] |= UINT32_C(1) << (pixel % 32u);
}

static lum_result put_angles(struct model_line *line, const lum_group *group)
{
    const uint32_t first = group->first_sample_index;
    uint32_t there = 0;
    for (uint32_t i = 0; i < group->num_samples; i++) {
        there += is_marked(line->angle_marks, first + i) ? 1u : 0u;
    }
    if (there > 0) {
        return there == group->num_samples ? LUM_E_DUPLICATE : LUM_E_CONFLICT;
    }
    for (uint32_t i = 0; i < group->num_samples; i++) {
        const uint8_t *b = group->samples + (size_t)LUM_SAMPLE_BYTES * i;
        const lum_angle angle = {(int16_t)(uint16_t)(b[0] | b[1] << 8),
                                 (int16_t)(uint16_t)(b[2] | b[3] << 8)};
        mark(line->angle_marks, first + i);
        line->content.angle_sum += mixed_angle(first + i, angle);
    }
    line->content.angles += group->num_samples;
    return LUM_OK;
}

static uint32_t word_at(const lum_group *group, uint32_t i)
{
    const uint8_t *b = group->samples + (size_t)LUM_SAMPLE_BYTES * i;
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 |
           (uint32_t)b[3] << 24;
}

/* Words of a pixel keep their order, so the sum identifies each of them. */
static uint64_t mixed_word(uint32_t word, uint32_t place)
{
    return mixed((uint64_t)place << 32 | word);
}

static lum_result put_words(struct model_line *line, const lum_group *group,
                            uint32_t capacity, uint64_t *bad)
{
    uint16_t places[LUM_LINE_PIXELS] = {0};
    uint64_t sum = 0;
    uint32_t good = 0;
    uint32_t there = 0;
    for (uint32_t i = 0; i < group->num_samples; i++) {
        const uint32_t word = word_at(group, i);
        const uint32_t pixel = lum_word_pixel(word);
        if (lum_word_is_good(word)) {
            good++;
            sum += mixed_word(word, places[pixel]++);
            there += is_marked(line->word_marks, pixel) ? 1u : 0u;
        }
    }
    if (there > 0) {
        return there == good ? LUM_E_DUPLICATE : LUM_E_CONFLICT;
    }
    if (line->content.words + good > capacity) {
        return LUM_E_NO_ROOM;
    }
    for (uint32_t i = 0; i < group->num_samples; i++) {
        const uint32_t word = word_at(group, i);
        if (lum_word_is_good(word)) {
            mark(line->word_marks, lum_word_pixel(word));
        }
    }
    const uint64_t end =
        (uint64_t)group->first_sample_index + group->num_samples;
    line->sent += group->num_samples;
    if (end <= capacity && end > line->end) {
        line->end = end;
    }
    line->content.words += good;
    line->content.word_sum += sum;
    *bad += group->num_samples - good;
    return LUM_OK;
}

lum_result model_finish(struct model *m, const lum_group *group,
                        int64_t arrival, uint64_t *bad)
{
    struct model_eye *eye = &m->eye[group->eye];
    if (m->place <= MODEL_LATE) {
        return m->place == MODEL_STRAY ? LUM_E_STRAY : LUM_E_LATE;
    }
    if (m->place == MODEL_BREAK) {
        forget(eye);
    }
    struct model_line *line = m->place == MODEL_OPEN
                                  ? &eye->open[m->target]
                                  : open_line(m, eye, group->line, arrival);
    const lum_result r =
        group->tag == LUM_TAG_ANGLES
            ? put_angles(line, group)
            : put_words(line, group, m->config.words_per_line, bad);
    if (r == LUM_OK) {
        line->accepted++;
        line->last_arrival = arrival;
        if (m->packet_us < line->low_clock_us) {
            line->low_clock_us = m->packet_us;
        }
    }
    return r;
}

bool model_find_idle(const struct model *m, int64_t before, unsigned *eye,
                     unsigned *index)
{
    for (*eye = 0; *eye < LUM_EYES; ++*eye) {
        const struct model_eye *e = &m->eye[*eye];
        for (*index = 0; *index < e->open_count; ++*index) {
            if (e->open[*index].last_arrival < before) {
                return true;
            }
        }
    }
    return false;
}

void model_end(struct model *m)
{
    for (unsigned e = 0; e < LUM_EYES; e++) {
        m->eye[e].has_newest = false;
        m->eye[e].has_candidate = false;
        forget(&m->eye[e]);
    }
}

/* Adds up the marked ones of n pixels; those without a mark have angles 0. */
static bool add_angles(const lum_line *line, uint32_t first, uint32_t n,
                       uint64_t *sum)
{
    static const lum_angle none[32];
    const lum_angle *angles = &line->angles[first];
    if (line->angle_marks[first / 32u] == 0) {
        return memcmp(angles, none, n * sizeof *angles) == 0;
    }
    for (uint32_t i = 0; i < n; i++) {
        if (is_marked(line->angle_marks, first + i)) {
            *sum += mixed_angle(first + i, angles[i]);
        } else if (memcmp(&angles[i], none, sizeof *none) != 0) {
            return false;
        }
    }
    return true;
}

static bool angles_agree(const struct model_line *expected,
                         const lum_line *line)
{
    uint64_t sum = 0;
    for (uint32_t first = 0; first < LUM_LINE_PIXELS; first += 32u) {
        const uint32_t left = LUM_LINE_PIXELS - first;
        if (!add_angles(line, first, left < 32u ? left : 32u, &sum)) {
            return false;
        }
    }
    return sum == expected->content.angle_sum &&
           memcmp(expected->angle_marks, line->angle_marks,
                  sizeof expected->angle_marks) == 0;
}

static bool words_agree(const struct model_line *expected, const lum_line *line)
{
    uint64_t sum = 0;
    uint32_t before = 0;
    uint32_t place = 0;
    for (uint32_t i = 0; i < line->word_count; i++) {
        const uint32_t word = line->words[i];
        const uint32_t pixel = lum_word_pixel(word);
        if (!lum_word_is_good(word) || pixel < before) {
            return false;
        }
        place = i > 0 && pixel == before ? place + 1u : 0;
        before = pixel;
        sum += mixed_word(word, place);
    }
    return sum == expected->content.word_sum;
}

bool model_agrees(const struct model_line *expected, const lum_line *line)
{
    const uint64_t lost =
        expected->end > expected->sent ? expected->end - expected->sent : 0;
    return line->number == expected->number &&
           line->clock_us == expected->clock_us &&
           line->arrival == expected->arrival && line->lost_words == lost &&
           line->word_count == expected->content.words &&
           line->angle_count == expected->content.angles &&
           angles_agree(expected, line) && words_agree(expected, line);
}
