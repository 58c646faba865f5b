#include "infer_report.h"

#include "../common/json.h"
#include "../common/profile_difference.h"

#include <inttypes.h>

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

/* --- Text --- */

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

void infer_report_text(const struct infer_report *report, FILE *out)
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

/* --- JSON --- */

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

void infer_report_json(const struct infer_report *report, FILE *out)
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
