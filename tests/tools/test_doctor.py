#!/usr/bin/env python3
"""lumctl doctor on a real system: what it finds, what it says of it, and that its fixes fix. Without rights, over time, and
on most broken hosts: tests/world/stories (doctor.c, doctor_hosts.c)."""
import json
import os
import pathlib
import pty
import re
import shutil
import signal
import subprocess
import sys
import unittest

import shards
from live import HERE, Hosts, Sensor, inside, needs_namespaces, wait_until
from support import BIN, PATIENCE_S, Folder, run

NAMES = ["interface", "route", "arp", "port", "session", "firewall", "buffer", "mtu", "answer", "data", "layout", "loss",
         "strangers", "clock", "status"]
WIRE = ["data", "layout", "loss", "strangers", "clock", "status"]

is_root = os.geteuid() == 0
needs_root = unittest.skipUnless(is_root, "only root may become another user")
needs_nft = unittest.skipUnless(is_root and shutil.which("nft", path="/usr/sbin:/sbin:/usr/bin"), "nft is not installed")

NET = f"127.35.{shards.index()}."  # tests that run side by side do not share addresses


# A busy machine that is held up loses what the queue between two hosts cannot hold; with fewer frames a second it holds more.
CALM = ["--rate", "4"]


class Findings:
    """What the doctor said, by check."""

    def __init__(self, r):
        self.status, self.error = r.returncode, r.stderr
        assert r.stdout, f"the doctor ended with {r.returncode}: {r.stderr}"
        said = json.loads(r.stdout)
        self.overall = said["overall"]
        self.names = [c["name"] for c in said["checks"]]
        self.of = {c["name"]: c for c in said["checks"]}
        assert all(c["mend"] == c["fix"] for c in said["checks"]), said  # the name before

    def __getitem__(self, name):
        return self.of[name]["result"]

    def text(self, name):
        return self.of[name]["text"]

    def fix(self, name):
        return self.of[name]["fix"]

    def __str__(self):
        return "\n".join(f"{c['result']} {n}: {c['text']} [{c['fix']}]" for n, c in self.of.items())


