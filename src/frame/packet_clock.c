/* Clocks and times of packets that are written, perhaps with another profile
 * than they came with. */
#include "packet_cut.h"

#include "core/field.h"

static const lum_field *clock_of(const lum_layout *layout)
{
    return &layout->profile.group[LUM_FIELD_TIMESTAMP];
}

/* A line that came with this clock goes round with it. */
static bool is_same_clock(const lum_layout *to, const lum_layout *from)
{
    return from == NULL ||
           (to->profile.clock_unit_ns == from->profile.clock_unit_ns &&
            field_bits(clock_of(to)) == field_bits(clock_of(from)));
}

bool lum_cut_keeps_clock(const lum_layout *to, const lum_layout *from)
{
    return from == NULL ||
           (to->profile.clock_unit_ns == from->profile.clock_unit_ns &&
            field_bits(clock_of(to)) <= field_bits(clock_of(from)));
}

bool lum_cut_keeps_head(const lum_layout *to, const lum_layout *from)
{
    if (from == NULL) {
        return true;
    }
    for (unsigned f = 0; f < LUM_GROUP_FIELDS; f++) {
        const lum_field *a = &to->profile.group[f];
        const lum_field *b = &from->profile.group[f];
        if (a->at != b->at || a->bytes != b->bytes || a->order != b->order ||
            a->low != b->low || a->bits != b->bits) {
            return false;
        }
    }
    return to->profile.samples_at == from->profile.samples_at;
}

uint64_t lum_cut_ticks(const lum_layout *layout, int64_t clock_us)
{
    const int64_t unit = layout->profile.clock_unit_ns;
    const int64_t whole = clock_us / unit * 1000;
    const int64_t rest = clock_us % unit * 1000; /* below 1e12 */
    const int64_t up = unit <= 1000 && rest > 0 && rest % unit != 0 ? 1 : 0;
    const int64_t down = unit > 1000 && rest < 0 && rest % unit != 0 ? 1 : 0;
    return (uint64_t)(whole + rest / unit + up - down);
}

/* Readers take the clock for the nearest one that fits its bits. */
int lum_cut_check_clock(const lum_layout *layout, const lum_raw_line *line,
                        const int64_t *before_us, lum_error *error)
{
    const unsigned bits = clock_bits(clock_of(layout));
    if (line->layout != NULL && bits > 0 && line->clock_us == 0 &&
        field_bits(clock_of(line->layout)) == 0) {
        return lum_error_set(
            error,
            "line %lu of the %s eye: its profile has no clock, and that of the "
            "file has one; give the line a clock, or write with a profile "
            "whose "
            "timestamp is none",
            (unsigned long)line->number, lum_cut_eye(line->eye));
    }
    if (bits == 0 || bits > 40u || before_us == NULL ||
        (line->packet_count > 0 && is_same_clock(layout, line->layout))) {
        return 0;
    }
    const int64_t half =
        (INT64_C(1) << (bits - 1u)) * layout->profile.clock_unit_ns / 1000;
    const int64_t step = line->clock_us - *before_us;
    if (step < half && step > -half) {
        return 0;
    }
    return lum_error_set(
        error,
        "line %lu of the %s eye: its clock is %lld us from that "
        "of the line before it; the profile's clock of %u bits "
        "tells less than %lld us",
        (unsigned long)line->number, lum_cut_eye(line->eye), (long long)step,
        bits, (long long)half);
}

int lum_cut_check_time(const lum_raw_line *line, lum_error *error)
{
    int64_t low = line->arrival_ns;
    for (size_t i = 0; i < line->packet_count; i++) {
        const int64_t ns = line->packets[i].arrival_ns;
        low = ns < low ? ns : low;
    }
    return low >= 0
               ? 0
               : lum_error_set(error,
                               "line %lu of the %s eye: its arrival is %lld "
                               "ns; right is 0 or more, in ns since 1970",
                               (unsigned long)line->number,
                               lum_cut_eye(line->eye), (long long)low);
}
