/* lumctl shell, from a pipe and at a terminal. */
#include "help.h"
#include "made_up.h"

#include <string.h>

/* A shell that reads a text to its end. */
static user_tool *shell(const user_bench *b, const char *text)
{
    return run_fed(b->host, "lumctl shell", text);
}

STORY(words_and_raw_text, "a shell carries out words and the manual's raw text")
{
    static const char *const done[] = {"60p", "50p", "30g",
                                       "40b", "55p", "20g"};
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_expect_status(
        shell(&b, "power 60\n# a remark\n\n50p\nsend '30g 40b'\n55p 20g"),
        DONE);
    for (size_t i = 0; i < sizeof done / sizeof *done; i++) {
        user_expect_at_least(user_done(s, done[i]), 1);
    }
}

STORY(quit_ends_a_shell, "quit ends a shell, and what follows is not read")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_expect_status(shell(&b, "power 61\nquit\npower 62\n"), DONE);
    user_expect_at_least(user_done(s, "61p"), 1);
    user_expect_equal(user_done(s, "62p"), 0);
}

STORY(a_wrong_line,
      "a shell goes on after a wrong line and ends with its status")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *tool = shell(&b, "power 101\n101p\nnonsense\npower 63\n");
    user_expect_status(tool, BAD);
    user_expect_has(user_err(tool), "101");
    user_expect_at_least(user_done(s, "63p"), 1);
}

STORY(a_typo_in_a_shell,
      "a typo in a shell is answered by the shell's own help")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *tool = shell(&b, "nonsense\nqut\nOf\nstatus --zzzzzz\n"
                                "status -x\nhelp nonsense\n");
    user_expect_has(user_err(tool),
                    "'nonsense': no such command; help lists them");
    user_expect_has(user_err(tool), "did you mean quit?");
    user_expect_has(
        user_err(tool),
        "'Of' begins with the letter O, not the digit zero; did you "
        "mean 0f?");
    user_expect_has(user_err(tool), "no such option; see help");
    user_expect_lacks(user_err(tool), "lumctl --help");
}

STORY(who_leaves_after_a_typo,
      "who leaves a shell after a typo leaves with status 0")
{
    static const char *const ends[] = {"quit", "exit"};
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    for (size_t i = 0; i < 2; i++) {
        user_expect_status(
            shell(&b,
                  user_format("nonsense\npower 101\nstatus\n%s\n", ends[i])),
            DONE);
    }
    user_expect_status(shell(&b, "nonsense\n"), BAD);
    /* Nobody sends heartbeats. */
    user_expect_status(
        shell(&b, "nonsense\napply /nonexistent.yaml\nlaser on\nquit\n"),
        FAILED);
}

STORY(help_in_a_shell, "help of one command is that of the command line")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *tool = shell(&b, "help power\nhelp\n");
    user_expect_status(tool, DONE);
    user_tool *help = user_run(b.host, "lumctl help power");
    user_expect_status(help, DONE);
    user_expect(strlen(user_out(help)) > 100);
    user_expect_has(user_out(tool), user_out(help));
    user_expect_has(user_out(tool), "Commands are those of the command line");
}

STORY(words_behind_quit, "words behind quit are told, and it is none")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *tool = shell(&b, "exit 3\nquit now\npower 66\n");
    user_expect_status(tool, BAD);
    user_expect_has(user_err(tool), "exit: '3' is one word too many");
    user_expect_has(user_err(tool), "quit: 'now' is one word too many");
    user_expect_at_least(user_done(s, "66p"), 1);
}

STORY(options_of_a_line, "options of a line hold for that line alone")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_expect_status(shell(&b, "power 64 --dry-run\npower 65\n"), DONE);
    user_expect_at_least(user_done(s, "65p"), 1);
    user_expect_equal(user_done(s, "64p"), 0);
}

STORY(a_shell_with_heartbeat,
      "a shell with --heartbeat owns the sensor and leaves the laser off")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_expect_status(
        run_fed(b.host, "lumctl shell --heartbeat", "laser on\n"), DONE);
    user_expect_at_least(user_laser_rises(s), 1);
    user_expect(!user_laser_is_on(s));
}

STORY(a_hazard_in_a_shell_with_heartbeat,
      "a laser that a hazard ends in a shell stays down until it is typed")
{
    const user_bench b = user_bench_new();
    user_sensor *s =
        user_sensor_start(b.sensor, "--rate 2 --fault interlock@5-8");
    world_file *end = NULL;
    world_writer *input = world_writer_new(&end);
    user_tool *tool = user_start_with(b.host, (user_with){.input = end},
                                      "lumctl shell --heartbeat");
    user_type(tool, input, "laser on\n");
    user_until(user_laser_is_on(s));
    user_until(user_has(user_out(tool), "went off (HW_SAFETY_BAD"));
    user_until(user_heard(s, "d") > 0);
    user_until(user_events(s, "fault") == 2);
    const size_t beats = user_events(s, "heartbeat");
    user_until(user_events(s, "heartbeat") > beats + 15);
    user_expect(!user_laser_is_on(s));
    user_type(tool, input, "laser on\n");
    user_until(user_laser_is_on(s));
    world_writer_close(input);
    user_expect_status(tool, DONE);
    user_expect(!user_laser_is_on(s));
}

