#include "yscan_table.h"

#include "../../common/terminal.h"
#include "../config_files.h"

#include "base/text.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

static const char *const eye_names[LUM_EYES] = {
    [LUM_EYE_BLUE] = "blue",
    [LUM_EYE_GREEN] = "green",
};

static double degrees(int64_t udeg)
{
    return (double)udeg / 1e6;
}

enum exit_status yscan_load_calibration(const struct ctl *ctl,
                                        lum_calibration *out)
{
    lum_error error = {""};
    if (ctl->calibration != NULL) {
        *out = *ctl->calibration;
        return EXIT_DONE;
    }
    lum_calibration_default(out);
    if (files_load_calibration(ctl->options.calibration, &ctl->options.set, out,
                               &error) != 0) {
        return ctl_complain(EXIT_BAD, "%s", error.text);
    }
    return EXIT_DONE;
}

const char *yscan_name_calibration(const struct ctl *ctl,
                                   char out[MEMORY_FROM_BYTES])
{
    const struct ctl_options *o = &ctl->options;
    (void)snprintf(out, MEMORY_FROM_BYTES, "%s",
                   o->calibration != NULL ? o->calibration : "");
    for (size_t i = 0; i < o->set.count; i++) {
        if (!o->set.list[i].is_of_profile) {
            lum_text_add(out, MEMORY_FROM_BYTES, "%s--set %s",
                         *out != '\0' ? " " : "", o->set.list[i].text);
        }
    }
    return out[0] != '\0' ? out : NULL;
}

/* --- From a shape to elevations --- */

/* The elevations that both eyes see. Complains if there are none. */
static enum exit_status find_span(const lum_calibration *calibration,
                                  int32_t *min_udeg, int32_t *max_udeg)
{
    const lum_eye_calibration *a = &calibration->eye[LUM_EYE_BLUE];
    const lum_eye_calibration *b = &calibration->eye[LUM_EYE_GREEN];
    *min_udeg = a->elevation_min_udeg > b->elevation_min_udeg
                    ? a->elevation_min_udeg
                    : b->elevation_min_udeg;
    *max_udeg = a->elevation_max_udeg < b->elevation_max_udeg
                    ? a->elevation_max_udeg
                    : b->elevation_max_udeg;
    if (*min_udeg >= *max_udeg) {
        return ctl_complain(
            EXIT_BAD,
            "yscan: no elevation is seen by both eyes: blue sees %g to %g "
            "degrees, green %g to %g; check the calibration",
            degrees(a->elevation_min_udeg), degrees(a->elevation_max_udeg),
            degrees(b->elevation_min_udeg), degrees(b->elevation_max_udeg));
    }
    return EXIT_DONE;
}

/* What the span makes impossible though the shape is sound in itself. */
static enum exit_status complain_shape(const lum_yscan_shape *shape,
                                       int32_t min, int32_t max)
{
    if (shape->kind == LUM_YSCAN_GAUSSIAN) {
        return ctl_complain(EXIT_BAD,
                            "yscan: the center %g is not within the %g to %g "
                            "degrees that the lines are to cover",
                            degrees(shape->center_udeg), degrees(min),
                            degrees(max));
    }
    return ctl_complain(EXIT_BAD,
                        "yscan: no lines fit from %g to %g degrees: the lower "
                        "end must be below the upper one",
                        degrees(min), degrees(max));
}

/* A requested end that is outside the span. Lines are in the middle of their
 * shares, so a few might still fit. */
static bool find_excess(const lum_yscan_shape *shape, int32_t min, int32_t max,
                        int32_t *udeg)
{
    const bool has_regions = shape->kind == LUM_YSCAN_REGIONS;
    const size_t last = has_regions ? shape->region_count - 1 : 0;
    const int32_t low =
        has_regions ? shape->regions[last].min_udeg : shape->min_udeg;
    const int32_t high =
        has_regions ? shape->regions[0].max_udeg : shape->max_udeg;
    const int32_t ends[] = {low == INT32_MIN ? min : low,
                            high == INT32_MAX ? max : high};
    for (int i = 0; i < 2; i++) {
        if (ends[i] < min || ends[i] > max) {
            *udeg = ends[i];
            return true;
        }
    }
    return false;
}

enum exit_status yscan_fill(const lum_yscan_shape *shape,
                            const lum_calibration *calibration, size_t lines,
                            struct yscan_table *out)
{
    int32_t min = 0;
    int32_t max = 0;
    int32_t end = 0;
    const enum exit_status status = find_span(calibration, &min, &max);
    if (status != EXIT_DONE) {
        return status;
    }
    if (find_excess(shape, min, max, &end)) {
        return ctl_complain(EXIT_BAD,
                            "yscan: %g degrees is outside the %g to %g that "
                            "both eyes see (--calibration FILE gives a "
                            "sensor's own)",
                            degrees(end), degrees(min), degrees(max));
    }
    out->count = lines;
    if (lum_yscan_make(shape, min, max, out->udeg, lines) == LUM_OK) {
        return EXIT_DONE;
    }
    return complain_shape(shape,
                          shape->min_udeg == INT32_MIN ? min : shape->min_udeg,
                          shape->max_udeg == INT32_MAX ? max : shape->max_udeg);
}

