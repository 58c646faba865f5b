"""Wireshark's dissector, read by tshark: kinds as lumdump counts them, fields,
faults. LUM_WIRESHARK is the folder of lumsdk.lua."""
import json
import os
import pathlib
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
from collections import Counter

from support import (BIN, CLIENT, MAGIC, PATIENCE_S, SENSOR, Folder, angles, frames_of, group, ip, pcap, run,
                     simulate, summary, udp, word)

SCRIPT = pathlib.Path(os.environ.get("LUM_WIRESHARK", BIN.parent / "tools" / "wireshark")) / "lumsdk.lua"
ROOT = pathlib.Path(__file__).resolve().parents[2]
VECTORS = ROOT.parent / "shared" / "vectors"
KINDS = "data heartbeat set_ip timestamp tlv malformed unknown_tag unknown_type foreign cut_short".split()
TO_SENSOR = {"source": CLIENT, "destination": SENSOR, "sport": 50000, "dport": 5517}
BITS = """GALVO_AMP_BX_BAD GALVO_AMP_BY_BAD GALVO_AMP_GX_BAD GALVO_AMP_GY_BAD HEARTBEAT_TIMEOUT BOARD_OVER_105
FAN_PWM_BAD HW_SAFETY_BAD SYS_ON_SW_OFF TLV_CMD_OFF BIT_10 TLV_CMD_ON BIT_12 BIT_13 BIT_14 BIT_15""".split()

HOME = tempfile.TemporaryDirectory()
# No settings and no plugins but ours.
ENVIRONMENT = {**os.environ, "HOME": HOME.name, "WIRESHARK_CONFIG_DIR": HOME.name, "WIRESHARK_PLUGIN_DIR": HOME.name}


def tshark(path, *arguments, script=SCRIPT):
    """Lines of tshark's output; what it has to say beside them is an error."""
    r = subprocess.run(["tshark", "-n", "-X", f"lua_script:{script}", "-r", str(path), *arguments],
                       capture_output=True, timeout=PATIENCE_S, env=ENVIRONMENT)
    said = [s for s in r.stderr.decode().splitlines() if "Running as user" not in s and "cut short in the" not in s]
    if said:
        raise AssertionError(f"tshark {path}: {said}")
    return r.stdout.decode(errors="replace").splitlines()


def fields(path, *names, options=()):
    """A list of values for each packet; several values of one field by |."""
    wanted = [part for name in names for part in ("-e", name)]
    return [row.split("\t") for row in tshark(path, *options, "-T", "fields", "-E", "aggregator=|", *wanted)]


def told(path, *options):
    """Kind, fragments and messages of each packet."""
    rows = fields(path, "lum.kind", "ip.fragment.count", "_ws.expert.message", options=("-o", "lum.samples:0", *options))
    broken = [row[2] for row in rows if "Lua Error" in row[2]]
    if broken:
        raise AssertionError(broken[0])
    return rows


def count(rows):
    """Packets by kind, and records that are neither of a kind nor a fragment."""
    kinds = Counter(kind for row in rows for kind in row[0].split("|"))
    kinds["other"] += kinds.pop("", 0) - sum(int(row[1]) - 1 for row in rows if row[1])
    return kinds


def counts(path, *options):
    return count(told(path, *options))


def control(number, body=b""):
    return MAGIC + struct.pack("<I", number) + body


def tlv(sequence, *items):
    return control(7, struct.pack("<I", sequence)
                   + b"".join(struct.pack("<HH", number, len(value)) + value for number, value in items))


def with_length(frame, length):
    """The frame with that as its UDP length."""
    return frame[:38] + struct.pack(">H", length) + frame[40:]


