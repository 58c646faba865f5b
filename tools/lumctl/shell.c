/* The command shell: what is typed, and what the sensor says meanwhile. */
#include "../common/interrupt.h"
#include "ctl.h"
#include "ctl_session.h"
#include "laser_outcome.h"
#include "line_words.h"
#include "prompt_input.h"
#include "status_report.h"

#include "lum/base/time.h"
#include "lum/command.h"
#include "lum/host/command_text.h"
#include "lum/laser.h"

#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define PROMPT_LINE_BYTES 2048u
#define WORDS_MAX         64
#define POLL_NS           INT64_C(1000000000)
#define LOOK_NS           (INT64_C(1000000) * PROMPT_LOOK_MS)

enum prompt_event {
    PROMPT_NONE, /* no whole line yet */
    PROMPT_LINE,
    PROMPT_TOO_LONG, /* a line that does not fit was thrown away */
    PROMPT_END       /* end of the input */
};

struct shell {
    struct ctl *ctl;
    bool knows; /* status was shown */
    uint16_t status;
    enum exit_status first;           /* of the first command that failed */
    enum exit_status first_not_typed; /* the same, wrong lines left out */
    bool was_left;                    /* by a person, or by a word for it */
};

/* --- The prompt --- */

/* Lines typed at a terminal, or read from a pipe or a file. A terminal is one
 * for a process. */
static struct {
    char bytes[PROMPT_LINE_BYTES]; /* read, not yet taken */
    size_t len;
    size_t taken; /* bytes of the line that was handed out */
    bool is_cut;  /* a line too long: the rest of it is thrown away */
    bool has_ended;
    const char *shown; /* empty where there is no terminal */
} p;

/* Cuts the first line off, whose end is at `end`. */
static enum prompt_event hand_out(size_t end, const char **out)
{
    p.bytes[end] = '\0';
    if (end > 0 && p.bytes[end - 1] == '\r') {
        p.bytes[end - 1] = '\0';
    }
    p.taken = end + 1;
    if (p.is_cut) {
        p.is_cut = false;
        return PROMPT_TOO_LONG;
    }
    *out = p.bytes;
    return PROMPT_LINE;
}

static void read_more(void)
{
    if (p.len == PROMPT_LINE_BYTES - 1) {
        p.is_cut = true;
        p.len = 0;
    }
    const int n =
        prompt_input_read(p.bytes + p.len, PROMPT_LINE_BYTES - 1 - p.len);
    if (n < 0) {
        p.has_ended = true;
    } else {
        p.len += (size_t)n;
    }
}

/* Takes what was typed; the last line need not end. *out lives until the next
 * call. */
static enum prompt_event prompt_take(const char **out)
{
    p.len -= p.taken;
    memmove(p.bytes, p.bytes + p.taken, p.len);
    p.taken = 0;
    const char *end = memchr(p.bytes, '\n', p.len);
    if (end == NULL && !p.has_ended) {
        read_more();
        end = memchr(p.bytes, '\n', p.len);
    }
    if (end != NULL) {
        return hand_out((size_t)(end - p.bytes), out);
    }
    if (!p.has_ended) {
        return PROMPT_NONE;
    }
    if (p.len == 0 && !p.is_cut) {
        return PROMPT_END;
    }
    const size_t rest = p.len;
    p.len++;
    return hand_out(rest, out);
}

static void prompt_show(void)
{
    (void)fputs(p.shown, stdout);
    (void)fflush(stdout);
}

static void prompt_open(const char *text)
{
    memset(&p, 0, sizeof p);
    p.shown = report_is_terminal(stdin) ? text : "";
    prompt_show();
}

/* Ends the line that a key such as ^C was echoed to. */
static void prompt_break(void)
{
    if (*p.shown != '\0') {
        (void)fputc('\n', stdout);
        (void)fflush(stdout);
    }
}

/* Ctrl-C: the terminal has forgotten what was typed so far. */
static void prompt_forget(void)
{
    prompt_break();
    prompt_show();
}

