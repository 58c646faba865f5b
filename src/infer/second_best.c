/* The second best reading as a profile. */
#include "fields.h"

#include "lum/group.h"

#include <string.h>

/* Profiles that differ in fewer packets are the same, but for corruption. */
#define OTHER 0.01

/* --- The profile --- */

/* A number's upper bytes may be those of the clock beside it, if they never
 * change. */
static lum_field lower_bytes(lum_field line, lum_field clock)
{
    while (line.bytes > 1 && line.bits == 0 &&
           lum_infer_share_bits(line, clock)) {
        line.bytes /= 2;
        line.at = (uint8_t)(line.order == LUM_ORDER_BIG ? line.at + line.bytes
                                                        : line.at);
    }
    return line;
}

/* What stands where the reading has its line or eye cannot be the clock. */
static void clear_clock(lum_profile *profile)
{
    lum_field *clock = &profile->group[LUM_FIELD_TIMESTAMP];
    lum_field *line = &profile->group[LUM_FIELD_LINE];
    const lum_field lower = lower_bytes(*line, *clock);
    *line = lum_infer_share_bits(lower, *clock) ? *line : lower;
    if (lum_infer_share_bits(*line, *clock) ||
        lum_infer_share_bits(profile->group[LUM_FIELD_EYE], *clock)) {
        *clock = (lum_field){.bytes = 0};
    }
}

/* @return false where the reading has no place for the eye. */
static bool set_reading(lum_profile *profile, const lum_infer_reading *reading)
{
    profile->group[LUM_FIELD_LINE] = reading->line;
    if (reading->is_one_eye) {
        /* The other eye's lines are this one's. */
        return false;
    }
    profile->group[LUM_FIELD_EYE] = reading->eye;
    memcpy(profile->eye_values, reading->eye_value, sizeof reading->eye_value);
    clear_clock(profile);
    return reading->line.bytes > 0 && reading->eye.bytes > 0;
}

static bool set_rival(const lum_infer_state *state, unsigned field,
                      lum_profile *profile)
{
    if (field == LUM_FIELD_LINE) {
        return set_reading(profile, &state->readings.other_line);
    }
    if (field == LUM_FIELD_EYE) {
        return set_reading(profile, &state->readings.other_eye);
    }
    if (field == LUM_FIELD_TIMESTAMP) {
        profile->clock_unit_ns = state->clock.rival_unit_ns;
    }
    profile->group[field] = state->field[field].rival;
    return state->field[field].rival.bytes > 0;
}

/* --- Whether its points are others --- */

static bool is_same(const lum_group *a, const lum_group *b, unsigned flip)
{
    return a->tag == b->tag && a->eye == (b->eye ^ flip) &&
           a->line == b->line && a->num_samples == b->num_samples &&
           a->first_sample_index == b->first_sample_index;
}

/* Whether two layouts decode the packets alike, but for the names of the
 * eyes. Clocks count only where they are asked for: they have other ticks. */
static bool decodes_alike(const lum_infer_state *state, const lum_layout *a,
                          const lum_layout *b)
{
    size_t other[2] = {0, 0};
    for (size_t i = 0; i < state->data.count; i++) {
        const lum_infer_packet *p = state->data.at[i];
        lum_group x;
        lum_group y;
        const bool is_x = lum_group_decode(a, p->bytes, p->len, &x) == LUM_OK;
        const bool is_y = lum_group_decode(b, p->bytes, p->len, &y) == LUM_OK;
        for (unsigned flip = 0; flip < 2; flip++) {
            other[flip] +=
                is_x != is_y || (is_x && is_y && !is_same(&x, &y, flip));
        }
    }
    const size_t least = other[0] < other[1] ? other[0] : other[1];
    return (double)least < OTHER * (double)state->data.count;
}

void lum_infer_second(const lum_infer_state *state, unsigned field,
                      lum_infer_result *out)
{
    lum_layout found;
    lum_layout second;
    out->second = out->profile;
    out->has_second =
        set_rival(state, field, &out->second) &&
        lum_layout_init(&found, &out->profile, NULL, NULL) == LUM_OK &&
        lum_layout_init(&second, &out->second, NULL, NULL) == LUM_OK &&
        (field == LUM_FIELD_TIMESTAMP ||
         !decodes_alike(state, &found, &second));
}
