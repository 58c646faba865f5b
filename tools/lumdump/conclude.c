#include "conclude.h"

#include "../common/number.h"
#include "../common/shell_word.h"

#include "rig_report.h"

#include "lum/wire.h"

#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* A name of a file, and what is said of it. */
#define WARNING_BYTES 6000u

enum exit_status conclude_error(const lum_error *error, enum exit_status status)
{
    (void)fprintf(stderr, "lumdump: %s\n", error->text);
    return status;
}

const char *conclude_capture(const struct options *options,
                             char out[MISFIT_CAPTURE_BYTES])
{
    for (size_t i = 0; options->is_live && i < options->output_count; i++) {
        const struct output_options *output = &options->outputs[i];
        if (options_takes_packets(options, i) && !options_rotates(options, i) &&
            sources_is_file(output->name) &&
            shell_word(output->name, out, MISFIT_CAPTURE_BYTES) != NULL) {
            return out;
        }
    }
    return options->is_live
               ? NULL
               : misfit_capture(&options->sources, out, MISFIT_CAPTURE_BYTES);
}

/* One write, so that a line of another program is not within it. */
void conclude_warn(const struct options *o, const char *format, ...)
{
    char text[WARNING_BYTES];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (!o->quiet) {
        (void)fprintf(stderr, "lumdump: warning: %s\n", text);
    }
}

static void warn_of_source(const struct options *o, const char *text)
{
    conclude_warn(o, "%s: %s", o->source, text);
}

/* They name the source themselves. */
void conclude_about(const struct options *options,
                    const struct provenance_source *about)
{
    for (size_t i = 0; i < about->note_count; i++) {
        conclude_warn(options, "%s", about->notes[i].text);
    }
}

void conclude_notes(struct pass *pass)
{
    struct outputs_notes *notes = &pass->notes;
    while (notes->told < notes->count) {
        warn_of_source(pass->options, notes->list[notes->told++].text);
    }
}

/* --- The sensors --- */

static void print_sensors(const struct pass *pass)
{
    const lum_demux *demux = lum_framer_demux(pass->framer);
    for (size_t i = 0; i < lum_demux_sensor_count(demux); i++) {
        char name[LUM_SENSOR_NAME_BYTES];
        (void)fprintf(stderr, " %s", lum_demux_name(demux, i, name));
    }
}

static enum exit_status name_sensors(const struct pass *pass)
{
    (void)fprintf(stderr,
                  "lumdump: %s: packets of several sensors; choose one by "
                  "--sensor:",
                  pass->options->source);
    print_sensors(pass);
    (void)fprintf(
        stderr,
        ", and perhaps more\n"
        "or read all of them, each by its own calibration and pose, by --rig "
        "FILE (docs/formats.md), such as:\nversion: 1\nsensors:\n");
    for (size_t i = 0;
         i < lum_demux_sensor_count(lum_framer_demux(pass->framer)); i++) {
        char line[RIG_TEXT_BYTES];
        (void)fprintf(stderr, "%s\n", rig_line_for(pass->framer, i, line));
    }
    return EXIT_BAD;
}

/* None of the rig's sensors sent data, and others did. */
static bool lacks_rig(const struct pass *pass)
{
    const struct rig *rig = pass->options->rig;
    return rig != NULL && !rig_has_any_data(rig, pass->framer) &&
           lum_demux_sensor_count(lum_framer_demux(pass->framer)) > 0;
}

static enum exit_status refuse_rig(const struct pass *pass)
{
    char text[RIG_TEXT_BYTES];
    conclude_remarks(pass->options, pass->source.capture,
                     lum_framer_demux(pass->framer));
    (void)rig_tell_missing(pass->options->rig, pass->framer, text);
    (void)fprintf(stderr, "lumdump: %s: %s\n", pass->options->source, text);
    return EXIT_FAILED;
}

static bool lacks_asked_sensor(const struct pass *pass)
{
    const lum_demux *demux = lum_framer_demux(pass->framer);
    for (size_t i = 0; i < lum_demux_sensor_count(demux); i++) {
        if (lum_demux_is_requested(demux, i)) {
            return false;
        }
    }
    return pass->options->sensor.is_chosen && lum_demux_sensor_count(demux) > 0;
}

static enum exit_status refuse_sensor(const struct pass *pass)
{
    const char *interface = pass->options->sensor.interface;
    (void)fprintf(stderr, "lumdump: %s: no data of %s%s%s in it, but of",
                  pass->options->source,
                  number_address(pass->options->sensor.address).text,
                  *interface != '\0' ? "%" : "", interface);
    print_sensors(pass);
    (void)fputc('\n', stderr);
    return EXIT_FAILED;
}

