/* Which views a caller asks for: columns, selection and smoothing, checked. */
#include "views.h"

#include "base/sized.h"

#include <string.h>

static int check_view(const lum_view *given, lum_checked_view *out,
                      lum_error *error)
{
    lum_view *v = &out->asked;
    if (lum_sized_take(v, sizeof *v, given, "a view", "lum_view", error) != 0) {
        return -1;
    }
    out->window = v->smooth_window > 1u ? v->smooth_window : 0;
    if ((v->columns & ~LUM_COLUMNS_ALL) != 0) {
        return lum_error_set(error, "view.columns has unknown bits; use a "
                                    "subset of LUM_COLUMNS_ALL");
    }
    if (v->selection.edges < LUM_EDGES_RISING ||
        v->selection.edges > LUM_EDGES_BOTH ||
        v->selection.returns < LUM_RETURNS_ALL ||
        v->selection.returns > LUM_RETURNS_NUMBER) {
        return lum_error_set(error, "view.selection.edges or .returns is out "
                                    "of range; lum_view_default() sets them");
    }
    if (out->window != 0 && lum_smooth_init(&out->smooth, v->smooth_window,
                                            v->smooth_order) != LUM_OK) {
        return lum_error_set(error,
                             "a view cannot smooth with window %lu and order "
                             "%lu; the window is odd and at most %u, the order "
                             "below it and at most %u",
                             (unsigned long)v->smooth_window,
                             (unsigned long)v->smooth_order,
                             LUM_SMOOTH_WINDOW_MAX, LUM_SMOOTH_ORDER_MAX);
    }
    return 0;
}

int lum_views_check(const lum_view *given, size_t count, lum_checked_views *out,
                    lum_error *error)
{
    const uint8_t *at = (const uint8_t *)given;
    if (count > LUM_VIEWS_MAX) {
        return lum_error_set(error, "%zu views; at most %u are possible", count,
                             LUM_VIEWS_MAX);
    }
    out->count = count;
    for (size_t i = 0; i < count; i++) {
        size_t size = 0;
        memcpy(&size, at, sizeof size);
        if (size <= sizeof size || size != given->struct_size) {
            return lum_error_set(error, "struct_size of a view is not set; "
                                        "set it to sizeof(lum_view), as "
                                        "lum_view_default() does");
        }
        if (check_view((const lum_view *)(const void *)at, &out->view[i],
                       error) != 0) {
            return -1;
        }
        at += size;
    }
    return 0;
}