def one_of_each():
    """A packet of each kind that is read, with all that can stand in it."""
    return [group(2, 0, 17, [struct.pack("<hh", 16384, -16384)] * 3, 997, 123456),
            group(3, 1, 17, [word(2564, 500), word(2570, 500, False), word(5128, 500)], 0, 4294967295),
            control(8), control(5, ip("10.42.0.99")), control(6, struct.pack("<II", 3, 123456)), tlv(4),
            tlv(5, (1, b"50p 15y u"), (2, b"\x50\x02"), (3, b"hot"), (4, struct.pack("<hh", 1, -1)), (9, b"\xde\xad"))]


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def capture(self, *payloads, to_sensor=False):
        frames = [udp(p, **TO_SENSOR) if to_sensor else udp(p) for p in payloads]
        return self.folder.write("in.pcap", pcap(frames))

    def same_counts(self, path, *options, other=True):
        want = summary(path)
        found = counts(path, *options)
        names = KINDS + ["other"] * other
        self.assertEqual({k: found[k] for k in names}, {k: want[k] for k in names}, path)
        return found


class Counts(Case):
    def test_of_a_drive_without_faults(self):
        path = simulate(self.folder / "in.pcap", "--frames", 1)
        self.assertGreater(self.same_counts(path)["data"], 500)

    def test_of_a_drive_with_faults(self):
        path = simulate(self.folder / "in.pcap", "--frames", 2, "--corrupt", 0.7, "--loss", 0.1, "--reorder", 0.1,
                        "--duplicate", 0.1, "--seed", 3)
        found = self.same_counts(path)
        self.assertGreater(found["malformed"], 2)
        self.assertGreater(found["foreign"], 2)

    def test_of_each_packet_with_each_length(self):
        packets = [p[:n] for p in one_of_each() for n in range(len(p) + 1)]
        found = self.same_counts(self.capture(*packets))
        self.assertEqual({k for k in KINDS if not found[k]}, {"unknown_tag", "unknown_type", "cut_short"})

    def test_of_packets_with_bytes_changed(self):
        rng = random.Random(4)
        packets = []
        for _ in range(3000):
            packet = bytearray(rng.choice(one_of_each()))
            for _ in range(rng.randint(0, 3)):
                packet[rng.randrange(7, min(26, len(packet)))] = rng.choice((0, 1, 2, 3, 5, 6, 7, 8, 255))
            packets.append(bytes(packet) + bytes(rng.choice((0, 0, 4))))
        found = self.same_counts(self.capture(*packets))
        self.assertEqual([k for k in KINDS if found[k] < 10], ["cut_short"])

    def test_of_captures_that_hold_a_part(self):
        frames = [udp(p) for p in one_of_each()] + [udp(b"x" * 60, sport=53, dport=9999)]
        # a heartbeat, and bytes of the IP payload behind it
        frames.append(with_length(udp(control(8) + bytes(8)), 8 + 12))
        for snap in (20, 36, 39, 41, 42, 50, 54, 60, 66, 80):
            with self.subTest(snap):
                data = pcap(frames, snap=snap) + pcap([udp(one_of_each()[0])])[24:]
                self.same_counts(self.folder.write("in.pcap", data), other=snap >= 42)

    def test_of_lengths_that_cannot_be(self):
        frames = [udp(one_of_each()[0])]
        for length in 0, 7, 8, 9, 28, 29, 100, 65535:
            frames.append(with_length(udp(control(8) + bytes(8)), length))
        self.same_counts(self.folder.write("in.pcap", pcap(frames + [f + bytes(20) for f in frames])))

    def test_of_ipv6_and_of_packets_quoted_by_icmp(self):
        inner = udp(control(8), **TO_SENSOR)[14:]
        icmp = b"\x03\x03" + bytes(6) + inner
        quoted = (bytes(12) + b"\x08\x00" + struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(icmp), 1, 0, 64, 1, 0)
                  + ip(SENSOR) + ip(CLIENT) + icmp)
        datagram = inner[20:]
        six = (bytes(12) + b"\x86\xdd" + struct.pack(">IHBB", 0x60000000, len(datagram), 17, 64) + bytes(15) + b"\x01"
               + bytes(15) + b"\x02" + datagram)
        path = self.folder.write("in.pcap", pcap([quoted, six]))
        self.assertEqual(self.same_counts(path)["other"], 2)
        self.assertEqual(fields(path, "lum.type", "lum.kind"), [["8", ""], ["", "other"]])

    def test_is_the_same_when_tshark_reads_twice(self):
        path = simulate(self.folder / "in.pcap", "--frames", 1, "--corrupt", 0.5)
        self.assertEqual(counts(path, "-2"), counts(path))


