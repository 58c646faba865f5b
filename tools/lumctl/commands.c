/* The table of commands, and how a command line is run. */
#include "ctl.h"

#include "../common/host.h"
#include "../common/input_files.h"
#include "../common/nearest.h"
#include "config_files.h"
#include "ctl_session.h"
#include "help.h"
#include "options.h"
#include "remember.h"
#include "text_command.h"
#include "yscan/yscan_shape.h"

#include "base/text.h"
#include "lum/version.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

struct command {
    const char *name;
    const char *arguments; /* as --help shows them; NULL: none */
    const char *summary;
    unsigned own;         /* own_options it has */
    const char *lacks[2]; /* options of every command that it refuses */
    ctl_command run;
};

/* What looks on asks at its own pace, and writes what it sees. */
#define OWN_WATCHER (OWN_EVERY | OWN_UNTIL | OWN_CSV | OWN_PROMETHEUS)

static const struct command table[] = {
    {.name = "status",
     .summary = "the laser's status, hazards first",
     .own = OWN_WATCH | OWN_DURATION | OWN_WATCHER,
     .run = command_status},
    {.name = "wait",
     .arguments = "[answers|up|down|clear]",
     .summary = "wait for an answer, a laser state, or no hazard",
     .own = OWN_FOR,
     .lacks = {"dry-run", "json"},
     .run = command_wait},
    {.name = "time",
     .summary = "the sensor's clock: reading, offset, drift",
     .own = OWN_WATCH | OWN_DURATION,
     .run = command_time},
    {.name = "set-ip",
     .arguments = "ADDRESS",
     .summary = "give it another address, and check it",
     .own = OWN_FORCE,
     .run = command_set_ip},
    {.name = "laser",
     .arguments = "on|off",
     .summary = "switch the laser, and check the result",
     .run = command_laser},
    {.name = "power",
     .arguments = "N",
     .summary = "laser power, 0 to 100 percent",
     .run = command_parameter},
    {.name = "threshold",
     .arguments = "green|blue N",
     .summary = "detection threshold, 0 to 100 percent",
     .run = command_parameter},
    {.name = "lines",
     .arguments = "640|64",
     .summary = "lines of a frame",
     .run = command_parameter},
    {.name = "yscan",
     .arguments = "FOV|--shape SHAPE",
     .summary = "spread the lines over elevations",
     .own = OWN_SHAPE | OWN_LINES | OWN_CALIBRATION,
     .run = command_yscan},
    {.name = "holdoff",
     .arguments = "N",
     .summary = "holdoff delay, 150 to 250 in steps of 10",
     .run = command_parameter},
    {.name = "offset",
     .arguments = "green|blue N",
     .summary = "offset of galvo and ADC, 0 to 30",
     .run = command_parameter},
    {.name = "send",
     .arguments = "TEXT",
     .summary = "the manual's raw text: '50p 15y u'",
     .run = command_send},
    {.name = "tlv",
     .arguments = "TYPE:HEX...",
     .summary = "any TLVs in one packet",
     .run = command_tlv},
    {.name = "apply",
     .arguments = "FILE",
     .summary = "settings from a YAML file",
     .own = OWN_CALIBRATION,
     .run = command_apply},
    {.name = "sweep",
     .arguments = "PLAN",
     .summary = "steps of settings, each with a recording",
     .own = OWN_OUTPUT | OWN_LASER | OWN_CONTINUE | OWN_RATE | OWN_CALIBRATION,
     .lacks = {"json"},
     .run = command_sweep},
    {.name = "find",
     .summary = "sensors whose address was forgotten",
     .own = OWN_SUBNET,
     .lacks = {"dry-run", "host"},
     .run = command_find},
    {.name = "show",
     .summary = "the settings, as far as this host knows",
     .lacks = {"dry-run"},
     .run = command_show},
    {.name = "save",
     .summary = "these settings as YAML for apply",
     .lacks = {"dry-run", "json"},
     .run = command_save},
    {.name = "heartbeat",
     .summary = "own the session: keep laser and data on",
     .own = OWN_RATE | OWN_DURATION | OWN_LASER | OWN_WATCHER,
     .run = command_heartbeat},
    {.name = "doctor",
     .summary = "find what is wrong, and how to fix it",
     .lacks = {"dry-run"},
     .run = command_doctor},
    {.name = "shell",
     .summary = "a prompt that takes all of these",
     .own = OWN_HEARTBEAT | OWN_CALIBRATION,
     .lacks = {"dry-run"},
     .run = command_shell},
};

#define COMMANDS (sizeof table / sizeof table[0])

/* --- The table of commands --- */

const char *ctl_command_name(size_t i)
{
    return i < COMMANDS ? table[i].name : NULL;
}

