/* A run with --infer: the capture is read, and the layout that was found is
 * written and reported. */
#include "runs.h"

#include "../common/interrupt.h"
#include "../common/json.h"
#include "../common/misfit.h"
#include "../common/profile_difference.h"
#include "../common/shell_word.h"
#include "replay.h"
#include "targets.h"

#include "base/outfile.h"
#include "lum/infer/infer.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Records between looks at signals. */
#define RECORDS_A_LOOK 256u

/* What was found out about a layout. */
struct infer_report {
    const char *source;
    const char *capture; /* of it, as a word of a shell */
    const char *profile; /* file that it is written to, as such; NULL: none */
    uint64_t records;    /* that were read */
    bool is_truncated;
    uint64_t damaged; /* parts that could not be read and were passed over */
    lum_infer_result result;
    char yaml[LUM_INFER_YAML_BYTES]; /* empty: no layout was found */
};

static const char *name_verdict(lum_infer_verdict verdict)
{
    switch (verdict) {
    case LUM_INFER_FOUND:
        return "found";
    case LUM_INFER_UNSURE:
        return "unsure";
    case LUM_INFER_TOO_LITTLE:
        return "too little";
    case LUM_INFER_NOTHING_FITS:
    default:
        return "nothing fits";
    }
}

/* --- A report for people --- */

static const char *plural(uint64_t n)
{
    return n == 1 ? "" : "s";
}

static void print_unused(uint32_t n, const char *what, const char *why,
                         FILE *out)
{
    if (n > 0) {
        (void)fprintf(out, "not used   %" PRIu32 " %s%s %s\n", n, what,
                      plural(n), why);
    }
}

/* What may be data and was not looked at, if there is such. */
static void print_all_unused(const lum_infer_counts *c, FILE *out)
{
    print_unused(c->other_type, "packet",
                 c->packets > 0 ? "of another type, or not 0 in bytes 9 to 11"
                                : "with our magic, and without samples",
                 out);
    print_unused(c->left_out, "packet", "of other sensors than the first 16",
                 out);
    print_unused(c->elsewhere, "record",
                 "of another port, sensor or interface, or no datagram", out);
    print_unused(c->cut_short, "datagram", "that the capture has only in part",
                 out);
}

static void print_head(const struct infer_report *report, FILE *out)
{
    const lum_infer_result *r = &report->result;
    const lum_infer_counts *c = &r->counts;
    (void)fprintf(out, "lumdump: %s: %s: %s\n", report->source,
                  name_verdict(r->verdict), r->text);
    (void)fprintf(
        out,
        "looked at  %s%" PRIu32 " packet%s that may be data, of %" PRIu32
        " sensor%s; %s%" PRIu32 " of other kinds, %" PRIu32 " foreign\n",
        c->is_full ? "the first " : "", c->packets, plural(c->packets),
        c->sensors, plural(c->sensors), c->is_full ? "until then " : "",
        c->control, c->foreign);
    if (c->joined > 0) {
        (void)fprintf(out,
                      "joined     %" PRIu32
                      " datagrams came joined, and were split\n",
                      c->joined);
    }
    print_all_unused(c, out);
}

static void print_finding(const lum_infer_finding *f, FILE *out)
{
    (void)fprintf(out, "\n%s: %s\n", f->name, f->value);
    (void)fprintf(out, "    %s%s\n",
                  f->is_told ? "" : "not in the packets: ", f->evidence);
    if (f->equal[0] != '\0') {
        (void)fprintf(out, "    fits equally well: %s\n", f->equal);
    }
    if (f->look[0] != '\0') {
        (void)fprintf(out, "    what decides: %s\n", f->look);
    }
}

static void print_second(const lum_infer_result *r, FILE *out)
{
    struct profile_difference all[LUM_KEYS_MAX];
    const char *divider = "";
    const size_t count =
        r->has_second ? profile_differences(&r->profile, &r->second, all) : 0;
    if (count == 0) {
        (void)fputs("no second reading was found\n", out);
        return;
    }
    (void)fputs("second best reading: ", out);
    for (size_t i = 0; i < count; i++) {
        (void)fprintf(out, "%s%s %s", divider, all[i].key,
                      all[i].other[0] != '\0' ? all[i].other : "none");
        divider = ", ";
    }
    (void)fputc('\n', out);
}

static void print_margin(const lum_infer_result *r, FILE *out)
{
    (void)fprintf(out,
                  "explained  %" PRIu32 " of %" PRIu32
                  " packets; margin %.1f points, of %s (sure from %.1f)\n",
                  r->fit, r->counts.packets, r->margin,
                  r->findings[r->margin_key].name, LUM_INFER_MARGIN_SURE);
    print_second(r, out);
    if (r->verdict == LUM_INFER_UNSURE) {
        (void)fputs("Unsure: look at the points before you rely on this "
                    "profile, or take a longer capture.\n",
                    out);
    }
}

