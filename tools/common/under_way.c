#include "under_way.h"

void under_way_add(struct under_way_counts *to,
                   const struct under_way_counts *more)
{
    to->lines += more->lines;
    to->words += more->words;
    to->no_angle += more->no_angle;
}

static void take_away(struct under_way_counts *from,
                      const struct under_way_counts *less)
{
    from->lines -= less->lines;
    from->words -= less->words;
    from->no_angle -= less->no_angle;
}

void under_way_take(struct under_way *u, const lum_line *line,
                    uint64_t no_angle)
{
    struct under_way_counts *last = &u->last[line->eye];
    const struct under_way_counts lacks = {
        .lines = line->angle_count < LUM_LINE_PIXELS ? 1u : 0u,
        .words = line->lost_words,
        .no_angle = no_angle};
    if (!u->has_joined[line->eye]) {
        u->has_joined[line->eye] = true;
        under_way_add(&u->counts, &lacks);
    } else if (u->is_leaving) {
        take_away(&u->counts, last);
        under_way_add(&u->counts, &lacks);
        *last = lacks;
    }
}

void under_way_leave(struct under_way *u)
{
    u->is_leaving = true;
}
