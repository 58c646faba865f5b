"""Several captures read as one stream; recordings that change files between frames; captures cut by frame, eye or line."""
import gzip
import os
import pathlib
import resource
import struct
import subprocess
import tempfile
import unittest

import shards
from support import BIN, MAGIC, PATIENCE_S, Folder, ip, line, pcap, run, simulate, summary, udp, word


def split(data):
    """The header of a pcap file, and its records."""
    records, at = [], 24
    while at < len(data):
        end = at + 16 + struct.unpack_from("<I", data, at + 8)[0]
        records.append(data[at:end])
        at = end
    return data[:24], records


def later(record, seconds):
    return struct.pack("<I", struct.unpack_from("<I", record)[0] + seconds) + record[4:]


def fragments(packet, size, number):
    """An Ethernet frame with UDP over IPv4, in fragments."""
    body = packet[34:]
    for at in range(0, len(body), size):
        part = body[at:at + size]
        more = 0x2000 if at + size < len(body) else 0
        header = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(part), number, more | at // 8, 64, 17, 0)
        yield packet[:14] + header + ip("10.42.0.37") + ip("10.42.0.1") + part


class Case(unittest.TestCase):
    frames = "4"

    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory() as folder:
            whole = simulate(pathlib.Path(folder) / "whole.pcap", "--frames", cls.frames, "--lines", "64", "--seed", "1")
            cls.header, cls.records = split(whole.read_bytes())

    def setUp(self):
        self.folder = Folder(self)

    def part(self, name, records):
        return self.folder.write(name, self.header + b"".join(records))

    def rotated(self, count):
        """The capture in so many files, cut anywhere."""
        cuts = [len(self.records) * i // count for i in range(count + 1)]
        return [self.part(f"r-{i + 1:04d}.pcap", self.records[cuts[i]:cuts[i + 1]]) for i in range(count)]

    def whole(self):
        return self.part("whole.pcap", self.records)

    def csv(self, *arguments, **options):
        r = run("lumdump", *arguments, "-o", "-", "--format", "csv", "-q", **options)
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        return r.stdout_bytes

    def refused(self, status, *arguments, message):
        r = run("lumdump", *arguments)
        self.assertEqual(r.returncode, status, r.stderr)
        self.assertRegex(r.stderr, message)
        return r


class Rotated(Case):
    frames = "20"

    def test_rotated_files_give_every_point_of_the_whole(self):
        parts = self.rotated(7)
        whole = self.csv(self.whole())
        self.assertGreater(whole.count(b"\n"), 100_000)
        self.assertEqual(self.csv(*parts), whole)
        self.assertEqual(self.csv(*parts[::-1]), whole)
        one, several = summary(self.folder / "whole.pcap"), summary(*parts)
        self.assertEqual([p["name"] for p in several["sources"]], [str(p) for p in parts])
        self.assertEqual(sum(p["records"] for p in several["sources"]), one["records"])
        self.assertEqual({p["end"] for p in several["sources"]}, {"whole"})
        for got in one, several:
            del got["source"], got["sources"]
        self.assertEqual(several, one)


class Several(Case):
    def test_utc_is_the_same_too(self):
        parts = self.rotated(3)
        self.assertEqual(self.csv(*parts, "--time", "utc"), self.csv(self.whole(), "--time", "utc"))

    def test_formats_and_streams_mix(self):
        parts = self.rotated(3)
        packed = self.folder.write("packed.gz", gzip.compress(parts[1].read_bytes()))
        big = self.folder / "third.pcapng"
        self.assertEqual(run("lumdump", parts[2], "-q", "-o", big).returncode, 0)
        whole = self.csv(self.whole())
        self.assertEqual(self.csv("-", packed, big, stdin=parts[0].read_bytes()), whole)
        with open(parts[0], "rb") as first:
            r = subprocess.run([BIN / "lumdump", big, "-", packed, "-o", "-", "--format", "csv", "-q"], stdin=first,
                               capture_output=True, timeout=PATIENCE_S, check=True)
        self.assertEqual(r.stdout, whole)

    def test_a_capture_of_each_interface_is_merged_by_time(self):
        shares = [[], [], []]
        for i, record in enumerate(self.records):
            shares[i * 7919 % 1000 % 3].append(record)
        parts = [self.part(f"eth{i}.pcap", share) for i, share in enumerate(shares)]
        self.assertEqual(self.csv(*parts), self.csv(self.whole()))
        r = run("lumdump", *parts)
        self.assertRegex(r.stdout, r"sources +3  captures, read as one stream")
        self.assertRegex(r.stdout, r"seconds by which .*eth.*\.pcap begins before the end of those before it")
        self.assertLess(summary(*parts)["sources"][1]["gap_s"], 0)

    def test_a_datagram_in_fragments_may_be_in_two_files(self):
        packets = [udp(p) for n in range(3) for p in line([word(1000 + n, k) for k in range(300)], 0, n, 1000 + 1000 * n)]
        pieces = [f for i, packet in enumerate(packets) for f in fragments(packet, 512, i + 1)]
        self.header, self.records = split(pcap(pieces))
        want = self.csv(self.whole())
        self.assertEqual(want.count(b"\n"), 901)
        parts = [self.part(f"{i:03d}.pcap", [record]) for i, record in enumerate(self.records)]
        self.assertEqual(self.csv(*parts), want)

    def test_a_gap_is_told(self):
        half = len(self.records) // 2
        parts = [self.part("a.pcap", self.records[:half]),
                 self.part("b.pcap", [later(r, 12) for r in self.records[half:]])]
        self.assertRegex(run("lumdump", *parts).stdout, r"12\.\d+  seconds without a capture before .*b\.pcap")
        self.assertAlmostEqual(summary(*parts)["sources"][1]["gap_s"], 12.0, delta=0.1)
        self.assertNotIn("seconds without", run("lumdump", *self.rotated(5)).stdout)

    def test_a_missing_one_is_named_and_nothing_written(self):
        parts = self.rotated(3)
        gone = self.folder / "r-0004.pcap"
        before = self.folder.names()
        self.refused(1, *parts, gone, "-o", self.folder / "out.csv", message=r"r-0004\.pcap: cannot be opened: No such file")
        self.refused(1, gone, *parts, message=r"r-0004\.pcap: cannot be opened")
        self.assertEqual(self.folder.names(), before)

    def test_one_that_is_no_capture_is_named(self):
        parts = self.rotated(2)
        other = self.folder.write("notes.txt", "not a capture, but long enough to be looked at")
        self.refused(1, *parts, other, message=r"notes\.txt: not a capture")

    def test_one_file_twice_is_refused(self):
        parts = self.rotated(2)
        os.link(parts[0], self.folder / "same.pcap")
        self.refused(2, *parts, parts[0], message=r"r-0001\.pcap and .*r-0001\.pcap are one file: name each source once")
        self.refused(2, *parts, self.folder / "same.pcap", message="are one file")
        self.refused(2, "-", "-", message="are one file")

    def test_an_output_is_none_of_them(self):
        parts = self.rotated(3)
        self.refused(2, *parts, "-o", parts[2], "--format", "csv", message="is the source itself")
        self.refused(2, *parts, "-o", self.folder / "r.pcap", "--rotate", "1MB", message="has one of the names")

    def test_a_sensor_is_alone(self):
        parts = self.rotated(2)
        self.refused(2, parts[0], "udp://10.42.0.37", message="a sensor is the only source")
        self.refused(2, "udp://10.42.0.37", parts[0], message="a sensor is the only source")

    def test_one_that_breaks_off_ends_alone(self):
        parts = self.rotated(4)
        data = parts[1].read_bytes()
        parts[1].write_bytes(data[:-10])
        r = run("lumdump", *parts, "--json")
        self.assertEqual(r.returncode, 0)
        self.assertRegex(r.stderr, r"warning: .*r-0002\.pcap: cannot be read beyond record \d+")
        got = summary(*parts)
        self.assertTrue(got["truncated"])
        self.assertEqual([p["end"] for p in got["sources"]], ["whole", "broken off", "whole", "whole"])
        self.assertEqual(got["records"], len(self.records) - 1)

    def test_one_without_a_packet_is_no_harm(self):
        parts = self.rotated(2)
        self.assertEqual(self.csv(parts[0], self.part("empty.pcap", []), parts[1]), self.csv(self.whole()))

    def test_many_files_need_few_descriptors(self):
        parts = self.rotated(300)
        limit = lambda: resource.setrlimit(resource.RLIMIT_NOFILE, (24, 24))
        self.assertEqual(self.csv(*parts, preexec_fn=limit), self.csv(self.whole()))

    def test_duration_is_of_the_whole(self):
        parts = self.rotated(5)
        got, want = summary(*parts, "--duration", "0.1"), summary(self.whole(), "--duration", "0.1")
        self.assertEqual((got["points"], got["records"]), (want["points"], want["records"]))
        self.assertEqual(got["sources"][4]["end"], "not reached")


class Rotation(Case):
    """A file ends where a frame does."""

    def files(self, source, *arguments, name):
        r = run("lumdump", source, "-o", self.folder / name, *arguments, "-q")
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        stem, ending = name.split(".")
        return sorted(self.folder.path.glob(f"{stem}-*.{ending}"))

    def test_a_recording_is_cut_between_frames(self):
        files = self.files(self.whole(), "--rotate", "200kB", name="r.pcap")
        self.assertEqual(len(files), int(self.frames))
        for part in map(summary, files):
            self.assertEqual((part["frames"], part["lines"], part["lines_missing_angles"], part["lost_words"]), (1, 128, 0, 0))
        self.assertEqual(self.csv(*files), self.csv(self.whole()))

    def test_a_limit_of_more_than_a_frame_holds_whole_ones(self):
        size = os.path.getsize(self.whole()) // 3
        parts = [summary(p) for p in self.files(self.folder / "whole.pcap", "--rotate", f"{size}B", name="r.pcap")]
        self.assertEqual([p["frames"] for p in parts], [2, 2])

    def test_a_cloud_is_cut_between_frames_also_of_eyes_that_are_apart(self):
        lines = 40
        packets = []
        for step in range(3 * lines + 6):
            for eye, at in ((0, step), (1, step - 6)):
                if 0 <= at < 3 * lines:
                    words = [word(1000, k) for k in range(20)]
                    packets += [udp(p) for p in line(words, eye, at % lines, 1000 + 1000 * step)]
        source = self.folder.write("apart.pcap", pcap(packets, step=0.0002))
        whole = self.csv(source)
        files = self.files(source, "--rotate", "10kB", name="c.csv")
        self.assertEqual(len(files), 3)
        for number, path in enumerate(files, 1):
            rows = path.read_text().splitlines()[1:]
            self.assertEqual({r.split(",")[8] for r in rows}, {str(number)})
            self.assertEqual(len(rows), 2 * lines * 20)
        header = whole.splitlines()[0]
        rows = sorted(r for p in files for r in p.read_bytes().splitlines() if r != header)
        self.assertEqual(rows, sorted(whole.splitlines()[1:]))

    def test_where_no_frame_ends_it_is_cut_all_the_same(self):
        packets = [udp(p) for n in range(1200) for p in line([word(1000, 0)], 0, n, 1000 + 4000 * n)]
        source = self.folder.write("long.pcap", pcap(packets))
        for name in "r.pcap", "c.csv":
            with self.subTest(name):
                self.assertEqual(len(self.files(source, "--rotate", "1s", name=name)), 2)
        beats = [packets[0]] + [udp(MAGIC + struct.pack("<I", 0))] * 49
        beats = self.folder.write("beats.pcap", pcap(beats, step=0.1))
        self.assertEqual(len(self.files(beats, "--rotate", "1s", name="b.pcap")), 2)


def is_data(record):
    return record[16 + 42 + 8] == 8


class Cut(Case):
    """A capture written by --frames, --eye or --incomplete holds the packets of those lines."""

    def cut(self, source, *arguments):
        out = self.folder / "cut.pcap"
        r = run("lumdump", source, *arguments, "-o", out, "-q")
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        return out

    def points(self, *arguments):
        """The rows but for the number of the frame, which begins anew in a part; the end closes one eye before the other."""
        rows = [row.split(b",") for row in self.csv(*arguments).splitlines()[1:]]
        return sorted(b",".join(row[:8] + row[9:]) for row in rows)

    def check(self, source, *arguments):
        out = self.cut(source, *arguments)
        want = self.points(source, *arguments)
        self.assertGreater(len(want), 1000)
        self.assertTrue(self.points(out) == want, "other points")
        return summary(out)

    def test_frames(self):
        got = self.check(self.whole(), "--frames", "2:3")
        self.assertEqual((got["frames"], got["lines"], got["lines_missing_angles"], got["lost_words"]), (2, 256, 0, 0))
        self.assertEqual(got["records"], got["data"])
        self.assertLess(got["records"], len(self.records) * 0.6)

    def test_one_eye_of_frames(self):
        got = self.check(self.whole(), "--eye", "green", "--frames", ":2")
        self.assertEqual((got["lines_blue"], got["lines_green"]), (0, 128))

    def test_lines_that_lack_something(self):
        del self.__class__.records[500:505]
        self.addCleanup(self.__class__.setUpClass)
        self.assertGreater(summary(self.whole())["lines_missing_angles"] + summary(self.folder / "whole.pcap")["lost_words"], 0)
        got = self.check(self.folder / "whole.pcap", "--incomplete", "drop")
        self.assertEqual((got["lines_missing_angles"], got["lost_words"]), (0, 0))

    def test_packets_that_are_lost_or_out_of_order(self):
        source = simulate(self.folder / "bad.pcap", "--frames", "4", "--lines", "64", "--seed", "3", "--loss", "0.02",
                          "--reorder", "0.05", "--duplicate", "0.02")
        self.check(source, "--frames", "2:3")
        self.check(source, "--eye", "blue")

    def test_an_eye_that_falls_silent(self):
        half = len(self.records) // 2
        records = self.records[:half] + [r for r in self.records[half:] if r[16 + 42 + 13] == 0]
        self.check(self.part("silent.pcap", records), "--frames", "1:3")

    def test_other_packets_of_the_time_come_if_they_are_asked_for(self):
        beat = udp(MAGIC + struct.pack("<I", 0))
        records = []
        for i, record in enumerate(self.records):
            records.append(record)
            if i % 100 == 0:
                records.append(record[:8] + struct.pack("<II", len(beat), len(beat)) + beat)
        source = self.part("beats.pcap", records)
        beats = summary(source)["heartbeat"]
        self.assertEqual(summary(self.cut(source, "--frames", "2:3"))["heartbeat"], 0)
        self.assertEqual(summary(self.cut(source, "--frames", "2:3", "--packets", "lines"))["heartbeat"], 0)
        got = summary(self.cut(source, "--frames", "2:3", "--packets", "all"))
        self.assertAlmostEqual(got["heartbeat"], beats // 2, delta=1)
        self.assertEqual(got["lines"], 256)
        self.assertEqual(summary(self.cut(source))["heartbeat"], beats)

    def test_one_of_several_sensors(self):
        other = [r[:42] + bytes([10, 42, 0, 38]) + r[46:] for r in self.records]
        source = self.part("two.pcap", [r for pair in zip(self.records, other) for r in pair])
        out = self.cut(source, "--sensor", "10.42.0.38", "--frames", "2:2")
        self.assertEqual([s["address"] for s in summary(out)["sensors"]], ["10.42.0.38"])
        self.assertTrue(self.points(out) == self.points(source, "--sensor", "10.42.0.38", "--frames", "2:2"), "other points")

    def test_beside_a_cloud_and_in_several_files(self):
        r = run("lumdump", self.whole(), "--frames", "2:4", "--rotate", "200kB", "-o", self.folder / "c.pcap",
                "-o", self.folder / "c.csv", "-q")
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        parts = [summary(p) for p in sorted(self.folder.path.glob("c-*.pcap"))]
        self.assertEqual([(p["frames"], p["lines"]) for p in parts], [(1, 128)] * 3)
        self.assertEqual(len(list(self.folder.path.glob("c-*.csv"))), 3)

    def test_what_cannot_be_cut_is_refused(self):
        source, out = self.whole(), self.folder / "x.pcap"
        for arguments in (["--range", "2:80"], ["--box", ":,:,:4"], ["--return", "last"], ["--edge", "both"],
                          ["--range", "2:80", "-o", self.folder / "x.csv"]):
            with self.subTest(arguments):
                self.refused(2, source, "-o", out, *arguments, message=f"{arguments[0]}: a packet holds many points")
        self.refused(2, source, "-o", out, "--packets", "all", message="--packets goes with a capture that")
        self.refused(2, source, "-o", self.folder / "x.csv", "--eye", "blue", "--packets", "all", message="--packets goes with")
        for option in ["--eye", "blue"], ["--range", ":9"], ["--frames", "1:2"], ["--incomplete", "drop"]:
            with self.subTest(option):
                self.refused(2, "udp://127.0.0.1:9", "-o", out, *option, message="a recording holds all packets")
        self.assertEqual(self.folder.names(), ["whole.pcap"])


if __name__ == "__main__":
    shards.main()