class Doctor(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def examine(self, address, *options):
        return Findings(run("lumctl", "--host", address, *options, "doctor", "--json"))

    def assert_fine(self, found, but=()):
        self.assertEqual((found.status, found.overall), (0, "fine"), str(found))
        self.assertEqual(found.names, NAMES)
        for name in NAMES:
            if name not in but:
                self.assertEqual(found[name], "fine", str(found))


class Loopback(Doctor):
    def sensor(self, *arguments, address=NET + "1"):
        return Sensor(self, self.folder, *CALM, *arguments, address=address)

    def test_a_simulator_is_all_fine(self):
        self.sensor()
        found = self.examine(NET + "1")
        # what only root or a tuned host may see is no fault
        self.assert_fine(found, but=("buffer", "loss"))
        self.assertIn("lumsim", found.text("port"))
        self.assertIn(NET + "1", found.text("route"))
        self.assertIn("host's rate", found.text("clock"))
        self.assertIn("laser may be up", found.text("status"))

    def test_colours_are_for_terminals_that_want_them(self):
        for variables, coloured in (({}, True), ({"NO_COLOR": "1"}, False)):
            ours, theirs = pty.openpty()
            environment = {k: v for k, v in os.environ.items() if k != "NO_COLOR"} | {"TERM": "xterm"} | variables
            p = subprocess.Popen([str(BIN / "lumctl"), "--host", NET + "2", "doctor"], stdout=theirs,
                                 stderr=subprocess.DEVNULL, stdin=subprocess.DEVNULL, env=environment)
            os.close(theirs)
            out = b""
            try:
                while chunk := os.read(ours, 4096):
                    out += chunk
            except OSError:
                pass
            os.close(ours)
            self.assertEqual(p.wait(PATIENCE_S), 1)
            self.assertEqual(b"\033[" in out, coloured, out)

    def test_nothing_that_listens_is_said_with_the_command_that_starts_a_simulator(self):
        found = self.examine(NET + "3")
        self.assertEqual((found.status, found.overall), (1, "wrong"), str(found))
        self.assertEqual(found["port"], "wrong")
        for name in WIRE:
            self.assertEqual(found[name], "not looked at")
            self.assertIn("nothing listens", found.text(name))

    def test_a_simulator_at_another_address_is_pointed_at(self):
        self.sensor(address=NET + "4")
        found = self.examine(NET + "5")
        self.assertEqual(found.status, 1)
        self.assertIn("lumsim", found.text("port"))
        self.assertRegex(found.fix("port"), r"^lumctl --host 127\.\d+\.\d+\.\d+( --port \d+)? doctor$")

    def test_troubleshooting_has_a_section_for_each_check(self):
        text = (HERE.parents[1] / "docs/troubleshooting.md").read_text()
        self.assertEqual([line[3:] for line in text.splitlines() if line.startswith("## ")][:len(NAMES)], NAMES)

    def test_words_and_options_that_it_cannot_have_are_refused(self):
        for arguments, says in ((("doctor", "now"), "now"), (("--dry-run", "doctor"), "--dry-run")):
            r = run("lumctl", "--host", NET + "18", *arguments)
            self.assertEqual((r.returncode, r.stdout), (2, ""), r.stderr)
            self.assertIn(says, r.stderr)

    def test_an_interface_that_is_not_there_is_named(self):
        found = self.examine(NET + "18", "--interface", "nowhere0")
        self.assertEqual((found.status, found["interface"]), (1, "wrong"), str(found))
        self.assertIn("nowhere0", found.text("interface"))
        self.assertIn("lo", found.text("interface"))
        self.assertEqual(found["route"], "not looked at")

    def test_a_full_disk_is_no_success(self):
        with open("/dev/full", "wb") as full:
            r = subprocess.run([str(BIN / "lumctl"), "--host", NET + "19", "doctor"], stdout=full,
                               stderr=subprocess.PIPE, timeout=PATIENCE_S)
        self.assertEqual(r.returncode, 1)
        self.assertIn(b"standard output", r.stderr)

    @needs_root
    def test_without_rights_it_says_what_it_could_not_look_at(self):
        self.sensor("--rate", "2", address=NET + "20")  # the receive buffer may be small
        os.chmod(self.folder.path, 0o755)
        copy = shutil.copy(BIN / "lumctl", self.folder / "lumctl")
        r = subprocess.run([copy, "--host", NET + "20", "doctor", "--json"], capture_output=True, text=True, timeout=PATIENCE_S,
                           user=65534, group=65534, extra_groups=[])
        found = Findings(r)
        self.assertEqual(found.status, 0, str(found))
        self.assertIn("root", found.text("port"))
        self.assertIn(found["buffer"], ("note", "fine"))
        for name in ("interface", "route", "firewall", "mtu", "answer", "data", "layout", "clock", "status"):
            self.assertEqual(found[name], "fine", str(found))


class OnHosts(Doctor):
    """The client's host is broken in one way, and fixed by the very commands that the doctor gives."""

    def setUp(self):
        super().setUp()
        self.hosts = Hosts(self, self.folder)
        shim = self.folder / "bin"
        shim.mkdir()
        (shim / "sudo").write_text('#!/bin/sh\nexec "$@"\n')
        (shim / "sudo").chmod(0o755)
        self.environment = dict(os.environ, PATH=f"{shim}:{BIN}:{os.environ['PATH']}:/usr/sbin:/sbin")

    def sensor(self, *arguments):
        return Sensor(self, self.folder, *CALM, *arguments, address="10.42.0.37", namespace=self.hosts.sensor)

    def shell(self, command, timeout=PATIENCE_S):
        """As it stands, on the client's host. One that does not end, since it only looks, is ended."""
        p = subprocess.Popen([*inside(self.hosts.client), "sh", "-ec", command], stdout=subprocess.PIPE,
                             stderr=subprocess.STDOUT, text=True, env=self.environment, start_new_session=True)
        try:
            out, _ = p.communicate(timeout=timeout)
        except subprocess.TimeoutExpired:
            os.killpg(p.pid, signal.SIGKILL)
            out, _ = p.communicate(timeout=PATIENCE_S)
        return p.returncode, out

    def client(self, command):
        status, out = self.shell(command)
        self.assertEqual(status, 0, f"{command}: {out}")

    def look(self, *options):
        return Findings(self.hosts.run("lumctl", *options, "doctor", "--json"))

    def broken(self, check, status=1, says="", *options):
        found = self.look(*options)
        self.assertEqual((found.status, found[check]), (status, "wrong"), str(found))
        self.assertIn(says, found.text(check))
        return found

    def link_shows(self, flag):
        """The kernel notices a cable a moment later."""
        def shows():
            return flag in Hosts.ip("-n", self.hosts.client, "link", "show", "eth0")
        wait_until(shows, flag)

    def other_interface(self, address):
        self.client("ip link add other0 type veth peer name other1; ip link set other1 up; ip link set other0 up;"
                    f"ip addr add {address} dev other0")

    def follow(self, fix, found=None):
        """Do what a fix says, to the letter. The options of the next look, where it is one."""
        if fix.endswith(" &"):
            name, option, address, *others = fix[:-2].split()
            self.assertEqual((name, option), ("lumsim", "--address"))
            Sensor(self, self.folder, *others, address=address, namespace=self.hosts.client)
            return None
        looks = re.match(r"(?:sudo )?lumctl (.*) doctor(?:    #.*)?$", fix)
        if looks:
            return looks[1].split()
        changes = re.match(r"sudo (ip|sysctl) ", fix)
        status, out = self.shell(fix, timeout=PATIENCE_S if changes else 1.0)
        if changes:
            self.assertEqual(status, 0, f"{fix}: {out}\n{found}")
        return None

    def fixed(self, found, check, options=()):
        """Each fix, of the first thing that is wrong, is done; in the end nothing is wrong, and the sensor answers."""
        fixes = [found.fix(check)]
        for _ in range(4):
            self.assertIsNotNone(fixes[-1], str(found))
            options = self.follow(fixes[-1], found) or options
            self.link_shows("state UP")
            found = self.look(*options)
            wrong = [name for name in NAMES if found[name] == "wrong"]
            if not wrong:
                break
            fixes.append(found.fix(wrong[0]))
        self.assert_fine(found)
        self.assertEqual(self.hosts.run("lumctl", *options, "time").returncode, 0)
        return fixes

    def unharmed(self, *options):
        """A set-up that works: nothing is wrong with it, and no fix of a note breaks it."""
        found = self.look(*options)
        self.assertEqual(found.status, 0, str(found))
        for name in NAMES:
            if found.fix(name):
                self.follow(found.fix(name))
                again = self.look(*options)
                self.assertEqual({n: again[n] for n in NAMES}, {n: found[n] for n in NAMES}, f"{found}\n---\n{again}")
        return found


@needs_namespaces
class TwoHosts(OnHosts):
    def test_all_fine(self):
        self.sensor()
        found = self.look()
        self.assert_fine(found)
        self.assertEqual(found.text("interface"), "eth0 is up and has 10.42.0.1/24")
        self.assertRegex(found.text("arp"), r"10\.42\.0\.37 is at (..:){5}..")

    def test_no_address(self):
        self.sensor()
        self.client("ip addr flush dev eth0")
        found = self.broken("interface", 1, "subnet")
        self.assertEqual(found.fix("interface"), "sudo ip addr add 10.42.0.1/24 dev eth0")
        for name in ("route", "arp", "mtu", "answer", *WIRE):
            self.assertEqual(found.text(name), "not looked at: no interface in the sensor's subnet")
        self.fixed(found, "interface")

    def test_fixes_bear_the_port(self):
        found = self.broken("port", 1, "nothing listens on its port 5518", "--host", "127.0.0.3", "--port", "5518")
        self.assertEqual(self.fixed(found, "port", ("--host", "127.0.0.3", "--port", "5518")),
                         ["lumsim --address 127.0.0.3 --port 5518 &"])

    def test_interface_down(self):
        self.sensor()
        self.client("ip link set eth0 down")
        found = self.broken("interface", 1, "down")
        self.assertEqual(found.fix("interface"), "sudo ip link set eth0 up")
        self.fixed(found, "interface")

    def test_the_route_leads_elsewhere(self):
        self.sensor()
        self.other_interface("172.16.5.1/24")
        self.client("ip route add 10.42.0.37/32 dev other0")
        found = self.broken("route", 1, "goes out by other0, and not by eth0 in its subnet, where it answers")
        self.assertEqual(found.text("answer"), "not looked at: the route leads elsewhere")
        self.assertEqual(self.fixed(found, "route"), ["lumctl --host 10.42.0.37 --interface eth0 doctor    # --interface "
                                                       "eth0 with every tool"])

    def test_the_route_leads_to_a_gateway(self):
        self.sensor()
        self.client("ip route add 10.42.0.32/29 via 10.42.0.9")
        found = self.broken("route", 1, "to the gateway 10.42.0.9")
        self.assertEqual(self.fixed(found, "route"), ["sudo ip route replace 10.42.0.37/32 dev eth0 src 10.42.0.1"])

    def by_the_wrong_one(self, address="10.42.0.2/24"):
        """The route of the address that came first holds."""
        self.sensor()
        self.client("ip addr flush dev eth0")
        self.other_interface(address)
        self.client("ip addr add 10.42.0.1/24 dev eth0")

    def test_an_interface_in_its_subnet_and_the_cable_in_another(self):
        self.sensor()
        self.client("ip addr flush dev eth0")
        self.other_interface("10.42.0.1/24")
        found = self.broken("arp", 1, "nobody on other0 answers for 10.42.0.37, but a device on eth0 does, which has no address")
        self.assertEqual(found.fix("arp"), "sudo ip addr add 10.42.0.2/32 dev eth0 && sudo ip route add 10.42.0.37/32 dev eth0 "
                                            "src 10.42.0.2")
        self.follow(found.fix("arp"))
        found = self.unharmed()
        self.assertEqual((found["route"], found["answer"], found["data"]), ("note", "fine", "fine"), str(found))

    def test_two_interfaces_in_its_subnet_and_a_strict_filter(self):
        self.by_the_wrong_one()
        self.client("sysctl -qw net.ipv4.conf.all.rp_filter=1")
        found = self.broken("route", 1, "other0")
        fixes = self.fixed(found, "route")
        self.assertEqual(fixes[1:], ["sudo sysctl -w net/ipv4/conf/eth0/rp_filter=2"])

    def test_a_permanent_entry_of_another_device(self):
        self.sensor()
        self.client("ip neigh replace 10.42.0.37 lladdr 02:00:00:00:00:99 dev eth0 nud permanent")
        found = self.broken("arp", 1, "10.42.0.37 is at 02:00:00:00:00:99, but ")
        self.assertEqual(self.fixed(found, "arp"), ["sudo ip neigh del 10.42.0.37 dev eth0"])

    def test_the_sensors_address_on_the_host_itself(self):
        self.sensor()
        self.client("ip addr add 10.42.0.37/24 dev eth0")
        found = self.broken("port", 1, "own address (dev eth0)")
        self.assertEqual(found["arp"], "wrong", str(found))
        self.assertEqual(self.fixed(found, "port"), ["sudo ip addr del 10.42.0.37/24 dev eth0"])

    def test_a_port_that_is_rewritten(self):
        self.sensor("--port", "6000")
        r = subprocess.run([*inside(self.hosts.sensor), "nft", "-f", "-"], input="""table ip rewrite {
            chain in { type filter hook prerouting priority -300; udp dport 5517 udp dport set 6000; }
        }""", capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual(r.returncode, 0, r.stderr)
        found = self.broken("answer", 1, "answers from port 6000")
        self.assertEqual(self.fixed(found, "answer"), ["lumctl --host 10.42.0.37:6000 doctor"])

    def test_a_route_that_forbids(self):
        self.client("ip route add unreachable 10.42.0.37/32")
        self.assertEqual(self.broken("route", 1, "no route").text("arp"), "not looked at: no route")

    def test_mtu(self):
        self.sensor()
        self.client("ip link set eth0 mtu 1400")
        found = self.broken("mtu", 1, "1400")
        self.assertEqual(found["answer"], "fine")
        self.fixed(found, "mtu")

    def look_unprivileged(self, *options):
        os.chmod(self.folder.path, 0o755)
        copy = shutil.copy(BIN / "lumctl", self.folder / "lumctl")
        r = subprocess.run([*inside(self.hosts.client), sys.executable, "-c",
                            "import os, sys; os.setgroups([]); os.setgid(65534); os.setuid(65534);"
                            "os.execv(sys.argv[1], sys.argv[1:])", copy, *options, "doctor", "--json"],
                           capture_output=True, text=True, timeout=PATIENCE_S)
        return Findings(r)

    @needs_nft
    def test_a_rule_without_rights(self):
        self.sensor()
        self.client("nft 'add table inet f { chain in { type filter hook input priority 0; policy drop; }; }'")
        found = self.look_unprivileged()
        self.assertEqual((found.status, found["firewall"]), (3, "not looked at"), str(found))
        self.assertIn("only root can see whether one comes in and is dropped", found.text("firewall"))

    def test_unprivileged(self):
        self.sensor("--rate", "2")  # the receive buffer may be small
        found = self.look_unprivileged()
        for name in ("interface", "route", "arp", "firewall", "mtu", "answer", "data", "layout", "clock", "status"):
            self.assertEqual(found[name], "fine", str(found))
        self.assertIn("only root can see whether another device answers", found.text("arp"))
        limit = int(pathlib.Path("/proc/sys/net/core/rmem_max").read_text())
        self.assertEqual(found["buffer"], "fine" if limit >= 33554432 else "wrong", str(found))
        self.assertEqual(found.status, 0 if found["buffer"] == "fine" else 1)


# Each drops what comes from the sensor, or what goes to it: the commands, and what of them the doctor's command lists.
RULES = {
    "policy": ("nft 'add table inet f { chain in { type filter hook input priority 0; policy drop; tcp dport 22 accept; }; }'",
               "policy drop"),
    "a chain behind a jump": (
        "nft 'add table ip g { chain no_udp { udp sport { 53, 5000-6000 } counter drop; }; chain in { type filter hook "
        "prerouting priority 0; ip saddr 10.42.0.0/16 jump no_udp; }; }'", "drop"),
    "what leaves": ("nft 'add table inet f { chain out { type filter hook output priority 0; udp dport 5517 reject; }; }'",
                    "udp dport 5517 reject"),
    "after routing": ("nft 'add table ip f { chain po { type filter hook postrouting priority 0; ip daddr 10.42.0.37 drop; }; }'",
                      "ip daddr 10.42.0.37 drop"),
    "no tracking": (
        "nft 'add table inet f { chain raw { type filter hook prerouting priority -300; udp sport 5517 notrack; }; chain in { "
        "type filter hook input priority 0; policy drop; ct state established accept; }; }'", "policy drop"),
    "a map": ("nft 'add table inet f { chain in { type filter hook input priority 0; udp sport vmap { 5517 : drop }; }; }'",
              "5517 : drop"),
    "the device's own chain": (
        "nft 'add table netdev f { chain i { type filter hook ingress device eth0 priority 0; udp sport 5517 drop; }; }'",
        "udp sport 5517 drop"),
    "iptables, policy": ("iptables-nft -P INPUT DROP; iptables-nft -A INPUT -p tcp --dport 22 -j ACCEPT", "policy drop"),
    "iptables of the old kind": ("iptables-legacy -t raw -A PREROUTING -s 10.42.0.37 -j DROP", "-A PREROUTING -s 10.42.0.37/32 -j DROP"),
}


@needs_namespaces
@needs_nft
class Firewall(OnHosts):
    """A rule drops packets: that is seen, and the command that is given lists the rule."""

    def drops(self, name):
        rules, lists = RULES[name]
        program = rules.split()[0]
        if not shutil.which(program, path="/usr/sbin:/sbin:/usr/bin"):
            self.skipTest(program + " is not installed")
        self.sensor()
        self.client(rules)
        leaves = "hook output" in rules or "hook postrouting" in rules
        found = self.broken("firewall", 1, "this host refuses to send" if leaves else "come in by eth0, and this host drops them")
        self.assertIn(lists, self.shell(found.fix("firewall"))[1])

    def test_rules_let_all_but_answers_drop(self):
        self.sensor()
        self.client("nft 'add table inet f { chain in { type filter hook input priority 0; policy drop; iif lo accept; "
                    "ct state vmap { invalid : drop, established : accept, related : accept }; }; }'")
        self.assert_fine(self.look())

    def test_rules_that_let_answers_pass_and_data_not(self):
        self.sensor()
        self.client("nft 'add table inet f { chain in { type filter hook input priority 0; udp length > 300 drop; }; }'")
        found = self.broken("data", 1, "came in by eth0, and this host drops them, though not short answers")
        self.assertEqual((found["answer"], found["firewall"]), ("fine", "fine"), str(found))
        self.assertIn("udp length > 300 drop", self.shell(found.fix("data"))[1])

    def test_a_rule_that_limits_is_no_bad_cable(self):
        self.sensor()
        self.client("nft 'add table inet f { chain in { type filter hook input priority 0; udp length > 300 limit rate over "
                    "100/second drop; }; }'")
        found = self.broken("loss", 1, "this host dropped")
        self.assertIn("though its buffer had room", found.text("loss"))
        self.assertIn("limit rate over 100/second", self.shell(found.fix("loss"))[1])


def add_stories():
    for name in RULES:
        def story(self, name=name):
            self.drops(name)
        setattr(Firewall, "test_rules_" + re.sub(r"\W+", "_", name), story)


add_stories()


if __name__ == "__main__":
    shards.main()
