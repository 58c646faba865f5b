/* The shape of a Y scan as --shape has it. */
#ifndef LUMCTL_YSCAN_SHAPE_H
#define LUMCTL_YSCAN_SHAPE_H

#include "../ctl.h"

#include "lum/host/yscan_plan.h"

/* Reads uniform[:MIN:MAX], gaussian:CENTER:SIGMA[:MIN:MAX] or
 * regions:MIN..MAX=WEIGHT,...; degrees. Regions come in any order. Complains.
 */
enum exit_status yscan_parse_shape(const char *text, lum_yscan_shape *out);

/* The file's name of csv:FILE, else NULL. */
const char *yscan_csv_name(const char *text);

/* Reads elevations in degrees, one a line; blank lines and text after a # are
 * ignored, the first line may be a header. path "-": standard input. An error
 * if there are not exactly this many. */
enum exit_status yscan_read_csv(const char *path, int32_t *udeg, size_t lines);

/* Degrees to the nearest millionth; false: not a number from -90 to 90. */
bool yscan_parse_degrees(const char *text, int32_t *udeg);

#endif
