#include "gather.h"

#include "stage.h"

void gather_end(struct gather *gather)
{
    for (size_t i = 0; i < gather->members; i++) {
        picture_drop(&gather->member[i].newest);
    }
    picture_drop(&gather->next);
}

static void put(struct gather_member *m, struct picture *picture)
{
    picture_drop(&m->newest);
    m->newest = *picture;
    m->has_newest = true;
    m->is_new = true;
    *picture = (struct picture){0};
}

/* Times of 0 are not known. */
static bool is_late(const struct gather *g, const struct gather_member *m,
                    const struct picture *picture)
{
    return m->missed == GATHER_OLD && g->count >= (int64_t)GATHER_OLD &&
           picture->arrival_ns < g->begin_ns[(g->count + 1) % GATHER_OLD];
}

void gather_put(struct gather *gather, size_t member, struct picture *picture)
{
    struct gather_member *m = &gather->member[member];
    if (is_late(gather, m, picture)) {
        picture_drop(picture);
        gather->late++;
        gather->late_member = member;
        return;
    }
    if (!m->is_new) {
        put(m, picture);
        return;
    }
    gather->next = *picture;
    gather->next_member = member;
    gather->has_next = true;
    *picture = (struct picture){0};
}

/* One that never sent is waited for too, and as long. */
static bool is_due(const struct gather *g, bool is_end)
{
    bool has_new = false;
    bool lacks_one = false;
    for (size_t i = 0; i < g->members; i++) {
        const struct gather_member *m = &g->member[i];
        has_new |= m->is_new;
        lacks_one |= !m->is_new && m->missed < GATHER_OLD;
    }
    return g->has_next || (has_new && (is_end || !lacks_one));
}

/* A frame that began before points were wanted has none, and is left out. The
 * others have common views. */
static void find_views(const struct gather *g, struct feed_views *out)
{
    bool has_any = false;
    for (size_t i = 0; i < g->members; i++) {
        const struct feed_views *views = &g->member[i].newest.views;
        size_t kept = 0;
        if (views->count == 0) {
            continue;
        }
        if (!has_any) {
            *out = *views;
            has_any = true;
        }
        for (size_t k = 0; k < out->count; k++) {
            if (feed_views_find(views, &out->at[k]) < views->count) {
                out->at[kept++] = out->at[k];
            }
        }
        out->count = kept;
    }
}

static void add_part(struct picture *out, const struct picture *from,
                     size_t member)
{
    struct picture_part *part = &out->part[out->parts];
    part->sensor = (uint8_t)member;
    part->frame = from->frame;
    for (size_t i = 0; i < out->views.count; i++) {
        const lum_frame *points = picture_points(from, &out->views.at[i]);
        out->points[out->parts][i] = lum_frame_keep(points);
    }
    out->parts++;
    out->lines += from->lines;
    out->lost_words += from->lost_words;
    loss_add(&out->loss, &from->loss);
    out->cut += from->cut;
}

/* The new frame that began first. */
static const struct picture *find_first(const struct gather *g)
{
    const struct picture *first = NULL;
    for (size_t i = 0; i < g->members; i++) {
        const struct gather_member *m = &g->member[i];
        if (m->is_new &&
            (first == NULL || m->newest.arrival_ns < first->arrival_ns)) {
            first = &m->newest;
        }
    }
    return first;
}

static void join(struct gather *g, struct picture *out)
{
    const struct picture *first = find_first(g);
    *out = (struct picture){.frame = ++g->count,
                            .arrival_ns = first->arrival_ns,
                            .clock_us = first->clock_us,
                            .begin_utc_ns = first->begin_utc_ns,
                            .utc_error_ns = first->utc_error_ns,
                            .sensor = first->sensor};
    g->begin_ns[g->count % GATHER_OLD] = first->arrival_ns;
    find_views(g, &out->views);
    for (size_t i = 0; i < g->members; i++) {
        const struct gather_member *m = &g->member[i];
        if (m->has_newest &&
            (out->views.count == 0 || m->newest.views.count > 0)) {
            add_part(out, &m->newest, i);
        }
    }
}

static void age(struct gather_member *m)
{
    m->missed = m->is_new ? 0 : m->missed + (m->missed < GATHER_OLD);
    m->is_new = false;
    if (m->missed == GATHER_OLD) {
        picture_drop(&m->newest);
        m->has_newest = false;
    }
}

bool gather_take(struct gather *gather, bool is_end, struct picture *out)
{
    if (!is_due(gather, is_end)) {
        return false;
    }
    join(gather, out);
    for (size_t i = 0; i < gather->members; i++) {
        age(&gather->member[i]);
    }
    if (gather->has_next) {
        gather->has_next = false;
        put(&gather->member[gather->next_member], &gather->next);
    }
    return true;
}
