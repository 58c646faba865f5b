/* Turns errors of decoding and of reading into counters and messages for the
 * page. */
#include "report.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

static struct stage *stage_of(const struct report *r)
{
    return r->options->decoder.stage;
}

/* Why frames are incomplete, and which sensors are not shown. */
static void tell_message(const struct report *r, const struct decoder *decoder)
{
    char text[LUM_ERROR_BYTES] = "";
    char others[200];
    char shown[LUM_SENSOR_NAME_BYTES];
    size_t len = 0;
    if (r->broken.text[0] != '\0') {
        len = (size_t)snprintf(text, sizeof text, "%.280s", r->broken.text);
    }
    (void)decoder_others(decoder, shown, others, sizeof others);
    if (r->options->rig == NULL && others[0] != '\0' && shown[0] != '\0') {
        (void)snprintf(text + len, sizeof text - len,
                       "%s%s is shown; there is also %s: choose by lumview "
                       "--sensor, or show all by a rig: lumview --rig, or a "
                       "rig file dropped on lumview.html",
                       len > 0 ? "; " : "", shown, others);
        len = strlen(text);
    }
    const char *sensor = "";
    const uint64_t late = decoder_late(decoder, &sensor);
    if (late > 0) {
        (void)snprintf(text + len, sizeof text - len,
                       "%sa frame of %s is left out, as the sensor paused in "
                       "it or has stopped (%" PRIu64 " in all)",
                       len > 0 ? "; " : "", sensor, late);
        len = strlen(text);
    }
    if (r->cut > 0) {
        (void)snprintf(text + len, sizeof text - len,
                       "%sframe %" PRId64 " has more than %u points: %" PRIu64
                       " of them are not shown",
                       len > 0 ? "; " : "", r->cut_frame, FRAME_POINTS_MAX,
                       r->cut);
    }
    stage_set_text(stage_of(r), FEED_MESSAGE, text);
}

static void tell_empty(const struct report *r, const struct decoder *decoder)
{
    lum_error text;
    const struct sources *sources = r->options->sources;
    const bool are_several = sources->count > 1;
    if (r->broken.text[0] != '\0') {
        tell_message(r, decoder);
        return;
    }
    (void)lum_error_set(
        &text, "%s: there is no frame in %s%s; lumdump %s%stells what %s",
        sources->name, are_several ? "them" : "it",
        r->options->decoder.sensor.is_given ? " of the sensor that was chosen"
        : r->options->rig != NULL           ? " of the rig's sensors"
                                            : "",
        are_several ? "" : sources->name, are_several ? "" : " ",
        are_several ? "they hold" : "it holds");
    stage_set_text(stage_of(r), FEED_MESSAGE, text.text);
}

static void count(const struct report *r, const struct decoder *decoder)
{
    struct totals now;
    decoder_count(decoder, &now);
    totals_add(&now, &r->before);
    stage_set_totals(stage_of(r), &now);
    decoder_tell_doubt(decoder, r->options->sources, "");
}

void report_frame(struct report *report, const lum_capture *capture,
                  const struct decoder *decoder, const struct picture *picture)
{
    if (picture->cut > 0) {
        report->cut = picture->cut;
        report->cut_frame = picture->frame;
    }
    count(report, decoder);
    tell_message(report, decoder);
    if (!report->is_scanned) {
        captures_tell(report->captures, capture, decoder_demux(decoder),
                      report->options->said, stage_of(report));
    }
}

void report_end(struct report *report, const lum_capture *capture,
                const struct decoder *decoder)
{
    int64_t first = 0;
    int64_t last = 0;
    if (decoder_range(decoder, &first, &last)) {
        tell_message(report, decoder);
    } else {
        tell_empty(report, decoder);
    }
    if (report->is_scanned) {
        captures_tell_others(report->captures, capture, report->options->said,
                             stage_of(report));
    } else {
        captures_tell(report->captures, capture, decoder_demux(decoder),
                      report->options->said, stage_of(report));
        captures_warn(report->captures, capture, decoder_demux(decoder));
    }
    count(report, decoder);
}

void report_add_pass(struct report *report, const struct decoder *decoder)
{
    struct totals now;
    decoder_count(decoder, &now);
    totals_add(&report->before, &now);
}
