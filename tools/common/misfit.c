#include "misfit.h"

#include "shell_word.h"

#include <inttypes.h>
#include <stdio.h>

/* Fewer packets or words than this show nothing. */
#define LEAST 20u

static uint64_t count_odd(const lum_demux_counters *c)
{
    return c->packets[LUM_PACKET_MALFORMED] +
           c->packets[LUM_PACKET_UNKNOWN_TAG] +
           c->packets[LUM_PACKET_UNKNOWN_TYPE];
}

/* Angles are in the longest packets, which a snap length cuts first. */
static bool lack_angles(const lum_demux_counters *c)
{
    const lum_assembly_counters *a = &c->assembly;
    return a->lines >= LEAST && a->words >= LEAST &&
           a->lines_missing_angles == a->lines &&
           c->cut_short < a->lines_missing_angles;
}

/* One in ten, and not only a few. */
static bool is_much(uint64_t odd, uint64_t good)
{
    return odd >= LEAST && odd > good / 10u;
}

bool misfit_find(const lum_demux_counters *counters, char *out, size_t room)
{
    const lum_assembly_counters *a = &counters->assembly;
    const uint64_t good = counters->packets[LUM_PACKET_DATA];
    const uint64_t odd = count_odd(counters);
    *out = '\0';
    if (is_much(odd, good)) {
        (void)snprintf(out, room,
                       "%" PRIu64 " of %" PRIu64
                       " packets that may be data do not fit the layout",
                       odd, odd + good);
    } else if (is_much(a->bad_words, a->words)) {
        (void)snprintf(out, room,
                       "%" PRIu64
                       " range words are impossible, against %" PRIu64
                       " good ones, so the layout may be another one",
                       a->bad_words, a->words);
    } else if (lack_angles(counters)) {
        (void)snprintf(out, room,
                       "each of %" PRIu64
                       " lines lacks angles, so the layout may be another one",
                       a->lines);
    } else if (a->stray >= LEAST && a->stray > good / 2u) {
        (void)snprintf(out, room,
                       "the clocks of %" PRIu64 " of %" PRIu64
                       " packets jump, so the layout may be another one",
                       a->stray, good);
    }
    return *out != '\0';
}

void misfit_advise(const char *source, const char *capture, char *out,
                   size_t room)
{
    if (capture != NULL) {
        (void)snprintf(out, room,
                       "lumdump %s --infer -o profile.yaml finds the layout, "
                       "for --profile profile.yaml",
                       capture);
    } else {
        (void)snprintf(out, room,
                       "record it by lumdump %s --laser --duration 3 -o "
                       "look.pcap; lumdump look.pcap --infer -o profile.yaml "
                       "finds the layout, for --profile profile.yaml",
                       source);
    }
}

const char *misfit_capture(const struct sources *sources, char *out,
                           size_t room)
{
    for (size_t i = 0; i < sources->count; i++) {
        if (sources_is_file(sources->paths[i]) &&
            shell_word(sources->paths[i], out, room) != NULL) {
            return out;
        }
    }
    return "CAPTURE";
}
