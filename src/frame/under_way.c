#include "framer_internal.h"

static void add(lum_under_way *to, const lum_under_way *more)
{
    to->lines += more->lines;
    to->words += more->words;
    to->no_angle += more->no_angle;
}

static void take_away(lum_under_way *from, const lum_under_way *less)
{
    from->lines -= less->lines;
    from->words -= less->words;
    from->no_angle -= less->no_angle;
}

void lum_under_way_take(lum_under_way_state *u, const lum_line *line,
                        uint64_t no_angle)
{
    lum_under_way *last = &u->last[line->eye];
    const lum_under_way lacks = {
        .lines = line->angle_count < LUM_LINE_PIXELS ? 1u : 0u,
        .words = line->lost_words,
        .no_angle = no_angle};
    if (!u->has_joined[line->eye]) {
        u->has_joined[line->eye] = true;
        add(&u->counts, &lacks);
    } else if (u->is_leaving) {
        take_away(&u->counts, last);
        add(&u->counts, &lacks);
        *last = lacks;
    }
}

void lum_under_way_leave(lum_under_way_state *u)
{
    u->is_leaving = true;
}

void lum_under_way_join(lum_under_way_state *u)
{
    *u = (lum_under_way_state){.counts = u->counts};
}
