#include "framer_internal.h"

static void count(lum_under_way *all, const lum_under_way *line,
                  const lum_under_way *instead_of)
{
    all->lines += line->lines - instead_of->lines;
    all->words += line->words - instead_of->words;
    all->no_angle += line->no_angle - instead_of->no_angle;
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
        count(&u->counts, &lacks, &(lum_under_way){.lines = 0});
    } else if (u->is_leaving) {
        count(&u->counts, &lacks, last);
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
