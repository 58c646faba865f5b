#include "ctl.h"

enum exit_status command_apply(struct ctl *ctl, int count, char **words)
{
    (void)ctl;
    return ctl_complain(EXIT_BAD,
                        "apply: this lumctl was built without libyaml and does "
                        "not read '%.40s'; give the settings one by one, or "
                        "build it with the config library",
                        count > 1 ? words[1] : "files");
}