/* Whether packets of ours came, and no data among them. */
static bool lacks_data(const struct pass *pass)
{
    const lum_demux_counters total = summary_count_packets(&pass->summary);
    return total.packets[LUM_PACKET_DATA] == 0 &&
           pass->diagnosis.shape_count > 0;
}

/* --- Warnings --- */

/* If lines gave no point: why, as far as the counters show. */
static void warn_of_no_points(const struct pass *pass)
{
    const lum_framer_counters p = summary_count(&pass->summary);
    const lum_demux_counters c = summary_count_packets(&pass->summary);
    const struct live_counts *live = pass->summary.live;
    const char *why = "the selection leaves none";
    if (p.points > 0 || p.lines[LUM_EYE_BLUE] + p.lines[LUM_EYE_GREEN] == 0) {
        return;
    }
    if (c.assembly.words == 0) {
        why = live != NULL && live->darkness[0] != '\0'
                  ? live->darkness
                  : "there are no ranges, as when the laser is off";
    } else if (p.losses.no_angle + p.losses.no_range > 0) {
        why = "see no_angle and no_range in the summary, and the selection";
    }
    conclude_warn(pass->options,
                  "%s: lines came, but no point is left of them: %s",
                  pass->options->source, why);
}

static void warn_of_points(const struct options *o, const char *name,
                           uint64_t n, const char *why)
{
    if (n > 0) {
        conclude_warn(o, "%s: %" PRIu64 " point%s left out, which %s",
                      output_title(name), n, n == 1 ? "" : "s", why);
    }
}

static void warn_of_left_out(const struct pass *pass)
{
    const struct options *o = pass->options;
    const struct summary_outputs *s = &pass->summary.outputs;
    for (size_t i = 0; i < s->left_out_count; i++) {
        const struct left_out *l = &s->left_out[i];
        warn_of_points(o, l->name, l->late,
                       "came after their frame had been written");
        warn_of_points(o, l->name, l->cut,
                       "are beyond the most that a frame can hold");
        warn_of_points(o, l->name, l->no_place,
                       "have no place in an organised cloud");
    }
}

static void warn_of_few(const struct pass *pass)
{
    const struct summary *s = &pass->summary;
    if (s->whole.frames < s->whole.asked) {
        conclude_warn(
            pass->options,
            "%s: only %" PRIu64
            " of %u whole frames came: others lack lines or "
            "words, or the laser was off, or came on during them; choose them "
            "by numbers, such as --frames 2:2",
            s->source, s->whole.frames, (unsigned)s->whole.asked);
    }
}

/* Of several frames over each other, the losses tell. */
static void warn_of_pictures(const struct pass *pass)
{
    const struct summary_outputs *s = &pass->summary.outputs;
    char text[200];
    for (size_t i = 0; i < s->drawn_count; i++) {
        const struct drawn *d = &s->drawn[i];
        if (d->frames == 1 && !d->is_whole) {
            conclude_warn(pass->options, "%s: it shows %s",
                          output_title(d->name),
                          summary_text_drawn(d, text, sizeof text));
        }
    }
}

/* Packets that a corrupted network brings are too few for it. */
static void warn_of_layout(const struct pass *pass)
{
    const struct options *o = pass->options;
    const lum_demux_counters total = summary_count_packets(&pass->summary);
    char what[160];
    char capture[MISFIT_CAPTURE_BYTES];
    char advice[MISFIT_ADVICE_BYTES + sizeof capture];
    if (!misfit_find(&total, what, sizeof what)) {
        return;
    }
    misfit_advise(o->source, conclude_capture(o, capture), advice,
                  sizeof advice);
    conclude_warn(o, "%s: %s: %s", o->source, what, advice);
}

void conclude_remarks(const struct options *options, const lum_capture *capture,
                      const lum_demux *demux)
{
    lum_error text;
    for (size_t i = 0;
         lum_capture_remark(capture, demux, options->sensor.port, i, &text);
         i++) {
        warn_of_source(options, text.text);
    }
}

static void warn_of_nothing(const struct options *o)
{
    conclude_warn(
        o,
        "%s: no packet of a G2 was found: no complete packet to or from "
        "UDP port %u has its magic",
        o->source, o->sensor.port != 0 ? o->sensor.port : LUM_PORT);
}

/* It names the capture itself. */
static void warn_of_damage(const struct pass *pass)
{
    lum_error why = {""};
    if (summary_damaged(&pass->summary, &why) != 0) {
        conclude_warn(pass->options, "%s", why.text);
    }
}

