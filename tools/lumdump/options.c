/* Questions about options already read, for each output: its format, whether
 * it rotates, takes frames, packets or messages. */
#include "options.h"

#include "cloud/part.h"
#include "points/columns.h"

#include <string.h>

#define THREADS_DEFAULT 8u /* at most */

/* --- Formats and names --- */

bool options_has_ending(const char *name, const char *ending)
{
    const size_t n = strlen(name);
    const size_t m = strlen(ending);
    return n > m && strcmp(name + n - m, ending) == 0;
}

bool options_find_format(const char *name, unsigned *out)
{
    lum_format format = LUM_FORMAT_CSV;
    if (options_has_ending(name, ".pcap") ||
        options_has_ending(name, ".pcapng")) {
        *out = options_has_ending(name, ".pcap") ? FORMAT_PCAP : FORMAT_PCAPNG;
        return true;
    }
    if (lum_format_from_name(name, &format) != 0) {
        return false;
    }
    *out = format;
    return true;
}

bool options_is_capture(unsigned format)
{
    return format == FORMAT_PCAP || format == FORMAT_PCAPNG;
}

bool options_is_standard_output(const struct options *options, size_t i)
{
    return strcmp(options->outputs[i].name, "-") == 0;
}

bool options_is_rotation(const struct rotation *r)
{
    return r->bytes != 0 || r->ns != 0;
}

int options_pattern(const char *name)
{
    const char *p = strchr(name, '%');
    if (p == NULL) {
        return 0;
    }
    p++;
    p += strspn(p, "0123456789");
    return *p == 'd' && strchr(p, '%') == NULL ? 1 : -1;
}

/* --- One output --- */

static bool is_mcap(const struct options *o, size_t i)
{
    return o->outputs[i].format == (unsigned)LUM_FORMAT_MCAP;
}

bool options_takes_packets(const struct options *options, size_t i)
{
    return options_is_capture(options->outputs[i].format) ||
           (is_mcap(options, i) &&
            (options->mcap.contents & LUM_MCAP_OF_DATAGRAMS) != 0);
}

bool options_is_recording(const struct options *options, size_t i)
{
    return options_is_capture(options->outputs[i].format) ||
           (is_mcap(options, i) &&
            options->mcap.contents == LUM_MCAP_OF_DATAGRAMS);
}

bool options_is_organized(const struct options *options, size_t i)
{
    return options->cloud.organized &&
           options->outputs[i].format == (unsigned)LUM_FORMAT_PCD;
}

bool options_has_preset(const struct options *options, size_t i)
{
    const unsigned format = options->outputs[i].format;
    return options->cloud.preset != NULL && !options_is_recording(options, i) &&
           lum_format_has_presets((lum_format)format);
}

bool options_has_messages(const struct options *options, size_t i)
{
    return !options_is_recording(options, i) &&
           lum_format_has_frames((lum_format)options->outputs[i].format);
}

bool options_rotates(const struct options *options, size_t i)
{
    const char *name = options->outputs[i].name;
    return !options_is_organized(options, i) &&
           options_is_rotation(&options->files.rotation) &&
           !options_is_standard_output(options, i) &&
           options_pattern(name) == 0;
}

bool options_is_picture(const struct options *options, size_t i)
{
    return options->outputs[i].format == (unsigned)LUM_FORMAT_PNG &&
           options_pattern(options->outputs[i].name) == 0;
}

bool options_has_frames(const struct options *options)
{
    return options->choice.frame_first != INT64_MIN ||
           options->choice.frame_last != INT64_MAX ||
           options->choice.whole != 0;
}

bool options_is_in_world(const struct options *options)
{
    return options->points.motion.poses != NULL &&
           options->points.motion.to == LUM_MOVE_TO_WORLD;
}

bool options_makes_map(const struct options *options)
{
    return options->cloud.voxel > 0 && options_is_in_world(options);
}

unsigned options_threads(const struct options *options)
{
    if (options->points.threads != 0) {
        return options->points.threads;
    }
    const unsigned cores = cores_count();
    return cores < THREADS_DEFAULT ? cores : THREADS_DEFAULT;
}

bool options_draws_one(const struct options *options, size_t i)
{
    return options_is_picture(options, i) && !options_rotates(options, i) &&
           !options_has_frames(options);
}

bool options_takes_frames(const struct options *options, size_t i)
{
    const unsigned format = options->outputs[i].format;
    return options_is_organized(options, i) ||
           format == (unsigned)LUM_FORMAT_PNG ||
           options_has_messages(options, i) || options_has_preset(options, i) ||
           ((options->choice.whole != 0 ||
             options->points.motion.poses != NULL) &&
            !options_is_recording(options, i)) ||
           (options->cloud.has_times && !options_is_capture(format) &&
            lum_format_has_columns((lum_format)format));
}

bool options_has_comment(const struct options *options, unsigned format)
{
    return options->cloud.comments ||
           (format != LUM_FORMAT_CSV && format != LUM_FORMAT_XYZ);
}

/* --- All of a run --- */

unsigned options_leaves(const struct options *options)
{
    unsigned leaves = LUM_LEAVE_ALL;
    for (size_t i = 0; i < options->output_count; i++) {
        const unsigned format = options->outputs[i].format;
        if (!options_is_capture(format)) {
            leaves &=
                lum_format_leaves((lum_format)format, options->cloud.columns);
        }
    }
    return leaves;
}

bool options_any(const struct options *options, options_question *is_so)
{
    size_t i = 0;
    while (i < options->output_count && !is_so(options, i)) {
        i++;
    }
    return i < options->output_count;
}
