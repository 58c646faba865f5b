#include "picture_internal.h"

#define HALF_SCALE 32768.0

/* Degrees of the typical calibration, used if there is no other. */
static const float typical[4] = {-30.0f, 60.0f, -17.0f, 20.0f};

static void set_axis(float *min, float *step, double center, double half,
                     double most)
{
    const double kept = half < most ? half : most;
    *min = (float)(center - kept);
    *step = (float)(2.0 * kept / LUM_PANORAMA_CELLS);
}

static void begin_eye(lum_panorama *p, const lum_eye_projector *eye)
{
    if (eye == NULL) {
        p->azimuth_min = typical[0];
        p->azimuth_step = typical[1] / (float)LUM_PANORAMA_CELLS;
        p->elevation_min = typical[2];
        p->elevation_step = typical[3] / (float)LUM_PANORAMA_CELLS;
        return;
    }
    set_axis(&p->azimuth_min, &p->azimuth_step, eye->azimuth_center,
             eye->azimuth_deg * HALF_SCALE, 180.0);
    set_axis(&p->elevation_min, &p->elevation_step, eye->elevation_center,
             eye->elevation_deg * HALF_SCALE, 90.0);
}

void lum_raster_begin(lum_raster *raster, const lum_projector *projector)
{
    for (unsigned i = 0; i < LUM_EYES; i++) {
        begin_eye(&raster->eye[i],
                  projector != NULL ? &projector->eye[i] : NULL);
    }
}

/* -1: outside, or NaN. */
static int cell(float at, int cells)
{
    return at >= 0.0f && at < (float)cells ? (int)at : -1;
}

static void add_to_panorama(lum_panorama *p, const lum_sample *s)
{
    const int column = cell((s->azimuth - p->azimuth_min) / p->azimuth_step,
                            LUM_PANORAMA_CELLS);
    const int row = cell((s->elevation - p->elevation_min) / p->elevation_step,
                         LUM_PANORAMA_CELLS);
    if (column >= 0 && row >= 0 && s->range > 0.0f) {
        float *nearest = &p->nearest[row][column];
        if (*nearest <= 0.0f || s->range < *nearest) {
            *nearest = s->range;
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
        add_to_panorama(panorama, s);
        add_to_ground(raster, s);
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