/* What makes times unsure without a trace in them. */
static void warn_of_clocks(const struct pass *pass)
{
    const lum_clock_fit_info clocks = summary_count_clocks(&pass->summary);
    const uint64_t still = clocks.still;
    const uint64_t steps = clocks.host_steps;
    if (still > 0) {
        conclude_warn(pass->options,
                      "%s: the arrival times of %" PRIu64
                      " line%s stood still: UTC is not known there; the "
                      "sensor's clock is, by --time sensor",
                      pass->options->source, still, still == 1 ? "" : "s");
    }
    if (steps > 0) {
        conclude_warn(pass->options,
                      "%s: the clock of the host that recorded it was stepped "
                      "%" PRIu64 " time%s: within a second of that, UTC is "
                      "not known",
                      pass->options->source, steps, steps == 1 ? "" : "s");
    }
}

static void warn_of_poses(const struct pass *pass)
{
    char text[800];
    if (pass->motion != NULL && motion_tell(pass->motion, text, sizeof text)) {
        conclude_warn(pass->options, "%s", text);
    }
}

static void warn_of_voxels(const struct pass *pass)
{
    const struct voxel_counts *v = &pass->summary.voxels;
    if (v->out_of_range > 0) {
        conclude_warn(
            pass->options,
            "--voxel: %" PRIu64 " of %" PRIu64
            " points are left out of the map: they are too far from 0 for "
            "voxels of %g m; use poses in metres, or larger voxels",
            v->out_of_range, v->points + v->out_of_range, v->size);
    }
}

static void warn_of_losses(const struct pass *pass)
{
    const struct options *o = pass->options;
    if (pass->summary.truncated) {
        conclude_warn(o, "%s",
                      pass->source.warning.text); /* it names the source */
    }
    if (pass->source.has_changed) {
        warn_of_source(o, "a later part of it has another calibration or "
                          "profile: those at its start were used for all");
    }
    if (!pass->summary.span.is_known) {
        warn_of_nothing(o);
    }
    conclude_remarks(o, pass->source.capture, lum_framer_demux(pass->framer));
    warn_of_layout(pass);
    warn_of_no_points(pass);
    warn_of_left_out(pass);
    warn_of_few(pass);
    warn_of_pictures(pass);
    warn_of_clocks(pass);
    warn_of_poses(pass);
    warn_of_voxels(pass);
}

/* --- The end --- */

/* A reader that has left is no failure. */
enum exit_status conclude_stdout(void)
{
    if ((fflush(stdout) == 0 && !ferror(stdout)) || errno == EPIPE) {
        return EXIT_DONE;
    }
    (void)fprintf(stderr, "lumdump: standard output: cannot be written: %s\n",
                  strerror(errno));
    return EXIT_FAILED;
}

enum exit_status conclude_summary(const struct pass *pass)
{
    const struct options *o = pass->options;
    warn_of_losses(pass);
    if (o->json) {
        summary_json_print(&pass->summary, stdout);
    } else if (!o->quiet) {
        summary_text_print(&pass->summary,
                           o->output_count > 0 ? stderr : stdout);
    }
    return conclude_stdout();
}

static enum exit_status finish(struct pass *pass, lum_error *error)
{
    if (pass->outputs != NULL) {
        struct outputs *outputs = pass->outputs;
        pass_note_left_out(pass);
        pass->outputs = NULL;
        const int closed = outputs_close(outputs, error);
        const int reason = errno;
        pass->summary.outputs.retention = pass->notes.retention;
        conclude_notes(pass);
        if (closed != 0) {
            return reason == EPIPE ? EXIT_DONE
                                   : conclude_error(error, EXIT_FAILED);
        }
    }
    return conclude_summary(pass);
}

enum exit_status conclude(struct pass *pass, enum pass_result result,
                          lum_error *error)
{
    switch (result) {
    case PASS_SENSORS:
        return name_sensors(pass);
    case PASS_FAILED:
        return conclude_error(error, EXIT_FAILED);
    case PASS_REFUSED:
        return conclude_error(error, EXIT_BAD);
    case PASS_INTERRUPTED:
    case PASS_READER_LEFT:
        return EXIT_DONE;
    case PASS_DONE:
    case PASS_DROPPED:
    default:
        break;
    }
    warn_of_damage(pass);
    if (lacks_asked_sensor(pass)) {
        return refuse_sensor(pass);
    }
    if (lacks_rig(pass)) {
        return refuse_rig(pass);
    }
    if (lacks_data(pass)) {
        char capture[MISFIT_CAPTURE_BYTES];
        conclude_remarks(pass->options, pass->source.capture,
                         lum_framer_demux(pass->framer));
        diagnosis_print(&pass->diagnosis, pass->options->source,
                        conclude_capture(pass->options, capture), stderr);
        return EXIT_FAILED;
    }
    return finish(pass, error);
}