/* --- From elevations to what is sent --- */

static enum exit_status complain_line(const lum_eye_calibration *eye,
                                      const char *name, const int32_t *udeg,
                                      size_t at)
{
    const unsigned line = (unsigned)at;
    if (udeg[at] < eye->elevation_min_udeg ||
        udeg[at] > eye->elevation_max_udeg) {
        return ctl_complain(
            EXIT_BAD,
            "yscan: line %u at %g degrees is outside what the %s eye sees, %g "
            "to %g degrees (--calibration FILE gives a sensor's own)",
            line, degrees(udeg[at]), name, degrees(eye->elevation_min_udeg),
            degrees(eye->elevation_max_udeg));
    }
    if (at > 0 && udeg[at] != udeg[at - 1]) {
        return ctl_complain(EXIT_BAD,
                            "yscan: line %u turns, from %g to %g degrees; "
                            "elevations must all fall or all rise",
                            line, degrees(udeg[at - 1]), degrees(udeg[at]));
    }
    return ctl_complain(EXIT_BAD,
                        "yscan: line %u at %g degrees does not fit 16 bits of "
                        "the profile's angle_lsb_deg",
                        line, degrees(udeg[at]));
}

static int32_t distance(int32_t a, int32_t b)
{
    return a > b ? a - b : b - a;
}

/* Between the two, rounded towards the upper one. */
static int16_t middle_of(int16_t a, int16_t b)
{
    const int32_t sum = (int32_t)a + b + 1;
    return (int16_t)(sum >= 0 ? sum / 2 : -((1 - sum) / 2));
}

/* One table serves both eyes, so where they differ it lies halfway. */
static void join_eyes(const struct ctl *ctl, const lum_calibration *calibration,
                      const int16_t *other, struct yscan_table *table)
{
    table->off_udeg = 0;
    for (size_t i = 0; i < table->count; i++) {
        if (table->raw[i] == other[i]) {
            continue;
        }
        table->raw[i] = middle_of(table->raw[i], other[i]);
        for (unsigned eye = 0; eye < LUM_EYES; eye++) {
            const int32_t off =
                distance(lum_yscan_elevation(&calibration->eye[eye],
                                             &ctl->layout, table->raw[i]),
                         table->udeg[i]);
            table->off_udeg = off > table->off_udeg ? off : table->off_udeg;
        }
    }
}

enum exit_status yscan_encode(const struct ctl *ctl,
                              const lum_calibration *calibration,
                              struct yscan_table *table)
{
    int16_t other[YSCAN_LINES];
    int16_t *const out[LUM_EYES] = {table->raw, other};
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        const lum_eye_calibration *c = &calibration->eye[eye];
        size_t at = 0;
        if (lum_yscan_encode(c, &ctl->layout, table->udeg, table->count,
                             out[eye], &at) != LUM_OK) {
            return complain_line(c, eye_names[eye], table->udeg, at);
        }
    }
    join_eyes(ctl, calibration, other, table);
    return EXIT_DONE;
}

/* "9 degrees above", "2 degrees above and 1 below"; false: nothing. */
static bool describe_excess(const lum_eye_calibration *eye, int32_t half_udeg,
                            char *out, size_t size)
{
    const int64_t above = (int64_t)half_udeg - eye->elevation_max_udeg;
    const int64_t below = (int64_t)eye->elevation_min_udeg + half_udeg;
    int n = 0;
    if (above > 0) {
        n = snprintf(out, size, "%g degrees above", degrees(above));
    }
    if (below > 0) {
        (void)snprintf(out + n, size - (size_t)n, "%s%g degrees below",
                       n > 0 ? " and " : "", degrees(below));
    }
    return above > 0 || below > 0;
}

static bool see_the_same(const lum_eye_calibration *a,
                         const lum_eye_calibration *b)
{
    return a->elevation_min_udeg == b->elevation_min_udeg &&
           a->elevation_max_udeg == b->elevation_max_udeg;
}

void yscan_note_view(const struct ctl *ctl, const lum_calibration *calibration,
                     unsigned fov_deg)
{
    const int32_t half = (int32_t)fov_deg * 500000;
    const bool same = see_the_same(&calibration->eye[LUM_EYE_BLUE],
                                   &calibration->eye[LUM_EYE_GREEN]);
    for (unsigned i = 0; i < (same ? 1u : (unsigned)LUM_EYES); i++) {
        const lum_eye_calibration *eye = &calibration->eye[i];
        char excess[80];
        if (describe_excess(eye, half, excess, sizeof excess)) {
            ctl_note(ctl,
                     "warning: %u degrees around the horizon reach from %g to "
                     "%g, but %s %s %g to %g: %s",
                     fov_deg, degrees(-half), degrees(half),
                     same ? "the" : eye_names[i], same ? "eyes see" : "sees",
                     degrees(eye->elevation_min_udeg),
                     degrees(eye->elevation_max_udeg), excess);
        }
    }
}

