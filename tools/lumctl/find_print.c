/* What find has found, for people and as JSON. */
#include "find.h"

#include "../common/number.h"
#include "beside.h"
#include "ctl_session.h"
#include "status_report.h"

#include <stdio.h>
#include <stdlib.h>

static const struct {
    const char *word;
    const char *meaning;
} hows[FIND_HOWS] = {
    [FIND_ARP] = {"arp", "a device has this address, perhaps a sensor"},
    [FIND_OTHER] = {"other",
                    "sends the magic, but no packet that a sensor sends"},
    [FIND_SENDS] = {"sends", "sends packets of a sensor"},
    [FIND_ANSWERS] = {"answers", "answers"},
};

/* By address, then the surest first. */
static int compare(const void *a, const void *b)
{
    const struct find_found *x = a;
    const struct find_found *y = b;
    if (x->host.address != y->host.address) {
        return x->host.address < y->host.address ? -1 : 1;
    }
    return (x->how < y->how) - (x->how > y->how);
}

static const char *name_of(const struct host_interface *interface)
{
    return interface != NULL ? interface->name : "";
}

static void put_found(struct json *json, const struct find_plan *plan,
                      struct find_result *r, const struct find_found *f)
{
    const struct find_reach reach = find_reach(plan, r, f);
    const bool has_other = f->other_mac[0] != '\0';
    json_open_object(json, NULL);
    json_text(json, "sensor", session_name(f->host).text);
    json_text(json, "interface", name_of(f->interface));
    json_text(json, "how", hows[f->how].word);
    if (f->how == FIND_ANSWERS) {
        json_uint(json, "clock_us", f->clock_us);
    } else {
        json_null(json, "clock_us");
    }
    report_json_trip(json, f->round_trip_ns);
    json_text(json, "mac", f->mac[0] != '\0' ? f->mac : NULL);
    json_bool(json, "several_macs", has_other);
    json_text(json, "other_mac", has_other ? f->other_mac : NULL);
    json_text(json, "reach", *reach.text != '\0' ? reach.text : NULL);
    json_close_object(json);
}

static void put_range(struct json *json, const struct find_range *range)
{
    json_open_object(json, NULL);
    json_text(json, "interface", name_of(range->interface));
    json_text(json, "subnet", find_show_subnet(&range->subnet).text);
    json_text(json, "by", range->by_arp ? "arp" : "udp");
    json_close_object(json);
}

static void print_json(const struct find_plan *plan, struct find_result *r)
{
    struct json json;
    json_begin_line(&json, stdout);
    json_open_array(&json, "sensors");
    for (size_t i = 0; i < r->count; i++) {
        put_found(&json, plan, r, &r->found[i]);
    }
    json_close_array(&json);
    json_open_array(&json, "searched");
    for (size_t i = 0; i < plan->range_count; i++) {
        if (plan->ranges[i].is_askable) {
            put_range(&json, &plan->ranges[i]);
        }
    }
    json_close_array(&json);
    json_open_array(&json, "left_out");
    for (size_t i = 0; i < plan->left_out.count; i++) {
        json_text(&json, NULL, plan->left_out.texts[i]);
    }
    json_close_array(&json);
    json_uint(&json, "left_out_more", plan->left_out.more);
    json_uint(&json, "asked", r->asked);
    json_uint(&json, "not_sent", r->unsent);
    json_bool(&json, "complete", !r->is_cut_short && !r->is_full);
    json_end_line(&json);
}

static void print_reach(const struct find_plan *plan, struct find_result *r,
                        const struct find_found *f)
{
    const struct find_reach reach = find_reach(plan, r, f);
    if (*reach.text != '\0') {
        (void)printf("    not reached from this host; as root: %s\n",
                     reach.text);
    } else if (find_needs_address(plan, f)) {
        (void)printf("    not reached from this host: give %s an address in "
                     "%s/24 that no device has\n",
                     f->interface->name,
                     number_address(f->host.address & BESIDE_MASK).text);
    }
}

/* Packets reach one of the two, and never the other. */
static void print_other(const struct find_found *f)
{
    if (f->is_mac_of_sensor) {
        (void)printf("    two devices have this address: this sensor, and %s, "
                     "which may be a sensor too or a computer; disconnect it, "
                     "and give one of them another address\n",
                     f->other_mac);
    } else {
        (void)printf("    two devices have this address, the other is %s: "
                     "either may be an unreachable sensor; disconnect one, and "
                     "give the other another address\n",
                     f->other_mac);
    }
}

static void print_found(const struct find_plan *plan, struct find_result *r,
                        const struct find_found *f)
{
    char trip[32] = "";
    if (f->round_trip_ns > 0) {
        (void)snprintf(trip, sizeof trip, " in %.2f ms",
                       (double)f->round_trip_ns / 1e6);
    }
    (void)printf("%-21s  %-10s  %-17s  %s%s\n", session_name(f->host).text,
                 name_of(f->interface), f->mac, hows[f->how].meaning, trip);
    if (f->other_mac[0] != '\0') {
        print_other(f);
    }
    print_reach(plan, r, f);
}

/* One address on two interfaces. */
static void print_twins(const struct ctl *ctl, const struct find_result *r)
{
    for (size_t i = 0; i + 1 < r->count; i++) {
        const struct find_found *a = &r->found[i];
        const struct find_found *b = &r->found[i + 1];
        if (a->host.address == b->host.address &&
            a->interface != b->interface) {
            ctl_note(ctl,
                     "%s is on %s and on %s: the routes choose one; "
                     "--interface chooses another",
                     session_name(a->host).text, name_of(a->interface),
                     name_of(b->interface));
        }
    }
}

static void print_text(const struct ctl *ctl, const struct find_plan *plan,
                       struct find_result *r)
{
    if (r->count > 0) {
        (void)printf("%-21s  %-10s  %-17s  %s\n", "address", "interface", "MAC",
                     "what was seen");
    }
    for (size_t i = 0; i < r->count; i++) {
        print_found(plan, r, &r->found[i]);
    }
    print_twins(ctl, r);
    for (size_t i = 0; i < plan->left_out.count; i++) {
        ctl_note(ctl, "%s", plan->left_out.texts[i]);
    }
    if (plan->left_out.more > 0) {
        ctl_note(ctl, "and %u more were not searched",
                 (unsigned)plan->left_out.more);
    }
}

void find_print(const struct ctl *ctl, const struct find_plan *plan,
                struct find_result *result)
{
    qsort(result->found, result->count, sizeof result->found[0], compare);
    if (ctl->options.json) {
        print_json(plan, result);
    } else {
        print_text(ctl, plan, result);
    }
    if (result->unsent > 0) {
        ctl_note(ctl, "%u of %u requests were not sent: %s", result->unsent,
                 result->questions, result->error.text);
    }
    if (result->is_cut_short) {
        ctl_note(ctl, "interrupted: %u of %u addresses were asked",
                 result->asked, result->wanted);
    }
}
