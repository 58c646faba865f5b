/* Clocks and times of packets that are written, perhaps with another profile
 * than they came with. */
#include "packet_cut.h"

#include "core/field.h"
#include "lum/clock.h"

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

uint64_t lum_cut_ticks(const lum_layout *layout, int64_t clock_us)
{
    const int64_t unit = layout->profile.clock_unit_ns;
    const int64_t rest = clock_us % unit * 1000; /* below 1e12 */
    const uint64_t whole = (uint64_t)(clock_us / unit) * 1000u;
    const uint64_t up = rest > 0 && rest % unit != 0 ? 1u : 0u;
    const uint64_t ticks = whole + (uint64_t)(rest / unit) + up;
    const bool is_after =
        unit > 1000 && lum_clock_us(ticks, (uint32_t)unit) > clock_us;
    return is_after ? ticks - 1u : ticks;
}

/* Half a round of the clock; 0: nothing reaches it. */
static uint64_t half_us(const lum_layout *layout)
{
    const uint64_t unit = layout->profile.clock_unit_ns;
    const unsigned bits = clock_bits(clock_of(layout));
    const uint64_t half = bits > 0 ? UINT64_C(1) << (bits - 1u) : 0;
    if (bits <= 32u) {
        return half * unit / 1000u;
    }
    return half / 1000u <= UINT64_MAX / unit ? half / 1000u * unit : 0;
}

uint64_t lum_cut_extend(const lum_layout *layout, uint64_t near_ticks,
                        uint64_t clock_raw)
{
    const unsigned bits = clock_bits(clock_of(layout));
    return bits > 0 ? lum_clock_extend(near_ticks, clock_raw, bits) : 0;
}

/* How far a packet's clock is behind the line's: 0 if they are the same. */
static uint64_t clock_delta(const lum_layout *layout, int64_t clock_us,
                            uint64_t clock_raw)
{
    const uint64_t low = lum_cut_ticks(layout, clock_us);
    const uint64_t ticks = lum_cut_extend(layout, low, clock_raw);
    const bool is_same =
        clock_bits(clock_of(layout)) == 0 ||
        lum_clock_us(ticks, layout->profile.clock_unit_ns) == clock_us;
    return is_same ? 0 : low - ticks;
}

void lum_cut_move(lum_cut *cut, const lum_layout *to, const lum_raw_line *line)
{
    if (cut->is_anew || cut->count == 0) {
        return;
    }
    const lum_raw_packet first = cut->packets[0].head;
    const uint64_t ticks = clock_delta(line->layout != NULL ? line->layout : to,
                                       line->clock_us, first.clock_raw);
    const uint64_t ns = (uint64_t)line->arrival_ns - (uint64_t)first.arrival_ns;
    for (size_t i = 0; i < cut->count; i++) {
        lum_raw_packet *p = &cut->packets[i].head;
        p->clock_raw += ticks;
        p->arrival_ns = (int64_t)((uint64_t)p->arrival_ns + ns);
    }
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
    const uint64_t half = half_us(layout);
    if (half == 0 || before_us == NULL ||
        (line->packet_count > 0 && is_same_clock(layout, line->layout))) {
        return 0;
    }
    const bool is_up = line->clock_us > *before_us;
    const uint64_t step = is_up
                              ? (uint64_t)line->clock_us - (uint64_t)*before_us
                              : (uint64_t)*before_us - (uint64_t)line->clock_us;
    if (step < half) {
        return 0;
    }
    return lum_error_set(
        error,
        "line %lu of the %s eye: its clock is %llu us from that of the line "
        "before it; the profile's clock of %u bits needs less than %llu us",
        (unsigned long)line->number, lum_cut_eye(line->eye),
        (unsigned long long)step, bits, (unsigned long long)half);
}

int lum_cut_check_time(const lum_cut *cut, const lum_raw_line *line,
                       lum_error *error)
{
    int64_t low = line->arrival_ns;
    for (size_t i = 0; i < cut->count; i++) {
        const int64_t ns = cut->packets[i].head.arrival_ns;
        low = ns < low ? ns : low;
    }
    return low >= 0 ? 0
                    : lum_error_set(error,
                                    "line %lu of the %s eye: its arrival is "
                                    "%lld ns; use 0 or more, in ns since 1970",
                                    (unsigned long)line->number,
                                    lum_cut_eye(line->eye), (long long)low);
}
