#include "help.h"

#include <ctype.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#define LEFT_CHARS 23 /* of the left column */

const char help_begin[] = "Usage: lumctl [OPTION]... COMMAND [WORD]...\n"
                          "Talk to a Luminar Model G2: look, set, switch.\n"
                          "\n"
                          "Commands (for details: lumctl COMMAND --help):\n";

const char help_end[] =
    "\n"
    "The environment variable LUM_HOST does the same as --host.\n"
    "\n"
    "Exit status: 0 done; 1 it failed; 2 bad arguments or configuration;\n"
    "3 the sensor does not answer; 4 it reports a hazard (status, wait,\n"
    "laser on, heartbeat, sweep).\n"
    "\n"
    "Examples:\n"
    "  lumctl status                              does it answer, and how is "
    "it\n"
    "  lumctl --host 127.0.0.1 status --watch     a simulated one\n"
    "  lumctl set-ip 10.42.0.38\n"
    "  lumctl power 50 --json\n"
    "  lumctl --dry-run --sequence 7 laser on     the packet, in hex\n";

static const struct {
    const char *name;
    const char *text;
} details[] = {
    {"status",
     "Bits 0 to 8 are hazards: exit status 4. HEARTBEAT_TIMEOUT alone means\n"
     "that nobody owns the session: the sensor is idle, exit status 0.\n"
     "--watch asks twice a second; on a terminal it redraws, otherwise it\n"
     "writes a line for each change.\n"
     "--every writes a line each time; a hazard that came and went in\n"
     "between also gives exit status 4. Several runs may share a CSV file.\n"
     "\n"
     "  lumctl status --every 10 --csv night.csv --until hazard\n"
     "  lumctl status --every 15 --prometheus lumsdk.prom\n"},
    {"wait",
     "Without a word it waits until the sensor answers; clear: until no "
     "hazard\n"
     "is left. Without --for it ends only then, or by Ctrl-C. Exit status 3:\n"
     "not in time; 4: not in time, and there is a hazard.\n"
     "\n"
     "  lumctl wait --for 60 && lumctl status\n"},
    {"time", "Eight exchanges, or with --watch one each second, with a line "
             "for each.\n"},
    {"set-ip",
     "The sensor changes its address at once, and boots at 10.42.0.37 again\n"
     "when its power was off. Addresses at which this host could not reach\n"
     "it any more are refused, except with --force.\n"},
    {"laser",
     "It stays on only while a program sends heartbeats: lumdump\n"
     "udp://ADDRESS, lumctl heartbeat, or lumctl shell --heartbeat. Keep\n"
     "people's eyes away from the beam.\n"},
    {"yscan",
     "FOV spreads the lines evenly over 11 to 30 degrees around the "
     "horizon.\n"
     "SHAPE is one of\n"
     "  uniform[:MIN:MAX]           even from MIN to MAX degrees\n"
     "  gaussian:CENTER:SIGMA[:MIN:MAX]\n"
     "                              densest around CENTER\n"
     "  regions:MIN..MAX=WEIGHT[,MIN..MAX=WEIGHT...]\n"
     "                              bands, each with its share of the lines\n"
     "  csv:FILE                    an elevation in degrees on each line\n"},
    {"send",
     "u, d               laser on, off\n"
     "0..100 p           power\n"
     "0..100 g, b        threshold green, blue\n"
     "0f, 1f             640 lines, 64 lines\n"
     "11..30 y           Y scan, degrees\n"
     "150..250 h         holdoff, in steps of 10\n"
     "0..30 G, B         offset green, blue\n"
     "Separate commands by one space; all are checked before any is sent.\n"},
    {"tlv",
     "TYPE is 0 to 65535, HEX the bytes of the value: 1:75 is the command u.\n"
     "The answer is shown.\n"},
    {"apply", "--dry-run shows the plan and sends nothing.\n"},
    {"sweep",
     "PLAN is YAML: steps of settings as apply takes them, each with what to\n"
     "record. The sample calib/sweep.yaml explains every key. The folder gets\n"
     "a recording for each step and manifest.json, which says what was done;\n"
     "it has the plan's name unless -o names it. Anything that goes wrong\n"
     "ends the sweep; --continue does what is missing.\n"
     "With --laser keep people's eyes away from the beam.\n"
     "\n"
     "  lumctl sweep plan.yaml --dry-run\n"
     "  lumctl sweep plan.yaml -o night --laser --continue\n"},
    {"find",
     "Asks each address of the subnets of each interface that is up for a\n"
     "time stamp; in a subnet larger than a /22, only the part around this\n"
     "host's own address. As root it also asks by ARP, where this host has\n"
     "no address in the sensor's subnet. Nothing else is sent. Simulators:\n"
     "--interface lo.\n"},
    {"show",
     "The sensor cannot be asked for its settings: this shows what it last\n"
     "acknowledged to this user of this host. If its clock shows a restart,\n"
     "all settings are forgotten.\n"},
    {"save", "lumctl save > mine.yaml; lumctl apply mine.yaml. Settings that\n"
             "cannot be written are left out and named.\n"},
    {"heartbeat",
     "Until Ctrl-C, or for --duration. The sensor sends its data here; it\n"
     "switches its laser off 3 s after the last heartbeat. With --laser it is\n"
     "switched on, and off before the command ends: keep people's eyes away\n"
     "from the beam. --every writes lines as with status, with what is lost\n"
     "of the data.\n"
     "\n"
     "  lumctl heartbeat --laser --duration 60 --every 10 --csv warm.csv\n"},
    {"doctor",
     "Checks the host, the way to the sensor and the sensor, in order,\n"
     "and prints the command that fixes what is wrong. As root it finds\n"
     "more.\n"},
    {"shell", "Takes commands like lumctl, and the manual's text (50p).\n"
              "quit or Ctrl-D ends it.\n"},
};

void help_row(const char *name, const char *takes, const char *text)
{
    char left[48];
    const int n =
        snprintf(left, sizeof left, "%s%s%s", name, takes != NULL ? " " : "",
                 takes != NULL ? takes : "");
    (void)printf("  %-*s%s%*s  %s\n", LEFT_CHARS, left,
                 n > LEFT_CHARS ? "\n" : "",
                 n > LEFT_CHARS ? LEFT_CHARS + 2 : 0, "", text);
}

void help_command(const char *name, const char *takes, const char *summary)
{
    (void)printf("Usage: lumctl [OPTION]... %s%s%s\n%c%s.\n", name,
                 takes != NULL ? " " : "", takes != NULL ? takes : "",
                 toupper((unsigned char)*summary), summary + 1);
    for (size_t i = 0; i < sizeof details / sizeof details[0]; i++) {
        if (strcmp(details[i].name, name) == 0) {
            (void)printf("\n%s", details[i].text);
        }
    }
    (void)puts("\nOptions:");
}
