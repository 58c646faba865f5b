/* A step of a sweep: sets, settles, records and proves. */
#include "sweep_run.h"

#include "../common/frame_watch.h"
#include "../common/own_address.h"
#include "../common/terminal.h"
#include "ctl_session.h"
#include "remember.h"
#include "setting.h"
#include "watch.h"

#include "base/text.h"
#include "lum/base/time.h"
#include "lum/laser.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define SECOND_NS INT64_C(1000000000)
#define LOOK_NS   (SECOND_NS / 20)
#define FIRST_NS  (5 * SECOND_NS)  /* the first frame has to begin */
#define FRAME_NS  (10 * SECOND_NS) /* the next one has to begin */
#define GAP_NS    SECOND_NS        /* data has to come */
#define DISK_NS   (60 * SECOND_NS) /* a file has to be on the disk */

/* The clocks of sensor and host drift against each other by less than 1/2000;
 * a jump below this is not told from the looks' own error. */
#define CLOCK_DRIFT_PER 2000
#define CLOCK_SLACK_NS  (SECOND_NS / 50)

/* If no frame begins for this long after its end was due, a recording ends at
 * any packet. */
#define OVERDUE_NS (2 * SECOND_NS)

#define OPTIONS_MAX 2u
#define BROKEN      "the session with the sensor broke"

/* A recording under way. */
struct recording {
    struct sweep *sweep;
    const lum_sweep_step *what;
    struct recorder *recorder;
    struct frame_watch frames;
    int64_t asked_ns; /* monotonic */
    bool has_begun;
    bool has_ended;
    int64_t begun_ns; /* monotonic, as the next: the calendar may be set */
    int64_t last_ns;  /* the latest packet */
    int64_t frame_ns; /* the latest frame that began */
    uint32_t count;   /* frames that are whole */
    enum exit_status status;
};

/* --- What may go wrong --- */

static enum exit_status fail(struct sweep *s, enum exit_status status,
                             const char *why)
{
    (void)snprintf(s->why, sizeof s->why, "%s", why);
    return status;
}

static enum exit_status status_of(const lum_news *news)
{
    static const lum_news_kind silences[] = {
        LUM_NEWS_NO_ANSWER_YET, LUM_NEWS_NO_DATA_YET, LUM_NEWS_SILENT,
        LUM_NEWS_DATA_STOPPED,  LUM_NEWS_MOVED,       LUM_NEWS_NO_ANSWER};
    for (size_t i = 0; i < sizeof silences / sizeof silences[0]; i++) {
        if (news->kind == silences[i]) {
            return EXIT_NO_ANSWER;
        }
    }
    return lum_laser_has_hazard(news->status) ? EXIT_HAZARD : EXIT_FAILED;
}

enum exit_status sweep_trouble(struct sweep *sweep)
{
    const lum_news *trouble = &sweep->ctl->trouble;
    if (trouble->kind == 0) {
        return EXIT_DONE;
    }
    (void)lum_news_sentence(trouble, sweep->why, sizeof sweep->why);
    return status_of(trouble);
}

/* As sweep_trouble(), and EXIT_FAILED after a signal. */
static enum exit_status check(struct sweep *sweep)
{
    return lum_cancel_is_raised(sweep->ctl->cancel)
               ? fail(sweep, EXIT_FAILED, "interrupted")
               : sweep_trouble(sweep);
}

/* --- Time that passes --- */

/* Beside the laser session's looks: only an end of the wait. */
static lum_result ask_nothing(struct ctl *ctl, void *context)
{
    (void)ctl;
    (void)context;
    return LUM_OK;
}

struct rest {
    struct sweep *sweep;
    int64_t end_ns;
};

static bool take_rest(void *context, const lum_sensor_event *event)
{
    struct rest *r = context;
    (void)event;
    return check(r->sweep) == EXIT_DONE && lum_time_monotonic_ns() < r->end_ns;
}

static bool take_laser(void *context, const lum_sensor_event *event)
{
    const struct rest *r = context;
    lum_laser_session_view view = {.struct_size = sizeof view};
    (void)lum_laser_session_look(r->sweep->ctl->laser, &view);
    return view.laser == LUM_LASER_ASKED && take_rest(context, event);
}

