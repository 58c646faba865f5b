#include "ctl.h"

enum exit_status command_sweep(struct ctl *ctl, int count, char **words)
{
    (void)ctl;
    return ctl_complain(EXIT_BAD,
                        "sweep: this lumctl was built without libyaml or "
                        "without captures, or for Windows, and does not do "
                        "'%.40s'; do its steps one by one: lumctl apply, "
                        "lumdump",
                        count > 1 ? words[1] : "plans");
}
