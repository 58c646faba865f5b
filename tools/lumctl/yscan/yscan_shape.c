#include "yscan_shape.h"

#include "../../common/number.h"

#include <stdio.h>
#include <string.h>

#define TEXT_BYTES 1024
#define FIELDS     6 /* one more than any shape takes */
#define SIGMA_MIN  0.01
#define WEIGHT_MAX 1000000

static const char grammar[] =
    "uniform[:MIN:MAX], gaussian:CENTER:SIGMA[:MIN:MAX], "
    "regions:MIN..MAX=WEIGHT,... or csv:FILE, in degrees";

static int32_t to_udeg(double degrees)
{
    return (int32_t)(degrees * 1e6 + (degrees < 0.0 ? -0.5 : 0.5));
}

static bool parse_between(const char *text, double min, double max,
                          int32_t *udeg)
{
    double degrees = 0.0;
    const bool good = number_parse_real(text, min, max, &degrees);
    *udeg = good ? to_udeg(degrees) : *udeg;
    return good;
}

bool yscan_parse_degrees(const char *text, int32_t *udeg)
{
    return parse_between(text, -90.0, 90.0, udeg);
}

const char *yscan_csv_name(const char *text)
{
    return strncmp(text, "csv:", 4) == 0 ? text + 4 : NULL;
}

static enum exit_status refuse(const char *spec, const char *field,
                               const char *allowed)
{
    return ctl_complain(EXIT_BAD, "yscan: --shape %.60s: '%.40s' is not %s",
                        spec, field, allowed);
}

static enum exit_status refuse_degrees(const char *spec, const char *field)
{
    return refuse(spec, field, "a number of degrees from -90 to 90");
}

/* The lower end is in text[0], the upper one in text[1]. */
static enum exit_status take_ends(const char *spec, char *const *text,
                                  int32_t *min, int32_t *max)
{
    for (int i = 0; i < 2; i++) {
        if (!yscan_parse_degrees(text[i], i == 0 ? min : max)) {
            return refuse_degrees(spec, text[i]);
        }
    }
    if (*min >= *max) {
        return ctl_complain(EXIT_BAD,
                            "yscan: --shape %.60s: %s is not below %s; the "
                            "lower end comes first",
                            spec, text[0], text[1]);
    }
    return EXIT_DONE;
}

static enum exit_status take_uniform(const char *spec, char **fields, int count,
                                     lum_yscan_shape *out)
{
    out->kind = LUM_YSCAN_UNIFORM;
    return count == 0 ? EXIT_DONE
                      : take_ends(spec, fields, &out->min_udeg, &out->max_udeg);
}

static enum exit_status take_gaussian(const char *spec, char **fields,
                                      int count, lum_yscan_shape *out)
{
    out->kind = LUM_YSCAN_GAUSSIAN;
    if (!yscan_parse_degrees(fields[0], &out->center_udeg)) {
        return refuse_degrees(spec, fields[0]);
    }
    if (!parse_between(fields[1], SIGMA_MIN, 90.0, &out->sigma_udeg)) {
        return refuse(spec, fields[1], "a sigma from 0.01 to 90 degrees");
    }
    return count == 2
               ? EXIT_DONE
               : take_ends(spec, fields + 2, &out->min_udeg, &out->max_udeg);
}

/* Cuts at the first of what parts two; NULL if it is not there. */
static char *cut(char *text, const char *between)
{
    char *at = strstr(text, between);
    if (at == NULL) {
        return NULL;
    }
    *at = '\0';
    return at + strlen(between);
}

static enum exit_status take_region(const char *spec, char *text,
                                    lum_yscan_region *out)
{
    char whole[48];
    int64_t weight = 1;
    (void)snprintf(whole, sizeof whole, "%s", text);
    char *share = cut(text, "=");
    char *max = cut(text, "..");
    if (max == NULL) {
        return refuse(spec, whole, "a region, MIN..MAX=WEIGHT");
    }
    if (share != NULL && !number_parse_int(share, 1, WEIGHT_MAX, &weight)) {
        return refuse(spec, share,
                      "a weight, a whole number from 1 to 1000000");
    }
    out->weight = (uint32_t)weight;
    char *const ends[] = {text, max};
    return take_ends(spec, ends, &out->min_udeg, &out->max_udeg);
}

/* Inserts a region among those that lie higher and lower. */
static void insert_region(lum_yscan_shape *s, lum_yscan_region r)
{
    size_t i = s->region_count++;
    while (i > 0 && s->regions[i - 1].max_udeg < r.max_udeg) {
        s->regions[i] = s->regions[i - 1];
        i--;
    }
    s->regions[i] = r;
}

static enum exit_status check_overlaps(const char *spec,
                                       const lum_yscan_shape *s)
{
    for (size_t i = 1; i < s->region_count; i++) {
        const double low = s->regions[i - 1].min_udeg / 1e6;
        const double high = s->regions[i].max_udeg / 1e6;
        if (high > low) {
            return ctl_complain(EXIT_BAD,
                                "yscan: --shape %.60s: two regions overlap: "
                                "one reaches up to %g, the next higher begins "
                                "at %g",
                                spec, high, low);
        }
    }
    return EXIT_DONE;
}

static enum exit_status take_regions(const char *spec, char **fields, int count,
                                     lum_yscan_shape *out)
{
    char *next = fields[0];
    (void)count;
    out->kind = LUM_YSCAN_REGIONS;
    while (next != NULL) {
        char *text = next;
        lum_yscan_region region = {0, 0, 0};
        next = cut(text, ",");
        if (out->region_count == LUM_YSCAN_REGIONS_MAX) {
            return ctl_complain(EXIT_BAD,
                                "yscan: --shape %.60s: more than %u regions",
                                spec, LUM_YSCAN_REGIONS_MAX);
        }
        const enum exit_status status = take_region(spec, text, &region);
        if (status != EXIT_DONE) {
            return status;
        }
        insert_region(out, region);
    }
    return check_overlaps(spec, out);
}

static const struct kind {
    const char *name;
    enum exit_status (*take)(const char *spec, char **fields, int count,
                             lum_yscan_shape *out);
    int counts[2]; /* fields that it takes: either number */
} kinds[] = {
    {"uniform", take_uniform, {0, 2}},
    {"gaussian", take_gaussian, {2, 4}},
    {"regions", take_regions, {1, 1}},
};

static const struct kind *find_kind(const char *name, int count)
{
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (strcmp(kinds[i].name, name) == 0 &&
            (kinds[i].counts[0] == count || kinds[i].counts[1] == count)) {
            return &kinds[i];
        }
    }
    return NULL;
}

enum exit_status yscan_parse_shape(const char *text, lum_yscan_shape *out)
{
    char copy[TEXT_BYTES];
    char *fields[FIELDS] = {copy};
    int count = 0;
    const int len = snprintf(copy, sizeof copy, "%s", text);
    for (char *at = copy; at != NULL && count < FIELDS; count++) {
        fields[count] = at;
        at = cut(at, ":");
    }
    const struct kind *kind =
        len >= 0 && len < TEXT_BYTES ? find_kind(copy, count - 1) : NULL;
    if (kind == NULL) {
        return ctl_complain(EXIT_BAD, "yscan: --shape '%.60s' is not %s", text,
                            grammar);
    }
    *out = (lum_yscan_shape){.min_udeg = INT32_MIN, .max_udeg = INT32_MAX};
    return kind->take(text, fields + 1, count - 1, out);
}
