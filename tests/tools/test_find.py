#!/usr/bin/env python3
"""lumctl find: sensors at addresses that nobody remembers, on interfaces with a fitting address and without one, which takes raw
sockets. What it asks by UDP: tests/world/stories/find.c."""
import json
import subprocess
import sys
import unittest

import shards
from live import Hosts, Process, Sensor, inside, needs_namespaces, wait_until
from support import PATIENCE_S, Folder, run

DONE, FAILED, BAD, NO_ANSWER = range(4)

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

# A busy machine may hold up a sensor that is to be found.
PATIENT = ["--timeout", 1500]


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def check(self, status, r):
        self.assertEqual(r.returncode, status, (r.stdout, r.stderr))
        return r


class Arguments(Case):
    def test_arguments(self):
        for words, says in ((["--subnet", "10.0.0.0/21"], "wider than a /22"), (["--subnet", "10.0.0.0"], "not a subnet"),
                            (["--subnet", "10.0.0/24"], "not a subnet"), (["--subnet", "10.0.0.0/33"], "not a subnet"),
                            (["--interface", "nosuch"], "there is no interface nosuch"), (["--host", "10.42.0.37"], "--subnet says where"),
                            (["--dry-run"], "--dry-run"), (["all"], "'all'")):
            r = self.check(BAD, run("lumctl", "find", *words))
            self.assertEqual((r.stdout, r.stderr.count("\n")), ("", 1), words)
            self.assertIn(says, r.stderr)
        self.assertIn("it goes with find", self.check(BAD, run("lumctl", "status", "--subnet", "10.0.0.0/24")).stderr)


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
        r = subprocess.run([*inside(self.hosts.client), "sh", "-ec", command], capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual((r.returncode, r.stderr), (0, ""), command)

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
            self.assertIn(("two devices have this address: this sensor, and " + macs[1], "either may be an unreachable sensor")
                          [first], r.stdout)

    def test_a_named_subnet_is_asked_by_arp_where_no_address_fits(self):
        self.address("10.7.7.7/24")
        self.sensor("10.7.7.7")
        found = self.find(NO_ANSWER, "--interface", "eth0", "--subnet", "10.7.7.0/28")
        self.assertEqual([(s["sensor"], s["how"], s["reach"]) for s in found["sensors"]],
                         [("10.7.7.7", "arp", "ip addr add 10.7.7.1/24 dev eth0")])
        self.assertEqual(found["searched"], [{"interface": "eth0", "subnet": "10.7.7.0/28", "by": "arp"}])
        self.apply(found["sensors"][0]["reach"])
        self.assertEqual([s["how"] for s in self.find(DONE, "--subnet", "10.7.7.0/28")["sensors"]], ["answers"])

    def test_hundreds_of_devices_are_all_shown(self):
        """300 addresses answer ARP."""
        batch = self.folder / "addresses"
        batch.write_text("".join(f"addr add 10.7.{n >> 8}.{n & 255}/23 dev eth0\n" for n in range(1, 301)))
        self.hosts.ip("-n", self.hosts.sensor, "-batch", str(batch))
        found = self.find(NO_ANSWER, "--subnet", "10.7.0.0/23")
        self.assertEqual((len(found["sensors"]), found["complete"], found["left_out"]), (300, True, []))


if __name__ == "__main__":
    shards.main()