static enum exit_status rest(struct sweep *sweep, int64_t ns,
                             bool (*take)(void *context,
                                          const lum_sensor_event *event))
{
    struct rest r = {sweep, lum_time_monotonic_ns() + ns};
    const struct watch watch = {.looks = true,
                                .period_ns = ns < LOOK_NS ? ns : LOOK_NS,
                                .ask = ask_nothing,
                                .take = take,
                                .context = &r};
    const enum exit_status status = watch_run(sweep->ctl, &watch);
    return status != EXIT_DONE ? fail(sweep, status, BROKEN) : check(sweep);
}

enum exit_status sweep_await_laser(struct sweep *sweep, int64_t ns)
{
    return rest(sweep, ns, take_laser);
}

/* --- A recording --- */

static bool end_recording(struct recording *r, enum exit_status status,
                          const char *why)
{
    r->has_ended = true;
    r->status = status == EXIT_DONE ? status : fail(r->sweep, status, why);
    return false;
}

static bool is_over(const struct recording *r, int64_t now_ns,
                    bool begins_frame)
{
    const int64_t since_ns = now_ns - r->begun_ns;
    return r->what->frames > 0
               ? r->count == r->what->frames
               : since_ns >= r->what->record_ns + OVERDUE_NS ||
                     (begins_frame && since_ns >= r->what->record_ns);
}

/* Begins and ends with a frame. */
static bool take_datagram(struct recording *r, const lum_received *datagram,
                          int64_t now_ns)
{
    const bool begins_frame = frame_watch_begins(
        &r->frames, &r->sweep->ctl->layout, datagram->bytes, datagram->len);
    if (!r->has_begun) {
        r->has_begun = begins_frame;
        r->begun_ns = now_ns;
        r->frame_ns = now_ns;
    } else {
        r->count += begins_frame ? 1u : 0u;
        r->frame_ns = begins_frame ? now_ns : r->frame_ns;
        if (now_ns - r->last_ns > GAP_NS) {
            return end_recording(r, EXIT_NO_ANSWER,
                                 "no data came for more than 1 s");
        }
        if (is_over(r, now_ns, begins_frame)) {
            return end_recording(r, EXIT_DONE, "");
        }
    }
    r->last_ns = now_ns;
    if (r->has_begun) {
        recorder_put(r->recorder, datagram);
    }
    return true;
}

/* What did not come in time. */
static bool is_in_time(struct recording *r, int64_t now_ns)
{
    if (!r->has_begun) {
        return now_ns - r->asked_ns < FIRST_NS ||
               end_recording(r, EXIT_NO_ANSWER, "no frame began within 5 s");
    }
    if (now_ns - r->last_ns > GAP_NS) {
        return end_recording(r, EXIT_NO_ANSWER,
                             "no data came for more than 1 s");
    }
    return r->what->frames == 0 || now_ns - r->frame_ns < FRAME_NS ||
           end_recording(r, EXIT_FAILED, "no frame began within 10 s");
}

static bool take_recording(void *context, const lum_sensor_event *event)
{
    struct recording *r = context;
    lum_error error;
    const enum exit_status trouble = check(r->sweep);
    const int64_t now_ns = lum_time_monotonic_ns();
    bool goes_on = true;
    if (trouble != EXIT_DONE) {
        r->has_ended = true;
        r->status = trouble;
        return false;
    }
    if (event->kind == LUM_SENSOR_DATAGRAMS) {
        for (size_t i = 0; i < event->datagram_count && goes_on; i++) {
            goes_on = take_datagram(r, &event->datagrams[i], now_ns);
        }
        recorder_publish(r->recorder);
    } else {
        goes_on = is_in_time(r, now_ns);
    }
    return goes_on && (recorder_look(r->recorder, &error) == RECORDER_WRITES ||
                       end_recording(r, EXIT_FAILED, error.text));
}

static enum exit_status record(struct recording *r)
{
    const struct watch watch = {
        .looks = true, .take = take_recording, .context = r};
    r->asked_ns = lum_time_monotonic_ns();
    const enum exit_status status = watch_run(r->sweep->ctl, &watch);
    if (status != EXIT_DONE) {
        return fail(r->sweep, status, BROKEN);
    }
    return r->has_ended ? r->status : check(r->sweep);
}

