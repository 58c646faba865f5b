#include "help.h"

#include <ctype.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

static const char begin[] = "Usage: lumctl [OPTION]... COMMAND [WORD]...\n"
                            "Talk to a Luminar Model G2: look, set, switch.\n"
                            "\n"
                            "Commands (more of each: lumctl COMMAND --help):\n";

static const char end[] =
    "\n"
    "LUM_HOST in the environment stands for --host.\n"
    "\n"
    "Exit status: 0 done; 1 it failed; 2 bad arguments or configuration;\n"
    "3 the sensor does not answer; 4 it reports a hazard (status, laser on).\n"
    "\n"
    "Examples:\n"
    "  lumctl status                              is it there, is it well\n"
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
     "that nobody owns the session: that is idle, and exit status 0.\n"
     "--watch asks twice a second; on a terminal it redraws, elsewhere it\n"
     "writes a line for each change.\n"},
    {"time", "Eight exchanges, or with --watch one each second, a line for "
             "each.\n"},
    {"set-ip",
     "The sensor changes at once, and boots at 10.42.0.37 again when its\n"
     "power was off. Addresses at which this host would not reach it any more\n"
     "are refused, but for --force.\n"},
    {"laser",
     "It stays on only while some program sends heartbeats: lumdump\n"
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
     "Commands are parted by one space; each is checked before any is sent.\n"},
    {"tlv",
     "TYPE is 0 to 65535, HEX the bytes of the value: 1:75 is the command u.\n"
     "What comes back is shown.\n"},
    {"apply", "--dry-run shows the plan and sends nothing.\n"},
    {"find",
     "Asks each address of the subnets of each interface that is up for a "
     "time\n"
     "stamp, of wider ones than a /22 the part around this host's own; as "
     "root\n"
     "also asks by ARP and listens to what is on the wire, where no address\n"
     "fits. Nothing else is sent. Simulators: --interface lo.\n"},
    {"show",
     "The sensor cannot be asked for its settings: shown is what it last\n"
     "acknowledged to this user of this host. Its clock tells of a restart,\n"
     "which voids all of it.\n"},
    {"save", "lumctl save > mine.yaml; lumctl apply mine.yaml. What cannot be\n"
             "written is left out, and said.\n"},
    {"heartbeat",
     "Until Ctrl-C, or for --duration. The sensor sends its data here; it\n"
     "switches its laser off 3 s after the last heartbeat.\n"},
    {"doctor",
     "Looks at the host, the way to the sensor and the sensor, in\n"
     "order, and names the command that mends what is wrong. --trace,\n"
     "as root, asks the kernel which firewall rule drops requests or\n"
     "answers.\n"},
    {"shell", "Takes commands as lumctl does, and the manual's text (50p).\n"
              "quit or Ctrl-D ends it.\n"},
};

void help_row(const char *name, const char *takes, const char *text)
{
    char left[48];
    (void)snprintf(left, sizeof left, "%s%s%s", name, takes != NULL ? " " : "",
                   takes != NULL ? takes : "");
    (void)printf("  %-23s  %s\n", left, text);
}

void help_begin(void)
{
    (void)fputs(begin, stdout);
}

void help_end(void)
{
    (void)fputs(end, stdout);
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
