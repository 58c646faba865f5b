#include "lum/config/config.h"

#include "file_text.h"
#include "lum/config/settings.h"
#include "sweep.h"

#include <stddef.h>

/* The text was parsed. */
static int end(lum_file_text *text, int result)
{
    lum_file_text_free(text);
    return result;
}

int lum_calibration_load(const char *path, lum_calibration *out,
                         lum_error *error)
{
    lum_file_text *text = lum_file_text_load(path, error);
    return text == NULL
               ? -1
               : end(text, lum_calibration_parse(text->bytes, text->len,
                                                 text->name, out, error));
}

int lum_profile_load(const char *path, lum_profile *out, lum_error *error)
{
    lum_file_text *text = lum_file_text_load(path, error);
    return text == NULL ? -1
                        : end(text, lum_profile_parse(text->bytes, text->len,
                                                      text->name, out, error));
}

int lum_settings_load(const char *path, lum_settings *out, lum_error *error)
{
    lum_file_text *text = lum_file_text_load(path, error);
    return text == NULL ? -1
                        : end(text, lum_settings_parse(text->bytes, text->len,
                                                       text->name, out, error));
}

int lum_sweep_load(const char *path, lum_sweep *out, lum_error *error)
{
    lum_file_text *text = lum_file_text_load(path, error);
    *out = (lum_sweep){.steps = NULL};
    return text == NULL ? -1
                        : end(text, lum_sweep_parse(text->bytes, text->len,
                                                    text->name, out, error));
}