class Joined(Case):
    def test_datagrams_have_their_kinds(self):
        path = simulate(self.folder / "in.pcap", "--frames", 1, "--corrupt", 0.3, "--joined")
        self.assertGreater(self.same_counts(path)["data"], 500)
        self.assertEqual(counts(path, "-2"), counts(path))

    def test_of_each_length_and_magic(self):
        angle, one = group(2, 0, 17, [bytes(4)] * 4), control(8, bytes(20))
        joined = angle + angle + one
        payloads = [joined[:n] for n in range(len(joined) + 1)]
        payloads += [control(8) * 3, MAGIC * 3, (MAGIC + bytes(3)) * 3, angle + MAGIC + bytes(4) + angle,
                     angle + one + angle, one + bytes(5) + one, b"x" + joined]
        self.assertGreater(self.same_counts(self.capture(*payloads))["heartbeat"], 3)

    def test_that_came_in_fragments(self):
        path = self.folder.write("in.pcap", pcap(Fragments.cut(b"".join(angles()), (1000, 2000))))
        self.assertEqual(self.same_counts(path)["data"], 3)
        self.assertEqual(fields(path, "lum.kind", "lum.joined", "ip.fragment.count")[2], ["data|data|data", "3", "3"])

    def test_requests_and_answers_find_each_other(self):
        frames = [udp(tlv(1, (1, b"u")) + tlv(2, (1, b"d")), **TO_SENSOR),
                  udp(tlv(1, (2, b"\0\x08")) + tlv(2, (2, b"\0\x08")) + tlv(3))]
        path = self.folder.write("in.pcap", pcap(frames))
        names = "lum.joined", "lum.request_frame", "lum.answer_frame", "_ws.expert.message", "_ws.col.Info"
        self.assertEqual(fields(path, *names, options=("-2",)),
                         [["2", "", "2|2", "", "2 joined, the last: TLV command d seq 2"],
                          ["3", "1|1", "", "answer to no request of this capture", "3 joined, the last: TLV asks for status seq 3"]])


class Fragments(Case):
    @staticmethod
    def cut(payload, sizes, identity=7):
        segment = udp(payload)[34:]
        offset, frames = 0, []
        for size in (*sizes, len(segment) - sum(sizes)):
            piece = segment[offset:offset + size]
            more = 0x2000 if offset + size < len(segment) else 0
            header = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(piece), identity, more | offset // 8, 64, 17, 0)
            frames.append(bytes(12) + b"\x08\x00" + header + ip(SENSOR) + ip(CLIENT) + piece)
            offset += size
        return frames

    def setUp(self):
        super().setUp()
        self.pieces = self.cut(next(angles()), (400, 400))

    def test_are_joined_in_any_order(self):
        a, b, c = self.pieces
        path = self.folder.write("in.pcap", pcap([c, a, b]))
        self.assertEqual(self.same_counts(path)["data"], 1)
        self.assertEqual(fields(path, "lum.kind", "ip.fragment.count", "lum.data.num_samples")[2], ["data", "3", "334"])

    def test_that_are_cut_leave_the_first_for_the_datagram(self):
        for snap in (60, 433):
            path = self.folder.write("in.pcap", pcap(self.pieces, snap=snap))
            self.assertEqual(self.same_counts(path, other=False)["cut_short"], 1)

    def test_are_joined_when_there_was_no_tree(self):
        path = self.folder.write("in.pcap", pcap(self.pieces))
        self.assertEqual(fields(path, "lum.kind", options=("-2",))[2], ["data"])

    def test_that_wireshark_does_not_join_are_cut_short(self):
        path = self.folder.write("in.pcap", pcap(self.pieces))
        self.assertEqual(fields(path, "lum.kind", options=("-o", "ip.defragment:FALSE")), [["cut_short"], [""], [""]])