static void end_laser_by_hazard(const char *typed)
{
    const user_bench b = user_bench_new();
    const user_sensor *s =
        user_sensor_start(b.sensor, "--rate 2 --fault interlock@5-8");
    user_expect_status(run_fed(b.host, "lumctl shell --heartbeat", typed),
                       DONE);
    user_expect_equal(user_events(s, "fault"), 2);
    user_expect_equal(user_laser_rises(s), 1);
}

STORY(a_hazard_during_status_watch,
      "a laser that a hazard ends in a shell stays down during status --watch")
{
    end_laser_by_hazard("laser on\nstatus --watch --duration 12\n");
}

STORY(a_hazard_during_time_watch, "the same during time --watch")
{
    end_laser_by_hazard("laser on\ntime --watch --duration 12\n");
}

STORY(heartbeats_of_a_command,
      "heartbeat in a shell counts from its own begin, not the shell's")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *tool = run_fed(b.host, "lumctl shell --heartbeat",
                              "status --watch --duration 20\n"
                              "heartbeat --duration 2 --json\n"
                              "heartbeat --duration 2\n");
    user_expect_status(tool, DONE);
    const char *told = strstr(user_out(tool), "{\"sensor\"");
    user_expect(told != NULL && user_number(told, "heartbeats") <= 12);
    user_expect_like(user_err(tool), "1[0-2] heartbeats in 2.0 s");
}

STORY(a_shell_without_heartbeat, "a shell without --heartbeat sends none")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_expect_status(shell(&b, "status\n"), DONE);
    user_expect_equal(user_events(s, "heartbeat"), 0);
}

STORY(a_shell_behind_set_ip, "after set-ip, a shell names the new address")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *tool = shell(&b, "set-ip 10.42.0.99\nstatus --json\n");
    user_expect_status(tool, DONE);
    user_expect_has(user_out(tool), "\"sensor\": \"10.42.0.99\"");
}

STORY(a_hazard_behind_set_ip,
      "after set-ip, a laser that a hazard ends in a shell stays down, too")
{
    const user_bench b = user_bench_new();
    const user_sensor *s =
        user_sensor_start(b.sensor, "--rate 2 --fault interlock@8-11");
    world_file *end = NULL;
    world_writer *input = world_writer_new(&end);
    user_tool *tool = user_start_with(b.host, (user_with){.input = end},
                                      "lumctl shell --heartbeat");
    user_type(tool, input, "laser on\n");
    user_until(user_laser_is_on(s));
    user_type(tool, input, "set-ip 10.42.0.99\n");
    user_until(user_events(s, "fault") == 2);
    const size_t beats = user_events(s, "heartbeat");
    user_until(user_events(s, "heartbeat") > beats + 15);
    user_expect_equal(user_laser_rises(s), 1);
    user_expect_lacks(user_out(tool), "another program switched");
    world_writer_close(input);
    user_expect_status(tool, DONE);
}

STORY(a_shell_waits_for_no_resolver,
      "a shell that keeps a sensor alive waits for no resolver")
{
    const user_bench b = user_bench_new();
    world_net_name_server(20 * WORLD_S, false);
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *tool =
        run_fed(b.host, "lumctl shell --heartbeat",
                "laser on\nset-ip some.name\nset-ip --dry-run some.name\n"
                "status --host some.name\nstatus --host 10.42.0.37\n"
                "status --host some.name:5517\n");
    user_expect_status(tool, BAD);
    user_expect_equal(
        user_count(user_err(tool),
                   "no name is looked up while this shell sends heartbeats"),
        4);
    user_expect_has(user_err(tool), "hold for a whole shell");
    user_expect_equal(user_events(s, "set_ip"), 0);
    user_expect_equal(user_laser_rises(s), 1);
    user_expect_status(shell(&b, "set-ip --dry-run --force localhost\n"), DONE);
}