static bool take_finish(void *context, const lum_sensor_event *event)
{
    const struct recording *r = context;
    lum_error error;
    (void)event;
    return recorder_look(r->recorder, &error) < RECORDER_WHOLE &&
           check(r->sweep) == EXIT_DONE &&
           lum_time_monotonic_ns() - r->asked_ns < DISK_NS;
}

/* Waits until the file is whole; heartbeats go on. */
static enum exit_status finish(struct recording *r)
{
    struct sweep *s = r->sweep;
    lum_error error = {""};
    const struct watch watch = {.looks = true,
                                .period_ns = LOOK_NS,
                                .ask = ask_nothing,
                                .take = take_finish,
                                .context = r};
    recorder_close(r->recorder, false);
    r->asked_ns = lum_time_monotonic_ns();
    const enum exit_status status = watch_run(s->ctl, &watch);
    const enum recorder_state state = recorder_look(r->recorder, &error);
    if (state == RECORDER_WHOLE) {
        return EXIT_DONE;
    }
    if (state == RECORDER_FAILED) {
        return fail(s, EXIT_FAILED, error.text);
    }
    return status != EXIT_DONE ? fail(s, status, BROKEN)
           : check(s) != EXIT_DONE
               ? check(s)
               : fail(s, EXIT_FAILED,
                      "the recording is not on the disk after 60 s");
}

/* --- Its settings --- */

/* Whether another program of this host has set, later, what a step has set, be
 * it to the same value: it may have been another one in between. Lines clear a
 * table. */
static bool is_of_other(const struct sweep *s, const struct memory *now,
                        lum_command_id id)
{
    const struct memory_entry *mine = &s->expected.entries[id];
    const struct memory_entry *scan = &s->expected.entries[LUM_COMMAND_YSCAN];
    const struct memory_entry *last = &now->entries[id];
    const bool is_mine = mine->standing == MEMORY_DONE;
    const bool clears = id == LUM_COMMAND_LINE_MODE &&
                        scan->standing == MEMORY_DONE &&
                        s->expected.table.scan != MEMORY_DEGREES;
    return last->standing != MEMORY_NOTHING &&
           ((is_mine &&
             (last->standing != MEMORY_DONE || last->value != mine->value ||
              last->utc_ns > mine->utc_ns)) ||
            (clears && last->utc_ns > scan->utc_ns));
}

static const char *find_other(const struct sweep *s, const struct memory *now)
{
    for (size_t i = 0; i < SETTINGS; i++) {
        if (is_of_other(s, now, settings[i].id)) {
            return settings[i].name;
        }
    }
    return NULL;
}

/* Whether a sensor's clock went on all the time: after a restart it begins at 0
 * again. Closer than memory_compare(), which has to do with readings that are
 * days apart, and not by the calendar, which may be set. */
static bool is_same_run(const struct memory_clock *before,
                        const struct memory_clock *now, int64_t passed)
{
    const uint32_t ticks = now->clock_us - before->clock_us;
    const int64_t jump = (int32_t)(ticks - (uint32_t)(passed / 1000));
    const int64_t most = (before->error_ns + now->error_ns + CLOCK_SLACK_NS +
                          passed / CLOCK_DRIFT_PER) /
                         1000;
    return jump <= most && jump >= -most;
}

/* Asks for the clock. */
static enum exit_status look(struct sweep *s, struct remembered *out)
{
    const bool was_quiet = s->ctl->options.quiet;
    s->ctl->options.quiet = true;
    const enum exit_status status = remember_look(s->ctl, out);
    s->ctl->options.quiet = was_quiet;
    if (out->has_answered) {
        return check(s); /* nothing can be stored: it shows no others */
    }
    return check(s) != EXIT_DONE
               ? check(s)
               : fail(s, status != EXIT_DONE ? status : EXIT_NO_ANSWER,
                      "the sensor does not answer");
}

/* When a reading was made, monotonic. */
static int64_t time_of(const struct memory_clock *clock)
{
    return lum_time_monotonic_ns() - (lum_time_utc_ns() - clock->utc_ns);
}