static bool needs_look(const lum_infer_result *r)
{
    for (size_t i = 0; i < r->finding_count; i++) {
        if (r->findings[i].look[0] != '\0') {
            return true;
        }
    }
    return false;
}

/* How two readings are looked at. */
static void print_look(const struct infer_report *report, FILE *out)
{
    if (needs_look(&report->result)) {
        const char *profile = report->profile;
        (void)fprintf(
            out,
            "\nTo look at two readings side by side, %s, change the "
            "key in the copy, and:\n"
            "  lumview %s --profile %s --profile other.yaml\n",
            profile != NULL ? "copy the profile as other.yaml"
                            : "save the profile as profile.yaml, copy it as "
                              "other.yaml",
            report->capture, profile != NULL ? profile : "profile.yaml");
    }
    (void)fputc('\n', out);
}

static void infer_report_text(const struct infer_report *report, FILE *out)
{
    const lum_infer_result *r = &report->result;
    print_head(report, out);
    if (!r->has_profile) {
        return;
    }
    print_margin(r, out);
    for (size_t i = 0; i < r->finding_count; i++) {
        print_finding(&r->findings[i], out);
    }
    print_look(report, out);
}

/* --- A report for programs --- */

static void put_texts(struct json *json, const lum_infer_finding *f)
{
    json_text(json, "key", f->name);
    json_text(json, "value", f->value);
    json_bool(json, "told", f->is_told);
    json_text(json, "evidence", f->evidence);
    json_text(json, "equal", f->equal);
    json_text(json, "look", f->look);
}

static void put_findings(struct json *json, const lum_infer_result *r)
{
    json_open_array(json, "findings");
    for (size_t i = 0; i < r->finding_count; i++) {
        json_open_object(json, NULL);
        put_texts(json, &r->findings[i]);
        json_close_object(json);
    }
    json_close_array(json);
}

static void put_second(struct json *json, const lum_infer_result *r)
{
    struct profile_difference all[LUM_KEYS_MAX];
    if (!r->has_second) {
        json_null(json, "second");
        return;
    }
    const size_t count = profile_differences(&r->profile, &r->second, all);
    json_open_object(json, "second");
    for (size_t i = 0; i < count; i++) {
        json_text(json, all[i].key, all[i].other);
    }
    json_close_object(json);
}

static void put_counts(struct json *json, const struct infer_report *report)
{
    const lum_infer_counts *c = &report->result.counts;
    json_uint(json, "records", report->records);
    json_bool(json, "truncated", report->is_truncated);
    json_uint(json, "damaged", report->damaged);
    json_uint(json, "packets", c->packets);
    json_uint(json, "fit", report->result.fit);
    json_uint(json, "control", c->control);
    json_uint(json, "foreign", c->foreign);
    json_uint(json, "cut_short", c->cut_short);
    json_uint(json, "joined", c->joined);
    json_uint(json, "other_type", c->other_type);
    json_uint(json, "left_out", c->left_out);
    json_uint(json, "elsewhere", c->elsewhere);
    json_uint(json, "sensors", c->sensors);
    json_bool(json, "full", c->is_full);
}

static void infer_report_json(const struct infer_report *report, FILE *out)
{
    const lum_infer_result *r = &report->result;
    struct json json;
    json_begin_line(&json, out);
    json_text(&json, "source", report->source);
    json_text(&json, "verdict", name_verdict(r->verdict));
    json_text(&json, "text", r->text);
    put_counts(&json, report);
    if (r->has_profile) {
        json_real(&json, "margin", r->margin, 3);
        json_text(&json, "margin_key", r->findings[r->margin_key].name);
        json_text(&json, "profile", report->yaml);
    } else {
        json_null(&json, "margin");
        json_null(&json, "margin_key");
        json_null(&json, "profile");
    }
    put_second(&json, r);
    put_findings(&json, r);
    json_end_line(&json);
}

/* --- A run --- */

struct inference {
    const struct options *options;
    lum_infer *infer;
    lum_capture *capture;
    struct infer_report report;
    uint32_t skipped; /* records of other interfaces than the one asked for */
    char capture_word[MISFIT_CAPTURE_BYTES];
    char profile_word[MISFIT_CAPTURE_BYTES];
};

/* --- Reading --- */

/* What cannot be read to its end is looked at as far as it can. */
static void note_break(struct inference *f, const lum_error *why)
{
    f->report.is_truncated = true;
    conclude_warn(f->options, "%s", why->text);
}

static void note_damage(struct inference *f)
{
    lum_error why = {""};
    f->report.damaged = lum_capture_damaged(f->capture, &why);
    if (f->report.damaged != 0) {
        conclude_warn(f->options, "%s", why.text);
    }
}

