#!/usr/bin/env python3
"""What files say of where they come from: a capture brings its calibration and its profile along, clouds tell theirs."""
import re
import shutil
import signal
import struct
import subprocess
import unittest

import shards
from support import BIN, PATIENCE_S, Folder, line, pcap, read_csv, run, simulate, udp, word

CALIBRATION = "version: 1\neyes: {blue: {mount: {x_m: 10.0, yaw_deg: 12.5}}}\n"
PROFILE = "version: 1\neye_values: {blue: 1, green: 0}\n"
FAR = "version: 1\ndata_packet_type: 9\n"
KINDS = "csv", "ply", "pcd", "xyz"


def block(kind, body):
    body += bytes(-len(body) % 4)
    n = len(body) + 12
    return struct.pack("<II", kind, n) + body + struct.pack("<I", n)


def section(*comments, order="<"):
    """A section's header with these comments, and an interface of Ethernet in microseconds."""
    options = b"".join(struct.pack("<HH", 1, len(c)) + c + bytes(-len(c) % 4) for c in comments)
    return (block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1) + options + bytes(4))
            + block(1, struct.pack("<HHI", 1, 0, 0)))


def packets(lines=(0, 1)):
    payloads = [p for n in lines for p in line([word(100000 + 100 * n, 500)], number=n, clock=1000 + n)]
    return b"".join(block(6, struct.pack("<IIIII", 0, 0, i * 100, len(f), len(f)) + f)
                    for i, f in enumerate(map(udp, payloads)))


def las_records(las):
    """The variable length records of a LAS file 1.4, by who made them and their number."""
    records = {}
    size, count = struct.unpack_from("<H4xI", las, 94)
    for _ in range(count):
        maker, number, n = struct.unpack_from("<2x16sHH", las, size)
        records[maker.rstrip(b"\0"), number] = las[size + 54:size + 54 + n]
        size += 54 + n
    assert size == struct.unpack_from("<I", las, 96)[0], "points begin elsewhere"
    return records


def text_of(path):
    """What a cloud says of itself."""
    if path.suffix == ".las":
        return las_records(path.read_bytes()).get((b"lumsdk", 1), b"").decode()
    prefix = "comment " if path.suffix == ".ply" else "# "
    head = path.read_bytes()[:20000].decode("ascii", "replace").splitlines()
    return "".join(s[len(prefix):] + "\n" for s in head if s.startswith(prefix))


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def dump(self, *arguments, status=0, **options):
        r = run("lumdump", *arguments, **options)
        self.assertEqual(r.returncode, status, (arguments, r.stderr))
        return r

    def points(self, *arguments, **options):
        out = self.folder / "points.csv"
        r = self.dump(*arguments, "-o", out, "-q", **options)
        self.assertEqual(r.stderr, "", arguments)
        return read_csv(out)

    def source(self):
        frames = map(udp, [p for n in range(2) for p in line([word(100000 + 100 * n, 500)], number=n, clock=1000 + n)])
        return self.folder.write("in.pcap", pcap(list(frames)))


