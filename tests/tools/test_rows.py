"""What the rows of a cloud's file are: columns that were asked for, times in a frame, rows of pixels (--organized)."""
import collections
import json
import math
import operator
import struct
import unittest

import shards
from support import Folder, group, line, pcap, read_csv, run, simulate, udp, word

LINES = 20  # of a frame of each eye, in what is made by hand
PERIOD_US = 1500
FRAME_LINES_MAX = 65536  # of both eyes, that a frame can hold
NAMES = ("x y z range azimuth elevation pulse_width timestamp frame eye line pixel return_number number_of_returns "
         "edge").split()
TYPES = {("F", 4): "f", ("F", 8): "d", ("I", 4): "i", ("U", 4): "I", ("U", 2): "H", ("U", 1): "B"}


def clock_of(frame, number, eye):
    """Of a line; frames count from 1, and green is a little late."""
    return 10_000 + ((frame - 1) * LINES + number) * PERIOD_US + 100 * eye


def words_of(number):
    return [word(1000 + number, 0), word(3000 + number, 0), word(2000 + number, 500), word(4000, 999)]


def drive(change=None, frames=3, eyes=(0, 1)):
    """A capture of some frames, eyes in this order. change(frame, number, eye, packets) gives the packets of a line that
    are in it."""
    out = []
    for frame in range(1, frames + 1):
        for number in range(LINES):
            for eye in eyes:
                packets = list(line(words_of(number), eye, number, clock_of(frame, number, eye)))
                packets = packets if change is None else change(frame, number, eye, packets)
                out += [udp(p) for p in packets]
    return pcap(out)


Cloud = collections.namedtuple("Cloud", "header comments points")


def read_pcd(path):
    """Header, comments, and a dictionary for each point."""
    header, comments, data = {}, [], path.read_bytes()
    while "DATA" not in header:
        text, data = data.split(b"\n", 1)
        text = text.decode()
        if text.startswith("#"):
            comments.append(text)
        else:
            key, *header[key] = text.split(" ")
    names = ["pulse_width" if n == "intensity" else n for n in header["FIELDS"]]
    if header["DATA"] == ["ascii"]:
        rows = [tuple(map(float, row.split(b" "))) for row in data.splitlines()]
    else:
        layout = struct.Struct("<" + "".join(TYPES[t, int(s)] for t, s in zip(header["TYPE"], header["SIZE"])))
        rows = list(layout.iter_unpack(data))
    return Cloud(header, comments, [dict(zip(names, row)) for row in rows])