static bool is_of_asked_interface(const struct inference *f)
{
    const char *asked = f->options->sensor.interface;
    const char *interface = lum_capture_interface(f->capture);
    return *asked == '\0' ||
           (interface != NULL && strcmp(interface, asked) == 0);
}

static enum pass_result read_all(struct inference *f, lum_error *error)
{
    lum_record record;
    lum_error broken = {""};
    int wants = 1;
    int status = 1;
    for (uint64_t i = 1;
         wants > 0 &&
         (status = lum_capture_next(f->capture, &record, &broken)) > 0;
         i++) {
        const bool is_asked = is_of_asked_interface(f);
        wants = is_asked ? lum_infer_push(f->infer, &record, error) : wants;
        f->skipped += !is_asked;
        if (i % RECORDS_A_LOOK == 0 && interrupt_signal() != 0) {
            return PASS_INTERRUPTED;
        }
    }
    f->report.records = replay_records(f->capture);
    if (interrupt_signal() != 0) {
        return PASS_INTERRUPTED;
    }
    note_damage(f);
    if (status < 0) {
        note_break(f, &broken);
    }
    return wants < 0 ? PASS_FAILED : PASS_DONE;
}

static enum pass_result solve(struct inference *f, lum_error *error)
{
    const struct options *o = f->options;
    const lum_infer_options options = {.struct_size = sizeof options,
                                       .has_sensor = o->sensor.is_chosen,
                                       .sensor = o->sensor.address,
                                       .port = o->sensor.port};
    enum pass_result result = replay_open(o, &f->capture, error);
    if (result != PASS_DONE) {
        return result;
    }
    if (lum_infer_create(&options, &f->infer, error) != 0) {
        return PASS_FAILED;
    }
    result = read_all(f, error);
    if (result != PASS_DONE) {
        return result;
    }
    f->report.result.struct_size = sizeof f->report.result;
    const int solved = lum_infer_solve(f->infer, &f->report.result, error);
    f->report.result.counts.elsewhere += f->skipped;
    if (interrupt_signal() != 0) {
        return PASS_INTERRUPTED;
    }
    return solved < 0 ? PASS_FAILED : PASS_DONE;
}

/* --- Telling --- */

/* Where the profile goes; NULL: with --json, into that alone. */
static const char *target_of(const struct options *o)
{
    if (o->output_count > 0) {
        return o->outputs[0].name;
    }
    return o->json ? NULL : "-";
}

static const char *name_file(struct inference *f, const char *target)
{
    return target == NULL || strcmp(target, "-") == 0
               ? NULL
               : shell_word(target, f->profile_word, sizeof f->profile_word);
}

/* The report comes first: on a terminal the profile follows it. */
static enum exit_status tell(struct inference *f, lum_error *error)
{
    const struct options *o = f->options;
    const char *target = target_of(o);
    const bool is_found = f->report.result.has_profile;
    if (is_found) {
        (void)lum_infer_write_yaml(&f->report.result, f->report.yaml,
                                   sizeof f->report.yaml);
    }
    conclude_remarks(o, f->capture, NULL);
    if (!is_found || (!o->json && !o->quiet)) {
        infer_report_text(&f->report, stderr);
    }
    if (is_found && target != NULL &&
        lum_outfile_save(target, f->report.yaml, strlen(f->report.yaml),
                         error) != 0) {
        return errno == EPIPE ? EXIT_DONE : conclude_error(error, EXIT_FAILED);
    }
    if (o->json) {
        infer_report_json(&f->report, stdout);
    }
    const enum exit_status printed = conclude_stdout();
    return is_found ? printed : EXIT_FAILED;
}

enum exit_status infer_run(const struct options *options)
{
    lum_error error = {""};
    const char *target = target_of(options);
    if ((target != NULL &&
         targets_check_inputs(options, target, &error) != 0) ||
        (options->json && targets_check_inputs(options, "-", &error) != 0)) {
        return conclude_error(&error, EXIT_BAD);
    }
    struct inference *f = calloc(1, sizeof *f);
    if (f == NULL) {
        (void)lum_error_set(&error, "out of memory");
        return conclude_error(&error, EXIT_FAILED);
    }
    f->options = options;
    f->report.source = options->source;
    f->report.capture = misfit_capture(&options->sources, f->capture_word,
                                       sizeof f->capture_word);
    f->report.profile = name_file(f, target);
    const enum pass_result result = solve(f, &error);
    enum exit_status status = EXIT_DONE;
    if (result == PASS_DONE) {
        status = tell(f, &error);
    } else if (result != PASS_INTERRUPTED) {
        status = conclude_error(&error, EXIT_FAILED);
    }
    lum_infer_free(f->infer);
    lum_capture_close(f->capture);
    free(f);
    if (interrupt_signal() != 0) {
        interrupt_die();
    }
    return status;
}