class Captures(Case):
    def setUp(self):
        super().setUp()
        self.calibration = self.folder.write("front.yaml", CALIBRATION)
        self.profile = self.folder.write("other.yaml", PROFILE)
        self.plain = self.source()
        self.known = self.folder / "known.pcapng"
        self.dump(self.plain, "--calibration", self.calibration, "--profile", self.profile, "-o", self.known, "-q")
        self.want = self.points(self.plain, "--calibration", self.calibration, "--profile", self.profile)

    def test_a_capture_that_knows_its_calibration_needs_no_option(self):
        self.assertNotEqual(self.want, self.points(self.plain))
        self.assertEqual(self.want, self.points(self.known))
        self.assertEqual(self.want, self.points("-", stdin=self.known.read_bytes()))

    def test_it_goes_on_from_capture_to_capture(self):
        source = self.known
        for i in range(7):
            copy = self.folder / f"copy-{i}.pcapng"
            self.assertEqual(self.dump(source, "-o", copy, "-q").stderr, "")
            source = copy
        self.assertEqual(self.want, self.points(source))
        ply = self.folder / "out.ply"
        self.dump(source, "-o", ply, "-q")
        sources = re.findall(r'^source: "(.*)"$', text_of(ply), re.M)
        self.assertEqual(sources, [f"copy-{i}.pcapng" for i in (6, 5, 4, 3, 2)])  # so many are kept

    def test_an_option_wins_and_says_so(self):
        other = self.folder.write("mine.yaml", "version: 1\neyes: {blue: {mount: {x_m: 20.0}}}\n")
        r = self.dump(self.known, "--calibration", other, "-o", self.folder / "x.csv")
        self.assertIn("known.pcapng: it has a calibration of its own, which is not used", r.stderr)
        self.assertNotIn("profile of its own", r.stderr)
        self.assertEqual(read_csv(self.folder / "x.csv"),
                         self.points(self.plain, "--calibration", other, "--profile", self.profile))
        copy = self.folder / "copy.pcapng"
        self.dump(self.known, "--calibration", other, "-o", copy, "-q")
        self.assertEqual(read_csv(self.folder / "x.csv"), self.points(copy))

    def test_pcap_has_no_room_and_that_is_said(self):
        r = self.dump(self.known, "-o", self.folder / "x.pcap")
        self.assertIn("x.pcap: pcap has no room for the calibration", r.stderr)
        self.assertEqual(self.dump(self.plain, "-o", self.folder / "x.pcap").stderr.count("no room"), 0)

    def test_packets_are_those_of_a_pcap(self):
        for name in "a.pcap", "a.pcapng":
            self.dump(self.plain, "-o", self.folder / name, "-q")
        self.assertEqual(self.points(self.folder / "a.pcap"), self.points(self.folder / "a.pcapng"))
        self.dump(self.folder / "a.pcapng", "-o", self.folder / "b.pcap", "-q")
        self.assertEqual((self.folder / "b.pcap").read_bytes(), (self.folder / "a.pcap").read_bytes())
        out = self.dump(self.plain, "-o", "-", "--format", "pcapng").stdout_bytes
        self.assertEqual(self.points("-", stdin=out), self.points(self.plain))

    def test_files_of_a_rotation_each_know_it(self):
        simulate(self.folder / "s.pcap", "--frames", "2", "--lines", "64")
        self.dump(self.folder / "s.pcap", "--calibration", self.calibration, "-o", self.folder / "r.pcapng",
                  "--rotate", "1MB", "-q")
        parts = [n for n in self.folder.names() if re.match(r"r-\d+\.pcapng", n)]
        self.assertGreater(len(parts), 1)
        for n in parts:
            self.assertIn(b"# lumsdk calibration 1\n", (self.folder / n).read_bytes(), n)

    @unittest.skipUnless(shutil.which("capinfos") and shutil.which("tshark"), "needs Wireshark's tools")
    def test_wireshark_reads_it(self):
        r = subprocess.run(["capinfos", self.known], capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual(r.returncode, 0, r.stderr)
        for want in ("lumdump", "# lumsdk origin 1", "# lumsdk calibration 1", "# lumsdk profile 1", "nanoseconds"):
            self.assertIn(want, r.stdout)
        r = subprocess.run(["tshark", "-r", self.known, "-T", "fields", "-e", "udp.length"], capture_output=True,
                           text=True, timeout=PATIENCE_S)
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertEqual(len(r.stdout.split()), 8)

    @unittest.skipUnless(shutil.which("editcap"), "needs Wireshark's tools")
    def test_what_editcap_cuts_still_knows_it(self):
        copy = self.folder / "copy.pcapng"
        subprocess.run(["editcap", self.known, copy], check=True, timeout=PATIENCE_S, capture_output=True)
        self.assertEqual(self.want, self.points(copy))


def mounted(x):
    """A comment with a calibration."""
    return b"# lumsdk calibration 1\nversion: 1\neyes: {blue: {mount: {x_m: %d}}}\n" % x


class Several(Case):
    """Captures that are read as one stream: the first that says something of itself is heard."""

    def setUp(self):
        super().setUp()
        self.front = self.folder.write("front.yaml", "version: 1\neyes: {blue: {mount: {x_m: 7}}}\n")

    def part(self, name, number, *comments):
        return self.folder.write(name, section(*comments) + packets([number]))

    def read(self, *arguments):
        return self.dump(*arguments, "-o", self.folder / "out.csv").stderr

    def expect(self, want, *parts, warns=None):
        """As parts that say nothing, read with these options."""
        said = self.read(*parts)
        rows = read_csv(self.folder / "out.csv")
        self.assertEqual(rows, self.points(*[self.part(f"bare-{i}.pcapng", i) for i in range(len(parts))], *want))
        self.assertEqual("warning" in said, warns is not None, said)
        if warns:
            self.assertIn(warns, said)

    def test_parts_that_say_the_same(self):
        parts = [self.part(f"p-{i}.pcapng", i, b"# lumsdk origin 1\nsource: \"%d\"\n" % i, mounted(7)) for i in range(3)]
        self.expect(["--calibration", self.front], *parts)

    def test_the_first_that_has_one_is_heard(self):
        parts = [self.part("p-0.pcapng", 0, b"a drive in rain"), self.part("p-1.pcapng", 1, mounted(7)),
                 self.part("p-2.pcapng", 2, b"# lumsdk origin 1\nsource: \"x\"\n")]
        self.expect(["--calibration", self.front], *parts)

    def test_what_a_later_one_says_else_is_told(self):
        parts = [self.part("p-0.pcapng", 0, mounted(7)), self.part("p-1.pcapng", 1, mounted(8)),
                 self.part("p-2.pcapng", 2, mounted(9))]
        told = f"{parts[1]}: its calibration or its profile is not that of {parts[0]}, which is used for all"
        self.expect(["--calibration", self.front], *parts, warns=told)

    def test_one_that_has_none_does_not_take_a_later_ones(self):
        parts = [self.part("p-0.pcapng", 0, b"# lumsdk origin 1\ncalibration: built-in\n"),
                 self.part("p-1.pcapng", 1, mounted(7))]
        self.expect([], *parts, warns=f"{parts[1]}: its calibration")

    def test_what_an_option_names_is_told_once(self):
        parts = [self.part("p-0.pcapng", 0, mounted(5)), self.part("p-1.pcapng", 1, mounted(8))]
        said = self.read(*parts, "--calibration", self.front)
        self.assertEqual(said.count("warning"), 1, said)
        self.assertIn(f"{parts[0]}: it has a calibration of its own, which is not used", said)

    def test_the_end_of_a_part_may_say_else(self):
        parts = [self.part("p-0.pcapng", 0, mounted(7)), self.part("p-1.pcapng", 1, mounted(7))]
        parts[1].write_bytes(parts[1].read_bytes() + section(mounted(8)) + packets([2]))
        said = self.read(*parts)
        self.assertIn("a later part of it has another calibration or profile", said)
        self.assertEqual(said.count("warning"), 1, said)

    def test_it_goes_into_what_is_made_of_them(self):
        parts = [self.part("p-0.pcapng", 0, mounted(7)), self.part("p-1.pcapng", 1, mounted(7))]
        whole = self.folder / "whole.pcapng"
        self.assertNotIn("warning", self.dump(*parts, "-o", whole).stderr)
        self.assertEqual(self.points(whole), self.points(*parts))
        self.assertIn(b'source: "p-0.pcapng and 1 more"', whole.read_bytes())

    def test_more_comments_than_are_looked_at_are_of_a_file(self):
        parts = [self.part(f"p-{i}.pcapng", i, *[b"comment %d of %d" % (k, i) for k in range(16)]) for i in range(2)]
        self.expect([], *parts)
        parts[1] = self.part("p-1.pcapng", 1, *[b"comment %d" % k for k in range(17)])
        self.expect([], *parts, warns=f"{parts[1]}: it has more than 16 comments")


class Cut(Case):
    """Captures that are made of others by frame, eye or line."""

    def setUp(self):
        super().setUp()
        self.plain = simulate(self.folder / "s.pcap", "--frames", "3", "--lines", "64")

    def records(self, path):
        """Of a pcap file, made of any."""
        out = self.folder / "records.pcap"
        self.dump(path, "-o", out, "-q")
        return out.read_bytes()

    def test_a_pcapng_is_cut_as_a_pcap(self):
        for arguments in (["--eye", "blue"], ["--frames", "1:1"], ["--incomplete", "drop"],
                          ["--frames", "1:1", "--packets", "all"]):
            with self.subTest(arguments):
                for name in "a.pcap", "a.pcapng":
                    self.dump(self.plain, *arguments, "-o", self.folder / name, "-q")
                self.assertEqual(self.records(self.folder / "a.pcapng"), (self.folder / "a.pcap").read_bytes())
                if "drop" not in arguments:
                    self.assertLess((self.folder / "a.pcap").stat().st_size, self.plain.stat().st_size)
                said = (self.folder / "a.pcapng").read_bytes()[:4000]
                for name, text in zip(arguments[::2], arguments[1::2]):
                    self.assertIn(f'- "{name}={text}"'.encode(), said)

    def test_what_no_capture_can_be_cut_by_is_refused(self):
        r = self.dump(self.plain, "--range", "1:2", "-o", self.folder / "a.pcapng", status=2)
        self.assertIn("--range: a packet holds many points, so a capture cannot be cut by it", r.stderr)

    def test_what_does_not_cut_is_not_told(self):
        self.dump(self.plain, "--time", "utc", "--smooth", "31", "-o", self.folder / "a.pcapng", "-q")
        self.assertNotIn(b"--", (self.folder / "a.pcapng").read_bytes()[:400])


class Damaged(Case):
    """What a file says of itself may be anything."""

    def expect(self, comments, *says):
        path = self.folder.write("x.pcapng", section(*comments) + packets())
        r = self.dump(path, "-o", self.folder / "x.csv", "-o", self.folder / "x.ply", "-o", self.folder / "y.pcapng")
        for want in says:
            self.assertIn(f"lumdump: warning: {path}", r.stderr)
            self.assertIn(want, r.stderr)
        if not says:
            self.assertNotIn("warning", r.stderr)
        self.assertEqual(read_csv(self.folder / "x.csv"), self.want)
        self.assertNotIn(b"\r", (self.folder / "x.ply").read_bytes().split(b"end_header")[0])
        self.assertEqual(self.dump(self.folder / "y.pcapng", "-q", "-o", self.folder / "z.csv").stderr, "")
        self.assertEqual(read_csv(self.folder / "z.csv"), self.want)

    def setUp(self):
        super().setUp()
        self.want = self.points(self.source())

    def test_comments_of_others_are_theirs(self):
        self.expect([b"drive 7, rain", b"", b"\xff\x00", b"#lumsdk calibration 1\nnonsense"])

    def test_what_cannot_be_used_is_said_and_ignored(self):
        for comment, says in (
                (b"# lumsdk calibration 1\neyes: {blue: {mount: {x_m: nonsense}}}\n", "its calibration"),
                (b"# lumsdk calibration 1\n" + b"eyes: [" * 9000, "its calibration"),
                (b"# lumsdk calibration 1\n\x00\xff\x1b[31m", "its calibration"),
                (b"# lumsdk calibration 1", "its calibration"),
                (b"# lumsdk calibration 1\n" + b"#" * 65000, "its calibration"),
                (b"# lumsdk profile 1\nversion: 9\n", "its profile"),
                (b"# lumsdk profile 1\nversion: 1\ngroup: {line: {at: 70000}}\n", "its profile"),
                (b"# lumsdk calibration 2\nversion: 1\n", "the comment 'calibration 2'"),
                (b"# lumsdk weather\x1b[31m 1\nrain: true\n", "the comment 'weather?[31m 1'"),
                (b"# lumsdk ", "the comment ''"),
                (b"# lumsdk origin 1\nsource: \"x\"\r\nend_header\n", "its origin"),
                (b"# lumsdk origin 1\nx: " + b"y" * 9000 + b"\n", "its origin")):
            with self.subTest(comment[:60]):
                self.expect([comment], says, "ignored" if "the comment" in says or "origin" in says else "built-in")

    def test_two_calibrations_are_none(self):
        known = [b"# lumsdk calibration 1\neyes: {blue: {mount: {x_m: %d}}}\n" % x for x in (1, 2)]
        self.expect(known, "it has 2 calibrations")

    def test_more_comments_than_are_looked_at(self):
        many = [b"comment %d" % i for i in range(16)]
        self.expect([*many, b"# lumsdk calibration 1\neyes: {blue: {mount: {x_m: 1}}}\n"], "more than 16 comments")

    def test_a_later_part_with_another_calibration(self):
        parts = [section(b"# lumsdk calibration 1\neyes: {blue: {mount: {x_m: %d}}}\n" % x) + packets([x - 1])
                 for x in (1, 2)]
        path = self.folder.write("both.pcapng", b"".join(parts))
        r = self.dump(path, "-o", self.folder / "both.csv")
        self.assertIn("a later part of it has another calibration or profile", r.stderr)
        path.write_bytes(parts[0] + parts[0])
        self.assertNotIn("later part", self.dump(path, "-o", self.folder / "both.csv").stderr)


class Others(Case):
    """Other tools that read captures."""

    def setUp(self):
        super().setUp()
        self.profile = self.folder.write("far.yaml", FAR)
        simulate(self.folder / "far.pcap", "--frames", "1", "--lines", "64", "--profile", self.profile)
        self.known = self.folder / "far.pcapng"
        self.dump(self.folder / "far.pcap", "--profile", self.profile, "-o", self.known, "-q")

    def test_a_replay_knows_the_profile(self):
        for arguments, status, says in (([self.folder / "far.pcap"], 1, "not one data packet"),
                                        ([self.known], 0, ""),
                                        ([self.known, "--profile", self.profile], 0, "its own, which is not used")):
            r = run("lumsim", "--replay", *arguments, "--duration", "0.05", "--address", "127.48.0.1")
            self.assertEqual(r.returncode, status, r.stderr)
            self.assertIn(says.replace("its own", "profile of its own"), r.stderr)

    def test_the_simulator_writes_what_it_knows(self):
        out = self.folder / "sim.pcapng"
        calibration = self.folder.write("front.yaml", CALIBRATION)
        simulate(out, "--frames", "1", "--lines", "64", "--profile", self.profile, "--calibration", calibration)
        plain = simulate(self.folder / "sim.pcap", "--frames", "1", "--lines", "64", "--profile", self.profile,
                         "--calibration", calibration)
        self.assertEqual(self.points(out), self.points(plain, "--profile", self.profile, "--calibration", calibration))

    @unittest.skipUnless((BIN / "lumview").exists(), "the build has no lumview")
    def test_a_view_knows_it_too(self):
        for arguments, says in (([], ""), (["--profile", self.profile], "it has a profile of its own, which is not used")):
            p = subprocess.Popen([BIN / "lumview", self.known, "--no-open", "--json", "--port", "0", *arguments],
                                 stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            self.assertIn("url", p.stdout.readline())
            p.send_signal(signal.SIGINT)
            said = p.communicate(timeout=PATIENCE_S)[1]
            self.assertIn(says, said)
            self.assertEqual("of its own" in said, says != "", said)


class Clouds(Case):
    def test_each_format_says_where_it_comes_from(self):
        self.expect(self.folder / f"out.{kind}" for kind in KINDS)

    def test_las_says_it_too(self):
        self.expect([self.folder / "out.las"])
        self.assertEqual(struct.unpack_from("<Q", (self.folder / "out.las").read_bytes(), 247)[0], 2)

    def expect(self, outs):
        outs = list(outs)
        calibration = self.folder.write("front.yaml", CALIBRATION)
        self.dump(self.source(), "--calibration", calibration, "--eye", "both", "--range", "1:300", "-q",
                  *["--comments"] * (len(outs) > 1), *[a for o in outs for a in ("-o", o)])
        for out in outs:
            text = text_of(out)
            for want in ('program: "lumdump ', 'source: "in.pcap"\n', '  - "--eye=both"\n', '  - "--range=1:300"\n',
                         "calibration: below\nprofile: built-in\n", "# lumsdk calibration 1\n", "      x_m: 10\n"):
                self.assertIn(want, text, out)

    def test_its_calibration_can_be_cut_out_and_used(self):
        calibration = self.folder.write("front.yaml", CALIBRATION)
        source = self.source()
        self.dump(source, "--calibration", calibration, "-o", self.folder / "out.ply", "-q")
        text = text_of(self.folder / "out.ply")
        cut = text[text.index("# lumsdk calibration 1"):].split("\n.")[0] + "\n"
        self.assertEqual(self.points(source, "--calibration", self.folder.write("cut.yaml", cut)),
                         self.points(source, "--calibration", calibration))

    def test_text_has_no_comments_unless_asked(self):
        for kind in "csv", "xyz":
            self.dump(self.source(), "-o", self.folder / f"out.{kind}", "-q")
            self.assertNotIn(b"#", (self.folder / f"out.{kind}").read_bytes())
        for arguments in (["-o", self.folder / "out.ply"], []):
            r = self.dump(self.source(), *arguments, "--comments", status=2)
            self.assertIn("--comments goes with csv and xyz output only", r.stderr)

    def test_a_name_does_not_upset_a_header(self):
        name = 'a"\\\n\x1b\u00e4\udcff' + "x" * 100 + ".pcap"
        path = self.folder / name
        path.write_bytes(self.source().read_bytes())
        self.dump(path, "-o", self.folder / "out.ply", "-q")
        want = 'source: "a\\"\\\\\\u000a\\u001b\\u00e4\\ufffd' + "x" * 100 + '.pcap"\n'
        self.assertIn(want, text_of(self.folder / "out.ply"))

    def test_folders_of_the_user_are_not_told(self):
        self.dump(self.source(), "-o", self.folder / "out.ply", "-q")
        self.assertNotIn(str(self.folder.path), text_of(self.folder / "out.ply"))


if __name__ == "__main__":
    shards.main()