void yscan_note_eyes(const struct ctl *ctl, const struct yscan_table *table)
{
    if (table->off_udeg > 0) {
        ctl_note(ctl,
                 "the two eyes are calibrated differently and share the table: "
                 "it lies halfway, and lines are up to %g degrees off",
                 degrees(table->off_udeg));
    }
}

/* --- The table as text --- */

#define ROWS_MAX 24
#define UDEG     1000000
#define LEFT     20 /* columns in front of the bar */
#define RIGHT    10 /* and behind it */
#define BAR_MIN  10
#define BAR_MAX  200

/* Heights of a row, in microdegrees. */
static const int32_t heights[] = {UDEG / 20, UDEG / 10, UDEG / 5, UDEG / 2,
                                  UDEG,      2 * UDEG,  5 * UDEG, 10 * UDEG};

/* The row that an elevation lies in; row 0 is the one above the horizon. */
static int32_t row_of(int32_t udeg, int32_t height)
{
    return udeg >= 0 ? udeg / height : -((-udeg - 1) / height) - 1;
}

static int32_t choose_height(int32_t min, int32_t max)
{
    const size_t count = sizeof heights / sizeof heights[0];
    size_t i = 0;
    while (i + 1 < count &&
           row_of(max - 1, heights[i]) - row_of(min, heights[i]) >= ROWS_MAX) {
        i++;
    }
    return heights[i];
}

static size_t count_row(const int32_t *udeg, size_t n, int32_t row,
                        int32_t height, int32_t last)
{
    size_t count = 0;
    for (size_t i = 0; i < n; i++) {
        const int32_t at = row_of(udeg[i], height);
        count += at == row || (row == last && at > last);
    }
    return count;
}

static void put_bar(FILE *out, size_t count, size_t most, size_t columns)
{
    char bar[BAR_MAX + 1];
    const size_t len = (count * columns + most - 1) / most;
    memset(bar, '#', len);
    bar[len] = '\0';
    (void)fprintf(out, "|%s%s%lu\n", bar, len > 0 ? " " : "",
                  (unsigned long)count);
}

static void put_horizon(FILE *out, size_t columns)
{
    char dashes[BAR_MAX + 1];
    memset(dashes, '-', columns);
    dashes[columns] = '\0';
    (void)fprintf(out, "%*s%s horizon\n", LEFT, "+", dashes);
}

/* How many lines lie at each elevation from min to max, uppermost first, the
 * horizon marked; no line of it is wider than this many columns, at least 40.
 */
static void draw(FILE *out, unsigned columns, const int32_t *udeg, size_t n,
                 int32_t min_udeg, int32_t max_udeg)
{
    const int32_t height = choose_height(min_udeg, max_udeg);
    const int32_t top = row_of(max_udeg - 1, height);
    const int32_t bottom = row_of(min_udeg, height);
    size_t room =
        columns > LEFT + RIGHT + BAR_MIN ? columns - LEFT - RIGHT : BAR_MIN;
    size_t most = 1;
    room = room < BAR_MAX ? room : BAR_MAX;
    for (int32_t row = bottom; row <= top; row++) {
        const size_t count = count_row(udeg, n, row, height, top);
        most = count > most ? count : most;
    }
    (void)fprintf(out, "%*s  lines\n", LEFT - 1, "degrees ");
    for (int32_t row = top; row >= bottom; row--) {
        (void)fprintf(out, "%7.2f .. %6.2f ", row * (height / 1e6),
                      (row + 1) * (height / 1e6));
        put_bar(out, count_row(udeg, n, row, height, top), most, room);
        if (row == 0 && bottom < 0) {
            put_horizon(out, room);
        }
    }
}

void yscan_show(const struct ctl *ctl, const lum_calibration *calibration,
                const struct yscan_table *table)
{
    int32_t min = 0;
    int32_t max = 0;
    char text[YSCAN_TEXT_BYTES];
    if (!ctl->options.quiet &&
        find_span(calibration, &min, &max) == EXIT_DONE) {
        (void)fprintf(stderr, "Y scan: %s\n", yscan_describe(table, text));
        draw(stderr, (unsigned)terminal_columns(), table->udeg, table->count,
             min, max);
    }
}

const char *yscan_describe(const struct yscan_table *table,
                           char out[YSCAN_TEXT_BYTES])
{
    const int32_t first = table->udeg[0];
    const int32_t last = table->udeg[table->count - 1];
    (void)snprintf(out, YSCAN_TEXT_BYTES,
                   "%u lines from %.2f %s to %.2f degrees",
                   (unsigned)table->count, degrees(first),
                   last > first ? "up" : "down", degrees(last));
    return out;
}

bool yscan_is_refused(const char *debug)
{
    static const char *const names[] = {"y-scan", "yscan", "y scan", "table"};
    char lower[sizeof((struct ctl_answer *)0)->debug];
    size_t n = 0;
    for (; debug[n] != '\0' && n + 1 < sizeof lower; n++) {
        lower[n] = (char)tolower((unsigned char)debug[n]);
    }
    lower[n] = '\0';
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        if (strstr(lower, names[i]) != NULL) {
            return true;
        }
    }
    return false;
}