static const struct command *find(const char *name)
{
    for (size_t i = 0; i < COMMANDS; i++) {
        if (strcmp(table[i].name, name) == 0) {
            return &table[i];
        }
    }
    return NULL;
}

/* --- Help and version --- */

/* A reader that has left is no failure. */
static enum exit_status finish_output(void)
{
    errno = 0;
    if (fflush(stdout) == 0 && ferror(stdout) == 0) {
        return EXIT_DONE;
    }
    return errno == EPIPE ? EXIT_DONE
                          : ctl_complain(EXIT_FAILED, "standard output: %s",
                                         errno != 0 ? strerror(errno)
                                                    : "it cannot be written");
}

static enum exit_status help_all(void)
{
    (void)fputs(help_begin, stdout);
    for (size_t i = 0; i < COMMANDS; i++) {
        help_row(table[i].name, table[i].arguments, table[i].summary);
    }
    (void)puts("\nOptions, before or after the command:");
    options_help(true, 0, NULL);
    (void)puts("\nOptions of single commands:");
    options_help(false, ~0u, NULL);
    (void)fputs(help_end, stdout);
    return finish_output();
}

static enum exit_status help_one(const struct command *command)
{
    help_command(command->name, command->arguments, command->summary);
    options_help(true, command->own, command->lacks);
    return finish_output();
}

static enum exit_status version(void)
{
    (void)puts("lumctl " LUM_VERSION);
    return finish_output();
}

/* --- Refusals --- */

/* The manual prints "Of", where 0f is meant; a shell takes that as a command.
 */
static bool is_meant_as_text(const struct ctl *ctl, const char *name)
{
    char meant[16];
    const char *what = "";
    if (!ctl->in_shell ||
        !text_find_digits(name, strlen(name), meant, sizeof meant, &what)) {
        return false;
    }
    (void)ctl_complain(EXIT_BAD, "'%s' %s; did you mean %s?", name, what,
                       meant);
    return true;
}

static enum exit_status complain_unknown(const struct ctl *ctl,
                                         const char *name)
{
    static const char *const of_shell[] = {"help", "quit", "exit"};
    const char *names[COMMANDS + 3];
    size_t count = COMMANDS;
    if (is_meant_as_text(ctl, name)) {
        return EXIT_BAD;
    }
    for (size_t i = 0; i < COMMANDS; i++) {
        names[i] = table[i].name;
    }
    for (size_t i = 0; i < (ctl->in_shell ? 3u : 1u); i++) {
        names[count++] = of_shell[i];
    }
    const char *near = nearest(name, names, count);
    if (near != NULL) {
        return ctl_complain(EXIT_BAD, "'%s': no such command; did you mean %s?",
                            name, near);
    }
    return ctl_complain(EXIT_BAD, "'%s': no such command; %s lists them", name,
                        ctl->in_shell ? "help" : "lumctl --help");
}

#define NAMES_BYTES 128u

/* The commands that have an option. */
static const char *list_owners(unsigned own, char names[NAMES_BYTES])
{
    names[0] = '\0';
    for (size_t i = 0; i < COMMANDS; i++) {
        if ((table[i].own & own) != 0) {
            lum_text_list(names, NAMES_BYTES, ", ", table[i].name);
        }
    }
    return names;
}

/* An option that belongs to other commands. */
static enum exit_status check_own(const struct command *command, unsigned given)
{
    const unsigned wrong =
        given & ~(command->own | (unsigned)(OWN_SESSION | OWN_PROFILE));
    char names[NAMES_BYTES];
    if (wrong == 0) {
        return EXIT_DONE;
    }
    const unsigned first = wrong & (~wrong + 1u);
    return ctl_complain(EXIT_BAD, "--%s does not go with %s; it goes with %s",
                        options_name(first), command->name,
                        list_owners(first, names));
}

/* Words and a dry run where there can be none. */
static enum exit_status check_line(const struct ctl *ctl,
                                   const struct command *command, int count,
                                   char **words)
{
    if (command->arguments == NULL && count > 1) {
        return ctl_complain(EXIT_BAD, "%s: '%s': no word is expected after %s",
                            command->name, words[1], command->name);
    }
    return ctl->options.dry_run && command->lacks[0] != NULL &&
                   strcmp(command->lacks[0], "dry-run") == 0
               ? ctl_complain(EXIT_BAD,
                              "--dry-run prints the packet of a command; it "
                              "does not go with %s",
                              command->name)
               : EXIT_DONE;
}