/* Before the first setting. */
static enum exit_status look_first(struct sweep *s)
{
    struct remembered now;
    const enum exit_status status =
        s->clock.is_known ? EXIT_DONE : look(s, &now);
    if (status == EXIT_DONE && !s->clock.is_known) {
        s->clock = now.clock;
        s->looked_ns = time_of(&now.clock);
    }
    return status;
}

/* The laser session looks once a second: another program may have switched the
 * laser off since. */
static enum exit_status look_at_laser(struct sweep *s)
{
    struct ctl_answer answer = {.has_status = false};
    bool was_sent = false;
    const enum exit_status status =
        ctl_request(s->ctl, NULL, 0, &answer, &was_sent);
    if (check(s) != EXIT_DONE) {
        return check(s);
    }
    if (status != EXIT_DONE) {
        return fail(s, status, "the sensor does not answer");
    }
    s->has_status = answer.has_status;
    s->status = answer.status;
    if (!s->ctl->options.owner.laser ||
        (answer.has_status && lum_laser_is_on(answer.status))) {
        return EXIT_DONE;
    }
    return fail(s,
                lum_laser_has_hazard(answer.status) ? EXIT_HAZARD : EXIT_FAILED,
                "the laser is no longer up");
}

/* That the laser is as it was, the sensor has not restarted since the sweep's
 * first look, and no lumctl of this user has set what it has set. */
static enum exit_status prove(struct sweep *s)
{
    struct remembered now;
    enum exit_status status = look_at_laser(s);
    status = status == EXIT_DONE ? look(s, &now) : status;
    if (status != EXIT_DONE) {
        return status;
    }
    const int64_t now_ns = time_of(&now.clock);
    if (!is_same_run(&s->clock, &now.clock, now_ns - s->looked_ns)) {
        return fail(s, EXIT_FAILED, "the sensor restarted, by its clock");
    }
    s->clock = now.clock;
    s->looked_ns = now_ns;
    const char *other = now.has_file ? find_other(s, &now.memory) : NULL;
    if (other != NULL) {
        (void)snprintf(s->why, sizeof s->why,
                       "another lumctl has set %s meanwhile", other);
        return EXIT_FAILED;
    }
    return EXIT_DONE;
}

static enum exit_status set(struct sweep *s, struct manifest_result *result)
{
    if (s->settings.count > 0) {
        enum exit_status status = plan_send(s->ctl, &s->settings);
        if (status != EXIT_DONE) {
            return check(s) != EXIT_DONE
                       ? check(s)
                       : fail(s, status, "its settings were not answered");
        }
        status = plan_judge(&s->settings);
        if (status != EXIT_DONE) {
            return fail(s, status, "the sensor refused a setting");
        }
        memory_merge(&s->expected, &s->ctl->changes, lum_time_utc_ns());
        remember_changes(s->ctl);
    }
    result->set_utc_ns = lum_time_utc_ns();
    return EXIT_DONE;
}

/* --- The step --- */

static void say_about(const struct sweep *s, size_t step,
                      struct provenance *out)
{
    char at[64];
    char set[256] = "";
    char source[64];
    const char *texts[OPTIONS_MAX] = {at, set};
    const struct provenance_run run = {.program = "lumctl",
                                       .source = source,
                                       .options = texts,
                                       .option_count = OPTIONS_MAX};
    (void)snprintf(source, sizeof source, "udp://%s",
                   session_name(session_host(s->ctl)).text);
    (void)snprintf(at, sizeof at, "sweep, step %u of %u", (unsigned)step + 1u,
                   (unsigned)s->plan.count);
    for (size_t i = 0; i < s->in_force.count; i++) {
        const struct plan_item *item = &s->in_force.items[i];
        lum_text_add(set, sizeof set, "%s%s %s", *set != '\0' ? ", " : "",
                     item->setting, item->value);
    }
    provenance_make(&run, &s->geometry, NULL, out);
}

static lum_endpoint host_of(const struct ctl *ctl)
{
    lum_endpoint host = {0, 0};
    lum_socket_local(lum_sensor_socket(ctl->sensor), &host);
    if (host.address == 0) {
        host.address =
            own_address(session_host(ctl).address, ctl->options.interface);
    }
    return host;
}