@unittest.skipUnless(VECTORS.is_dir(), f"{VECTORS} is not there")
class Vectors(Case):
    def check(self, path, rows):
        found = count(rows)
        r = run("lumdump", path, "--json")
        if r.returncode != 0:
            # status 1: packets came, and no data among them
            self.assertEqual((r.returncode, found["data"]), (1, 0), path.name)
            return
        want = json.loads(r.stdout)
        names = KINDS + ["other"]
        self.assertEqual({k: found[k] for k in names}, {k: want[k] for k in names}, path.name)

    @staticmethod
    def can_be_joined(path):
        """A whole pcap file of Ethernet in microseconds, without fragments that wait at its end."""
        head = path.read_bytes()[:24]
        return (head[:4] == b"\xd4\xc3\xb2\xa1" and head[20:24] == b"\x01\0\0\0"
                and not path.name.startswith(("cut", "ip-")))

    def test_counts_are_those_of_lumdump(self):
        paths = sorted(VECTORS.glob("*.pcap")) + sorted(VECTORS.glob("*.pcapng"))
        joined = [p for p in paths if self.can_be_joined(p)]
        self.assertGreater(len(joined), 10)
        # tshark takes longer to start than to read any of them
        data = joined[0].read_bytes()[:24] + b"".join(p.read_bytes()[24:] for p in joined)
        rows = iter(told(self.folder.write("joined.pcap", data)))
        for path in joined:
            with self.subTest(path.name):
                self.check(path, [next(rows) for _ in frames_of(path.read_bytes())])
        self.assertIsNone(next(rows, None))
        # Wireshark joins fragments by rules of its own
        for path in sorted(set(paths) - set(joined) - {VECTORS / "ip-fragments-mixed.pcap"}):
            with self.subTest(path.name):
                self.check(path, told(path))

    def test_another_layout_is_a_preference(self):
        path, profile = VECTORS / "profile-1.pcap", VECTORS / "profile-1.profile.yaml"
        if not profile.exists():
            self.skipTest("profile-1 is not there")
        layout = ("lum.layout:data_packet_type=3 line=12 num_samples=18 timestamp=20 first_sample_index=24 eye=30 "
                  "tag=31 samples=40 blue=10 green=48 angle_lsb_deg=0.0009155")
        want = summary(path, "--profile", profile)
        found = counts(path, "-o", layout)
        self.assertEqual({k: found[k] for k in KINDS}, {k: want[k] for k in KINDS})
        self.assertGreater(found["data"], 50)


    def test_a_wider_layout_is_one_too(self):
        profile = self.folder.write("wide.yaml", "version: 1\nsample_order: big\ngroup: {line: {at: 14, bytes: 2, order: big, "
                                    "bits: [0, 14]}, eye: {at: 14, bytes: 2, order: big, bits: [15, 15]}, num_samples: none, "
                                    "timestamp: {at: 24, bytes: 8, order: big, unit_ns: 1}, samples: 32}\n")
        path = self.folder / "wide.pcap"
        self.assertEqual(run("lumsim", "-o", path, "--frames", 1, "--profile", profile).returncode, 0)
        layout = ("-o", "lum.layout:line=14/2/big/0-14 eye=14/2/big/15-15 num_samples=none timestamp=24/8/big unit_ns=1 "
                  "samples=32 sample_order=big")
        want, found = summary(path, "--profile", profile), counts(path, *layout)
        self.assertEqual({k: found[k] for k in KINDS}, {k: want[k] for k in KINDS})
        rows = fields(path, "lum.data.timestamp", "lum.data.eye_value", "lum.data.line", "lum.data.num_samples", options=layout)
        self.assertEqual(rows[0], ["5000000000", "0", "0", "334"])
        self.assertEqual({row[1] for row in rows}, {"0", "1"})
        self.assertEqual({int(row[2]) for row in rows}, set(range(64)))


