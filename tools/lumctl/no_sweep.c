/* The refusal of sweep in builds that cannot do it. */
#include "ctl.h"

enum exit_status command_sweep(struct ctl *ctl, int count, char **words)
{
    (void)ctl;
    return ctl_complain(EXIT_BAD,
                        "sweep: this lumctl was built without libyaml or "
                        "captures, or for Windows, and cannot do %.40s; use "
                        "lumctl apply and lumdump for each step",
                        count > 1 ? words[1] : "plans");
}
