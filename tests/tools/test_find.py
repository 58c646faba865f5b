#!/usr/bin/env python3
"""lumctl find: sensors at addresses that nobody remembers, on interfaces with a fitting address and without one."""
import json
import os
import pty
import shutil
import signal
import socket
import struct
import subprocess
import sys
import unittest

import shards
from live import Hosts, Process, Sensor, inside, needs_namespaces, readable, wait_until
from support import BIN, MAGIC, PATIENCE_S, Folder, run
from test_lumctl import FakeSensor

DONE, FAILED, BAD, NO_ANSWER = range(4)

# Sends a packet from port 5517 again and again: HERE THERE BODY, the body in hex behind the magic.
SENDER = """
import socket, sys, time
here, there, body = sys.argv[1:]
s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
s.bind((here, 5517))
while True:
    s.sendto(bytes.fromhex("%s" + body), (there, 5000))
    time.sleep(0.05)
""" % MAGIC.hex()

# Says by ARP, again and again, that each address is at a MAC of its own: DEVICE ADDRESS...
ARP = """
import socket, struct, sys, time
s = socket.socket(socket.AF_PACKET, socket.SOCK_RAW)
s.bind((sys.argv[1], 0x0806))
while True:
    for n, address in enumerate(sys.argv[2:]):
        mac = bytes([2, 0, 0, 0, 0, n])
        ip = socket.inet_aton(address)
        s.send(b"\\xff" * 6 + mac + struct.pack(">HHHBBH", 0x0806, 1, 0x0800, 6, 4, 2) + mac + ip + mac + ip)
    time.sleep(0.05)
"""

# Answers each question of ARP for an address as a device of its own: DEVICE ADDRESS MAC.
IMPOSTOR = """
import socket, struct, sys
device, address, mac = sys.argv[1], socket.inet_aton(sys.argv[2]), bytes.fromhex(sys.argv[3].replace(":", ""))
s = socket.socket(socket.AF_PACKET, socket.SOCK_RAW)
s.bind((device, 0x0806))
print("ready", flush=True)
while True:
    p = s.recv(64)
    if p[20:22] == b"\\0\\1" and p[38:42] == address:
        s.send(p[6:12] + mac + struct.pack(">HHHBBH", 0x0806, 1, 0x0800, 6, 4, 2) + mac + address + p[22:32])
"""

# Answers everything with a packet of a type that no sensor sends.
STRANGER = """
import socket, sys
s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
s.bind((sys.argv[1], 5517))
print("ready", flush=True)
while True:
    packet, sender = s.recvfrom(2048)
    s.sendto(packet[:8] + bytes([99]) + packet[9:], sender)
"""


# A busy machine may hold up a sensor that is to be found.
PATIENT = ["--timeout", 1500]


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def check(self, status, r):
        self.assertEqual(r.returncode, status, (r.stdout, r.stderr))
        return r


