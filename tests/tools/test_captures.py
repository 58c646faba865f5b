#!/usr/bin/env python3
"""Captures in every format, compressed, of mixed links, damaged and without an end, through lumdump."""
import bz2
import contextlib
import fcntl
import gzip
import io
import itertools
import json
import lzma
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import sys
import tarfile
import termios
import threading
import time
import unittest

import bag_maker
import mcap_maker
import shards
from support import (BIN, CLIENT, MAGIC, PATIENCE_S, SENSOR, Folder, block, frames_of, interface, line, packet, pcap, run,
                     section, simulate, summary, udp, word)

JUDGE = os.environ.get("LUM_JUDGE", "")
# In small blocks, so that what is cut gives something.
PACKERS = {".gz": gzip.compress, ".zst": lambda data: piped("zstd", data), ".lz4": lambda data: lz4_stored(data),
           ".bz2": lambda data: bz2.compress(data, 1)}
LZ4_BLOCK = 65536
LIMIT_KB = 64 * 1024


def line_frames(count=1):
    return [udp(p) for n in range(count) for p in line([word(2000, 1), word(3000, 2)], number=n, clock=1000 + n)]


def piped(program, data, *arguments):
    """None: it is not here."""
    return shutil.which(program) and subprocess.run([program, "-q", "-c", *arguments], input=data, stdout=subprocess.PIPE, check=True).stdout


def lz4_stored(data):
    """By lz4 where it is here; else a frame of blocks as they are."""
    packed = piped("lz4", data, "-B4")
    blocks = [data[at:at + LZ4_BLOCK] for at in range(0, len(data), LZ4_BLOCK)]
    return packed or b"\x04\x22\x4d\x18\x60\x40\x82" + b"".join(
        struct.pack("<I", len(b) | 1 << 31) + b for b in blocks) + bytes(4)


def turned(data):
    """A little-endian pcap file in the other byte order."""
    out, at = [struct.pack(">IHHIIII", *struct.unpack_from("<IHHIIII", data))], 24
    while at < len(data):
        head = struct.unpack_from("<IIII", data, at)
        out.append(struct.pack(">IIII", *head) + data[at + 16:at + 16 + head[2]])
        at += 16 + head[2]
    return b"".join(out)


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def points(self, source):
        r = run("lumdump", source, "-o", "-", "--format", "csv")
        self.assertEqual(r.returncode, 0, r.stderr)
        return r.stdout

    def compress(self, path, ending):
        """Beside it, or None where this build or this host cannot."""
        data = PACKERS[ending](path.read_bytes())
        if data is None:
            return None
        packed = path.with_name(path.name + ending)
        packed.write_bytes(data)
        r = run("lumdump", packed)
        return None if r.returncode != 0 and "this build has no" in r.stderr else packed

    def whole(self):
        return simulate(self.folder / "street.pcap", "--frames", "1", "--lines", "64", "--seed", "5", "--loss", "0.01")


