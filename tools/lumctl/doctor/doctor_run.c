/* The list of the doctor's checks, the order in which they run, and how their
 * findings are printed. */
#include "doctor.h"

#include "../../common/json.h"
#include "../../common/number.h"
#include "../status_report.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>

struct check {
    const char *name;
    enum doctor_need need;
    void (*look)(struct doctor *d, struct doctor_finding *out);
    bool explains_silence; /* fix it before the sensor is blamed */
};

/* The order is that in which people get them wrong. */
static const struct check checks[] = {
    {"interface", DOCTOR_NEEDS_NOTHING, doctor_check_interface, true},
    {"route", DOCTOR_NEEDS_INTERFACE, doctor_check_route, true},
    {"arp", DOCTOR_NEEDS_ROUTE, doctor_check_arp, false},
    {"port", DOCTOR_NEEDS_NOTHING, doctor_check_port, true},
    {"session", DOCTOR_NEEDS_NOTHING, doctor_check_session, true},
    {"firewall", DOCTOR_NEEDS_ROUTE, doctor_check_firewall, true},
    {"buffer", DOCTOR_NEEDS_NOTHING, doctor_check_buffer, false},
    {"mtu", DOCTOR_NEEDS_ROUTE, doctor_check_mtu, false},
    {"answer", DOCTOR_NEEDS_NEIGHBOUR, doctor_check_answer, false},
    {"data", DOCTOR_NEEDS_SESSION, doctor_check_data, false},
    {"layout", DOCTOR_NEEDS_DATA, doctor_check_layout, false},
    {"loss", DOCTOR_NEEDS_DATA, doctor_check_loss, false},
    {"strangers", DOCTOR_NEEDS_SESSION, doctor_check_strangers, false},
    {"clock", DOCTOR_NEEDS_ANSWER, doctor_check_clock, false},
    {"status", DOCTOR_NEEDS_ANSWER, doctor_check_status, false},
};

#define CHECKS (sizeof checks / sizeof checks[0])

static const struct {
    const char *word;   /* for people */
    const char *json;   /* for programs */
    const char *colour; /* on a terminal */
} results[DOCTOR_RESULTS] = {
    [DOCTOR_FINE] = {"ok", "fine", "\033[32m"},
    [DOCTOR_WRONG] = {"WRONG", "wrong", "\033[1;31m"},
    [DOCTOR_NOTE] = {"note", "note", "\033[33m"},
    [DOCTOR_UNSEEN] = {"-", "not looked at", "\033[2m"},
};

/* False if the reader has left, or the output cannot be written. */
static bool print_finding(const struct check *check,
                          const struct doctor_finding *f)
{
    const bool colour = report_may_colour(stdout);
    (void)printf(
        "  %s%-5s%s  %-9s  %s\n", colour ? results[f->result].colour : "",
        results[f->result].word, colour ? "\033[0m" : "", check->name, f->text);
    if (f->fix[0] != '\0') {
        (void)printf("%20sfix: %s\n", "", f->fix);
    }
    return fflush(stdout) == 0;
}

static void put_finding(struct json *json, const struct check *check,
                        const struct doctor_finding *f)
{
    const char *fix = f->fix[0] != '\0' ? f->fix : NULL;
    json_open_object(json, NULL);
    json_text(json, "name", check->name);
    json_text(json, "result", results[f->result].json);
    json_text(json, "text", f->text);
    json_text(json, "fix", fix);
    json_text(json, "mend", fix); /* the name before */
    json_close_object(json);
}

static void look(struct doctor *d, const struct check *check,
                 struct doctor_finding *out)
{
    *out = (struct doctor_finding){DOCTOR_UNSEEN, "", ""};
    session_keep_alive(d->ctl);
    if (d->lacks[check->need] != NULL) {
        doctor_unseen(out, "not looked at: %s", d->lacks[check->need]);
    } else {
        check->look(d, out);
    }
}

/* A hazard first; a silent sensor is blamed only if nothing on this host
 * explains the silence. */
static enum exit_status verdict(const struct doctor *d,
                                const struct doctor_finding *findings)
{
    bool is_wrong = false;
    bool is_explained = d->is_misled;
    for (size_t i = 0; i < CHECKS; i++) {
        const bool wrong = findings[i].result == DOCTOR_WRONG;
        is_wrong = is_wrong || wrong;
        is_explained = is_explained || (wrong && checks[i].explains_silence);
    }
    if (d->has_hazard) {
        return EXIT_HAZARD;
    }
    if (d->is_silent && !is_explained) {
        return EXIT_NO_ANSWER;
    }
    return is_wrong ? EXIT_FAILED : EXIT_DONE;
}

static const char *const overall_names[] = {
    [EXIT_DONE] = "fine",
    [EXIT_FAILED] = "wrong",
    [EXIT_NO_ANSWER] = "no answer",
    [EXIT_HAZARD] = "hazard",
};

static void print_json(const struct doctor *d, enum exit_status status,
                       const struct doctor_finding *findings)
{
    struct json json;
    json_begin_line(&json, stdout);
    json_text(&json, "sensor", d->address);
    json_open_array(&json, "checks");
    for (size_t i = 0; i < CHECKS; i++) {
        put_finding(&json, &checks[i], &findings[i]);
    }
    json_close_array(&json);
    json_text(&json, "overall", overall_names[status]);
    json_end_line(&json);
}

static void print_verdict(const struct doctor *d, enum exit_status status)
{
    static const char *const says[] = {
        [EXIT_DONE] = "nothing is wrong",
        [EXIT_FAILED] = "something is wrong, see above",
        [EXIT_NO_ANSWER] = "the sensor does not answer",
        [EXIT_HAZARD] = "the sensor reports a hazard",
    };
    if (!d->ctl->options.quiet) {
        (void)printf(
            "%s: %s%s\n", d->address, says[status],
            status == EXIT_DONE ? "" : "; docs/troubleshooting.md says more");
    }
}

/* It is not a failure if the reader has left; other errors are reported at the
 * end. */
static enum exit_status stop_printing(void)
{
    if (errno != EPIPE) {
        return EXIT_FAILED;
    }
    clearerr(stdout);
    return EXIT_DONE;
}

static enum exit_status examine(struct doctor *d)
{
    struct doctor_finding findings[CHECKS];
    for (size_t i = 0; i < CHECKS; i++) {
        look(d, &checks[i], &findings[i]);
        if (lum_cancel_is_raised(d->ctl->cancel)) {
            return EXIT_FAILED;
        }
        if (!d->ctl->options.json && !print_finding(&checks[i], &findings[i])) {
            return stop_printing();
        }
    }
    const enum exit_status status = verdict(d, findings);
    if (d->ctl->options.json) {
        print_json(d, status, findings);
    } else {
        print_verdict(d, status);
    }
    return status;
}

enum exit_status command_doctor(struct ctl *ctl, int count, char **words)
{
    struct doctor d = {.ctl = ctl, .sensor = session_host(ctl)};
    (void)count;
    (void)words;
    (void)number_format_address(d.sensor.address, d.address);
    lum_clock_sync_init(&d.session.clock);
    const enum exit_status status = examine(&d);
    doctor_close(&d);
    lum_framer_free(d.stream.framer);
    free(d.host.all);
    return status;
}