STORY(
    the_end_of_a_shell_twice_signalled,
    "its own session without heartbeats is a hazard, and its end switches off "
    "though it is signalled twice")
{
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, "10.42.0.37", NULL);
    m->status = MADE_UP_TIMEOUT | MADE_UP_OFF;
    m->delay_ns = 300 * WORLD_MS;
    world_file *end = NULL;
    world_writer *input = world_writer_new(&end);
    user_tool *tool =
        user_start_with(b.host, (user_with){.input = end},
                        "lumctl shell --heartbeat --timeout 2000");
    user_type(tool, input, "status\n");
    user_until(user_has(user_out(tool), "HAZARD"));
    user_signal(tool, SIGTERM);
    user_until(made_up_tries(m, "d") > 0);
    user_pause_between_ms(0, 250);
    user_signal(tool, SIGTERM);
    user_expect(user_wait(tool) != 0);
    user_expect_has(user_err(tool), "the laser is off");
}

STORY(an_endless_line, "an endless line and binary input do no harm")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    world_file *end = NULL;
    world_writer *input = world_writer_new(&end);
    user_tool *tool =
        user_start_with(b.host, (user_with){.input = end}, "lumctl shell");
    char line[1000];
    memset(line, 'x', sizeof line);
    for (unsigned i = 0; i < 100; i++) {
        world_writer_put(input, line, sizeof line);
    }
    world_writer_put(input, "\n\0\1\377\nstatus\n", 12);
    world_writer_close(input);
    user_expect_status(tool, BAD);
    user_expect_has(user_err(tool), "2047");
    user_expect_has(user_out(tool), "laser down");
}

/* --- At a terminal --- */

static user_tool *at_a_terminal(const user_bench *b, world_terminal *terminal,
                                const char *command)
{
    user_tool *tool = user_start_with(
        b->host, (user_with){.terminal = terminal}, "%s", command);
    user_until(user_has(user_shown(terminal), "lumctl>"));
    return tool;
}

/* What was shown since a moment, which strlen(user_shown()) tells. */
#define since(TERMINAL, FROM) (user_shown(TERMINAL) + (FROM))

STORY(a_prompt_again, "a command shows its outcome, and a prompt again")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    world_terminal *t = world_terminal_new("xterm");
    user_tool *tool = at_a_terminal(&b, t, "lumctl shell");
    const size_t from = strlen(user_shown(t));
    world_terminal_type(t, "power 50\n");
    user_until(user_has(since(t, from), "done"));
    user_until(user_has(since(t, from), "lumctl>"));
    user_expect_at_least(user_done(s, "50p"), 1);
    world_terminal_type(t, "quit\n");
    user_expect_status(tool, DONE);
}

STORY(a_status_above_the_prompt,
      "a status that changes appears while the prompt waits")
{
    const user_bench b = user_bench_new();
    const user_sensor *s =
        user_sensor_start(b.sensor, "--rate 2 --fault fan@USR1");
    world_terminal *t = world_terminal_new("xterm");
    user_tool *tool = at_a_terminal(&b, t, "lumctl shell");
    user_signal(s->tool, SIGUSR1);
    user_until(user_has(user_shown(t), "FAN_PWM_BAD"));
    world_terminal_type(t, "\4");
    user_expect_status(tool, DONE);
}

STORY(ctrl_c_takes_back_the_line,
      "Ctrl-C takes back the line and not the shell")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    world_terminal *t = world_terminal_new("xterm");
    user_tool *tool = at_a_terminal(&b, t, "lumctl shell");
    world_terminal_type(t, "power 5");
    const size_t from = strlen(user_shown(t));
    world_terminal_type(t, "\3");
    user_until(user_has(since(t, from), "lumctl>"));
    world_terminal_type(t, "6p\n");
    user_until(user_done(s, "6p") == 1);
    user_expect(!user_ended(tool));
    world_terminal_type(t, "exit\n");
    user_expect_status(tool, DONE);
    user_expect_equal(user_done(s, "56p"), 0);
}

STORY(ctrl_c_ends_a_command, "Ctrl-C ends a command and not the shell")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    world_terminal *t = world_terminal_new("xterm");
    user_tool *tool = at_a_terminal(&b, t, "lumctl shell");
    world_terminal_type(t, "status --watch\n");
    user_until(user_has(user_shown(t), "laser down"));
    const size_t from = strlen(user_shown(t));
    world_terminal_type(t, "\3");
    user_until(user_has(since(t, from), "lumctl>"));
    world_terminal_type(t, "exit\n");
    user_expect_status(tool, DONE);
}

STORY(sigterm_ends_a_shell, "SIGTERM ends a shell, and its laser")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    world_terminal *t = world_terminal_new("xterm");
    user_tool *tool = at_a_terminal(&b, t, "lumctl shell --heartbeat");
    user_type_at(tool, t, "laser on\n");
    user_until(user_laser_is_on(s));
    user_pause_between_ms(0, 1000);
    user_signal(tool, SIGTERM);
    (void)user_wait(tool);
    user_expect(!user_laser_is_on(s));
}
