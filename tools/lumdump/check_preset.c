#include "runs.h"

#include "../common/source_url.h"
#include "cloud_fields.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* What lumdump makes clouds of. */
static bool is_source(const char *name)
{
    static const char *const endings[] = {".pcap",     ".pcapng",
                                          ".pcap.gz",  ".pcapng.gz",
                                          ".pcap.zst", ".pcapng.zst"};
    bool is = source_url_is_sensor(name);
    for (size_t i = 0; i < sizeof endings / sizeof endings[0]; i++) {
        is = is || options_has_ending(name, endings[i]);
    }
    return is;
}

static const struct cloud_field *find(const struct cloud_fields *cloud,
                                      const char *name)
{
    for (unsigned i = 0; i < cloud->count; i++) {
        if (strcmp(cloud->at[i].name, name) == 0) {
            return &cloud->at[i];
        }
    }
    return NULL;
}

/* Prints a row; whether the field is as it is wanted. */
static bool check(const lum_preset *preset, unsigned i,
                  const struct cloud_fields *cloud)
{
    const lum_preset_field *want = &preset->fields[i];
    const char *type = lum_number_types[want->type].name;
    const struct cloud_field *found = find(cloud, want->name);
    const size_t offset = lum_preset_offset(preset, i);
    if (found == NULL) {
        (void)printf("%-16s %-7s %-7s missing\n", want->name, type, "-");
        return false;
    }
    const char *word = found->type < LUM_NUMBER_TYPES
                           ? lum_number_types[found->type].name
                           : found->word;
    if (cloud->has_types && found->type != want->type) {
        (void)printf("%-16s %-7s %-7s another type\n", want->name, type, word);
        return false;
    }
    if (preset->is_in_places && cloud->has_places && found->offset != offset) {
        (void)printf("%-16s %-7s %-7s at byte %" PRIu64 ", wanted at %zu\n",
                     want->name, type, word, found->offset, offset);
        return false;
    }
    if (preset->is_in_places && !cloud->has_places && found != &cloud->at[i]) {
        (void)printf("%-16s %-7s %-7s in another place\n", want->name, type,
                     word);
        return false;
    }
    (void)printf("%-16s %-7s %-7s none\n", want->name, type, word);
    return true;
}

static int read_fields(const char *name, struct cloud_fields *out,
                       lum_error *error)
{
    if (is_source(name)) {
        cloud_fields_of_messages(out);
        return 0;
    }
    return cloud_fields_read(name, out, error);
}

enum exit_status check_preset_run(const struct options *options)
{
    struct cloud_fields cloud;
    lum_error error = {""};
    unsigned wrong = 0;
    const lum_preset *preset =
        lum_preset_find(options->instead.check_preset, &error);
    if (preset == NULL || read_fields(options->source, &cloud, &error) != 0) {
        return conclude_error(&error, EXIT_BAD);
    }
    if (is_source(options->source)) {
        (void)printf("%s is packets; this is about the messages that lumdump "
                     "makes of them without --preset.\n",
                     options->source);
    }
    (void)printf("%-16s %-7s %-7s %s\n", "field", "wanted", "found",
                 "difference");
    for (unsigned i = 0; i < preset->count; i++) {
        wrong += check(preset, i, &cloud) ? 0u : 1u;
    }
    (void)printf(wrong == 0 ? "%s can read it.\n"
                            : "%s cannot read it: make it by --preset %s.\n",
                 preset->name, preset->name);
    const enum exit_status status = conclude_stdout();
    return status == EXIT_DONE && wrong > 0 ? EXIT_FAILED : status;
}