/* Records, proves, and only then gives the file its name. */
static enum exit_status record_step(struct sweep *s, size_t step,
                                    struct manifest_result *result)
{
    char path[MANIFEST_PATH_BYTES];
    static struct provenance about; /* large, and copied */
    struct recording r = {.sweep = s, .what = &s->plan.steps[step]};
    lum_error error = {""};
    say_about(s, step, &about);
    manifest_file(s->manifest, step, result->file, path);
    const struct recorder_options options = {.path = path,
                                             .about = &about,
                                             .layout = &s->ctl->layout,
                                             .sensor = session_host(s->ctl),
                                             .host = host_of(s->ctl)};
    r.recorder = recorder_new(&options, &error);
    if (r.recorder == NULL) {
        return fail(s, EXIT_FAILED, error.text);
    }
    enum exit_status status = record(&r);
    status = status == EXIT_DONE ? prove(s) : status;
    status = status == EXIT_DONE ? finish(&r) : status;
    if (status == EXIT_DONE) {
        recorder_free(r.recorder, &result->counts);
    } else {
        recorder_close(r.recorder, true);
        s->dropped = r.recorder; /* laser off comes first */
    }
    return status;
}

static enum exit_status do_step(struct sweep *s, size_t step,
                                struct manifest_result *result)
{
    const lum_sweep_step *what = &s->plan.steps[step];
    enum exit_status status = check(s);
    status = status == EXIT_DONE ? look_first(s) : status;
    status = status == EXIT_DONE ? set(s, result) : status;
    if (status == EXIT_DONE && what->settle_ns > 0) {
        status = rest(s, what->settle_ns, take_rest);
    }
    if (status == EXIT_DONE) {
        status = what->record_ns > 0 || what->frames > 0
                     ? record_step(s, step, result)
                     : prove(s);
    }
    return status;
}

/* Waits for no reader. */
static void tell_done(const struct sweep *s, size_t step,
                      const struct manifest_result *result)
{
    const struct recorder_counts *c = &result->counts;
    const uint64_t lost = c->losses.lines_incomplete + c->losses.lines_missing;
    if (!writable(stdout, 0)) {
        return;
    }
    (void)printf("step %u of %u: done", (unsigned)step + 1u,
                 (unsigned)s->plan.count);
    if (result->file[0] != '\0') {
        (void)printf(", %s/%s, %" PRIu64 " packets", s->folder, result->file,
                     c->packets);
    }
    if (lost > 0 || c->losses.words_lost > 0) {
        (void)printf("; lost: %" PRIu64 " lines or parts of them, %" PRIu64
                     " words",
                     lost, c->losses.words_lost);
    }
    if (c->dropped > 0) {
        (void)printf("; %" PRIu64 " packets not written, the disk is too slow",
                     c->dropped);
    }
    (void)putchar('\n');
    (void)fflush(stdout);
}

/* The last: of the proof, or of the laser session. */
static void take_status(const struct sweep *s, struct manifest_result *result)
{
    lum_laser_session_view view = {.struct_size = sizeof view};
    (void)lum_laser_session_look(s->ctl->laser, &view);
    result->has_status = s->has_status || view.has_status;
    result->status = s->has_status ? s->status : view.status;
}

enum exit_status sweep_step(struct sweep *sweep, size_t step)
{
    struct manifest_result result = {.why = "it was under way"};
    lum_error error = {""};
    sweep->has_status = false;
    manifest_note(sweep->manifest, step, &result);
    const enum exit_status status = do_step(sweep, step, &result);
    result.is_done = status == EXIT_DONE;
    take_status(sweep, &result);
    (void)snprintf(result.why, sizeof result.why, "%s", sweep->why);
    manifest_note(sweep->manifest, step, &result);
    if (result.is_done) {
        tell_done(sweep, step, &result);
    }
    if (manifest_tell(sweep->manifest, &error)) {
        return fail(sweep, ctl_complain(EXIT_FAILED, "%s", error.text),
                    "the manifest cannot be written");
    }
    return status;
}