static enum exit_status check_typed(const struct ctl_options *o)
{
    if (o->owner.laser) {
        return ctl_complain(EXIT_BAD, "--laser: a shell has 'laser on' and "
                                      "'laser off' for that");
    }
    if (o->repeat.csv != NULL || o->repeat.prometheus != NULL) {
        return ctl_complain(EXIT_BAD,
                            "--%s: a shell writes no files, so that it never "
                            "waits for a disk; run lumctl status beside it",
                            o->repeat.csv != NULL ? "csv" : "prometheus");
    }
    return EXIT_DONE;
}

static enum exit_status check_files(const struct repeat_options *o)
{
    if (o->every_s <= 0.0 && (o->csv != NULL || o->prometheus != NULL)) {
        return ctl_complain(EXIT_BAD, "--%s goes with --every S",
                            o->csv != NULL ? "csv" : "prometheus");
    }
    if (o->csv != NULL && o->prometheus != NULL &&
        (strcmp(o->csv, o->prometheus) == 0 ||
         input_files_is_same(o->csv, o->prometheus))) {
        return ctl_complain(EXIT_BAD, "--csv and --prometheus name one file");
    }
    return EXIT_DONE;
}

/* Options that need another beside them, or do not go together. */
static enum exit_status check_company(const struct ctl *ctl,
                                      const struct command *command)
{
    const struct repeat_options *o = &ctl->options.repeat;
    const bool needs_watch = (command->own & OWN_WATCH) != 0;
    const bool goes_on = o->watch || o->every_s > 0.0;
    if (o->watch && o->every_s > 0.0) {
        return ctl_complain(EXIT_BAD,
                            "--watch writes a line for each change, --every "
                            "one each time: give one of them");
    }
    if (needs_watch && o->duration_s > 0.0 && !goes_on) {
        return ctl_complain(
            EXIT_BAD,
            "--duration goes with --watch: lumctl %s --watch --duration %.6g",
            command->name, o->duration_s);
    }
    if (needs_watch && o->until != UNTIL_NOTHING && !goes_on) {
        return ctl_complain(EXIT_BAD, "--until goes with --watch or --every S");
    }
    return EXIT_DONE;
}

/* --- Running a command --- */

/* Rules for single commands. */
static void forget_own(struct ctl_options *options)
{
    options->repeat = (struct repeat_options){.watch = false};
    options->owner = (struct owner_options){.heartbeat = false};
    options->sweep = (struct sweep_options){.output = NULL};
    options->yscan = (struct yscan_options){.shape = NULL};
    options->force = false;
    options->subnet = NULL;
    options->wants_help = false;
    options->wants_version = false;
}

static enum exit_status load_layout(struct ctl *ctl)
{
    lum_error error = {""};
    if (ctl->in_shell) {
        return EXIT_DONE;
    }
    if (files_load_layout(ctl->options.profile, &ctl->options.set, &ctl->layout,
                          &error) != 0) {
        return ctl_complain(EXIT_BAD, "%s", error.text);
    }
    return EXIT_DONE;
}

/* A shell has one layout, even of dry runs. */
static enum exit_status check_shell(const struct ctl *ctl, unsigned given)
{
    const unsigned fixed =
        ctl->options.dry_run ? OWN_PROFILE : OWN_PROFILE | OWN_SESSION;
    if (!ctl->in_shell || (given & fixed) == 0) {
        return EXIT_DONE;
    }
    return ctl_complain(EXIT_BAD,
                        "--host, --port, --interface, --timeout, --retries and "
                        "--profile hold for a whole shell: leave it, and give "
                        "them to lumctl shell");
}

/* Keys as the files that they lie on top of. What a shell was given is for
 * those of its commands that use it. */
static enum exit_status check_set(const struct ctl *ctl,
                                  const struct command *command)
{
    const struct set_keys *set = &ctl->options.set;
    char names[NAMES_BYTES];
    for (size_t i = ctl->in_shell ? ctl->shell_set : 0; i < set->count; i++) {
        const struct set_key *key = &set->list[i];
        if (key->is_of_profile && ctl->in_shell) {
            return ctl_complain(EXIT_BAD,
                                "--set %.120s: a key of a profile holds for a "
                                "whole shell: leave it, and give it to lumctl "
                                "shell",
                                key->text);
        }
        if (!key->is_of_profile && (command->own & OWN_CALIBRATION) == 0) {
            return ctl_complain(EXIT_BAD,
                                "--set %.120s: a key of a calibration does not "
                                "go with %s; it goes with %s",
                                key->text, command->name,
                                list_owners(OWN_CALIBRATION, names));
        }
    }
    return EXIT_DONE;
}