class Fields(Case):
    def one(self, payload, *names, to_sensor=False, options=()):
        return fields(self.capture(payload, to_sensor=to_sensor), *names, options=options)[0]

    def test_of_the_header(self):
        self.assertEqual(self.one(control(8), "lum.magic", "lum.type", "lum.reserved", "lum.kind"),
                         ["edfef3a1efbe3412", "8", "000000", "heartbeat"])

    def test_of_angles(self):
        samples = [struct.pack("<hh", 16384, -16384), struct.pack("<hh", -32768, 32767)]
        names = """data.tag data.eye data.eye_value data.line data.num_samples data.first_sample_index data.timestamp
        angle.pixel angle.azimuth_raw angle.azimuth angle.elevation_raw angle.elevation""".split()
        self.assertEqual(self.one(group(2, 0, 517, samples, 998, 4000000000), *("lum." + n for n in names)),
                         ["2", "blue", "0", "517", "2", "998", "4000000000", "998|999", "16384|-32768", "15|-30",
                          "-16384|32767", "-12|2.99969482421875"])

    def test_of_words(self):
        words = [word(2564, 500), word(2570, 500, False), word(-5, 500), word(524287, 999)]
        names = "data.eye data.tag word.pixel word.tof word.rising word.return".split()
        found = self.one(group(3, 1, 2, words), *("lum." + n for n in names), "lum.word.range")
        self.assertEqual(found[:6], ["green", "3", "500|500|500|999", "2564|2570|-5|524287", "1|0|1|1", "1|1|2|1"])
        for value, want in zip(found[6].split("|"), (4.9998, 5.0115, -0.00975, 1022.35965)):
            self.assertAlmostEqual(float(value), want)

    def test_of_a_line_are_the_points_of_lumdump(self):
        packets = [*angles(), group(3, 0, 0, [word(1000 + 7 * i, i) for i in range(100)])]
        path = self.capture(*packets)
        self.assertEqual(run("lumdump", path, "-o", self.folder / "out.csv").returncode, 0)
        rows = (self.folder / "out.csv").read_text().splitlines()[1:]
        ranges = fields(path, "lum.word.range")[3][0].split("|")
        self.assertEqual([f"{float(r):.3f}" for r in ranges], [f"{float(r.split(',')[3]):.3f}" for r in rows])

    def test_of_set_ip_in_both_orders(self):
        names = "lum.set_ip.address", "lum.set_ip.reversed"
        self.assertEqual(self.one(control(5, ip("10.42.0.99")), *names), ["10.42.0.99", "99.0.42.10"])
        little = "-o", "lum.layout:set_ip_order=little"
        self.assertEqual(self.one(control(5, ip("10.42.0.99")), *names, options=little), ["99.0.42.10", "10.42.0.99"])

    def test_of_a_timestamp(self):
        self.assertEqual(self.one(control(6, struct.pack("<II", 7, 4294967295)), "lum.timestamp.sequence",
                                  "lum.timestamp.clock"), ["7", "4294967295"])

    def test_of_commands(self):
        found = self.one(tlv(4294967295, (1, b"50p 15y u 0f")), "lum.tlv.sequence", "lum.tlv.type", "lum.tlv.length",
                         "lum.tlv.command", "lum.command", "lum.command.name", "lum.command.value", to_sensor=True)
        self.assertEqual(found, ["4294967295", "1", "12", "50p 15y u 0f", "50p|15y|u|0f",
                                 "power|Y scan|laser on|line mode", "50|15|0"])

    def test_of_the_status_bit_by_bit(self):
        path = self.capture(*(tlv(i, (2, struct.pack("<H", 1 << i))) for i in range(16)))
        names = ["lum.laser." + name.lower() for name in BITS]
        for i, row in enumerate(fields(path, *names, "lum.laser.status", "lum.laser.down", "lum.laser.hazard")):
            want = [str(int(i == bit)) for bit in range(16)]
            want += [f"0x{1 << i:04x}", str(int(i <= 10)), str(int(i <= 8))]
            self.assertEqual(row, want, BITS[i])

    def test_of_debug_text_yscan_and_unknown_tlvs(self):
        found = self.one(tlv(1, (3, b"fan\0\xffbad"), (4, struct.pack("<hhh", 0, -32768, 16384)), (9, b"\xde\xad")),
                         "lum.tlv.debug", "lum.yscan.lines", "lum.yscan.raw", "lum.yscan.elevation", "lum.tlv.value")
        self.assertEqual(found, ["fan\\x00\\xffbad", "3", "0|-32768|16384", "-7|-17|-2", "dead"])

    def test_of_an_answer_lead_to_its_request(self):
        frames = [udp(tlv(1, (1, b"u")), **TO_SENSOR), udp(control(6, struct.pack("<II", 1, 0)), **TO_SENSOR),
                  udp(tlv(2), **TO_SENSOR), udp(control(6, struct.pack("<II", 1, 5))), udp(tlv(1, (2, b"\0\x08"))),
                  udp(tlv(9, (2, b"\0\x08")))]
        path = self.folder.write("in.pcap", pcap(frames))
        names = "lum.request_frame", "lum.answer_time", "lum.answer_frame", "_ws.expert.message"
        self.assertEqual(fields(path, *names, options=("-2",)),
                         [["", "", "5", ""], ["", "", "4", ""], ["", "", "", "no answer in this capture"],
                          ["2", "0.002", "", ""], ["1", "0.004", "", ""],
                          ["", "", "", "answer to no request of this capture"]])

    def test_tell_which_samples_are_missing(self):
        def part(first, line=0):
            return group(3, 0, line, [word(1000, first + i) for i in range(10)], first)
        path = self.capture(part(0), part(10), part(40), part(30), part(50), part(0, 1), part(30, 2))
        self.assertEqual([r[0] for r in fields(path, "lum.data.missing")], ["", "", "20", "", "", "", "30"])

    def test_show_so_many_samples_as_the_preference_says(self):
        words = group(3, 0, 0, [word(1, i) for i in range(9)] + [word(1, 1023)])
        for limit, want in ((0, 1), (3, 4), (10, 10), (1000, 10)):
            found = self.one(words, "lum.word.tof", "lum.data.bad_words", options=("-o", f"lum.samples:{limit}"))
            self.assertEqual((len(found[0].split("|")), found[1]), (want, "1"))

    def test_are_there_on_another_port_by_preference(self):
        path = self.folder.write("in.pcap", pcap([udp(control(8), sport=50001, dport=6001), udp(control(8))]))
        self.assertEqual(fields(path, "lum.kind"), [[""], ["heartbeat"]])
        self.assertEqual(fields(path, "lum.kind", options=("-o", "lum.ports:6000-6002")), [["heartbeat"], [""]])

    def test_of_a_datagram_cut_short_as_far_as_it_reaches(self):
        path = self.folder.write("in.pcap", pcap([udp(p) for p in angles(1, 9)], snap=14 + 28 + 16))
        self.assertEqual(fields(path, "lum.kind", "lum.type", "lum.data.line", "lum.data.num_samples")[0],
                         ["cut_short", "8", "9", ""])

    def test_can_be_filtered_by(self):
        path = self.capture(*one_of_each())
        for text, want in (("lum.data.eye == \"blue\"", "1"), ("lum.word.range > 9", "2"),
                           ("lum.kind == \"set_ip\"", "4"), ("lum.laser.hazard == 1", "7"),
                           ("lum.command == \"u\"", "7"), ("lum.fault.hazard", "7"),
                           ("lum.angle.azimuth == 15", "1"), ("lum.type == 8 && lum.data.line == 17", "1 2")):
            with self.subTest(text):
                found = fields(path, "frame.number", options=("-Y", text))
                self.assertEqual(" ".join(r[0] for r in found), want)


    def test_filters_of_the_documentation_are_understood(self):
        text = (ROOT / "docs" / "wireshark.md").read_text().split("## Filters for the bench")[1].split("\n\n")[1]
        filters = [row.split("`")[1] for row in text.splitlines()[2:]]
        self.assertGreater(len(filters), 10)
        path = self.capture(*one_of_each())
        fields(path, "lum.kind", options=("-Y", " or ".join(f"({f})" for f in filters)))

    def test_of_the_documentation_exist(self):
        text = (ROOT / "docs" / "wireshark.md").read_text().split("| field | meaning |")[1].split("\n\n")[0]
        names = set()
        for row in text.splitlines()[2:]:
            words = [w for w in row.split(" | ")[0].split("`")[1::2] if "NAME" not in w]
            names |= {w if w.startswith("lum.") else words[0].rsplit(".", 1)[0] + w for w in words}
        self.assertGreater(len(names), 40)
        fields(self.capture(*one_of_each()), *sorted(names))