class Here(Case):
    """On this host's loopback."""

    def test_a_simulator_in_a_subnet_that_is_named(self):
        sensor = Sensor(self, self.folder, address="127.62.0.3")
        found = json.loads(self.check(DONE, run("lumctl", "find", "--timeout", 3000, "--subnet", "127.62.0.0/29", "--json")).stdout)
        self.assertEqual([(s["sensor"], s["interface"], s["how"]) for s in found["sensors"]], [("127.62.0.3", "lo", "answers")])
        self.assertEqual(found["searched"], [{"interface": "lo", "subnet": "127.62.0.0/29", "by": "udp"}])
        self.assertEqual((found["asked"], found["not_sent"], found["complete"]), (6, 0, True))
        self.assertGreater(found["sensors"][0]["clock_us"], 0)
        self.assertGreater(found["sensors"][0]["round_trip_ms"], 0)
        self.assertEqual([e for kind in ("heartbeat", "tlv", "set_ip") for e in sensor.events(kind)], [])

    def test_only_requests_for_a_time_stamp_are_sent_twice_and_none_to_who_has_answered(self):
        silent = FakeSensor(self, "127.62.1.1", lambda *_: [])
        speaks = FakeSensor(self, "127.62.1.2")
        self.check(DONE, run("lumctl", "find", "--timeout", 3000, "--subnet", "127.62.1.0/30"))
        wait_until(lambda: len(silent.packets) >= 2, "the second request")
        self.assertEqual([p[8] for p in silent.packets], [6, 6])
        self.assertEqual([p[8] for p in speaks.packets], [6])
        self.check(DONE, run("lumctl", "find", "--timeout", 3000, "--subnet", "127.62.1.0/30", "--retries", 2))
        wait_until(lambda: len(silent.packets) >= 2 + 3, "the last request")
        self.assertEqual(len(silent.packets), 2 + 3)

    def test_an_answer_from_another_port_is_shown_with_it(self):
        other = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        other.bind(("127.62.2.1", 0))
        self.addCleanup(other.close)
        fake = FakeSensor(self, "127.62.2.1", lambda *_: [])
        name = f"127.62.2.1:{other.getsockname()[1]}"
        real = fake.socket

        class Elsewhere:
            """Receives at the port of sensors and answers from another."""
            recvfrom, close = real.recvfrom, real.close

            @staticmethod
            def sendto(out, sender):
                other.sendto(out, sender)
        fake.socket = Elsewhere
        fake.answer = lambda kind, sequence, body, count: [MAGIC + struct.pack("<III", 6, sequence, 1)]
        r = self.check(DONE, run("lumctl", "find", "--timeout", 3000, "--subnet", "127.62.2.0/30"))
        self.assertIn(name, r.stdout)

    def test_who_sends_the_magic_and_nothing_of_a_sensor_is_told_and_is_none(self):
        stranger = Process(self, self.folder, sys.executable, "-c", STRANGER, "127.62.3.1")
        wait_until(lambda: "ready" in stranger.stdout(), "the stranger")
        r = self.check(NO_ANSWER, run("lumctl", "find", "--timeout", 3000, "--subnet", "127.62.3.0/30"))
        self.assertRegex(r.stdout, r"127\.62\.3\.1 .*no packet that a sensor sends")
        self.assertIn("may be one", r.stderr)

    def test_none(self):
        r = self.check(NO_ANSWER, run("lumctl", "find", "--subnet", "127.62.4.0/30"))
        self.assertEqual(r.stdout, "")
        self.assertIn("no sensor answers at any of 2 addresses", r.stderr)
        found = json.loads(self.check(NO_ANSWER, run("lumctl", "find", "--subnet", "127.62.4.0/30", "--json")).stdout)
        self.assertEqual(found["sensors"], [])

    def test_arguments(self):
        for words, says in ((["--subnet", "10.0.0.0/21"], "wider than a /22"), (["--subnet", "10.0.0.0"], "not a subnet"),
                            (["--subnet", "10.0.0/24"], "not a subnet"), (["--subnet", "10.0.0.0/33"], "not a subnet"),
                            (["--interface", "nosuch"], "there is no interface nosuch"), (["--host", "10.42.0.37"], "--subnet says where"),
                            (["--dry-run"], "--dry-run"), (["all"], "'all'")):
            r = self.check(BAD, run("lumctl", "find", *words))
            self.assertEqual((r.stdout, r.stderr.count("\n")), ("", 1), words)
            self.assertIn(says, r.stderr)
        self.assertIn("it goes with find", self.check(BAD, run("lumctl", "status", "--subnet", "10.0.0.0/24")).stderr)

    def test_ctrl_c_prints_what_was_found_so_far(self):
        Sensor(self, self.folder, address="127.62.5.1")
        master, slave = pty.openpty()
        self.addCleanup(os.close, master)
        out = self.folder / "found"
        with open(out, "wb") as f:
            p = subprocess.Popen([BIN / "lumctl", "find", "--timeout", "20000", "--subnet", "127.62.4.0/22"], stdin=subprocess.DEVNULL, stdout=f, stderr=slave)
        self.addCleanup(lambda: p.poll() is None and p.kill())
        os.close(slave)
        shown = b""
        while b", 1 sensor found" not in shown:
            self.assertTrue(readable(master, PATIENCE_S), shown)
            shown += os.read(master, 4096)
        p.send_signal(signal.SIGINT)
        while True:
            try:
                data = os.read(master, 4096)
            except OSError:
                break
            if not data:
                break
            shown += data
        self.assertEqual(p.wait(PATIENCE_S), DONE)
        self.assertIn("127.62.5.1 ", out.read_text())
        self.assertIn(b"interrupted: ", shown)

    def test_ctrl_c_before_anything_was_found(self):
        asked = FakeSensor(self, "127.62.8.1", lambda *_: [])
        p = Process(self, self.folder, BIN / "lumctl", "find", "--timeout", "20000", "--subnet", "127.62.8.0/22")
        wait_until(lambda: asked.packets, "the first question")
        self.assertEqual(p.end(signal.SIGINT), -signal.SIGINT)
        self.assertIn("interrupted", p.stderr())

    def test_nothing_is_painted_where_no_terminal_is(self):
        r = run("lumctl", "find", "--subnet", "127.62.12.0/30")
        self.assertNotIn("\r", r.stderr)

    def test_a_shell_that_owns_a_sensor_keeps_it_alive_meanwhile(self):
        sensor = Sensor(self, self.folder, address="127.62.13.1")
        p = Process(self, self.folder, BIN / "lumctl", "--host", "127.62.13.1", "shell", "--heartbeat", stdin=subprocess.PIPE)
        p.p.stdin.write(b"laser on\nfind --subnet 127.62.16.0/23\nlaser off\n")
        p.p.stdin.flush()
        wait_until(lambda: sensor.laser_is_up(), "the laser")
        wait_until(lambda: not sensor.laser_is_up(), "its end")
        p.p.stdin.close()
        self.assertEqual(p.wait(), NO_ANSWER)
        up, down = [e["t"] for e in sensor.events("laser")][-2:]
        self.assertEqual([e for e in sensor.events("status", up) if e["t"] <= down and "HEARTBEAT_TIMEOUT" in e["bits"]], [])


