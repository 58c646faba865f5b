#include "sight.h"

#include <stdlib.h>
#include <string.h>

/* --- Making and freeing --- */

/* Eyes at the same place share a scene. */
static void share_scenes(lum_sight *s)
{
    const float *blue = s->mounts[LUM_EYE_BLUE];
    const float *green = s->mounts[LUM_EYE_GREEN];
    const bool same =
        blue[0] == green[0] && blue[1] == green[1] && blue[2] == green[2];
    s->scene_of[LUM_EYE_BLUE] = LUM_EYE_BLUE;
    s->scene_of[LUM_EYE_GREEN] = same ? LUM_EYE_BLUE : LUM_EYE_GREEN;
}

void lum_sight_init(lum_sight *out, const lum_place_options *options,
                    uint64_t seed, const lum_scan *scan, double rate_hz)
{
    memset(out, 0, sizeof *out);
    out->lines = scan->lines;
    out->rate_hz = rate_hz;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        memcpy(out->mounts[eye], lum_scan_mount(scan, eye),
               sizeof out->mounts[eye]);
    }
    share_scenes(out);
    lum_place_init(&out->place, options, seed);
}

static void free_kept(lum_sight *s, unsigned eye)
{
    for (uint32_t i = 0; s->kept[eye] != NULL && i < s->lines; i++) {
        free(s->kept[eye][i].hits);
    }
    free(s->kept[eye]);
    s->kept[eye] = NULL;
}

void lum_sight_free(lum_sight *sight)
{
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        lum_scene_free(&sight->scenes[eye]);
        free_kept(sight, eye);
    }
    free(sight->work.hits);
    sight->work.hits = NULL;
    sight->frame = 0;
}

const lum_place *lum_sight_place(const lum_sight *sight)
{
    return &sight->place;
}

/* --- Looking --- */

/* Without memory for lines to be kept, each frame is looked at. */
static lum_result make_room(lum_sight *s)
{
    if (s->work.hits == NULL) {
        s->work.hits =
            malloc(LUM_SCENE_HITS_MAX * LUM_LINE_PIXELS * sizeof *s->work.hits);
    }
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        if (s->kept[eye] == NULL && lum_place_is_still(&s->place)) {
            s->kept[eye] = calloc(s->lines, sizeof *s->kept[eye]);
        }
    }
    return s->work.hits != NULL ? LUM_OK : LUM_E_SPACE;
}

static lum_result set_scenes(lum_sight *s, int64_t frame)
{
    if (s->frame == frame || (s->frame != 0 && lum_place_is_still(&s->place))) {
        return LUM_OK;
    }
    const double time_s = (double)(frame - 1) / s->rate_hz;
    s->frame = 0;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        if (s->scene_of[eye] == eye &&
            lum_scene_set(&s->scenes[eye], &s->place, time_s, s->mounts[eye]) !=
                0) {
            return LUM_E_SPACE;
        }
    }
    s->frame = frame;
    return make_room(s);
}

/* Returns how many hits. */
static size_t cast(lum_sight *s, unsigned eye, const lum_scan_line *scan)
{
    const lum_scene *scene = &s->scenes[s->scene_of[eye]];
    size_t count = 0;
    for (uint32_t p = 0; p < LUM_LINE_PIXELS; p++) {
        float d[3];
        lum_place_turn(&s->place, scan->direction[p], d);
        const lum_ray ray = lum_ray_make(d);
        const size_t n = lum_scene_cast(scene, &ray, &s->work.hits[count]);
        s->work.counts[p] = (uint8_t)n;
        count += n;
    }
    return count;
}

static void keep(const lum_sight_line *work, size_t count, lum_sight_line *out)
{
    lum_hit *hits = malloc((count + 1) * sizeof *hits);
    if (hits != NULL) {
        *out = *work;
        out->hits = hits;
        memcpy(hits, work->hits, count * sizeof *hits);
    }
}

lum_result lum_sight_look(lum_sight *sight, int64_t frame, uint32_t line,
                          unsigned eye, const lum_scan_line *scan,
                          const lum_sight_line **out)
{
    if (set_scenes(sight, frame) != LUM_OK) {
        return LUM_E_SPACE;
    }
    lum_sight_line *kept =
        sight->kept[eye] != NULL ? &sight->kept[eye][line] : NULL;
    if (kept != NULL && kept->hits != NULL) {
        *out = kept;
        return LUM_OK;
    }
    const size_t count = cast(sight, eye, scan);
    if (kept != NULL) {
        keep(&sight->work, count, kept);
    }
    *out = &sight->work;
    return LUM_OK;
}