class Case(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def dump(self, source, *arguments, status=0, **options):
        r = run("lumdump", source, "-q", *arguments, **options)
        self.assertEqual(r.returncode, status, r.stderr)
        return r

    def assert_left_out(self, source, *arguments, says, late=0, cut=0, no_place=0):
        """A cloud of these options lacks points, and one of lines as they come beside it lacks none."""
        lacking = self.folder / "lacking.pcd"
        outputs = ["-o", lacking, "-o", self.folder / "whole.xyz"]
        r = run("lumdump", source, *arguments, *outputs)
        self.assertEqual(r.returncode, 0, r.stderr)
        told = [text for text in r.stderr.splitlines() if "left out" in text]
        self.assertEqual(told, [f"lumdump: warning: {lacking}: {late + cut + no_place} points left out, which {says}"])
        r = self.dump(source, *arguments, *outputs, "--json")
        self.assertEqual(r.stderr, "")
        self.assertEqual(json.loads(r.stdout)["left_out"],
                         [{"output": str(lacking), "late": late, "cut": cut, "no_place": no_place}])

    def refused(self, *arguments, says):
        r = self.dump(self.folder.write("in.pcap", drive(frames=1)), *arguments, status=2)
        self.assertIn(says, r.stderr)
        self.assertEqual(self.folder.names(), ["in.pcap"])

    def street(self, *arguments):
        return simulate(self.folder / "street.pcap", "--frames", "2", "--loss", "0.01", *arguments)


class Columns(Case):
    def test_rows_are_those_of_the_whole_file(self):
        source = self.street()
        self.dump(source, "-o", self.folder / "all.csv")
        self.dump(source, "--columns", "pixel,z,timestamp,pulse_width,eye", "-o", self.folder / "some.csv",
                  "-o", self.folder / "some.ply", "-o", self.folder / "some.pcd", "--ascii")
        want = [",".join(row[n] for n in ("pixel", "z", "timestamp", "pulse_width", "eye"))
                for row in read_csv(self.folder / "all.csv")]
        header, *got = (self.folder / "some.csv").read_text().splitlines()
        self.assertEqual(header, "pixel,z,timestamp,pulse_width,eye")
        self.assertEqual(got, want)
        for name, end in ("some.ply", "\nend_header\n"), ("some.pcd", "\nDATA ascii\n"):
            header, rows = (self.folder / name).read_text().split(end)
            self.assertEqual(rows.splitlines(), [row.replace(",", " ") for row in want])
        self.assertIn("\nFIELDS pixel z timestamp intensity eye\n", header)

    def test_outputs_that_have_no_choice_are_as_ever(self):
        source = self.street()
        self.dump(source, "-o", self.folder / "a.las", "-o", self.folder / "a.xyz", "-o", self.folder / "a.png")
        self.dump(source, "-o", self.folder / "b.las", "-o", self.folder / "b.xyz", "-o", self.folder / "b.png",
                  "-o", self.folder / "b.csv", "--columns", "x,time")
        for ending in "las", "xyz", "png":
            self.assertEqual((self.folder / f"b.{ending}").read_bytes(), (self.folder / f"a.{ending}").read_bytes())
        self.assertEqual(len(read_csv(self.folder / "b.csv")),
                         (self.folder / "b.xyz").read_bytes().count(b"\n"))

    def test_what_cannot_be_is_refused(self):
        for ending in "las", "xyz", "png", "pcap", "pcapng":
            self.refused("-o", self.folder / f"o.{ending}", "--columns", "x",
                         says="--columns goes with csv, ply and pcd output only")
        self.refused("--columns", "x", says="--columns goes with csv, ply and pcd output only")
        for names, says in (("x,foo", "'foo' is not a column; columns are x, y, z, range, "), ("x,x", "x is named twice"),
                            ("", "'' is not a column"), ("x,", "'' is not a column"), ("intensity", "pulse_width")):
            self.refused("-o", self.folder / "o.csv", "--columns", names, says=says)


class Times(Case):
    """The column time."""

    def rows(self, data, *arguments):
        source = self.folder.write("in.pcap", data)
        out = self.folder / "t.csv"
        self.dump(source, "--columns", "frame,line,eye,pixel,timestamp,time", "-o", out, *arguments)
        return read_csv(out)

    def check(self, rows, begins, clocks=True):
        """begins: the clock of each frame's earliest line."""
        self.assertEqual({int(r["frame"]) for r in rows}, set(begins))
        for r in rows:
            frame, number, eye, pixel = (int(r[n]) for n in ("frame", "line", "eye", "pixel"))
            clock = clock_of(frame, number, eye)
            if clocks:
                self.assertEqual(int(r["timestamp"]), clock)
            want = (clock - begins[frame] + pixel * PERIOD_US / 1000) * 1e-6
            self.assertAlmostEqual(float(r["time"]), want, delta=4e-9)

    def test_it_counts_from_the_earliest_line_of_the_frame(self):
        rows = self.rows(drive())
        self.check(rows, {n: clock_of(n, 0, 0) for n in (1, 2, 3)})
        self.assertEqual(len(rows), 3 * 2 * LINES * 4)

    def test_also_if_that_line_comes_behind_others(self):
        rows = self.rows(drive(eyes=(1, 0)))
        self.assertEqual((rows[0]["line"], rows[0]["eye"]), ("0", "1"))
        self.check(rows, {n: clock_of(n, 0, 0) for n in (1, 2, 3)})

    def test_lines_that_did_not_come_are_no_begin(self):
        rows = self.rows(drive(lambda frame, number, eye, packets: packets if frame == 1 or number > 2 else []))
        self.check(rows, {1: clock_of(1, 0, 0), 2: clock_of(2, 3, 0), 3: clock_of(3, 3, 0)})

    def test_lines_that_are_not_asked_for_are_no_begin_either(self):
        self.check(self.rows(drive(), "--eye", "green"), {n: clock_of(n, 0, 1) for n in (1, 2, 3)})

    def test_what_timestamps_are_does_not_matter(self):
        for time in "utc", "arrival":
            self.check(self.rows(drive(), "--time", time), {n: clock_of(n, 0, 0) for n in (1, 2, 3)}, clocks=False)

    def test_frames_that_are_chosen_are_timed_as_ever(self):
        self.check(self.rows(drive(), "--frames", "2:2"), {2: clock_of(2, 0, 0)})

    def test_no_point_is_lost_and_no_number_changes(self):
        source = self.street()
        self.dump(source, "-o", self.folder / "plain.csv")
        self.dump(source, "--columns", ",".join([*NAMES, "time"]), "-o", self.folder / "timed.csv",
                  "-o", self.folder / "t-%d.csv")
        want = (self.folder / "plain.csv").read_text().splitlines()[1:]
        timed = (self.folder / "timed.csv").read_text().splitlines()[1:]
        self.assertGreater(len(want), 100_000)
        self.assertEqual(sorted(row.rsplit(",", 1)[0] for row in timed), sorted(want))
        apart = [row for n in (1, 2) for row in (self.folder / f"t-{n}.csv").read_text().splitlines()[1:]]
        self.assertEqual(apart, timed)

    def test_points_that_come_when_their_frame_is_written_are_told(self):
        """An eye falls silent within a line and comes back much later."""
        def change(frame, number, eye, packets):
            is_last = (frame, number, eye) == (1, 10, 1)
            is_silent = eye == 1 and (1, 10) < (frame, number) < (8, 0)
            return packets[:2] + packets[3:] if is_last else [] if is_silent else packets
        data = drive(change, frames=9)
        rows = self.rows(data)
        self.dump(self.folder / "in.pcap", "-o", self.folder / "plain.csv")
        late = len(read_csv(self.folder / "plain.csv")) - len(rows)
        self.assertGreater(late, 0)
        self.assert_left_out(self.folder / "in.pcap", "--columns", "x,time", late=late,
                             says="came after their frame had been written")

    def test_points_that_a_full_frame_has_no_room_for_are_told(self):
        """So many lines in one frame, without angles but for the last one."""
        data = [udp(group(3, eye, number, [word(1, 1)], 0, clock_of(1, number, eye)))
                for number in range(FRAME_LINES_MAX // 2 + 50) for eye in (0, 1)]
        last = FRAME_LINES_MAX // 2 + 50
        data += [udp(p) for p in line(words_of(0), 0, last, clock_of(1, last, 0))]
        source = self.folder.write("in.pcap", pcap(data))
        self.dump(source, "-o", self.folder / "plain.csv")
        cut = len(read_csv(self.folder / "plain.csv"))
        self.assertGreater(cut, 0)
        self.assert_left_out(source, "--columns", "x,time", cut=cut, says="are beyond the most that a frame can hold")

    def test_the_outputs_that_lack_nothing_are_not_named(self):
        source = self.folder.write("in.pcap", drive())
        r = run("lumdump", source, "--columns", "x,time", "-o", self.folder / "t.csv", "--json")
        self.assertEqual((json.loads(r.stdout)["left_out"], r.stderr), ([], ""))
        self.assertEqual(json.loads(run("lumdump", source, "--json").stdout)["left_out"], [])

    def test_files_that_rotate_hold_them_all(self):
        source = self.street()
        what = ["--columns", "frame,eye,line,pixel,x,y,z,time"]
        self.dump(source, *what, "-o", self.folder / "one.csv")
        self.dump(source, *what, "-o", self.folder / "r.csv", "--rotate", "50kB")
        parts = [(self.folder / n).read_text().split("\n", 1)[1] for n in self.folder.names() if n.startswith("r-")]
        self.assertGreater(len(parts), 1)
        self.assertEqual("".join(parts), (self.folder / "one.csv").read_text().split("\n", 1)[1])

    def test_a_pipe_gets_them_too(self):
        self.dump(self.folder.write("in.pcap", drive()), "--columns", "x,y,z,time", "-o", self.folder / "a.ply")
        r = self.dump(self.folder / "in.pcap", "--columns", "x,y,z,time", "-o", "-", "--format", "ply")
        self.assertEqual(r.stdout_bytes, (self.folder / "a.ply").read_bytes())
        r = self.dump("-", "--columns", "time", "-o", "-", "--format", "csv", stdin=drive())
        self.assertEqual(r.stdout.splitlines()[:2], ["time", "0.000000000"])


class Organized(Case):
    def clouds(self, data, *arguments, returns="first"):
        """Of each frame that has one."""
        source = self.folder.write("in.pcap", data) if isinstance(data, bytes) else data
        for name in self.folder.names():
            if name.endswith(".pcd"):
                (self.folder / name).unlink()
        self.said = run("lumdump", source, "--organized", "--return", returns, "-o", self.folder / "f-%d.pcd", *arguments)
        self.assertEqual(self.said.returncode, 0, self.said.stderr)
        return {int(n[2:-4]): read_pcd(self.folder / n) for n in self.folder.names() if n.endswith(".pcd")}

    def check_shape(self, cloud, rows, eyes=(0, 1)):
        """That each point is where it belongs, and what is known of where there is none."""
        header, points = cloud.header, cloud.points
        self.assertEqual((header["WIDTH"], header["HEIGHT"]), (["1000"], [str(rows)]))
        self.assertEqual(header["POINTS"], [str(rows * 1000)])
        self.assertEqual(header["VIEWPOINT"], "0 0 0 1 0 0 0".split())
        self.assertEqual(len(points), rows * 1000)
        lines = rows // len(eyes)
        places = [(eye, number, pixel) for eye in eyes for number in range(lines) for pixel in range(1000)]
        self.assertTrue([(p["eye"], p["line"], p["pixel"]) for p in points] == places, "points are not where they belong")
        known = operator.itemgetter(*NAMES[:7])
        numbers = operator.itemgetter("return_number", "number_of_returns", "edge")
        for place, p in zip(places, points):
            missing = sum(map(math.isnan, known(p)))
            if missing != 0 and (missing != 7 or numbers(p) != (0, 0, 0)):
                self.fail(f"{place}: {p}")

    def lost(self, cloud):
        """(eye, line) of the rows without a point."""
        return {(row[0]["eye"], row[0]["line"]) for row in self.rows_of(cloud) if all(math.isnan(p["x"]) for p in row)}

    def rows_of(self, cloud):
        return [cloud.points[i:i + 1000] for i in range(0, len(cloud.points), 1000)]

    def test_points_are_those_of_an_unorganised_cloud(self):
        source = self.street("--lines", "64")
        for returns in "last", "2":
            clouds = self.clouds(source, returns=returns)
            self.assertEqual(set(clouds), {1, 2})
            self.dump(source, "--return", returns, "-o", self.folder / "plain.pcd")
            plain = collections.Counter(tuple(p.values()) for p in read_pcd(self.folder / "plain.pcd").points)
            got = collections.Counter(tuple(p.values()) for c in clouds.values() for p in c.points
                                      if not math.isnan(p["x"]))
            self.assertEqual(got, plain)
            self.assertGreater(sum(got.values()), 10_000)
            for number, cloud in clouds.items():
                self.check_shape(cloud, 128)
                self.assertEqual({p["frame"] for p in cloud.points}, {number})
        self.assertNotIn("left out", self.said.stderr)

    def test_what_a_selection_leaves_out_is_missing(self):
        source = self.street("--lines", "64")
        for arguments, eyes in ((["--eye", "green", "--ascii"], (1,)), (["--range", "5:30"], (0, 1))):
            clouds = self.clouds(source, *arguments)
            self.dump(source, "--return", "first", *arguments, "-o", self.folder / "plain.pcd")
            plain = read_pcd(self.folder / "plain.pcd").points
            got = [p for c in clouds.values() for p in c.points if not math.isnan(p["x"])]
            self.assertEqual(len(got), len(plain))
            self.assertEqual(sorted(p["range"] for p in got), sorted(p["range"] for p in plain))
            for cloud in clouds.values():
                self.check_shape(cloud, 64 * len(eyes), eyes)

    def test_a_line_that_did_not_come_is_a_row_without_points(self):
        def change(frame, number, eye, packets):
            if (frame, number, eye) == (2, 5, 0):
                return []
            return packets[:3] if (frame, number, eye) == (2, 9, 1) else packets  # no ranges
        clouds = self.clouds(drive(change))
        for number, cloud in clouds.items():
            self.check_shape(cloud, 2 * LINES)
            self.assertEqual(self.lost(cloud), {(0, 5), (1, 9)} if number == 2 else set())
            for row in self.rows_of(cloud):
                key = row[0]["line"], row[0]["eye"]
                found = [p["pixel"] for p in row if not math.isnan(p["x"])]
                times = {p["timestamp"] for p in row}
                if (number, *key) == (2, 5, 0):
                    self.assertTrue(all(map(math.isnan, times)))
                    continue
                self.assertEqual(times, {clock_of(number, *key)})
                self.assertEqual(found, [] if (number, *key) == (2, 9, 1) else [0, 500, 999])
        self.assertEqual(len(clouds), 3)

    def test_the_last_lines_count_though_they_are_lost(self):
        def change(frame, number, eye, packets):
            return [] if frame == 2 and number >= LINES - 3 else packets
        for number, cloud in self.clouds(drive(change)).items():
            self.check_shape(cloud, 2 * LINES)
            lost = {(eye, n) for eye in (0, 1) for n in range(LINES - 3, LINES)}
            self.assertEqual(self.lost(cloud), lost if number == 2 else set())

    def test_lines_that_are_not_whole_have_their_place(self):
        """Of every line a third of the angles is lost."""
        clouds = self.clouds(drive(lambda frame, number, eye, packets: packets[:2] + packets[3:]))
        for cloud in clouds.values():
            self.check_shape(cloud, 2 * LINES)
            self.assertEqual(self.lost(cloud), set())
        self.assertEqual(len(clouds), 3)

    def test_a_frame_without_any_line_has_no_file(self):
        clouds = self.clouds(drive(lambda frame, number, eye, packets: [] if (frame, eye) == (2, 1) else packets),
                             "--eye", "green")
        self.assertEqual(set(clouds), {1, 3})
        for cloud in clouds.values():
            self.check_shape(cloud, LINES, (1,))

    def test_a_frame_without_any_point_has_rows(self):
        clouds = self.clouds(drive(lambda frame, number, eye, packets: packets[:3]))
        for cloud in clouds.values():
            self.check_shape(cloud, 2 * LINES)
            self.assertEqual(len(self.lost(cloud)), 2 * LINES)
        self.assertEqual(len(clouds), 3)

    def test_a_damaged_number_makes_no_large_file_and_is_told(self):
        def change(frame, number, eye, packets):
            if (frame, number, eye) != (2, 10, 0):
                return packets
            extra = [word(2222, 7), word(2223, 8)]
            clock = clock_of(2, 10, 0) + 700
            straight = [struct.pack("<hh", 0, 0)] * 334
            return packets + [group(2, 0, 4000, straight, 0, clock), group(3, 0, 4000, extra, 0, clock)]
        clouds = self.clouds(drive(change))
        plain = self.folder / "plain.csv"
        self.dump(self.folder / "in.pcap", "--return", "first", "-o", plain)
        self.assertEqual({r["line"] for r in read_csv(plain)} - {str(n) for n in range(LINES)}, {"4000"})
        for cloud in clouds.values():
            self.check_shape(cloud, 2 * LINES)
        self.assertEqual(sum(not math.isnan(p["x"]) for c in clouds.values() for p in c.points),
                         len(read_csv(plain)) - 2)
        self.assertIn(": 2 points left out, which have no place in an organised cloud\n", self.said.stderr)
        self.assert_left_out(self.folder / "in.pcap", "--organized", "--return", "first", "--frames", "2:2", no_place=2,
                             says="have no place in an organised cloud")

    def test_one_frame_may_have_one_name(self):
        clouds = self.clouds(drive())
        self.dump(self.folder / "in.pcap", "--organized", "--return", "first", "--frames", "2:2", "-o",
                  self.folder / "one.pcd")
        one = read_pcd(self.folder / "one.pcd")
        self.assertEqual(one.header, clouds[2].header)
        self.assertEqual(str(one.points), str(clouds[2].points))  # NaN is not equal to itself
        self.assertIn('#   - "--frames=2:2"', one.comments)
        self.assertTrue(any("row is a line" in c for c in one.comments))
        # Its size is known when it begins, so that it may be a pipe, and what is read too.
        r = self.dump("-", "--organized", "--return", "first", "--frames", "2:2", "-o", "-", "--format", "pcd",
                      stdin=drive())
        self.assertEqual(r.stdout_bytes.split(b"DATA binary\n")[1],
                         (self.folder / "one.pcd").read_bytes().split(b"DATA binary\n")[1])

    def test_a_frame_that_did_not_come_has_no_rows(self):
        self.dump(self.folder.write("in.pcap", drive()), "--organized", "--return", "last", "--frames", "7:7",
                  "-o", self.folder / "one.pcd")
        none = read_pcd(self.folder / "one.pcd")
        self.assertEqual((none.header["WIDTH"], none.header["HEIGHT"], none.points), (["1000"], ["0"], []))

    def test_other_outputs_go_on_beside_it_and_columns_are_its_own_too(self):
        source = self.folder.write("in.pcap", drive())
        self.dump(source, "--return", "first", "-o", self.folder / "want.las")
        clouds = self.clouds(source, "-o", self.folder / "a.las", "-o", self.folder / "a.csv", "--columns", "z,time,line")
        # but for the options that it tells
        self.assertEqual((self.folder / "a.las").read_bytes()[-100_000:], (self.folder / "want.las").read_bytes()[-100_000:])
        rows = read_csv(self.folder / "a.csv")
        got = [p for c in clouds.values() for p in c.points if not math.isnan(p["z"])]
        self.assertEqual(len(rows), len(got))
        self.assertEqual(sorted(float(r["time"]) for r in rows), sorted(round(p["time"], 9) for p in got))
        self.assertTrue(all(math.isnan(p["time"]) for c in clouds.values() for p in c.points if math.isnan(p["z"])))
        self.assertEqual(clouds[1].header["FIELDS"], ["z", "time", "line"])

    def test_what_cannot_be_is_refused(self):
        organized = ("--organized", "--return", "first", "-o")
        for ending in "csv", "ply", "las", "xyz", "png", "pcap", "pcapng":
            self.refused(*organized, self.folder / f"f-%d.{ending}", says="--organized goes with pcd output only")
        self.refused(*organized[:3], says="--organized goes with pcd output only")
        self.refused("--organized", "-o", self.folder / "f-%d.pcd", says="--return first, last, strongest or a number")
        self.refused(*organized, self.folder / "f-%d.pcd", "--edge", "both", says="--edge rising or falling")
        for frames in [], ["--frames", "1:2"], ["--frames", "1:"]:
            self.refused(*organized, self.folder / "f.pcd", *frames, says="a file of each frame: put %04d")
        self.refused(*organized, self.folder / "f.pcd", "--frames", "1:1", "--rotate", "1MB", says="--rotate")


if __name__ == "__main__":
    shards.main()