/* Prints a line, and the prompt again below it. */
static void prompt_above(const char *text)
{
    prompt_break();
    (void)fprintf(stdout, "%s\n", text);
    prompt_show();
}

/* --- What the sensor says --- */

static void show_status(struct shell *s, uint16_t status)
{
    s->ctl->was_up &= lum_laser_is_on(status);
    if (s->knows && s->status == status) {
        return;
    }
    s->knows = true;
    s->status = status;
    s->ctl->has_status = true;
    s->ctl->status = status;
    prompt_above(report_line(status, session_is_owned(s->ctl, status)).text);
}

static void show_news(const struct shell *s)
{
    lum_news news = {.struct_size = sizeof news};
    while (lum_laser_session_next(s->ctl->laser, &news)) {
        char text[LUM_ERROR_BYTES];
        if (news.kind == LUM_NEWS_LASER_CAME_UP && s->ctl->was_up) {
            s->ctl->was_up = false;
        } else {
            prompt_above(lum_news_tell(&news, text, sizeof text));
        }
    }
}

static void note_failure(struct shell *s, enum exit_status status)
{
    if (s->first == EXIT_DONE) {
        s->first = status;
    }
    if (s->first_not_typed == EXIT_DONE && status != EXIT_BAD) {
        s->first_not_typed = status;
    }
}

/* False when the session is over. */
static bool take_event(struct shell *s, const lum_sensor_event *event)
{
    if (event->kind == LUM_SENSOR_FAILED) {
        note_failure(s, ctl_complain(EXIT_FAILED, "%s", event->error.text));
        return false;
    }
    if (event->has_status) {
        show_status(s, event->status);
    }
    return true;
}

/* --- Serving the session --- */

/* All that the sensor has to say now. False when the session is over. */
static bool serve_sensor(struct shell *s)
{
    lum_sensor_event event;
    lum_laser_session_serve(s->ctl->laser, s->ctl->sensor,
                            lum_time_monotonic_ns());
    do {
        session_receive(s->ctl, 0, &event);
        if (!take_event(s, &event)) {
            return false;
        }
    } while (event.kind != LUM_SENSOR_IDLE &&
             event.kind != LUM_SENSOR_CANCELLED);
    show_news(s);
    return true;
}

/* --- Lines typed --- */

static void help(void)
{
    (void)fputs("Commands are those of the command line, without its name:",
                stdout);
    for (size_t i = 0; ctl_command_name(i) != NULL; i++) {
        (void)printf(" %s", ctl_command_name(i));
    }
    (void)puts(
        "\n"
        "The manual's raw text works too, such as 50p or u. help COMMAND "
        "describes one. quit, or the end of the input, ends the shell.");
}

/* The manual's raw text is a separate command. */
static bool is_raw_text(const char *text)
{
    lum_command command;
    size_t len = strlen(text);
    lum_result result = LUM_OK;
    while ((result = lum_command_parse(&text, &len, &command)) == LUM_OK) {
    }
    return result == LUM_END || result == LUM_E_VALUE;
}

static enum exit_status run_words(struct shell *s, int argc, char **argv)
{
    const struct ctl_options before = s->ctl->options;
    lum_sensor_give_up(s->ctl->sensor);
    const enum exit_status status = ctl_run(s->ctl, argc, argv);
    s->ctl->options = before;
    if (s->ctl->has_status) {
        s->knows = true;
        s->status = s->ctl->status;
    }
    return status;
}

static bool is_end_word(const char *word)
{
    return strcmp(word, "quit") == 0 || strcmp(word, "exit") == 0;
}

