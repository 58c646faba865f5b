#include "order.h"

#include "core/field.h"

/* Beyond this a clock is corrupt, or began anew. */
#define BEHIND_MAX_NS INT64_C(1000000000000)

/* How far the sensor's clock is behind the newest record's; 0: not at all. */
static int64_t clock_behind_ns(const lum_order *order, const lum_field *field,
                               uint32_t unit_ns, uint64_t ticks)
{
    const uint64_t all = UINT64_MAX >> (64u - clock_bits(field));
    const uint64_t behind = (order->newest_ticks - ticks) & all;
    return behind <= all / 2u && behind < (uint64_t)BEHIND_MAX_NS / unit_ns
               ? (int64_t)(behind * unit_ns)
               : 0;
}

/* It is the latest now. */
static void go_on(lum_order *order, int64_t break_ns, int64_t time_ns,
                  uint64_t ticks)
{
    const bool is_break =
        !order->has_newest || time_ns - order->newest_ns > break_ns;
    *order = (lum_order){.has_newest = true,
                         .newest_ns = time_ns,
                         .newest_ticks = ticks,
                         .ahead = is_break ? 1u : order->ahead + 1u};
}

/* Whether it is one of more than stand ahead of it: then they are the ones that
 * are out of order. */
static bool has_majority(lum_order *order, int64_t time_ns)
{
    const bool is_in_row = order->behind != 0 && time_ns >= order->last_ns;
    order->behind = is_in_row ? order->behind + 1u : 1u;
    order->last_ns = time_ns;
    return order->behind > order->ahead;
}

/* By both clocks. */
static int64_t find_behind_ns(const lum_order *order, const lum_field *field,
                              uint32_t unit_ns, int64_t behind_ns,
                              uint64_t ticks)
{
    if (field->bytes == 0) {
        return behind_ns;
    }
    const int64_t clock_ns = clock_behind_ns(order, field, unit_ns, ticks);
    return behind_ns >= clock_ns / 2 && behind_ns <= clock_ns + clock_ns / 2
               ? behind_ns
               : 0;
}

int64_t lum_order_behind_ns(lum_order *order, const lum_field *field,
                            uint32_t unit_ns, int64_t break_ns, int64_t time_ns,
                            const lum_group *group)
{
    if (!order->has_newest || time_ns >= order->newest_ns) {
        go_on(order, break_ns, time_ns, group->clock_raw);
        return 0;
    }
    const int64_t behind_ns = find_behind_ns(
        order, field, unit_ns, order->newest_ns - time_ns, group->clock_raw);
    if (behind_ns > break_ns && has_majority(order, time_ns)) {
        const uint64_t behind = order->behind;
        order->has_newest = false;
        go_on(order, break_ns, time_ns, group->clock_raw);
        order->ahead = behind;
        return 0;
    }
    return behind_ns;
}
