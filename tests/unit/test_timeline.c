#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../../tools/lumsim/timeline.h"

#include "lum/laser.h"

#include <stdio.h>
#include <string.h>

/* The names of all, out of the complaint about another; those of hazards have
 * all bits but the one that a client brings about. */
static void every_hazard_is_a_fault(void **state)
{
    char names[512];
    const char *why = NULL;
    unsigned bits = 0;
    struct timeline refused = {.count = 0};
    (void)state;
    assert_false(timeline_add(&refused, "none@1", &why));
    const char *list = strstr(why, "one of ");
    assert_non_null(list);
    assert_true(strlen(list) < sizeof names);
    (void)snprintf(names, sizeof names, "%s", list + strlen("one of "));
    for (char *name = strtok(names, ", "); name != NULL;
         name = strtok(NULL, ", ")) {
        struct timeline timeline = {.count = 0};
        char text[40];
        (void)snprintf(text, sizeof text, "%s@1", name);
        assert_true(timeline_add(&timeline, text, &why));
        assert_string_equal(timeline.events[0].name, name);
        bits |= timeline.events[0].bits;
    }
    assert_int_equal(bits | LUM_LASER_HEARTBEAT_TIMEOUT, LUM_LASER_HAZARDS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_hazard_is_a_fault),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