static void run_line(struct shell *s, char *text)
{
    char program[] = "lumctl";
    char send[] = "send";
    char *argv[1 + WORDS_MAX + 1] = {program, send, text};
    char **words = argv + 1;
    int count = 2;
    enum exit_status status = EXIT_DONE;
    if (!is_raw_text(text)) {
        count = words_cut(text, words, WORDS_MAX);
    }
    if (count < 0) {
        status = ctl_complain(EXIT_BAD, "a quote is not closed, or there are "
                                        "more than 64 words");
    } else if (count == 1 && strcmp(words[0], "help") == 0) {
        help();
    } else if (count > 1 && is_end_word(words[0])) {
        status = ctl_complain(
            EXIT_BAD, "%s: '%s' is one word too many: just %s ends the shell",
            words[0], words[1], words[0]);
    } else if (count > 0) {
        words[count] = NULL;
        status = run_words(s, 1 + count, argv);
    }
    note_failure(s, status);
}

/* False when the shell is to end. */
static bool serve_input(struct shell *s)
{
    char copy[PROMPT_LINE_BYTES];
    const char *text = NULL;
    const enum prompt_event event = prompt_take(&text);
    if (event == PROMPT_END) {
        prompt_break();
        s->was_left = report_is_terminal(stdin);
        return false;
    }
    if (event == PROMPT_TOO_LONG) {
        note_failure(s, ctl_complain(EXIT_BAD,
                                     "a line of more than %u bytes "
                                     "was left out",
                                     PROMPT_LINE_BYTES - 1));
    }
    if (event == PROMPT_LINE) {
        (void)snprintf(copy, sizeof copy, "%s", text);
        words_trim(copy);
        if (is_end_word(copy)) {
            s->was_left = true;
            return false;
        }
        if (copy[0] != '\0' && *text != '#') {
            run_line(s, copy);
        }
        if (interrupt_signal() == SIGINT) {
            interrupt_forget();
            prompt_break();
        }
        prompt_show();
    }
    return true;
}

/* --- The loop and its end --- */

/* Ctrl-C clears the typed line; other signals end the shell. */
static bool serve_signal(void)
{
    if (interrupt_signal() == SIGINT) {
        interrupt_forget();
        prompt_forget();
        return true;
    }
    if (interrupt_signal() != 0) {
        prompt_break();
        return false;
    }
    return true;
}

static void loop(struct shell *s)
{
    const bool can_wait = prompt_descriptor() >= 0;
    while (serve_sensor(s)) {
        const int64_t now = lum_time_monotonic_ns();
        const lum_net_result result = lum_sensor_wait_any(
            &s->ctl->sensor, 1, prompt_descriptor(), s->ctl->cancel,
            now + (can_wait ? POLL_NS : LOOK_NS));
        /* Checked with any result: input that comes with a signal may hide the
         * signal. */
        if (result == LUM_NET_FAILED || !serve_signal() || !serve_input(s)) {
            return;
        }
    }
}

/* Heartbeats end with the shell. A laser that may be on is switched off instead
 * of waiting for the sensor's timeout, with any last status: a `laser on` may
 * be on its way. */
static enum exit_status put_laser_down(struct shell *s)
{
    lum_news end;
    char text[LUM_ERROR_BYTES];
    if (laser_switch_down(s->ctl, &end) == LUM_LASER_OFF_SEEN) {
        ctl_note(s->ctl, "the laser is off");
        return EXIT_DONE;
    }
    return ctl_complain(EXIT_FAILED, "%s",
                        lum_news_tell(&end, text, sizeof text));
}

enum exit_status command_shell(struct ctl *ctl, int count, char **words)
{
    struct shell s = {.ctl = ctl, .first = EXIT_DONE};
    (void)count;
    (void)words;
    if (ctl->in_shell) {
        return ctl_complain(EXIT_BAD, "this is the shell already");
    }
    const enum exit_status opened = ctl_open(ctl, ctl->options.owner.heartbeat);
    if (opened != EXIT_DONE) {
        return opened;
    }
    ctl->in_shell = true;
    ctl->shell_set = ctl->options.set.count;
    prompt_open("lumctl> ");
    loop(&s);
    ctl->in_shell = false;
    if (ctl->owns) {
        note_failure(&s, put_laser_down(&s));
    }
    return s.was_left ? s.first_not_typed : s.first;
}
