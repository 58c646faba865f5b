#include "picture_internal.h"

#include <math.h>

#define CELLS      LUM_PANORAMA_CELLS
#define HALF_SCALE 32768.0
#define RADIANS    (3.14159265358979323846 / 180.0)
#define BLOCK      256u

/* Degrees around what an eye can see: it sees near points from beside the
 * sensor's origin. */
#define MARGIN 5.0f

/* Where a corner, a middle of a side or the middle of what an eye sees lies.
 * across, up: -1 to 1. */
static void look(const lum_eye_projector *eye, double across, double up,
                 double *azimuth, double *elevation)
{
    const double az = across * eye->azimuth_deg * HALF_SCALE * RADIANS;
    const double el =
        (eye->elevation_center + up * eye->elevation_deg * HALF_SCALE) *
        RADIANS;
    const double v[3] = {cos(el) * cos(az), cos(el) * sin(az), sin(el)};
    const float *m = eye->rotation;
    double out[3];
    for (unsigned i = 0; i < 3; i++) {
        out[i] = (double)m[3u * i] * v[0] + (double)m[3u * i + 1u] * v[1] +
                 (double)m[3u * i + 2u] * v[2];
    }
    *azimuth = atan2(out[1], out[0]) / RADIANS;
    *elevation = atan2(out[2], hypot(out[0], out[1])) / RADIANS;
}

static void widen(lum_image_view *v, const lum_eye_projector *eye,
                  double middle, int at)
{
    double azimuth = 0.0;
    double elevation = 0.0;
    const int row = at / 3;
    look(eye, at % 3 - 1, row - 1, &azimuth, &elevation);
    const double turned = remainder(azimuth - middle, 360.0) + middle;
    v->left_deg = fmaxf(v->left_deg, (float)turned + MARGIN);
    v->right_deg = fminf(v->right_deg, (float)turned - MARGIN);
    v->top_deg = fminf(fmaxf(v->top_deg, (float)elevation + MARGIN), 90.0f);
    v->bottom_deg =
        fmaxf(fminf(v->bottom_deg, (float)elevation - MARGIN), -90.0f);
}

static lum_image_view view_of(const lum_eye_projector *eye)
{
    const lum_image_view all = {180.0f, -180.0f, 90.0f, -90.0f, CELLS, CELLS};
    double middle = 0.0;
    double height = 0.0;
    look(eye, 0.0, 0.0, &middle, &height);
    lum_image_view v = {(float)middle, (float)middle, (float)height,
                        (float)height, CELLS,         CELLS};
    for (int i = 0; i < 9; i++) {
        widen(&v, eye, middle, i);
    }
    const bool is_part = eye->azimuth_deg * HALF_SCALE < 90.0 &&
                         v.left_deg - v.right_deg < 180.0f;
    return is_part ? v : all;
}

static void begin_eye(lum_panorama *p, const lum_projector *projector,
                      unsigned eye)
{
    lum_image_view_default(&p->view, 1u << eye, CELLS);
    p->view.columns = CELLS;
    if (projector != NULL) {
        p->view = view_of(&projector->eye[eye]);
    }
    (void)!lum_image_scale_init(&p->scale, &p->view);
}

void lum_raster_begin(lum_raster *raster, const lum_projector *projector)
{
    for (unsigned i = 0; i < LUM_EYES; i++) {
        begin_eye(&raster->eye[i], projector, i);
    }
}

/* -1: outside, or NaN. */
static int cell(float at, int cells)
{
    return at >= 0.0f && at < (float)cells ? (int)at : -1;
}

/* At most BLOCK samples. */
static void add_to_panorama(lum_panorama *p, const lum_sample *samples,
                            size_t n)
{
    float at[3][BLOCK];
    uint32_t pixels[BLOCK];
    for (size_t i = 0; i < n; i++) {
        at[0][i] = samples[i].x;
        at[1][i] = samples[i].y;
        at[2][i] = samples[i].z;
    }
    lum_image_pixels(&p->scale, at[0], at[1], at[2], n, pixels);
    for (size_t i = 0; i < n; i++) {
        const float range = samples[i].range;
        if (pixels[i] != LUM_IMAGE_NONE && range > 0.0f) {
            float *nearest = &p->nearest[pixels[i]];
            *nearest = *nearest > 0.0f && *nearest < range ? *nearest : range;
        }
    }
}

static void add_to_ground(lum_raster *raster, const lum_sample *s)
{
    const int half = LUM_GROUND_CELLS / 2;
    float reach = LUM_GROUND_REACH;
    for (int level = 0; level < LUM_GROUND_LEVELS; level++) {
        const float scale = (float)half / reach;
        const int row = cell((s->x + reach) * scale, LUM_GROUND_CELLS);
        const int column = cell((s->y + reach) * scale, LUM_GROUND_CELLS);
        if (row >= 0 && column >= 0) {
            uint8_t *count = &raster->ground[level][row][column];
            *count = (uint8_t)(*count + (*count < UINT8_MAX));
        }
        reach *= 2.0f;
    }
}

void lum_raster_add(lum_raster *raster, const lum_line_samples *line)
{
    lum_panorama *panorama = &raster->eye[line->eye < LUM_EYES ? line->eye : 0];
    for (size_t i = 0; i < line->count; i++) {
        const lum_sample *s = &line->samples[i];
        const int bin = cell(s->range / LUM_RANGE_BIN, LUM_RANGE_BINS);
        raster->ranges[bin >= 0 ? bin : LUM_RANGE_BINS - 1]++;
        add_to_ground(raster, s);
    }
    for (size_t i = 0; i < line->count; i += BLOCK) {
        const size_t left = line->count - i;
        add_to_panorama(panorama, line->samples + i,
                        left < BLOCK ? left : BLOCK);
    }
    raster->points += line->count;
}

float lum_raster_range(const lum_raster *raster, double share)
{
    const double wanted = share * (double)raster->points;
    uint64_t below = 0;
    for (int i = 0; i < LUM_RANGE_BINS && raster->points > 0; i++) {
        below += raster->ranges[i];
        if ((double)below >= wanted) {
            return (float)(i + 1) * LUM_RANGE_BIN;
        }
    }
    return 0.0f;
}
