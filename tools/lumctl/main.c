/* The program lumctl. */
#include "../common/interrupt.h"
#include "ctl.h"
#include "ctl_session.h"
#include "options.h"

#include <stdlib.h>

static enum exit_status take_environment(struct ctl *ctl)
{
    const char *host = getenv("LUM_HOST");
    lum_error why = {""};
    if (host != NULL && *host != '\0' &&
        !options_parse_host(host, &ctl->options.host, &why)) {
        return ctl_complain(EXIT_BAD, "LUM_HOST in the environment: %s",
                            why.text);
    }
    return EXIT_DONE;
}

static void set_defaults(struct ctl *ctl)
{
    lum_sensor_options usual;
    lum_sensor_options_default(&usual);
    *ctl = (struct ctl){.options = {.host = usual.sensor,
                                    .requests.timeout_ms = usual.timeout_ms,
                                    .requests.retries = usual.retries}};
    lum_layout_default(&ctl->layout);
}

int main(int argc, char **argv)
{
    struct ctl ctl;
    lum_error error = {""};
    set_defaults(&ctl);
    if (lum_cancel_new(&ctl.cancel, &error) != 0) {
        return (int)ctl_complain(EXIT_FAILED, "%s", error.text);
    }
    interrupt_catch();
    interrupt_attach(ctl.cancel);
    enum exit_status status = take_environment(&ctl);
    if (status == EXIT_DONE) {
        status = ctl_run(&ctl, argc, argv);
    }
    session_end(&ctl);
    interrupt_attach(NULL);
    lum_cancel_free(ctl.cancel);
    if (status == EXIT_FAILED && interrupt_signal() != 0 && !ctl.is_lasting) {
        interrupt_die();
    }
    return (int)status;
}
