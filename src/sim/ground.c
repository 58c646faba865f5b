#include "ground.h"

#include <math.h>

/* Where the next dash of a centre line begins. */
#define DASH_M 6.0f

/* What lum_ray_make() has for a ray that does not move along an axis. */
#define FLAT 1e9f

static bool is_paint(float along, float across)
{
    const float dash = along / DASH_M;
    return fabsf(across) < 0.08f && dash - floorf(dash) < 0.5f;
}

/* Paint on the road returns more light than asphalt. */
static float road_reflectivity(const lum_ground *g, float x, float y)
{
    const float middle = 0.5f * (g->kerb_left_y + g->kerb_right_y);
    const float across = y - middle;
    const float zebra = x - g->crossing_x;
    if (zebra > 0.0f && zebra < 3.5f) {
        return across - floorf(across) < 0.5f ? 0.75f : 0.18f;
    }
    return is_paint(x - g->marks_x, across) ? 0.75f : 0.18f;
}

/* A low ray reaches the road over a pavement, hits a kerb's face, or comes from
 * above; both kerbs are between the same two heights. */
static void cast_street(const lum_ground *g, const lum_ray *ray, lum_hit *hit)
{
    const float high = g->pavement_z * ray->inverse[2];
    const float y = high * ray->d[1];
    const bool on_road = y > g->kerb_right_y && y < g->kerb_left_y;
    const float kerb = ray->d[1] > 0.0f ? g->kerb_left_y : g->kerb_right_y;
    const float face = kerb * ray->inverse[1];
    const float low = g->road_z * ray->inverse[2];
    if (!on_road) {
        hit->range = high;
        hit->reflectivity = 0.3f;
    } else if (face > high && face < low) {
        hit->range = face;
        hit->reflectivity = 0.35f;
        hit->cosine = fabsf(ray->d[1]);
    } else {
        hit->range = low;
        hit->reflectivity =
            road_reflectivity(g, low * ray->d[0], low * ray->d[1]);
    }
}

/* --- Roads of a town --- */

/* How far a ray that is within some road at t stays within it. */
static float leave_road(const lum_ground *g, const lum_ray *ray, float t,
                        int *axis)
{
    float end = t;
    for (int a = 0; a < 2; a++) {
        const int across = 1 - a;
        const float at = ray->d[across] * t;
        const float half =
            ray->d[across] > 0.0f ? LUM_ROAD_HALF : -LUM_ROAD_HALF;
        for (unsigned i = 0; i < g->roads.count[a]; i++) {
            const float middle = g->roads.middle[a][i];
            const float kerb = ray->inverse[across] >= FLAT
                                   ? FLAT
                                   : (middle + half) * ray->inverse[across];
            if (fabsf(at - middle) < LUM_ROAD_HALF + 1e-4f && kerb > end) {
                end = kerb;
                *axis = across;
            }
        }
    }
    return end;
}

static bool is_on_road(const lum_ground *g, float x, float y)
{
    const float at[2] = {x, y};
    for (int a = 0; a < 2; a++) {
        for (unsigned i = 0; i < g->roads.count[a]; i++) {
            if (fabsf(at[1 - a] - g->roads.middle[a][i]) < LUM_ROAD_HALF) {
                return true;
            }
        }
    }
    return false;
}

static float town_reflectivity(const lum_ground *g, float x, float y)
{
    const float at[2] = {x - g->marks_x, y - g->roads.marks_y};
    for (int a = 0; a < 2; a++) {
        for (unsigned i = 0; i < g->roads.count[a]; i++) {
            const float across = (a == 0 ? y : x) - g->roads.middle[a][i];
            if (is_paint(at[a], across)) {
                return 0.75f;
            }
        }
    }
    return 0.18f;
}

/* As in a street; between the two heights a ray may go from road to road. */
static void cast_town(const lum_ground *g, const lum_ray *ray, lum_hit *hit)
{
    const float high = g->pavement_z * ray->inverse[2];
    const float low = g->road_z * ray->inverse[2];
    int axis = 2;
    float end = high;
    if (!is_on_road(g, high * ray->d[0], high * ray->d[1])) {
        hit->range = high;
        hit->reflectivity = 0.3f;
        return;
    }
    float next = leave_road(g, ray, high, &axis);
    while (next > end && next < low) {
        end = next;
        next = leave_road(g, ray, end, &axis);
    }
    if (next < low) {
        hit->range = end;
        hit->reflectivity = 0.35f;
        hit->cosine = fabsf(ray->d[axis]);
        return;
    }
    hit->range = low;
    hit->reflectivity = town_reflectivity(g, low * ray->d[0], low * ray->d[1]);
}

/* --- Both --- */

bool lum_ground_cast(const lum_ground *g, const lum_ray *ray, lum_hit *hit)
{
    if (!g->is_there || ray->d[2] >= 0.0f) {
        return false;
    }
    *hit = (lum_hit){.cover = 1.0f,
                     .cosine = -ray->d[2],
                     .object = LUM_OBJECT_GROUND,
                     .thing = LUM_THING_GROUND};
    (g->roads.count[0] != 0 ? cast_town : cast_street)(g, ray, hit);
    return hit->range > LUM_SHAPE_NEAREST && hit->range < LUM_STREET_REACH;
}

lum_ground lum_ground_seen_from(const lum_ground *ground, const float by[3])
{
    lum_ground g = *ground;
    g.road_z -= by[2];
    g.pavement_z -= by[2];
    g.kerb_right_y -= by[1];
    g.kerb_left_y -= by[1];
    g.marks_x -= by[0];
    g.crossing_x -= by[0];
    g.roads.marks_y -= by[1];
    for (int a = 0; a < 2; a++) {
        for (unsigned i = 0; i < g.roads.count[a]; i++) {
            g.roads.middle[a][i] -= by[1 - a];
        }
    }
    return g;
}
