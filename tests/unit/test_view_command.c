#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lumview/page_command.h"

#include <stdlib.h>
#include <string.h>

static bool parse(const char *text, struct command *out)
{
    const size_t len = strlen(text);
    char *exact = malloc(len > 0 ? len : 1u);
    assert_non_null(exact);
    (void)memcpy(exact, text, len);
    const bool good = command_parse(exact, len, out);
    free(exact);
    return good;
}

static void every_command_is_understood(void **state)
{
    struct command c;
    (void)state;
    assert_true(parse("play", &c) && c.kind == COMMAND_PLAY);
    assert_true(parse("pause", &c) && c.kind == COMMAND_PAUSE);
    assert_true(parse("step -12", &c) && c.kind == COMMAND_STEP);
    assert_true(c.number == -12);
    assert_true(parse("seek 9007199254740992", &c) && c.kind == COMMAND_SEEK);
    assert_true(c.number == INT64_C(9007199254740992));
    assert_true(parse("speed 0.25", &c) && c.kind == COMMAND_SPEED);
    assert_true(c.speed >= 0.25 && c.speed <= 0.25);
    assert_true(parse("loop on", &c) && c.kind == COMMAND_LOOP && c.loops);
    assert_true(parse("loop off", &c) && !c.loops);
    assert_true(parse("frames 50", &c) && c.kind == COMMAND_FRAMES);
    assert_true(c.number == 50);
    assert_true(parse("past 30 562949953421311", &c) && c.kind == COMMAND_PAST);
    assert_true(c.number == 30 && c.past == (UINT64_C(1) << 49) - 1u);
}

static void views_have_edges_and_an_odd_window(void **state)
{
    struct command c;
    (void)state;
    assert_true(parse("view rising 0", &c) && c.kind == COMMAND_VIEW);
    assert_true(c.view.edges == LUM_EDGES_RISING && c.view.smooth == 0);
    assert_true(parse("view falling 1", &c));
    assert_true(c.view.edges == LUM_EDGES_FALLING && c.view.smooth == 1);
    assert_true(parse("view both 63", &c));
    assert_true(c.view.edges == LUM_EDGES_BOTH && c.view.smooth == 63);
}

static void all_else_is_refused(void **state)
{
    static const char *const wrong[] = {
        "",
        " ",
        "Play",
        "play ",
        "play x",
        " play",
        "play\n",
        "pause 1",
        "step",
        "step ",
        "step 1.5",
        "step 1 2",
        "step 0x1",
        "step 1000001",
        "seek",
        "seek x",
        "seek 9007199254740993",
        "seek -9007199254740993",
        "seek 99999999999999999999999",
        "speed",
        "speed nan",
        "speed inf",
        "speed 0",
        "speed 0.009",
        "speed 100.1",
        "speed -1",
        "loop",
        "loop maybe",
        "frames",
        "frames 0",
        "frames 51",
        "frames 2.5",
        "past",
        "past 30",
        "past 30 ",
        "past 30 -1",
        "past x 1",
        "past 30 9007199254740993",
        "loop on off",
        "view",
        "view rising",
        "view rising ",
        "view rising 2",
        "view rising 65",
        "view rising -1",
        "view up 0",
        "view  0",
        "view both 0 0",
        "laser on",
        "status",
    };
    struct command c;
    (void)state;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        assert_false(parse(wrong[i], &c));
    }
    assert_false(command_parse("play\0x", 6, &c));
    assert_false(command_parse("play\0", 5, &c));
}

static void what_is_too_long_is_not_read(void **state)
{
    char text[COMMAND_BYTES + 1u];
    struct command c;
    (void)state;
    (void)memset(text, '0', sizeof text);
    (void)memcpy(text, "step ", 5);
    text[COMMAND_BYTES - 1u] = '7';
    assert_true(command_parse(text, COMMAND_BYTES, &c) && c.number == 7);
    assert_false(command_parse(text, COMMAND_BYTES + 1u, &c));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_command_is_understood),
        cmocka_unit_test(views_have_edges_and_an_odd_window),
        cmocka_unit_test(all_else_is_refused),
        cmocka_unit_test(what_is_too_long_is_not_read),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