@needs_namespaces
class Wire(Case):
    """Two hosts and a wire."""

    def setUp(self):
        super().setUp()
        self.hosts = Hosts(self, self.folder)

    def address(self, *addresses, device="eth0", name=None):
        for address in addresses:
            self.hosts.ip("-n", name or self.hosts.sensor, "addr", "add", address, "dev", device)

    def second_wire(self):
        """eth1 of both hosts."""
        self.hosts.ip("link", "add", "eth1", "netns", self.hosts.client, "type", "veth", "peer", "name", "eth1", "netns",
                      self.hosts.sensor)
        for name in (self.hosts.client, self.hosts.sensor):
            self.hosts.ip("-n", name, "link", "set", "eth1", "up")
        wait_until(lambda: "LOWER_UP" in self.hosts.ip("-n", self.hosts.client, "link", "show", "eth1"), "the link")

    def sensor(self, address):
        return Sensor(self, self.folder, address=address, namespace=self.hosts.sensor)

    def find(self, status, *words):
        return json.loads(self.check(status, self.hosts.run("lumctl", "find", "--json", *PATIENT, *words)).stdout)

    def apply(self, command):
        """A printed command, word for word."""
        r = subprocess.run([*inside(self.hosts.client), "sh", "-ec", command], capture_output=True, text=True)
        self.assertEqual((r.returncode, r.stderr), (0, ""), command)

    def test_three_sensors_at_odd_addresses(self):
        self.address("10.42.0.77/24", "10.42.0.143/24", "10.42.0.251/24")
        sensors = [self.sensor(f"10.42.0.{n}") for n in (77, 143, 251)]
        r = self.check(DONE, self.hosts.run("lumctl", "find", *PATIENT))
        rows = r.stdout.splitlines()[1:]
        self.assertEqual([row.split()[:2] for row in rows], [[f"10.42.0.{n}", "eth0"] for n in (77, 143, 251)])
        mac = self.hosts.mac(self.hosts.sensor)
        self.assertTrue(all(mac in row and " answers in " in row for row in rows), rows)
        found = self.find(DONE)
        self.assertEqual([s["sensor"] for s in found["sensors"]], [f"10.42.0.{n}" for n in (77, 143, 251)])
        self.assertEqual([(s["mac"], s["reach"], s["several_macs"]) for s in found["sensors"]], [(mac, None, False)] * 3)
        self.assertEqual(found["searched"], [{"interface": "eth0", "subnet": "10.42.0.0/24", "by": "udp"}])
        self.assertEqual(found["asked"], 254)
        for sensor in sensors:
            self.assertEqual(sensor.events("heartbeat") + sensor.events("tlv"), [])

    def test_a_sensor_that_is_anothers_is_found_and_stays_his(self):
        sensor = self.sensor("10.42.0.37")
        owner = self.hosts.start("lumctl", "heartbeat")
        wait_until(lambda: sensor.events("heartbeat"), "the owner")
        self.find(DONE)
        self.assertIsNone(owner.p.poll())
        self.assertEqual(len({e["from"] for e in sensor.events("heartbeat")}), 1)

    def test_a_sensor_that_has_booted_beyond_this_hosts_subnets(self):
        self.sensor("10.42.0.37")
        self.hosts.ip("-n", self.hosts.client, "addr", "del", "10.42.0.1/24", "dev", "eth0")
        for other, first in (("10.42.0.1/24", 2), (None, 1)):
            if other:
                self.address(other)
            self.hosts.ip("-n", self.hosts.client, "addr", "flush", "dev", "eth0")
            found = self.find(NO_ANSWER)
            self.assertEqual([(s["sensor"], s["interface"], s["how"], s["reach"]) for s in found["sensors"] if s["sensor"] != "10.42.0.1"],
                             [("10.42.0.37", "eth0", "arp", f"ip addr add 10.42.0.{first}/24 dev eth0")])
            if other:
                self.hosts.ip("-n", self.hosts.sensor, "addr", "del", other, "dev", "eth0")
        r = self.check(NO_ANSWER, self.hosts.run("lumctl", "find"))
        self.assertIn("as root: ip addr add 10.42.0.1/24 dev eth0", r.stdout)
        self.apply(found["sensors"][0]["reach"])
        self.assertEqual([s["how"] for s in self.find(DONE)["sensors"]], ["answers"])
        self.check(DONE, self.hosts.run("lumctl", "status"))

    def test_the_mend_breaks_no_other_interface(self):
        self.second_wire()
        self.hosts.ip("-n", self.hosts.sensor, "addr", "del", "10.42.0.37/24", "dev", "eth0")
        self.address("10.42.0.99/24")
        self.sensor("10.42.0.99")
        # The boot address is at the other wire; a way back to the client leads there.
        self.address("10.42.0.37/32", device="eth1")
        subprocess.run([*inside(self.hosts.sensor), "sysctl", "-qw", "net.ipv4.conf.all.arp_ignore=1"], check=True)
        self.sensor("10.42.0.37")
        found = {s["sensor"]: s for s in self.find(DONE)["sensors"]}
        self.assertEqual({k: (v["interface"], v["how"]) for k, v in found.items()},
                         {"10.42.0.99": ("eth0", "answers"), "10.42.0.37": ("eth1", "arp")})
        self.assertEqual(found["10.42.0.37"]["reach"], "ip route add 10.42.0.37/32 dev eth1")
        self.apply(found["10.42.0.37"]["reach"])
        self.check(DONE, self.hosts.run("lumctl", "--host", "10.42.0.37", "time"))
        self.check(DONE, self.hosts.run("lumctl", "--host", "10.42.0.99", "time"))

    def test_two_devices_of_one_address_and_who_is_nobody(self):
        """Both MACs answer for the boot address. This host's own address is not somebody else's, and an address that
        is asked by UDP is no finding for speaking ARP."""
        self.second_wire()
        self.hosts.ip("-n", self.hosts.client, "addr", "flush", "dev", "eth0")
        self.address("10.77.0.1/24", name=self.hosts.client)
        self.address("10.78.0.1/24", device="eth1", name=self.hosts.client)
        Process(self, self.folder, sys.executable, "-c", ARP, "eth0", "10.42.0.37", "10.78.0.1", "10.77.0.9", "10.42.0.1", "10.99.1.2",
                namespace=self.hosts.sensor)
        found = self.find(NO_ANSWER, "--interface", "eth0")["sensors"]
        self.assertEqual([(s["sensor"], s["how"], s["several_macs"]) for s in found],
                         [("10.42.0.1", "arp", False), ("10.42.0.37", "arp", True), ("10.99.1.2", "arp", False)])
        # 10.42.0.1 is taken.
        self.assertEqual(found[1]["reach"], "ip addr add 10.42.0.2/24 dev eth0")
        self.assertEqual(found[2]["reach"], "ip addr add 10.99.1.1/24 dev eth0")
        r = self.check(NO_ANSWER, self.hosts.run("lumctl", "find", "--interface", "eth0"))
        self.assertIn("two devices have this address", r.stdout)

    def impostor(self, address, mac):
        p = Process(self, self.folder, sys.executable, "-c", IMPOSTOR, "eth0", address, mac, namespace=self.hosts.sensor)
        wait_until(lambda: "ready" in p.stdout(), "the other device")

    def test_a_sensor_and_a_computer_of_one_address_whomever_the_kernel_has_asked(self):
        """As root the wire is asked. The kernel's table stands as it is: the sensor in it, or the computer."""
        self.address("10.42.0.77/24")
        macs = [self.hosts.mac(self.hosts.sensor), "02:00:00:00:00:77"]
        for address in ("10.42.0.37", "10.42.0.77"):
            self.sensor(address)
            self.impostor(address, macs[1])
        for first, how, status in ((0, "answers", DONE), (1, "arp", NO_ANSWER)):
            for address in ("10.42.0.37", "10.42.0.77"):
                self.hosts.ip("-n", self.hosts.client, "neigh", "replace", address, "lladdr", macs[first], "nud", "permanent", "dev",
                              "eth0")
            found = self.find(status)["sensors"]
            self.assertEqual([(s["sensor"], s["how"], s["several_macs"]) for s in found],
                             [("10.42.0.37", how, True), ("10.42.0.77", how, True)])
            for s in found:
                self.assertEqual({s["mac"], s["other_mac"]}, set(macs))
            if first == 0:
                self.assertEqual([s["mac"] for s in found], [macs[0]] * 2)
            r = self.check(status, self.hosts.run("lumctl", "find", "--subnet", "10.42.0.32/29"))
            self.assertIn(("two devices have this address: this sensor, and " + macs[1], "either may be a sensor that nothing reaches")
                          [first], r.stdout)

    def test_an_interface_without_a_fitting_address_is_asked_for_all_of_the_sensors_subnet(self):
        """By ARP; each address counts once, and each search stands there once."""
        self.second_wire()
        self.hosts.ip("-n", self.hosts.client, "addr", "flush", "dev", "eth0")
        found = self.find(NO_ANSWER, "--retries", 0)
        self.assertEqual([s["sensor"] for s in found["sensors"]], ["10.42.0.37", "10.42.0.37"])
        self.assertEqual(found["searched"], [{"interface": d, "subnet": "10.42.0.0/24", "by": "arp"} for d in ("eth0", "eth1")])
        self.assertEqual(found["asked"], 254)
        self.hosts.ip("-n", self.hosts.sensor, "addr", "del", "10.42.0.37/24", "dev", "eth0")
        self.address("10.42.0.143/24")
        r = self.check(NO_ANSWER, self.hosts.run("lumctl", "find", "--interface", "eth0"))
        self.assertRegex(r.stdout, r"10\.42\.0\.143 .*perhaps a sensor\n.*ip addr add 10\.42\.0\.1/24 dev eth0")
        self.assertIn("no sensor answers at any of 254 addresses", r.stderr)

    def test_a_subnet_that_is_asked_in_several_ways_is_counted_once(self):
        self.second_wire()
        found = self.find(NO_ANSWER, "--subnet", "172.16.9.0/24", "--retries", 0)
        self.assertEqual(found["searched"], [{"interface": d, "subnet": "172.16.9.0/24", "by": by}
                                             for d, by in (("", "udp"), ("eth0", "arp"), ("eth1", "arp"))])
        self.assertEqual((found["asked"], found["not_sent"]), (254, 254))
        r = self.check(NO_ANSWER, self.hosts.run("lumctl", "find", "--subnet", "172.16.9.0/24", "--retries", 0))
        self.assertIn("254 of 762 questions did not leave", r.stderr)
        self.assertIn("no sensor answers at any of 254 addresses", r.stderr)

    def test_a_named_subnet_is_asked_by_arp_where_no_address_fits(self):
        self.address("10.7.7.7/24")
        self.sensor("10.7.7.7")
        found = self.find(NO_ANSWER, "--interface", "eth0", "--subnet", "10.7.7.0/28")
        self.assertEqual([(s["sensor"], s["how"], s["reach"]) for s in found["sensors"]],
                         [("10.7.7.7", "arp", "ip addr add 10.7.7.1/24 dev eth0")])
        self.assertEqual(found["searched"], [{"interface": "eth0", "subnet": "10.7.7.0/28", "by": "arp"}])
        self.apply(found["sensors"][0]["reach"])
        self.assertEqual([s["how"] for s in self.find(DONE, "--subnet", "10.7.7.0/28")["sensors"]], ["answers"])

    def test_a_sensor_that_only_sends_is_heard(self):
        """To .1, and .2 answers ARP: this host takes neither."""
        self.address("10.9.9.9/24", "10.9.9.2/24")
        mac = self.hosts.mac(self.hosts.client)
        self.hosts.ip("-n", self.hosts.sensor, "neigh", "replace", "10.9.9.1", "lladdr", mac, "dev", "eth0")
        Process(self, self.folder, sys.executable, "-c", SENDER, "10.9.9.9", "10.9.9.1", "08000000" + "02" * 40,
                namespace=self.hosts.sensor)
        found = self.find(DONE)
        self.assertEqual([(s["sensor"], s["how"], s["reach"]) for s in found["sensors"]],
                         [("10.9.9.9", "sends", "ip addr add 10.9.9.3/24 dev eth0")])

    def test_where_no_address_is_known_to_be_free_none_is_proposed(self):
        self.address("10.9.9.99/24", *(f"10.9.9.{n}/24" for n in range(1, 17)))
        Process(self, self.folder, sys.executable, "-c", ARP, "eth0", "10.9.9.99", namespace=self.hosts.sensor)
        found = self.find(NO_ANSWER)
        self.assertEqual([(s["sensor"], s["how"], s["reach"]) for s in found["sensors"] if s["sensor"].startswith("10.9.")],
                         [("10.9.9.99", "arp", None)])
        r = self.check(NO_ANSWER, self.hosts.run("lumctl", "find"))
        self.assertIn("not reached from this host: give eth0 an address in 10.9.9.0/24 that no device has", r.stdout)

    def test_more_than_there_is_room_for_are_counted(self):
        """300 addresses answer ARP; a sensor that sends is among those that are shown all the same."""
        self.address("10.9.9.9/24")
        mac = self.hosts.mac(self.hosts.client)
        self.hosts.ip("-n", self.hosts.sensor, "neigh", "replace", "10.9.9.1", "lladdr", mac, "dev", "eth0")
        batch = self.folder / "addresses"
        batch.write_text("".join(f"addr add 10.7.{n >> 8}.{n & 255}/23 dev eth0\n" for n in range(1, 301)))
        self.hosts.ip("-n", self.hosts.sensor, "-batch", str(batch))
        p = subprocess.Popen([*inside(self.hosts.client), str(BIN / "lumctl"), "find", "--json", "--subnet", "10.7.0.0/23"],
                             stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(p.kill)
        Process(self, self.folder, sys.executable, "-c", SENDER, "10.9.9.9", "10.9.9.1", "08000000" + "02" * 40,
                namespace=self.hosts.sensor)
        out, err = p.communicate(timeout=PATIENCE_S)
        found = json.loads(out)
        self.assertEqual(p.returncode, DONE, err)
        self.assertEqual((len(found["sensors"]), found["complete"]), (256, False))
        self.assertIn("10.9.9.9", [s["sensor"] for s in found["sensors"] if s["how"] == "sends"])
        self.assertEqual(len(found["left_out"]), 1)
        self.assertRegex(found["left_out"][0], "^seen and not shown, beyond the 256 that there is room for: [1-9][0-9]* address")

    def test_one_address_on_two_interfaces(self):
        self.sensor("10.42.0.37")
        third = self.hosts.sensor + "2"
        self.addCleanup(subprocess.run, ["ip", "netns", "del", third], capture_output=True)
        self.hosts.ip("netns", "add", third)
        self.hosts.ip("link", "add", "eth1", "netns", self.hosts.client, "type", "veth", "peer", "name", "eth0", "netns", third)
        for name, device, address in ((self.hosts.client, "eth1", "10.42.0.2/24"), (third, "eth0", "10.42.0.37/24")):
            self.address(address, device=device, name=name)
            self.hosts.ip("-n", name, "link", "set", device, "up")
        Sensor(self, self.folder, address="10.42.0.37", namespace=third)
        r = self.check(DONE, self.hosts.run("lumctl", "find", *PATIENT))
        self.assertEqual([row.split()[:2] for row in r.stdout.splitlines()[1:]], [["10.42.0.37", "eth0"], ["10.42.0.37", "eth1"]])
        self.assertRegex(r.stderr, "10.42.0.37 is on eth[01] and on eth[01]: say --interface")

    def test_what_was_not_searched_is_said(self):
        self.second_wire()
        self.hosts.ip("-n", self.hosts.client, "addr", "add", "10.42.0.1/16", "dev", "eth1")
        left_out = self.find(NO_ANSWER, "--interface", "eth1", "--retries", 0)["left_out"]
        self.assertEqual(left_out, ["of 10.42.0.0/16 on eth1 only 10.42.0.0/22 was searched, around this host's own address; "
                                    "--subnet searches another part"])
        self.hosts.ip("-n", self.hosts.sensor, "link", "set", "eth1", "down")
        wait_until(lambda: "NO-CARRIER" in self.hosts.ip("-n", self.hosts.client, "link", "show", "eth1"), "no link")
        r = self.check(FAILED, self.hosts.run("lumctl", "find", "--interface", "eth1"))
        self.assertIn("eth1: no link, and not searched", r.stderr)
        self.hosts.ip("-n", self.hosts.client, "link", "set", "eth1", "down")
        r = self.check(FAILED, self.hosts.run("lumctl", "find", "--interface", "eth1"))
        self.assertIn("ip link set eth1 up", r.stderr)
        self.assertIn("nothing could be asked", r.stderr)

    @unittest.skipUnless(shutil.which("setpriv"), "setpriv is not installed")
    def test_without_rights_all_but_arp_works_and_that_is_said(self):
        self.second_wire()
        self.sensor("10.42.0.37")
        nobody = ["setpriv", "--reuid", "65534", "--clear-groups", "--inh-caps", "-all", "--bounding-set", "-all"]
        binary = self.folder / "lumctl"
        shutil.copy(BIN / "lumctl", binary)
        binary.chmod(0o755)
        self.folder.path.chmod(0o755)
        r = subprocess.run([*inside(self.hosts.client), *nobody, str(binary), "find", "--json", *map(str, PATIENT)],
                           capture_output=True, text=True, timeout=PATIENCE_S)
        self.check(DONE, r)
        found = json.loads(r.stdout)
        self.assertEqual([(s["sensor"], s["how"], s["mac"]) for s in found["sensors"]], [("10.42.0.37", "answers", None)])
        self.assertEqual(len(found["left_out"]), 1)
        self.assertRegex(found["left_out"][0], r"^eth1: no address .*sudo lumctl find$")


if __name__ == "__main__":
    shards.main()