class Faults(Case):
    def test_have_their_names(self):
        angle = struct.pack("<hh", 0, 0)
        rows = [
            (b"hello", "foreign", "shorter than a header"),
            (b"hello, hello, hello", "foreign", "without our magic"),
            (MAGIC + b"\x08\0\x01\0", "unknown_type", "a reserved byte is not 0"),
            (control(9), "unknown_type", "type that is not known"),
            (control(5, b"abc"), "malformed", "set IP packet shorter than 16 bytes"),
            (control(6, b"abcdefg"), "malformed", "timestamp packet shorter than 20 bytes"),
            (control(7, b"abc"), "malformed", "TLV packet shorter than 16 bytes"),
            (control(8, b"abc"), "malformed", "data packet shorter than the offset of its samples"),
            (group(3, 0, 1, []), "malformed", "num_samples is 0"),
            (group(3, 0, 1, [word(1, 1)] * 2)[:-1], "malformed", "data packet shorter than its samples"),
            (group(3, 2, 1, [word(1, 1)]), "malformed", "the eye is neither of the two values"),
            (group(4, 0, 1, [word(1, 1)]), "unknown_tag", "the tag is neither angles nor ranges"),
            (group(2, 0, 1, [angle] * 2, 999), "malformed", "angles past the last pixel of a line"),
            (group(3, 0, 1, [struct.pack("<I", 0x800)]), "data", "bad word: bit 11 is set"),
            (group(3, 0, 1, [word(1, 1000)]), "data", "bad word: pixel above 999"),
            (group(3, 0, 1, [word(1, 1)]) + b"x", "data", "bytes after the packet's end are ignored"),
            (control(5, ip("224.0.0.1")), "set_ip", "not the address of a host"),
            (control(5, bytes(4)), "set_ip", "not the address of a host"),
            (control(5, b"\xff" * 4), "set_ip", "not the address of a host"),
            (tlv(1) + b"\x01\0\0", "tlv", "fewer bytes are left than the head of a TLV has"),
            (tlv(1) + b"\x01\0\x03\0ab", "tlv", "the TLV announces more bytes than are left: 2 of 3"),
            (tlv(1, (9, b"")), "tlv", "TLV of a type that is not known"),
            (tlv(1, (2, b"x")), "tlv", "status shorter than two bytes"),
            (tlv(1, (4, b"xyz")), "tlv", "Y-scan table with an odd number of bytes"),
            (tlv(1, (2, b"\x10\0")), "tlv", "the laser is down for a hazard: HEARTBEAT_TIMEOUT"),
            (tlv(1, (1, b"")), "tlv", "not a command of the manual: empty"),
        ]
        path = self.capture(*(row[0] for row in rows))
        for row, found in zip(rows, fields(path, "lum.kind", "_ws.expert.message")):
            with self.subTest(row[2]):
                self.assertEqual(found[0], row[1])
                self.assertIn(row[2], found[1].split("|"))

    def test_of_commands_are_those_that_lumctl_refuses(self):
        good = "u d 0p 100p 100g 0b 0f 1f 11y 30y 150h 250h 30G 0B".split() + ["u 5p", "0f 11y d"]
        bad = "x 101p 2f 10y 31y 145h 155h 260h 31G 05p +5p 5 p 5u 99999999999p".split() + ["u ", " u", "u  d", "5p\0"]
        path = self.capture(*(tlv(1, (1, text.encode())) for text in good + bad), to_sensor=True)
        for text, row in zip(good + bad, fields(path, "lum.fault.command", "lum.fault.command_value")):
            with self.subTest(text):
                self.assertEqual("".join(row) != "", text in bad)
                if "\0" not in text:
                    sent = run("lumctl", "send", "--dry-run", text)
                    self.assertEqual(sent.returncode == 0, text in good, sent.stderr)

    def test_leave_packets_of_others_to_others(self):
        row = fields(self.capture(b"x" * 40), "lum.kind", "frame.protocols", "_ws.col.Protocol")[0]
        self.assertEqual(row, ["foreign", "eth:ethertype:ip:udp:data", "UDP"])

    def test_of_a_layout_are_told_and_the_default_stands(self):
        path = self.capture(control(8), group(3, 1, 17, [word(1, 1)]))
        for layout in "nonsense=1", "tag=7", "tag=65", "samples=20", "blue", "angle_order=up", "angle_lsb_deg=0", \
                "line=14/3", "line=14/2/7-3", "line=14/2/9-16", "line=14/", "eye=none", "sample_order=up", "unit_ns=0":
            with self.subTest(layout):
                rows = fields(path, "lum.kind", "_ws.expert.message", options=("-o", "lum.layout:" + layout))
                self.assertEqual([r[0] for r in rows], ["heartbeat", "data"])
                self.assertIn('the preference "layout" is not understood', rows[0][1])