/* To the doctor it is a finding. */
static enum exit_status check_interface(const struct ctl *ctl,
                                        const struct command *command)
{
    lum_error why = {""};
    if (ctl->in_shell || ctl->options.dry_run ||
        command->run == command_doctor || ctl->options.interface == NULL ||
        host_has_interface(ctl->options.interface, &why)) {
        return EXIT_DONE;
    }
    return ctl_complain(EXIT_BAD, "--interface: %s", why.text);
}

/* What a command reads besides profile and calibration. Typed in a shell, it is
 * the command itself that refuses standard input. */
static struct input_file find_input(const struct ctl *ctl,
                                    const struct command *command,
                                    const struct options_found *found,
                                    char **words)
{
    const char *shape = ctl->options.yscan.shape;
    if (ctl->in_shell || command->run == command_shell) {
        return (struct input_file){"-", "the shell"};
    }
    if ((command->run == command_apply || command->run == command_sweep) &&
        found->count > 1) {
        return (struct input_file){words[1], command->name};
    }
    return (struct input_file){shape != NULL ? yscan_csv_name(shape) : NULL,
                               "--shape"};
}

/* A shell has its profile already. */
static enum exit_status check_stdin(const struct ctl *ctl,
                                    const struct command *command,
                                    const struct options_found *found,
                                    char **words)
{
    const struct ctl_options *o = &ctl->options;
    const struct input_file inputs[] = {
        {o->calibration, "--calibration"},
        {ctl->in_shell ? NULL : o->profile, "--profile"},
        find_input(ctl, command, found, words)};
    lum_error why = {""};
    return input_files_check_once(inputs, sizeof inputs / sizeof inputs[0],
                                  &why) == 0
               ? EXIT_DONE
               : ctl_complain(EXIT_BAD, "%s", why.text);
}

static enum exit_status run(struct ctl *ctl, const struct command *command,
                            const struct options_found *found, char **words)
{
    const bool owned = ctl->owns;
    enum exit_status status = check_own(command, found->own);
    status = status == EXIT_DONE ? check_line(ctl, command, found->count, words)
                                 : status;
    if (status == EXIT_DONE && ctl->in_shell) {
        status = check_typed(&ctl->options);
    }
    status = status == EXIT_DONE ? check_files(&ctl->options.repeat) : status;
    status = status == EXIT_DONE ? check_company(ctl, command) : status;
    status = status == EXIT_DONE ? check_shell(ctl, found->own) : status;
    status = status == EXIT_DONE ? check_set(ctl, command) : status;
    status = status == EXIT_DONE ? check_interface(ctl, command) : status;
    status =
        status == EXIT_DONE ? check_stdin(ctl, command, found, words) : status;
    status = status == EXIT_DONE ? load_layout(ctl) : status;
    if (status == EXIT_DONE) {
        status = command->run(ctl, found->count, words);
        ctl_end_packets(ctl);
    }
    if (ctl->in_shell && ctl->owns && !owned) {
        (void)session_change(ctl, session_host(ctl), false);
    }
    const enum exit_status written = finish_output();
    remember_changes(ctl);
    return status == EXIT_DONE ? written : status;
}

static enum exit_status help_word(const struct ctl *ctl, int count,
                                  char **words)
{
    const struct command *command = count > 1 ? find(words[1]) : NULL;
    if (count > 2) {
        return ctl_complain(
            EXIT_BAD, "help: '%s' is one word too many: one command", words[2]);
    }
    if (count > 1 && command == NULL) {
        return complain_unknown(ctl, words[1]);
    }
    return command != NULL ? help_one(command) : help_all();
}

static enum exit_status choose(struct ctl *ctl,
                               const struct options_found *found, char **words)
{
    const struct command *command = found->count > 0 ? find(words[0]) : NULL;
    if (ctl->options.wants_version) {
        return version();
    }
    if (found->count > 0 && strcmp(words[0], "help") == 0) {
        return help_word(ctl, found->count, words);
    }
    if (found->count > 0 && command == NULL) {
        return complain_unknown(ctl, words[0]);
    }
    if (ctl->options.wants_help) {
        return command != NULL ? help_one(command) : help_all();
    }
    if (command == NULL) {
        return ctl_complain(EXIT_BAD, "no command; %s lists them",
                            ctl->in_shell ? "help" : "lumctl --help");
    }
    return run(ctl, command, found, words);
}

enum exit_status ctl_run(struct ctl *ctl, int argc, char **argv)
{
    const struct ctl_options before = ctl->options;
    struct options_found found;
    forget_own(&ctl->options);
    ctl->options.no_names = ctl->owns;
    enum exit_status status =
        options_parse(&ctl->options, ctl->in_shell ? "help" : "lumctl --help",
                      argc, argv, &found);
    if (status == EXIT_DONE) {
        status = choose(ctl, &found, argv + 1);
    }
    ctl->options = before;
    return status;
}
