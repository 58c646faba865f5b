/* What each exact point of a simulated capture lies on, as a structured array
 * of NumPy: a row a point, sorted by frame, line, eye, pixel and return. */
#ifndef LUMSIM_LABELS_H
#define LUMSIM_LABELS_H

#include "lum/base/error.h"
#include "sim/render.h"

struct labels;

/* 0, or -1 with the reason in error. */
int labels_open(const char *path, struct labels **out, lum_error *error);

/* The next line of an eye. 0, or -1 with the reason in error. */
int labels_add(struct labels *labels, const lum_sim_line *line,
               lum_error *error);

/* 0, or -1 with the reason in error; then no file is left. */
int labels_close(struct labels *labels, lum_error *error);

/* Remove what was written. NULL is allowed. */
void labels_abort(struct labels *labels);

#endif
