/* The layout of the captures' packets, told by themselves, as `lumdump --infer`
 * does. */
#include "inputs.h"

#include "lum/capture/capture.h"
#include "lum/infer/infer.h"

#include <stdio.h>

static char yaml[LUM_INFER_YAML_BYTES];
static char sentence[LUM_ERROR_BYTES + 64u];

static const char *name_verdict(lum_infer_verdict verdict)
{
    switch (verdict) {
    case LUM_INFER_FOUND:
        return "A layout was found";
    case LUM_INFER_UNSURE:
        return "A layout was found, but it is uncertain";
    case LUM_INFER_TOO_LITTLE:
        return "No layout was found (too little data)";
    case LUM_INFER_NOTHING_FITS:
    default:
        return "No layout was found (none fits)";
    }
}

/* What cannot be read to its end is looked at as far as it can. */
static int push_all(lum_infer *infer, lum_capture *capture, lum_error *error)
{
    lum_record record;
    lum_error broken;
    int wants = 1;
    while (wants > 0 && lum_capture_next(capture, &record, &broken) > 0) {
        wants = lum_infer_push(infer, &record, error);
    }
    return wants < 0 ? -1 : 0;
}

static int solve(lum_infer *infer, lum_error *error)
{
    static lum_infer_result result;
    result.struct_size = sizeof result;
    if (lum_infer_solve(infer, &result, error) < 0) {
        return -1;
    }
    if (result.has_profile) {
        (void)lum_infer_write_yaml(&result, yaml, sizeof yaml);
    }
    (void)snprintf(sentence, sizeof sentence, "%s: %s",
                   name_verdict(result.verdict), result.text);
    return 0;
}

/* Look at the captures that were handed over. 0, or -1 with an error. */
EXPORTED(engine_infer) int engine_infer(void);
int engine_infer(void)
{
    const struct inputs *in = inputs_look();
    const lum_infer_options options = {.struct_size = sizeof options};
    lum_error *error = inputs_error();
    lum_capture *capture = NULL;
    lum_infer *infer = NULL;
    yaml[0] = '\0';
    const bool is_done =
        lum_capture_open_several((const char *const *)in->captures,
                                 in->capture_count, &capture, error) == 0 &&
        lum_infer_create(&options, &infer, error) == 0 &&
        push_all(infer, capture, error) == 0 && solve(infer, error) == 0;
    lum_infer_free(infer);
    lum_capture_close(capture);
    return is_done ? 0 : -1;
}

/* The profile as YAML; empty: none was found. */
EXPORTED(engine_profile) const char *engine_profile(void);
const char *engine_profile(void)
{
    return yaml;
}

EXPORTED(engine_sentence) const char *engine_sentence(void);
const char *engine_sentence(void)
{
    return sentence;
}
