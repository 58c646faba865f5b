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

int64_t lum_order_behind_ns(lum_order *order, const lum_field *field,
                            uint32_t unit_ns, int64_t time_ns,
                            const lum_group *group)
{
    const int64_t behind_ns = order->newest_ns - time_ns;
    if (!order->has_newest || behind_ns <= 0) {
        *order = (lum_order){true, time_ns, group->clock_raw};
        return 0;
    }
    if (field->bytes == 0) {
        return behind_ns;
    }
    const int64_t clock_ns =
        clock_behind_ns(order, field, unit_ns, group->clock_raw);
    return behind_ns >= clock_ns / 2 && behind_ns <= clock_ns + clock_ns / 2
               ? behind_ns
               : 0;
}
