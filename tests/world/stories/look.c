#include "look.h"

#include <string.h>

const char *const look_names[LOOK_NAMES] = {
    "interface", "route",  "arp",       "port",   "session",
    "firewall",  "buffer", "mtu",       "answer", "data",
    "layout",    "loss",   "strangers", "clock",  "status"};

user_bench tuned_bench(void)
{
    const user_bench b = user_bench_new();
    world_net_rights_of(b.host)->receive_max = 64u << 20;
    return b;
}

user_tool *examine(const user_bench *bench)
{
    return user_run(bench->host, "lumctl doctor --json");
}

const char *look_of(const user_tool *doctor, const char *check,
                    const char *what)
{
    for (size_t i = 0; i < LOOK_NAMES; i++) {
        const char *name =
            user_value(user_out(doctor), user_format("checks.%zu.name", i));
        if (name != NULL && strcmp(name, check) == 0) {
            const char *value = user_value(
                user_out(doctor), user_format("checks.%zu.%s", i, what));
            return value == NULL || strcmp(value, "null") == 0 ? "" : value;
        }
    }
    user_fail(USER_HERE, "no check %s in %s", check, user_out(doctor));
}

void expect_fine(user_tool *doctor)
{
    user_expect_status(doctor, DONE);
    expect_value(doctor, "overall", "fine");
    for (size_t i = 0; i < LOOK_NAMES; i++) {
        user_expect_same(
            user_value(user_out(doctor), user_format("checks.%zu.name", i)),
            look_names[i]);
        expect_check(doctor, look_names[i], "fine");
    }
}