class Formats(Case):
    def test_every_format_that_editcap_writes_gives_the_same_points(self):
        if shutil.which("editcap") is None:
            self.skipTest("no editcap")
        source = self.whole()
        expected = self.points(source)
        self.assertGreater(len(expected), 10000)
        for kind in "pcap", "nsecpcap", "modpcap", "pcapng":
            with self.subTest(kind):
                made = self.folder / f"made.{kind}"
                subprocess.run(["editcap", "-F", kind, source, made], check=True)
                self.assertEqual(self.points(made), expected)
                self.judge(made)
        self.assertEqual(self.points(self.folder.write("turned.pcap", turned(source.read_bytes()))), expected)
        self.judge(self.folder / "turned.pcap")

    def judge(self, path):
        """libpcap gives the same records, where the tests are built with it."""
        if JUDGE:
            r = subprocess.run([JUDGE, path], capture_output=True, text=True)
            self.assertEqual(r.returncode, 0, r.stderr)
            self.assertIn("to the end", r.stdout)

    def test_compressed_captures_are_read_in_place(self):
        source = self.whole()
        expected = self.points(source)
        for ending in PACKERS:
            packed = self.compress(source, ending)
            if packed is None:
                continue
            with self.subTest(ending):
                self.assertEqual(self.points(packed), expected)
                with open(packed, "rb") as f:
                    self.assertEqual(run("lumdump", "-", "-o", "-", "--format", "csv", stdin=f.read()).stdout, expected)
                # in two passes, too, which a header with the number of points takes
                r = run("lumdump", packed, "-o", "-", "--format", "ply")
                self.assertEqual(r.returncode, 0, r.stderr)

    def test_ethernet_beside_can(self):
        frames = line_frames(3)
        data = section() + interface(227) + interface(1) + interface(113)
        data += b"".join(packet(b"can frame", 0) + packet(f, 1) for f in frames) + packet(b"\0" * 16 + b"x", 2)
        got = summary(self.folder.write("car.pcapng", data))
        plain = summary(self.folder.write("plain.pcap", pcap(frames)))
        self.assertEqual(got["points"], plain["points"])
        self.assertEqual(got["other"], plain["other"] + len(frames) + 1)

    def test_ethernet_behind_packets_of_can(self):
        frames = line_frames(3)
        plain = summary(self.folder.write("plain.pcap", pcap(frames)))
        can = section() + interface(227) + packet(b"can frame") * 5
        behind = {
            "section": section() + interface() + b"".join(packet(f) for f in frames),
            "other-order": section(">") + interface(order=">") + b"".join(packet(f, order=">") for f in frames),
            "interface": interface() + b"".join(packet(f, 1) for f in frames),
        }
        for name, data in behind.items():
            with self.subTest(name):
                got = summary(self.folder.write(f"{name}.pcapng", can + data))
                self.assertEqual((got["points"], got["truncated"]), (plain["points"], False))
                self.assertEqual(got["other"], plain["other"] + 5)

    def test_nothing_but_can_is_refused(self):
        can = section() + interface(227) + packet(b"can frame") * 5 + section() + interface(105) + packet(b"wi-fi")
        source = self.folder.write("can.pcapng", can)
        whole = self.folder.write("whole.pcap", pcap(line_frames()))
        out = self.folder / "out.csv"
        cut = self.folder.write("cut.pcapng", can[:-20])
        for sources in [source], [source, whole], ["-"], [cut]:
            with self.subTest(sources):
                with open(source, "rb") as f:
                    r = run("lumdump", *sources, "-o", out, stdin=f.read())
                self.assertEqual((r.returncode, r.stdout), (1, ""))
                wanted = "cut short" if sources == [cut] else "link type 227 (CAN) is not supported; supported are Ethernet"
                self.assertIn(wanted, r.stderr)
                self.assertFalse(out.exists())

    def test_a_merged_capture_of_two_links(self):
        if shutil.which("mergecap") is None or shutil.which("text2pcap") is None:
            self.skipTest("no mergecap")
        source = self.whole()
        dump = self.folder.write("can.txt", "".join(f"000000 00 00 01 23 08 00 00 00 {i:02x} 02\n" for i in range(50)))
        subprocess.run(["text2pcap", "-q", "-l", "227", dump, self.folder / "can.pcap"], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        for first, second in ("street", "can"), ("can", "street"):
            made = self.folder / f"{first}-{second}.pcapng"
            subprocess.run(["mergecap", "-w", made, self.folder / f"{first}.pcap", self.folder / f"{second}.pcap"],
                           check=True)
            got, plain = summary(made), summary(source)
            self.assertEqual(got["points"], plain["points"])
            self.assertEqual(got["other"], plain["other"] + 50)

    def test_a_section_of_the_other_byte_order(self):
        frames = line_frames(2)
        half = len(frames) // 2
        data = section() + interface() + b"".join(packet(f) for f in frames[:half])
        data += section(">") + interface(order=">") + b"".join(packet(f, order=">") for f in frames[half:])
        got = summary(self.folder.write("both.pcapng", data))
        self.assertEqual((got["points"], got["truncated"]), (4, False))

    def test_ten_thousand_interfaces(self):
        data = section() + b"".join(interface(1 if i % 2 else 227) for i in range(10000))
        data += b"".join(packet(f, 9999) for f in line_frames())
        self.assertEqual(summary(self.folder.write("many.pcapng", data))["points"], 2)


class OneAddress(Case):
    """Sensors boot with one address: on two interfaces they are two sensors."""

    def drive(self, seed):
        return simulate(self.folder / f"{seed}.pcap", "--frames", 2, "--seed", seed)

    def merged(self, name, captures):
        """Captures by the name of their interface, as one file in order of time."""
        found = []
        for index, path in enumerate(captures.values()):
            data, at = path.read_bytes(), 24
            while at < len(data):
                seconds, fraction, length = struct.unpack_from("<III", data, at)
                ns = fraction if data[:4] == b"\x4d\x3c\xb2\xa1" else fraction * 1000
                found.append((seconds * 1_000_000 + ns // 1000, index, data[at + 16:at + 16 + length]))
                at += 16 + length
        blocks = [packet(frame, index, us) for us, index, frame in sorted(found)]
        return self.folder.write(name, section() + b"".join(interface(name=n) for n in captures) + b"".join(blocks))

    def alone(self, name, path):
        return summary(self.merged(f"alone-{path.name}.pcapng", {name: path}))["sensors"][0]

    def test_each_is_what_it_is_alone(self):
        odd = '\\Device\\NPF_{"1}'
        captures = {b"eth0": self.drive(4), odd.encode(): self.drive(3)}  # as they come
        source = self.merged("both.pcapng", captures)
        got = summary(source)["sensors"]
        self.assertEqual([(s.pop("address"), s.pop("interface"), s.pop("name")) for s in got],
                         [("10.42.0.37", "eth0", "10.42.0.37"), ("10.42.0.37", odd, f"10.42.0.37%{odd}")])
        for sensor, (name, path) in zip(got, captures.items()):
            alone = self.alone(name, path)
            del alone["address"]
            self.assertEqual(sensor, alone)

    def test_an_output_takes_the_one_that_is_asked_for(self):
        captures = {b"eth0": self.drive(4), b"eth1": self.drive(3)}  # as they come
        source, out = self.merged("both.pcapng", captures), self.folder / "out.csv"
        r = run("lumdump", source, "-o", out)
        self.assertEqual((r.returncode, out.exists()), (2, False))
        self.assertIn("choose one by --sensor: 10.42.0.37 10.42.0.37%eth1, and perhaps more\n", r.stderr)
        for asked, name in (("10.42.0.37", b"eth0"), ("10.42.0.37%eth0", b"eth0"), ("10.42.0.37%eth1", b"eth1")):
            alone = self.merged("alone.pcapng", {name: captures[name]})
            r = run("lumdump", source, "--sensor", asked, "-o", out, "-o", self.folder / "copy.pcap")
            self.assertEqual(r.returncode, 0, r.stderr)
            self.assertEqual(out.read_text(), self.points(alone))
            self.assertEqual(self.points(self.folder / "copy.pcap"), self.points(alone))
            self.assertEqual("name the other as 10.42.0.37%eth1 (--sensor" in r.stderr, "%" not in asked)
        r = run("lumdump", source, "--sensor", "10.42.0.37%eth2", "--json")
        self.assertEqual(r.returncode, 1)
        self.assertIn("no data of 10.42.0.37%eth2 in it, but of 10.42.0.37 10.42.0.37%eth1", r.stderr)

    def test_a_mirror_brings_repeats(self):
        path = self.drive(3)
        got = summary(self.merged("mirror.pcapng", {b"any": path, b"eth0": path}))
        plain = summary(path)
        self.assertEqual((got["points"], got["data"], got["duplicate"]), (plain["points"], 2 * plain["data"], plain["data"]))
        self.assertEqual([s.get("name") for s in got["sensors"]], [None])

    def test_files_that_name_their_interface_tell_them_apart(self):
        paths = [self.drive(4), self.drive(3)]
        named = [self.merged(f"{name}.pcapng", {name.encode(): path}) for name, path in zip(("eth0", "eth1"), paths)]
        self.assertEqual(summary(*named)["points"], sum(summary(path)["points"] for path in paths))
        r = run("lumdump", *paths, "--json")  # pcap names none: they are one, and it is told
        self.assertEqual(len(json.loads(r.stdout)["sensors"]), 1)
        self.assertIn("If two sensors have one address", r.stderr)


class Joined(Case):
    """Datagrams that a receiving host joined give what each on its own gives."""

    FAULTS = ("--frames", 2, "--seed", 5, "--loss", 0.02, "--reorder", 0.02, "--duplicate", 0.02, "--corrupt", 0.01)

    def drive(self, name, *arguments):
        return simulate(self.folder / name, *self.FAULTS, *arguments)

    def counts(self, *source):
        found = summary(*source)
        return {k: v for k, v in found.items() if isinstance(v, int) and k not in ("records", "joined")}

    def frames(self, path):
        return list(frames_of(path.read_bytes()))

    def check(self, source, alone):
        self.assertEqual(self.points(source), self.points(alone))
        self.assertEqual(self.counts(source), self.counts(alone))
        self.assertEqual(run("lumdump", source).stderr, run("lumdump", alone).stderr)
        self.assertGreater(summary(source)["joined"], 900)

    def test_of_every_capture(self):
        alone, joined = self.drive("alone.pcap"), self.drive("joined.pcap", "--joined")
        self.check(joined, alone)
        self.check(self.drive("joined.pcapng", "--joined"), alone)
        self.check(self.folder.write("made.mcap", mcap_maker.mcap(joined.read_bytes())), alone)
        found, records = summary(joined), len(self.frames(joined))
        self.assertEqual((found["records"], found["sources"][0]["records"]), (records, records))
        self.assertGreater(summary(alone)["records"], 2 * records)
        self.assertEqual(summary(alone)["joined"], 0)
        self.assertIn("of all packets: came joined, and were split", run("lumdump", joined).stdout)

    def test_that_came_in_fragments(self):
        alone, joined = self.drive("alone.pcap"), self.drive("joined.pcap", "--joined")
        parts = []
        for number, frame in enumerate(self.frames(joined)):
            body = frame[34:]
            for at in range(0, len(body), 1480):
                more = 0x2000 if at + 1480 < len(body) else 0
                head = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(body[at:at + 1480]), number % 65536,
                                   more | at // 8, 64, 17, 0)
                parts.append(frame[:14] + head + frame[26:34] + body[at:at + 1480])
        source = self.folder.write("parts.pcap", pcap(parts, step=0.00001))
        self.assertEqual(self.points(source), self.points(alone))

    def test_whose_copies_hold_each_on_its_own(self):
        alone, joined = self.drive("alone.pcap"), self.drive("joined.pcap", "--joined")
        for options in (), ("--eye", "green"), ("--frames", "2:2"):
            for ending in "pcap", "mcap":
                copies = []
                for source in joined, alone:
                    copies.append(self.folder / f"copy-{source.stem}.{ending}")
                    mcap = ("--mcap", "packets") if ending == "mcap" else ()
                    r = run("lumdump", source, "-q", *options, *mcap, "-o", copies[-1])
                    self.assertEqual(r.returncode, 0, r.stderr)
                with self.subTest(options=options, ending=ending):
                    self.assertEqual(summary(copies[0])["joined"], 0)
                    self.assertEqual(self.counts(copies[0]), self.counts(copies[1]))
                    self.assertEqual(self.points(copies[0]), self.points(copies[1]))
                    if ending == "pcap":
                        self.assertEqual(self.frames(copies[0]), self.frames(copies[1]))

    def test_that_end_behind_a_duration_count_no_record_too_many(self):
        joined = self.drive("joined.pcap", "--joined")
        times = list(mcap_maker.times_of(joined.read_bytes()))
        want = sum(t - times[0] <= 50_000_000 for t in times)
        self.assertEqual(summary(joined, "--duration", "0.05")["records"], want)

    def test_that_the_capture_holds_in_part_are_cut_short(self):
        joined = self.drive("joined.pcap", "--joined")
        frames = self.frames(joined)
        source = self.folder.write("cut.pcap", pcap(frames, snap=1514))
        found = summary(source)
        self.assertEqual(found["cut_short"], sum(len(f) > 1514 for f in frames))
        self.assertEqual(found["joined"], 0)

    def test_of_another_layout_are_found_by_infer(self):
        profile = self.folder.write("other.yaml", "version: 1\ngroup: {tag: 13, eye: 12, samples: 28}\n")
        made = [simulate(self.folder / f"{name}.pcap", "--frames", 3, "--profile", profile, *extra)
                for name, extra in (("alone", ()), ("joined", ("--joined",)))]
        alone, joined = (json.loads(run("lumdump", path, "--infer", "--json").stdout) for path in made)
        keys = [[s for s in found["profile"].splitlines() if "#" not in s] for found in (alone, joined)]
        self.assertEqual((keys[0], alone["joined"]), (keys[1], 0))
        self.assertEqual((joined["packets"], joined["fit"]), (alone["packets"], alone["fit"]))
        self.assertGreater(joined["joined"], joined["packets"] // 2)
        self.assertEqual(joined["records"], len(self.frames(made[1])))
        self.assertRegex(run("lumdump", made[1], "--infer").stderr,
                         rf"(?m)^joined +{joined['joined']} datagrams came joined, and were split$")


def ethernet(kind, inside):
    return bytes(12) + kind.to_bytes(2, "big") + inside


def ipv4(protocol, inside):
    return struct.pack(">BBHHHBBH8s", 0x45, 0, 20 + len(inside), 1, 0, 64, protocol, 0, bytes(8)) + inside


def ipv6(following, inside):
    return struct.pack(">IHBB32s", 6 << 28, len(inside), following, 64, bytes(32)) + inside


def to_port(port, inside):
    return struct.pack(">HHHH", 40000, port, 8 + len(inside), 0) + inside


def over_ip(protocol, inside):
    return ethernet(0x0800, ipv4(protocol, inside))


def gre(kind, inside, flags=0, more=b""):
    return over_ip(47, struct.pack(">HH", flags, kind) + more + inside)


# What mirror ports, switches and hosts make of a frame: its name, the bytes before the IPv4 packet, its link type, and how.
WRAPPINGS = (
    ("VXLAN", 64, 1, lambda f: over_ip(17, to_port(4789, b"\x08\0\0\0\0\0\x01\0" + f))),
    ("VXLAN", 64, 1, lambda f: over_ip(17, to_port(8472, b"\x08\0\0\0\0\0\x01\0" + f))),
    ("VXLAN", 66, 113, lambda f: bytes(14) + over_ip(17, to_port(4789, b"\x08" + bytes(7) + f))[12:]),
    ("IPv6, then VXLAN", 84, 1, lambda f: ethernet(0x86DD, ipv6(17, to_port(4789, b"\x08" + bytes(7) + f)))),
    ("Geneve", 72, 1, lambda f: over_ip(17, to_port(6081, b"\x02\0\x65\x58" + bytes(12) + f))),
    ("GRE", 38, 1, lambda f: gre(0x0800, f[14:])),
    ("GRE", 24, 101, lambda f: gre(0x0800, f[14:])[14:]),
    ("GRE", 56, 1, lambda f: gre(0x6558, f, 0x2000, bytes(4))),
    ("GRE, then MPLS", 42, 1, lambda f: gre(0x8847, b"\0\x01\x01\x40" + f[14:])),
    ("ERSPAN type I", 52, 1, lambda f: gre(0x88BE, f)),
    ("ERSPAN type II", 64, 1, lambda f: gre(0x88BE, bytes(8) + f, 0x1000, bytes(4))),
    ("ERSPAN type III", 68, 1, lambda f: gre(0x22EB, bytes(12) + f, 0x1000, bytes(4))),
    ("ERSPAN type III", 76, 1, lambda f: gre(0x22EB, bytes(11) + b"\x01" + bytes(8) + f, 0x1000, bytes(4))),
    ("MPLS", 22, 1, lambda f: ethernet(0x8847, b"\0\x01\0\x40\0\x02\x01\x40" + f[14:])),
    ("MPLS", 36, 1, lambda f: ethernet(0x8847, b"\0\x02\x01\x40" + bytes(4) + f)),
    ("PPPoE", 22, 1, lambda f: ethernet(0x8864, struct.pack(">HHHH", 0x1100, 7, len(f) - 12, 0x21) + f[14:])),
    ("IPv4", 34, 1, lambda f: over_ip(4, f[14:])),
    ("IPv6", 54, 1, lambda f: ethernet(0x86DD, ipv6(4, f[14:]))),
    ("IPv6", 62, 1, lambda f: ethernet(0x86DD, ipv6(60, b"\x04" + bytes(7) + f[14:]))),
    ("LLC/SNAP", 22, 1, lambda f: ethernet(500, b"\xaa\xaa\x03\0\0\0" + f[12:])),
    ("tags of a switch (DSA)", 18, 1, lambda f: f[:12] + b"\xc0\x02\0\0" + f[12:]),
    ("tags of a switch (DSA)", 22, 1, lambda f: f[:12] + b"\xda\xda\0\0\xc0\x02\0\0" + f[12:]),
    ("a header that is not known", 20, 1, lambda f: ethernet(0x892F, bytes(6) + f[14:])),
    ("pktap", 122, 258, lambda f: bytes(108) + f),
)


class Wrapped(Case):
    """Packets of a G2 that are not read as they stand: the command that strips what they stand in is named, and works."""

    def test_each_comes_with_the_command_that_strips_it(self):
        frames = line_frames(3)
        expected = self.points(self.folder.write("plain.pcap", pcap(frames)))
        for i, (name, bytes_before, link, wrap) in enumerate(WRAPPINGS):
            with self.subTest(name, bytes_before=bytes_before):
                source = self.folder.write(f"{i}.pcap", pcap([wrap(f) for f in frames], link=link))
                said = run("lumdump", source).stderr
                options = f"-C {bytes_before} -L{'' if link == 101 else ' -T rawip4'}"
                self.assertIn(f"strip them by editcap {options} IN OUT", said)
                if link > 200:
                    self.assertIn(f"({name}) is not supported", said)
                else:
                    self.assertIn(f"{len(frames)} packets of a G2 came wrapped in {bytes_before} bytes of other headers,", said)
                if shutil.which("editcap") is not None:
                    made = self.folder / f"{i}-stripped.pcap"
                    subprocess.run(["editcap", *options.split(), source, made], check=True)
                    self.assertEqual(self.points(made), expected)

    def test_each_cut_of_them_does_no_harm(self):
        frame = line_frames()[3]
        for name, _, link, wrap in WRAPPINGS:
            with self.subTest(name):
                whole = wrap(frame)
                cuts = [pcap([whole], link=link, snap=n)[24:] for n in range(140)]
                r = run("lumdump", self.folder.write("cuts.pcap", pcap([], link=link) + b"".join(cuts)))
                self.assertIn(r.returncode, (0, 1), r.stderr)  # 1: no link type that is read
                self.assertNotIn("Sanitizer", r.stderr)

    def test_those_of_others_are_not_named(self):
        others = [gre(0x0800, udp(b"not of a G2")[14:])]
        frames = line_frames()
        self.assertNotIn("wrapped", run("lumdump", self.folder.write("others.pcap", pcap(others + frames))).stderr)
        mixed = run("lumdump", self.folder.write("mixed.pcap", pcap([gre(0x88BE, frames[0]), *frames]))).stderr
        self.assertIn("1 packet of a G2 came wrapped in 52 bytes of other headers,", mixed)
        self.assertIn("IN OUT, but from these packets alone, since others of a G2 are not wrapped in it: first put these", mixed)

    def test_what_no_command_strips_says_how_to_record(self):
        tagged = [f[:12] + b"\xc0\x02\0\0" + f[12:] for f in line_frames()]
        said = run("lumdump", self.folder.write("other.pcap", pcap(tagged, link=284))).stderr
        self.assertIn("(tags of a Marvell switch (DSA)) is not supported", said)
        self.assertIn("packets of a G2 are in it: record at a port of the switch, such as lan1", said)
        self.assertNotIn("editcap", said)


class Port(Case):
    """NAT may have changed the sensors' port."""

    def test_it_is_named_and_can_be_chosen(self):
        packets = [p for n in range(40) for p in line([word(2000, 1)] * 20, number=n, clock=1000 + 1000 * n)]
        requests = [udp(MAGIC + b"\x08\0\0\0", source=CLIENT, destination=SENSOR, sport=50000, dport=port) for port in (5517, 5600)]
        expected = self.points(self.folder.write("plain.pcap", pcap([udp(p) for p in packets])))
        for beside in [], [requests[0]], [requests[1]]:
            source = self.folder.write("nat.pcap", pcap([udp(p, sport=5600) for p in packets] + beside))
            said = run("lumdump", source).stderr
            self.assertIn(f"{len(packets)} packets of a G2 came from UDP port 5600, but only port 5517 is read", said)
            self.assertIn("lumdump --port 5600", said)
        r = run("lumdump", source, "--port", "5600", "-o", "-", "--format", "csv")
        self.assertEqual(r.stdout, expected)
        self.assertNotIn("warning", r.stderr)
        got = summary(source, "--port", "5600")
        self.assertEqual((got["heartbeat"], got["other"], len(got["sensors"])), (1, 0, 1))
        copy = self.folder / "copy.pcap"
        self.assertEqual(run("lumdump", source, "--port", "5600", "-q", "-o", copy).returncode, 0)
        self.assertEqual(self.points(copy), expected)
        self.assertEqual(summary(copy)["heartbeat"], 1)
        said = run("lumdump", copy, "--port", "7000").stderr
        self.assertIn("to or from UDP port 7000", said)
        self.assertIn("came from UDP port 5517", said)

    def test_a_part_that_is_behind_another_port_is_told(self):
        packets = [p for n in range(40) for p in line([word(2000, 1)] * 20, number=n, clock=1000 + 1000 * n)]
        plain = [udp(p) for p in packets]
        second = [udp(p, source="10.42.0.38", sport=5600) for p in packets]
        third = [udp(p, source="10.42.0.39", sport=5700) for p in packets[:3]]
        part = [udp(p, sport=5600) for p in packets[::10]]
        for extra, told in ((second, f"{len(second)} packets of a G2 came from UDP port 5600,"), (part, "16 packets of a G2"),
                            (second + third, f"{len(second)} packets of a G2 came from UDP port 5600, and 3 from others,")):
            said = run("lumdump", self.folder.write("two.pcap", pcap(plain + extra))).stderr
            self.assertIn(told, said)
            self.assertIn("but only port 5517 is read: a device on the way has changed the port (NAT); read them with lumdump --port 5600", said)

    def test_other_ports_of_what_is_read_are_not_told(self):
        packets = list(line([word(2000, 1)] * 20))
        heartbeat, command = MAGIC + b"\x08\0\0\0", MAGIC + b"\x07\0\0\0" + bytes(20)
        frames = [udp(p, dport=20000 + i) for i in range(200) for p in packets]
        frames += [udp(p, sport=5600, dport=5517) for p in packets]
        for a, b in ((50000, 5517), (5517, 50001), (50002, 5600), (5600, 50002)):
            frames += [udp(p, sport=a, dport=b) for p in (heartbeat, command)]
        self.assertNotIn("NAT", run("lumdump", self.folder.write("ports.pcap", pcap(frames))).stderr)
        frames += [udp(p, sport=5601) for p in packets]  # still seen
        self.assertIn("from UDP port 5601,", run("lumdump", self.folder.write("ports.pcap", pcap(frames))).stderr)

    def test_what_is_read_of_a_port_with_many_others_is_not_told(self):
        packets = list(line([word(2000, 1)] * 20))
        frames = [udp(p, sport=5600, dport=20000 + i) for i in range(5) for p in packets] + [udp(p, sport=5600, dport=5517) for p in packets]
        said = run("lumdump", self.folder.write("ports.pcap", pcap(frames))).stderr
        self.assertIn(f"{5 * len(packets)} packets of a G2 came from UDP port 5600,", said)

    def test_the_layout_is_found_there(self):
        plain = simulate(self.folder / "plain.pcap", "--frames", "2", "--lines", "64", "--seed", "3").read_bytes()
        made = self.folder.write("nat.pcap", plain.replace(b"\x15\x8d", b"\x15\xe0"))
        r = run("lumdump", made, "--infer")
        self.assertEqual(r.returncode, 1)
        self.assertIn("lumdump --port 5600", r.stderr)
        r = run("lumdump", made, "--infer", "--port", "5600")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertNotIn("warning", r.stderr)

    def test_it_is_no_option_of_a_sensor(self):
        r = run("lumdump", "udp://127.0.0.1", "--port", "5600")
        self.assertEqual(r.returncode, 2)
        self.assertIn("udp://ADDRESS:PORT", r.stderr)


class Begun(Case):
    """A recording that was just begun has no packet; beside others it is told, and they are read."""

    def test_beside_others_it_is_a_warning(self):
        frames = line_frames(3)
        first = self.folder.write("r-1.pcap", pcap(frames))
        expected = self.points(first)
        head = pcap([])
        for name, data, said in (
                ("r-2.pcap", b"", "is empty"),
                ("r-2.pcap.gz", gzip.compress(b""), "is empty"),
                ("r-2.pcap", head[:10], "it ends within its headers (byte 0: a file header is cut short: 10 of its 24 bytes"),
                ("r-2.pcapng", section(), "it ends within its headers (it describes no interface"),
                ("r-2.pcapng", (section() + interface())[:40], "it ends within its headers (byte 28: a block is cut short")):
            with self.subTest(said, name=name):
                second = self.folder.write(name, data)
                alone = run("lumdump", second)
                self.assertEqual(alone.returncode, 1)
                self.assertIn(said, alone.stderr)
                for order in (first, second), (second, first):
                    r = run("lumdump", *order, "-o", "-", "--format", "csv")
                    self.assertEqual((r.returncode, r.stdout), (0, expected))
                    self.assertRegex(r.stderr, f"warning: {second}: .*{re.escape(said)}")
                    got = summary(*order)
                    self.assertTrue(got["truncated"])
                    self.assertEqual({s["name"]: s["end"] for s in got["sources"]}, {str(first): "whole", str(second): "broken off"})
                both = run("lumdump", second, self.folder.write("r-3.pcap", b""))
                self.assertEqual(both.returncode, 1)
                self.assertIn(said, both.stderr)

    def test_what_is_no_capture_still_ends_the_run(self):
        first = self.folder.write("r-1.pcap", pcap(line_frames()))
        for data in b"abc", b"x,y,z\n" * 10:
            self.assertEqual(run("lumdump", first, self.folder.write("other.pcap", data)).returncode, 1)


class Packed(Case):
    def test_what_is_not_unpacked_here_is_named_with_its_command(self):
        inside = self.folder.write("inside.pcap", pcap(line_frames()))
        archive, tar = io.BytesIO(), io.BytesIO()
        for out, mode in (archive, "w:gz"), (tar, "w"):
            with tarfile.open(fileobj=out, mode=mode) as made:
                made.add(inside, "drive.pcap")
        for name, data, command in (
                ("drive.tar.gz", archive.getvalue(), "tar -xf"), ("drive.tar", tar.getvalue(), "tar -xf"),
                ("drive.pcap.lzma", lzma.compress(inside.read_bytes(), lzma.FORMAT_ALONE), "xz -dc --format=lzma"),
                ("drive.pcap.xz", lzma.compress(inside.read_bytes()), "xz -dc"),
                ("drive.7z", b"7z\xbc\xaf\x27\x1c" + bytes(60), "7z e")):
            with self.subTest(name):
                r = run("lumdump", self.folder.write(name, data))
                self.assertEqual(r.returncode, 1)
                self.assertIn(command, r.stderr)


class Order(Case):
    """Records that stand out of order by their times lose packets as late; nothing else may look like it."""

    def records(self, *arguments):
        """Of a simulated capture: time in ns, and the frame."""
        path = simulate(self.folder / "order.pcap", "--frames", "3", "--lines", "64", "--seed", "7", *arguments)
        data = path.read_bytes()
        at = 24
        while at < len(data):
            s, ns, length = struct.unpack_from("<III", data, at)
            yield s * 1_000_000_000 + ns, data[at + 16:at + 16 + length]
            at += 16 + length

    def write(self, records):
        head = struct.pack("<IHHiIII", 0xA1B23C4D, 2, 4, 0, 0, 65535, 1)
        return self.folder.write("made.pcap", head + b"".join(
            struct.pack("<IIII", t // 1_000_000_000, t % 1_000_000_000, len(f), len(f)) + f for t, f in records))

    def queues(self, records, count, batch):
        """As a card with so many queues hands them out, so many of each at a time."""
        for i in range(0, len(records), count * batch):
            part = records[i:i + count * batch]
            yield from (r for q in range(count) for r in part[q::count])

    def test_it_is_told_with_the_command_that_sorts(self):
        records = list(self.records())
        expected = self.points(self.write(records))
        for count, batch in (4, 32), (2, 100), (8, 60), (2, 2000):
            with self.subTest(queues=count, batch=batch):
                path = self.write(self.queues(records, count, batch))
                got = summary(path)
                self.assertGreater(got["out_of_order"], 0.9 * (got["late"] + got["stray"]))
                said = run("lumdump", path).stderr
                self.assertEqual(said.count("reordercap IN OUT"), 1)
                self.assertIn(f"{got['out_of_order']} packets are too far out of order in the capture", said)
                if shutil.which("reordercap") is not None:
                    made = self.folder / "sorted.pcap"
                    subprocess.run(["reordercap", path, made], check=True, capture_output=True)
                    self.assertEqual(self.points(made), expected)
                    self.assertNotIn("reordercap", run("lumdump", made).stderr)

    def test_nothing_else_is_taken_for_it(self):
        rough = list(self.records("--loss", "0.02", "--reorder", "0.05", "--duplicate", "0.02"))
        shaken = list(self.records("--reorder", "0.2"))
        middle = rough[len(rough) // 2][0]
        for name, records in (
                ("network", rough),
                ("step", [(t - 1_000_000_000 * (t > middle), f) for t, f in rough]),
                ("one early", [shaken[-10], *shaken[:-10], *shaken[-9:]]),
                ("small step", [(t - 3_000_000 * (t > middle), f) for t, f in rough]),
                ("jitter", [(t + 40_000 * (i * 7 % 11), f) for i, (t, f) in enumerate(shaken)]),
                ("coarse", [(t // 10_000_000 * 10_000_000, f) for t, f in rough])):
            with self.subTest(name):
                path = self.write(records)
                self.assertLess(summary(path)["out_of_order"], 3)
                self.assertNotIn("reordercap", run("lumdump", path).stderr)


class Damage(Case):
    def warned(self, data, *parts):
        """The points before the damage are given, and the damage is told."""
        source = self.folder.write("damaged.pcapng", data)
        r = run("lumdump", source, "-o", "-", "--format", "csv")
        self.assertEqual(r.returncode, 0, r.stderr)
        for part in ("cannot be read beyond record", *parts):
            self.assertIn(part, r.stderr)
        return r.stdout.count("\n") - 1

    def test_blocks_of_impossible_lengths(self):
        data = section() + interface() + b"".join(packet(f) for f in line_frames())
        for length in 0, 3, 0xFFFFFFFF, 0xFFFFFFFC:
            for kind in 6, 0xBAD:
                with self.subTest(kind=kind, length=length):
                    bad = struct.pack("<II", kind, length) + bytes(40)
                    self.assertEqual(self.warned(data + bad, f"byte {len(data)}:"), 2)

    def test_a_compressed_capture_that_was_cut(self):
        source = self.whole()
        expected = self.points(source)
        for ending in PACKERS:
            packed = self.compress(source, ending)
            if packed is None:
                continue
            data = packed.read_bytes()
            with self.subTest(ending):
                cut = self.folder.write("cut" + ending, data[:len(data) // 2])
                r = run("lumdump", cut, "-o", "-", "--format", "csv")
                self.assertEqual(r.returncode, 0, r.stderr)
                self.assertIn(f"cut short at byte {len(data) // 2} of the compressed file", r.stderr)
                rows = r.stdout.splitlines()
                self.assertGreater(len(rows), len(expected.splitlines()) // 4)
                self.assertLess(len(rows), len(expected.splitlines()))

    def test_compressed_garbage(self):
        for name, start in (("x.gz", b"\x1f\x8b\x08\0"), ("x.zst", b"\x28\xb5\x2f\xfd"), ("x.lz4", b"\x04\x22\x4d\x18"), ("x.bz2", b"BZh9")):
            for rest in b"", b"garbage" * 100, bytes(5000):
                with self.subTest(name, rest=len(rest)):
                    source = self.folder.write(name, start + rest)
                    r = run("lumdump", source, "-o", self.folder / "out.csv")
                    self.assertEqual((r.returncode, r.stdout), (1, ""))
                    self.assertIn(name, r.stderr)
                    self.assertIn("a pcap, pcapng, MCAP or bag file is expected", r.stderr)
                    self.assertFalse((self.folder / "out.csv").exists())

    def test_a_compressed_file_of_something_else(self):
        source = self.folder.write("x.gz", gzip.compress(b"x,y,z\n" * 1000))
        r = run("lumdump", source)
        self.assertEqual(r.returncode, 1)
        self.assertIn("a pcap, pcapng, MCAP or bag file is expected", r.stderr)


class DamagedParts(Case):
    """What cannot be read is passed over, counted and told, and the rest gives what it gives."""

    def check(self, made, whole, damaged, why, lost):
        got, before = summary(made), summary(whole)
        self.assertEqual((got["damaged"], got["truncated"], before["damaged"]), (damaged, False, 0))
        self.assertEqual(sum(s["damaged"] for s in got["sources"]), damaged)
        self.assertEqual({s["end"] for s in got["sources"]}, {"whole"})
        self.assertEqual(before["records"] - got["records"], lost)
        r = run("lumdump", made)
        self.assertEqual(r.returncode, 0)
        self.assertRegex(r.stderr, f"lumdump: warning: .*{made.name}: {damaged} parts? of it could not be read and (was|were) passed "
                                   f"over.* byte [0-9]+: .*{why}")
        self.assertRegex(r.stdout, f"(losses    |   ) +{damaged}  damaged +parts of the capture that could not be read")
        found = run("lumdump", made, "--infer", "--json")
        self.assertEqual(json.loads(found.stdout)["damaged"], damaged)
        self.assertIn("passed over", found.stderr)
        self.assertEqual(run("lumdump", made, "-q", "-o", self.folder / "x.csv").stderr, "")

    def test_an_mcap_file(self):
        source = self.whole()
        data = bytearray(mcap_maker.mcap(source.read_bytes(), size=30_000))
        chunks, at = [], 8
        while at < len(data) - 8:
            if data[at] == 6:
                chunks.append(at)
            at += 9 + struct.unpack_from("<Q", data, at + 1)[0]
        middle = chunks[len(chunks) // 2]
        lost = data[middle:middle + 9 + struct.unpack_from("<Q", data, middle + 1)[0]].count(b"\x25\x8d\x15")
        self.assertGreater(len(chunks), 5)
        data[middle + 2000] ^= 1
        self.check(self.folder.write("damaged.mcap", data), source, 1, "its check sum is wrong", lost)
        data[chunks[-1] + 2000] ^= 1
        self.assertEqual(summary(self.folder.write("damaged.mcap", data))["damaged"], 2)

    def test_a_pcapng_file(self):
        frames = [f for n in range(3) for f in line_frames(10)]
        blocks = [section(), interface()] + [packet(f) for f in frames]
        whole = self.folder.write("whole.pcapng", b"".join(blocks))
        for k in (5, 9):
            head = bytearray(blocks[k])
            struct.pack_into("<I", head, 20, len(head))
            blocks[k] = bytes(head)
        made = self.folder.write("damaged.pcapng", b"".join(blocks))
        self.check(made, whole, 2, "a packet of", 2)
        both = summary(made, self.folder.write("other.pcapng", made.read_bytes()))
        self.assertEqual([s["damaged"] for s in both["sources"]], [2, 2])
        self.assertIn("2 parts of it, and 2 of the other captures could not be read", run("lumdump", made, self.folder / "other.pcapng").stderr)

    def test_nothing_that_can_be_read_is_refused(self):
        """In every format alike."""
        source = self.whole()
        mcap = mcap_maker.mcap(source.read_bytes(), size=30_000)
        described = mcap_maker.channel(mcap_maker.PACKETS, mcap_maker.SCHEMA)
        spoilt = bytearray(mcap)
        for at in (m.start() for m in re.finditer(b"\x25\x8d\x15", mcap)):
            spoilt[at] ^= 1  # each datagram's port
        frames = [bytearray(packet(f)) for f in line_frames(4)]
        for frame in frames:
            struct.pack_into("<I", frame, 20, len(frame))
        spoil = {"compression": b"bz2", "pack": lambda content: bz2.compress(content)[:-9], "chunk_size": 30_000}
        bag = bag_maker.bag(source.read_bytes(), **spoil)
        for name, data in (("a.mcap", bytes(spoilt)), ("b.mcap", bytes(spoilt[:8]) + described + bytes(spoilt[8:])),
                           ("c.pcapng", section() + interface() + b"".join(frames)), ("d.bag", bag),
                           ("e.bag", bag[:-2]), ("f.mcap", bytes(spoilt[:-30]))):
            with self.subTest(name):
                made = self.folder.write(name, data)
                r = run("lumdump", made, "--json")
                if "this build has no libbz2" in r.stderr:
                    continue
                self.assertEqual(r.returncode, 1, r.stderr)
                self.assertRegex(r.stderr, f"{name}: nothing of it can be read: byte [0-9]+: a (chunk|packet) ")
                r = run("lumdump", made, source, "-q", "-o", self.folder / "x.csv")
                self.assertEqual(r.returncode, 1, r.stderr)

    def test_a_bag_whose_chunk_has_another_length_than_it_says(self):
        source = self.whole()
        for keep in 0, -1:
            count = itertools.count()
            bag = bag_maker.bag(source.read_bytes(), chunk_size=30_000,
                                pack=lambda content: bytes(content)[:0 if keep == 0 else self.last_record(content)] if next(count) == 3 else content)
            made = self.folder.write("short.bag", bag)
            r = run("lumdump", made, "--json")
            self.assertEqual((r.returncode, json.loads(r.stdout)["damaged"]), (0, 1))
            self.assertRegex(r.stderr, "an uncompressed chunk of [0-9]+ bytes has [0-9]+")
            self.assertGreater(json.loads(r.stdout)["records"], summary(source)["records"] * 3 // 4)

    def last_record(self, content):
        at, before = 0, 0
        while at < len(content):
            header, = struct.unpack_from("<I", content, at)
            before, at = at, at + 8 + header + struct.unpack_from("<I", content, at + 4 + header)[0]
        return before

    def test_a_bag(self):
        source = self.whole()
        data = bag_maker.bag(source.read_bytes(), chunk_size=30_000)
        at = data.index(b"op=\x05", len(data) // 2) + 8  # its first record
        made = self.folder.write("damaged.bag", data[:at] + b"\xff\xff\xff\x7f" + data[at + 4:])
        r = run("lumdump", made, "--json")
        self.assertEqual((r.returncode, json.loads(r.stdout)["damaged"]), (0, 1))
        self.assertIn("of a chunk is longer than the rest of the chunk", r.stderr)
        self.assertGreater(json.loads(r.stdout)["records"], summary(source)["records"] * 3 // 4)


class Bag(Case):
    """A bag with the packets of a capture gives its points."""

    def test_the_same_points_from_a_file_and_from_a_pipe(self):
        source = self.whole()
        made = self.folder.write("made.bag", bag_maker.bag(source.read_bytes()))
        expected = self.points(source)
        self.assertGreater(len(expected), 10000)
        self.assertEqual(self.points(made), expected)
        r = run("lumdump", "-", "-o", "-", "--format", "csv", stdin=made.read_bytes())
        self.assertEqual((r.returncode, r.stdout), (0, expected))
        for key in "records", "points", "other", "data":
            self.assertEqual(summary(made).get(key), summary(source).get(key))

    def test_a_bag_that_breaks_off_gives_what_came_before(self):
        data = bag_maker.bag(self.whole().read_bytes())
        r = run("lumdump", self.folder.write("cut.bag", data[:len(data) // 2]), "--json")
        self.assertIn("a record is cut short", r.stderr)
        self.assertGreater(json.loads(r.stdout)["points"], 1000)

    def check_packed(self, compression, pack):
        source = self.whole()
        made = self.folder.write("packed.bag", bag_maker.bag(source.read_bytes(), compression, pack))
        r = run("lumdump", made, "-o", "-", "--format", "csv")
        if "this build has no" in r.stderr:
            self.assertEqual((r.returncode, r.stdout), (1, ""))
            self.assertIn(f"a chunk is compressed by {compression.decode()}, and this build has no lib{compression.decode()}: "
                          "rosbag decompress makes a readable file", r.stderr)
        else:
            self.assertEqual(r.stdout, self.points(source))
            self.assertEqual(run("lumdump", "-", "-o", "-", "--format", "csv", stdin=made.read_bytes()).stdout, r.stdout)

    def test_chunks_by_lz4(self):
        self.check_packed(b"lz4", lz4_stored)

    def test_chunks_by_bz2(self):
        self.check_packed(b"bz2", bz2.compress)

    def test_what_is_not_read_is_told(self):
        for name, data, says in (
                ("a.bag", bag_maker.bag(self.whole().read_bytes(), b"xz"), "a chunk is compressed by xz, which is not supported"),
                ("b.bag", b"#ROSBAG V2.0\n", "it has no messages of lumsdk_ros/Packets"),
                ("c.bag", b"#ROSBAG V1.2\n" + bytes(100), "a pcap, pcapng, MCAP or bag file is expected")):
            r = run("lumdump", self.folder.write(name, data))
            self.assertEqual(r.returncode, 1)
            self.assertIn(says, r.stderr)


class Mcap(Case):
    """An MCAP file with the datagrams of a capture gives its points."""

    def made(self, source, *arguments, **options):
        return self.folder.write("made.mcap", mcap_maker.mcap(source.read_bytes(), *arguments, **options))

    def check(self, made, expected):
        self.assertEqual(self.points(made), expected)
        r = run("lumdump", "-", "-o", "-", "--format", "csv", stdin=made.read_bytes())
        self.assertEqual((r.returncode, r.stdout), (0, expected))

    def test_the_same_points_from_a_file_and_from_a_pipe(self):
        source = self.whole()
        made = self.made(source)
        expected = self.points(source)
        self.assertGreater(len(expected), 10000)
        self.check(made, expected)
        for key in "records", "points", "other", "data_packets":
            self.assertEqual(summary(made).get(key), summary(source).get(key))
        for ending in PACKERS:
            packed = self.compress(made, ending)
            if packed is not None:
                self.assertEqual(self.points(packed), expected)

    def check_packed(self, compression, pack):
        source = self.whole()
        made = self.made(source, compression, pack)
        r = run("lumdump", made)
        if r.returncode == 0:
            self.check(made, self.points(source))
        else:
            self.assertRegex(r.stderr, f"a chunk is compressed by {compression}, and this build has no lib{compression}: mcap "
                                       "(de)?compress makes a readable file")

    @unittest.skipIf(shutil.which("zstd") is None, "no zstd")
    def test_chunks_by_zstd(self):
        self.check_packed("zstd", PACKERS[".zst"])

    def test_chunks_by_lz4(self):
        self.check_packed("lz4", lz4_stored)

    def test_a_chunk_larger_than_the_window(self):
        source = self.whole()
        many = source.read_bytes()[:24] + source.read_bytes()[24:] * (1 + 40_000_000 // source.stat().st_size)
        whole = self.folder.write("many.pcap", many)
        made = self.made(whole, size=60_000_000)
        self.assertGreater(made.stat().st_size, 33_554_432)
        self.assertEqual(summary(made)["points"], summary(whole)["points"])

    def test_a_capture_and_an_mcap_file_are_one_stream(self):
        source = self.whole()
        both = summary(self.made(source), source)
        self.assertEqual(both["records"], 2 * summary(source)["records"])

    def test_a_cut_one_gives_its_whole_chunks(self):
        source = self.whole()
        made = self.made(source, size=100_000)
        data = made.read_bytes()
        made.write_bytes(data[:len(data) // 2])
        r = run("lumdump", made, "-o", "-", "--format", "csv")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertIn("a chunk is cut short", r.stderr)
        self.assertGreater(len(r.stdout.splitlines()), 1000)

    def test_what_it_has_instead_of_packets_is_said(self):
        source = self.whole()
        r = run("lumdump", self.made(source, schema="std_msgs/msg/String"))
        self.assertEqual((r.returncode, r.stdout), (1, ""))
        self.assertIn("it has no packets of a sensor, only messages such as sensor_msgs/msg/PointCloud2; "
                      "clouds cannot be decoded again", r.stderr)

    def test_one_fix_is_told(self):
        """And what stands in the middle of the file is not taken for its begin."""
        large = mcap_maker.chunk(b"", "zstd", lambda _: b"\x28\xb5\x2f\xfd" + bytes(100))
        made = bytearray(mcap_maker.MAGIC + mcap_maker.record(1, bytes(8)) + large)
        struct.pack_into("<Q", made, len(made) - len(large) + 25, 70 << 20)
        r = run("lumdump", self.folder.write("large.mcap", made + mcap_maker.record(2, bytes(20)) + mcap_maker.MAGIC))
        self.assertEqual((r.returncode, r.stdout), (1, ""))
        self.assertIn("a chunk of 73400320 bytes; at most 67108864 can be read: mcap ", r.stderr)
        self.assertIn("compress makes a readable file", r.stderr)
        self.assertNotIn("libzstd", r.stderr)


@unittest.skipUnless(sys.platform == "linux", "memory and pipes are looked at as Linux shows them")
class Endless(Case):
    """A pipe that never ends takes no memory, and leaves at a signal."""

    def feed(self, p, head, again):
        """Writes until the reader has gone; tells by the event when 64 MB went through."""
        self.enough = threading.Event()

        def write():
            written = 0
            chunk = again * (1 + 1_000_000 // len(again))
            try:
                p.stdin.write(head)
                while True:
                    p.stdin.write(chunk)
                    written += len(chunk)
                    if written > 64_000_000:
                        self.enough.set()
            except OSError:
                self.enough.set()

        thread = threading.Thread(target=write, daemon=True)
        thread.start()
        return thread

    def ends(self, head, again):
        with subprocess.Popen([BIN / "lumdump", "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE) as p:
            thread = self.feed(p, head, again)
            self.assertTrue(self.enough.wait(PATIENCE_S))
            peak = pathlib.Path(f"/proc/{p.pid}/status").read_text().split("VmHWM:")[1].split()[0]
            p.send_signal(signal.SIGINT)
            p.stdout.read()
            p.stderr.read()
            p.wait(PATIENCE_S)
            thread.join(300)
            # What it still holds has no reader any more.
            with contextlib.suppress(BrokenPipeError):
                p.stdin.close()
            self.assertEqual(p.returncode, -signal.SIGINT)
            self.assertLess(int(peak), LIMIT_KB)

    def test_of_packets(self):
        self.ends(pcap([]), pcap(line_frames())[24:])

    def test_of_blocks_that_nobody_knows(self):
        self.ends(section() + interface(), block(0xBAD, bytes(1000)))

    def test_of_a_block_that_nobody_knows(self):
        self.ends(section() + interface() + struct.pack("<II", 0xBAD, 0xFFFFFFF0), bytes(1000))

    def test_a_silent_pipe_leaves_at_a_signal(self):
        with subprocess.Popen([BIN / "lumdump", "-"], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE) as p:
            p.stdin.write(pcap(line_frames()))
            p.stdin.flush()
            while struct.unpack("i", fcntl.ioctl(p.stdin, termios.FIONREAD, bytes(4)))[0] != 0:
                time.sleep(0.01)
            # once more where the first one came just before it began to wait
            while p.poll() is None:
                p.send_signal(signal.SIGINT)
                try:
                    p.wait(2)
                except subprocess.TimeoutExpired:
                    pass
            p.stdout.read()
            p.stderr.read()
            self.assertEqual(p.returncode, -signal.SIGINT)


if __name__ == "__main__":
    shards.main()
