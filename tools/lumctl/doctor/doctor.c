/* What all checks of the doctor share: they record findings and fixes, and
 * what later checks need that is missing. */
#include "doctor.h"

#include "../../common/number.h"

#include "lum/wire.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define LOOPBACK 0x7f000001u

void doctor_say(struct doctor_finding *out, enum doctor_result result,
                const char *text, ...)
{
    va_list arguments;
    va_start(arguments, text);
    out->result = result;
    (void)vsnprintf(out->text, sizeof out->text, text, arguments);
    va_end(arguments);
}

void doctor_fix(struct doctor_finding *out, const char *command, ...)
{
    va_list arguments;
    va_start(arguments, command);
    (void)vsnprintf(out->fix, sizeof out->fix, command, arguments);
    va_end(arguments);
}

struct doctor_place doctor_place(lum_endpoint at)
{
    struct doctor_place place;
    const size_t len = strlen(number_format_address(
        at.address != 0 ? at.address : LOOPBACK, place.text));
    if (at.port != LUM_PORT) {
        (void)snprintf(place.text + len, sizeof place.text - len, " --port %u",
                       (unsigned)at.port);
    }
    return place;
}

/* nft does not list the rules of iptables-legacy. */
static bool has_legacy_rules(void)
{
    char name[32];
    FILE *f = fopen("/proc/net/ip_tables_names", "r");
    const bool has = f != NULL && fgets(name, sizeof name, f) != NULL;
    if (f != NULL) {
        (void)fclose(f);
    }
    return has;
}

void doctor_fix_rules(const struct doctor *d, struct doctor_finding *out)
{
    doctor_fix(out,
               "%s | grep -niE 'length|limit|quota|drop|reject'    # and let "
               "UDP between here and %s through before it",
               has_legacy_rules()
                   ? "(sudo nft list ruleset; sudo iptables-legacy-save -c)"
                   : "sudo nft list ruleset",
               d->address);
}

void doctor_fix_elsewhere(const struct doctor *d, struct doctor_finding *out)
{
    doctor_fix(out,
               "sudo lumctl find --interface %s    # at which address does "
               "it answer? It boots at 10.42.0.37",
               d->route.interface);
}

void doctor_lack(struct doctor *d, enum doctor_need need, const char *why)
{
    for (unsigned i = need; i < DOCTOR_NEEDS; i++) {
        if (d->lacks[i] == NULL) {
            d->lacks[i] = why;
        }
    }
}