class Columns(Case):
    def test_say_what_a_packet_is(self):
        frames = [udp(group(2, 0, 17, [struct.pack("<hh", 0, 0)] * 100, 0, 123456)),
                  udp(group(3, 1, 18, [word(1, 1), word(1, 1001)], 360, 5)), udp(tlv(7, (1, b"50p")), **TO_SENSOR),
                  udp(tlv(7, (2, b"\x10\x02"), (3, b"late"))), udp(tlv(8), **TO_SENSOR), udp(control(8), **TO_SENSOR),
                  udp(control(5, ip("10.42.0.99")), **TO_SENSOR), udp(control(6, bytes(8)), **TO_SENSOR),
                  udp(control(6, struct.pack("<II", 0, 77))), udp(control(99)), udp(group(3, 5, 1, [word(1, 1)])),
                  udp(tlv(9, (2, b"\0\x08"))), udp(tlv(9, (2, b"\0\0")))]
        path = self.folder.write("in.pcap", pcap(frames))
        self.assertEqual([row[0] for row in fields(path, "_ws.col.Info")],
                         ["Data blue line 17 angles 100 samples from 0 clock 123456",
                          "Data green line 18 ranges 2 samples from 360 clock 5 [1 bad]",
                          "TLV command 50p seq 7",
                          "TLV status 0x0210 laser down: HEARTBEAT_TIMEOUT TLV_CMD_OFF, debug \"late\" seq 7",
                          "TLV asks for status seq 8", "Heartbeat", "Set IP 10.42.0.99", "Timestamp request seq 0",
                          "Timestamp clock 77 seq 0", "Unknown type 99, 12 bytes",
                          "Malformed: the eye is neither of the two values",
                          "TLV status 0x0800 laser up: TLV_CMD_ON seq 9", "TLV status 0x0000 laser may be up: no bit seq 9"])
        self.assertEqual({row[0] for row in fields(path, "_ws.col.Protocol")}, {"LUM"})

    def test_are_the_same_without_a_tree(self):
        path = self.folder.write("in.pcap", pcap([udp(p) for p in one_of_each()]))
        self.assertEqual([row[0] for row in fields(path, "_ws.col.Info")],
                         [line.split("LUM ", 1)[1].split(" ", 1)[1] for line in tshark(path)])


class Script(unittest.TestCase):
    def test_is_the_tables_and_the_parts(self):
        rest = SCRIPT.read_text()
        tables = subprocess.run([SCRIPT.parent / "lum_wireshark_tables"], stdout=subprocess.PIPE, text=True, check=True).stdout
        parts = {path.name: path.read_text() for path in (ROOT / "tools" / "wireshark").glob("*.lua")}
        for name, text in {"the tables": tables, **parts}.items():
            with self.subTest(name):
                self.assertEqual(rest.count(text), 1)
            rest = rest.replace(text, "")
        self.assertRegex(rest, r"^(local \w+ = \(function\(\)\nend\)\(\)\n\n)+$")


if __name__ == "__main__":
    if shutil.which("tshark") is None:
        print("tshark is not installed (Debian: tshark); the dissector was not tested")
        sys.exit(77)
    unittest.main()
