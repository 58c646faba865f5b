#include "find.h"

#include "../common/host.h"

#include <stdlib.h>

static enum exit_status check(const struct ctl *ctl, struct find_subnet *subnet)
{
    const struct ctl_options *options = &ctl->options;
    if (options->has_host && !ctl->in_shell) {
        return ctl_complain(EXIT_BAD,
                            "--host does not go with find, which looks for "
                            "sensors at any address; --subnet says where");
    }
    if (options->subnet == NULL) {
        return EXIT_DONE;
    }
    if (!find_parse_subnet(options->subnet, subnet)) {
        return ctl_complain(EXIT_BAD,
                            "--subnet: '%s' is not a subnet such as "
                            "10.42.0.0/24",
                            options->subnet);
    }
    if (subnet->bits < FIND_BITS_MIN) {
        return ctl_complain(EXIT_BAD,
                            "--subnet: '%s' is wider than a /%u, which is 1022 "
                            "addresses; search it part by part",
                            options->subnet, FIND_BITS_MIN);
    }
    return EXIT_DONE;
}

static enum exit_status make_plan(const struct ctl *ctl,
                                  const struct find_subnet *subnet,
                                  struct find_plan *plan)
{
    const char *name = ctl->options.interface;
    lum_error error = {""};
    *plan = (struct find_plan){.interfaces = NULL};
    if (interfaces_list(&plan->interfaces, &plan->interface_count, &error) !=
        0) {
        return ctl_complain(EXIT_FAILED, "%s", error.text);
    }
    if (name != NULL &&
        !host_lists_interface(plan->interfaces, plan->interface_count, name,
                              &error)) {
        return ctl_complain(EXIT_BAD, "--interface: %s", error.text);
    }
    find_make_plan(plan, name, subnet);
    return EXIT_DONE;
}

/* Of all that were seen; FIND_HOWS: nobody was. */
static enum find_how surest_of(const struct find_result *r)
{
    enum find_how best = FIND_HOWS;
    for (size_t i = 0; i < r->count; i++) {
        const struct find_found *f = &r->found[i];
        if (best == FIND_HOWS || f->how > best) {
            best = f->how;
        }
    }
    return best;
}

static enum exit_status conclude(const struct ctl *ctl,
                                 const struct find_plan *plan,
                                 const struct find_result *result)
{
    const enum find_how best = surest_of(result);
    if (best == FIND_SENDS || best == FIND_ANSWERS) {
        return EXIT_DONE;
    }
    if (result->is_cut_short) {
        return ctl_complain(EXIT_FAILED, "interrupted before a sensor was "
                                         "found");
    }
    if (best != FIND_HOWS) {
        return ctl_complain(EXIT_NO_ANSWER,
                            "no sensor answers at any of %u addresses; a "
                            "device that was seen may be one",
                            result->asked);
    }
    if (plan->range_count == 0 || result->asked == 0 ||
        result->unsent == result->questions) {
        return ctl_complain(EXIT_FAILED,
                            "nothing could be asked: no interface is up with "
                            "an address, or sending failed on all");
    }
    return ctl_complain(
        EXIT_NO_ANSWER,
        "no sensor answers at any of %u addresses%s. Look at its power and "
        "cable; lumctl doctor looks at this host; --subnet searches elsewhere",
        result->asked,
        ctl->options.interface != NULL || ctl->options.subnet != NULL
            ? ""
            : " (simulators of this host: --interface lo)");
}

static enum exit_status search(struct ctl *ctl, struct find_plan *plan)
{
    struct find_result *result = malloc(sizeof *result);
    if (result == NULL) {
        return ctl_complain(EXIT_FAILED, "no memory for a search");
    }
    enum exit_status status = find_ask(ctl, plan, result);
    if (status == EXIT_DONE || result->count > 0) {
        find_print(ctl, plan, result);
    }
    status = status == EXIT_DONE ? conclude(ctl, plan, result) : status;
    free(result);
    return status;
}

enum exit_status command_find(struct ctl *ctl, int count, char **words)
{
    struct find_subnet subnet = {0, 0};
    struct find_plan *plan = NULL;
    (void)count;
    (void)words;
    enum exit_status status = check(ctl, &subnet);
    if (status != EXIT_DONE) {
        return status;
    }
    plan = malloc(sizeof *plan);
    if (plan == NULL) {
        return ctl_complain(EXIT_FAILED, "no memory for a search");
    }
    status = make_plan(ctl, ctl->options.subnet != NULL ? &subnet : NULL, plan);
    status = status == EXIT_DONE ? search(ctl, plan) : status;
    free(plan->interfaces);
    free(plan);
    return status;
}
