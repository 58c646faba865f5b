#include "lum/infer/infer.h"

#include "base/sized.h"

#include <stdlib.h>

struct lum_infer {
    lum_infer_options options;
};

int lum_infer_create(const lum_infer_options *options, lum_infer **out,
                     lum_error *error)
{
    lum_infer *infer = calloc(1, sizeof *infer);
    *out = NULL;
    if (infer == NULL) {
        return lum_error_set(error, "no memory");
    }
    if (lum_sized_take(&infer->options, sizeof infer->options, options,
                       "the inference's options", "lum_infer_options",
                       error) != 0) {
        free(infer);
        return -1;
    }
    *out = infer;
    return 0;
}

int lum_infer_push(lum_infer *infer, const lum_record *record, lum_error *error)
{
    (void)infer, (void)record, (void)error;
    return 1;
}

int lum_infer_solve(lum_infer *infer, lum_infer_result *out, lum_error *error)
{
    (void)infer, (void)error;
    out->verdict = LUM_INFER_TOO_LITTLE;
    return 1;
}

void lum_infer_free(lum_infer *infer)
{
    free(infer);
}

size_t lum_infer_write_yaml(const lum_infer_result *result, char *out,
                            size_t room)
{
    (void)result, (void)out, (void)room;
    return 0;
}
