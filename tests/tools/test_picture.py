"""Pictures that lumdump draws: their size, their text, what stands where. Nothing here depends on the shape of letters."""
import json
import pathlib
import re
import unittest

import png_rows
import shards
from support import Folder, run, simulate
from test_rows import drive
from test_sources import split

HERE = pathlib.Path(__file__).resolve().parent
PAPER = (24, 26, 32)
PANEL = (12, 13, 16)
# Where docs/formats.md has them: a title and more text at the left and the time at the right, below it the view from above with
# the colour scale at its right, and the image of both eyes at the bottom, the green eye's half first.
TITLE, MORE = range(16, 46), range(52, 76)
ABOVE, BAR = range(112, 840), range(1456, 1484)
BOTH = range(902, 1152)
EYES = {"green": range(80, 826), "blue": range(834, 1578)}
TIME = range(1000, 1600)


class Picture(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)
        self.capture = self.folder / "s.pcap"
        self.assertEqual(run("lumsim", "-o", self.capture, "--frames", "1", "--lines", "64", "--seed", "1").returncode, 0)

    def draw(self, *arguments, **options):
        path = self.folder / "look.png"
        r = run("lumdump", self.capture, "-q", *arguments, "-o", path, **options)
        self.assertEqual((r.returncode, r.stderr), (0, ""))
        return path.read_bytes()

    def share_of_points(self, rows, eye):
        """How much of an eye's half of the image shows something; not where the far end of the street is, or beyond."""
        middle = range(EYES[eye].start, EYES[eye].start + 600) if eye == "green" else range(EYES[eye].stop - 600, EYES[eye].stop)
        pixels = [c for row in rows[BOTH.start + 30:BOTH.stop - 10:30] for c in png_rows.colours(row, middle.start, middle.stop)]
        return sum(c != PANEL for c in pixels) / len(pixels)

    def inked(self, rows, where, columns=range(0, 1000)):
        """The columns of the text in these rows."""
        return [x for y in where for x, c in enumerate(png_rows.colours(rows[y], columns.start, columns.stop)) if c != PAPER]

    def test_it_is_a_whole_png_of_the_size_that_is_documented(self):
        data = self.draw()
        self.assertEqual(png_rows.size(data), (1600, 1200))
        rows = png_rows.rows(data, 10)
        self.assertEqual({c for row in rows for c in png_rows.colours(row, 0, 1600)}, {PAPER})

    def test_it_has_the_size_that_is_asked_for_and_a_degree_is_as_wide_as_high(self):
        self.assertEqual(png_rows.size(self.draw("--size", "3200x2400")), (3200, 2400))
        for width, height in ((800, 1000), (1000, 640)):
            with self.subTest(width=width, height=height):
                data = self.draw("--size", f"{width}x{height}")
                self.assertEqual(png_rows.size(data), (width, height))
                rows = [png_rows.colours(row, 0, width) for row in png_rows.rows(data)]
                column = "".join(" #"[row[width // 3] != PAPER] for row in rows)
                image = [match for match in re.finditer("#{30,}", column)][-1]  # above it is the scene, below it are numbers
                across = [x for x, c in enumerate(rows[image.end() - 9]) if c != PAPER and x > 0.02 * width]
                self.assertAlmostEqual((across[-1] - across[0] + 1) / len(image[0]), 120 / 20, delta=0.15)

    def test_the_title_tells_file_frame_time_edge_return_and_calibration(self):
        first = png_rows.rows(self.draw(), MORE.stop)
        self.assertGreater(len(self.inked(first, TITLE, TIME)), 500)
        for what, arguments, where in (("edge", ("--edge", "falling"), MORE), ("return", ("--return", "first"), MORE),
                                       ("calibration", ("--set", "tof_lsb_ps=12.9"), MORE)):
            with self.subTest(what):
                other = png_rows.rows(self.draw(*arguments), MORE.stop)
                self.assertEqual([self.inked(other, rows) == self.inked(first, rows) for rows in (TITLE, MORE)], [True, False])
        data = self.capture.read_bytes()
        self.capture = self.folder.write("another name.pcap", data)
        renamed = png_rows.rows(self.draw(), MORE.stop)
        self.assertGreater(max(self.inked(renamed, TITLE)), max(self.inked(first, TITLE)))
        self.assertEqual(self.inked(renamed, MORE), self.inked(first, MORE))

    def test_a_picture_of_each_frame_has_its_time(self):
        self.drive("drive.pcap")
        self.assertEqual(run("lumdump", self.capture, "-q", "-o", self.folder / "f-%d.png").returncode, 0)
        two = self.folder / "f-2.png"
        self.assertEqual(two.read_bytes(), self.draw("--frames", "2:2"))
        times = [self.inked(png_rows.rows((self.folder / f"f-{i}.png").read_bytes(), TITLE.stop), TITLE, TIME) for i in (1, 2)]
        self.assertTrue(times[0] and times[0] != times[1])

    def test_packets_without_times_give_a_picture_none(self):
        data = bytearray(self.capture.read_bytes())
        at = 24
        while at < len(data):
            data[at:at + 8] = bytes(8)
            at += 16 + int.from_bytes(data[at + 8:at + 12], "little")
        self.capture = self.folder.write("no-times.pcap", bytes(data))
        self.assertEqual(self.inked(png_rows.rows(self.draw(), TITLE.stop), TITLE, TIME), [])

    def test_text_is_smooth(self):
        rows = png_rows.rows(self.draw(), TITLE.stop)
        seen = {c for y in TITLE for c in png_rows.colours(rows[y], 0, 1600)}
        self.assertIn(PAPER, seen)
        self.assertGreater(len(seen), 20, "letters of two colours have steps")

    def test_the_title_has_lower_case(self):
        """Of lower case letters more ink is in their lower half: few of them reach the top of capitals."""
        rows = png_rows.rows(self.draw(), TITLE.stop)
        ink = [sum(c != PAPER for c in png_rows.colours(rows[y], 0, 200)) for y in TITLE]
        inked = [n for n in ink if n]
        third = len(inked) // 3
        self.assertLess(1.5 * sum(inked[:third]), sum(inked[third:2 * third]))

    def test_it_is_the_same_whatever_fonts_a_machine_has(self):
        data = self.draw()
        bare = {"FONTCONFIG_FILE": "/nonexistent/fonts.conf", "HOME": "/nonexistent", "LC_ALL": "C"}
        self.assertEqual(self.draw(env=bare), data)

    def test_each_eye_has_its_place(self):
        for eye, other in (("green", "blue"), ("blue", "green")):
            with self.subTest(eye):
                rows = png_rows.rows(self.draw("--eye", eye), BOTH.stop)
                self.assertGreater(self.share_of_points(rows, eye), 0.98)
                self.assertEqual(self.share_of_points(rows, other), 0)

    def test_a_picture_of_no_points_says_so_by_its_title(self):
        full = png_rows.rows(self.draw(), BOTH.stop)
        none = png_rows.rows(self.draw("--range", "900:999"), BOTH.stop)
        self.assertEqual([self.share_of_points(none, eye) for eye in EYES], [0, 0])
        self.assertGreater(max(self.inked(none, TITLE)), 200)
        self.assertEqual(self.inked(none, TITLE, TIME), [], "no frame, no time")
        self.assertGreater(max(self.inked(full, MORE)), max(self.inked(none, MORE)))

    def drive(self, name, *arguments):
        self.capture = simulate(self.folder / name, "--frames", "4", "--lines", "64", *arguments)

    def said(self, *arguments):
        """What lumdump says of the picture: the end of its summary, its JSON, its warnings."""
        texts = [run("lumdump", self.capture, *arguments, "-o", self.folder / "said.png", *more) for more in ([], ["--json"])]
        picture = f"picture    {self.folder / 'said.png'} shows "
        shows = [line[len(picture):] for line in texts[0].stderr.splitlines() if line.startswith(picture)]
        [pictured] = json.loads(texts[1].stdout)["pictures"]
        self.assertEqual((pictured.pop("output"), len(shows)), (str(self.folder / "said.png"), 1))
        return shows[0], pictured, [line for line in texts[1].stderr.splitlines() if "shows" in line]

    def points_of(self, frames):
        return json.loads(run("lumdump", self.capture, "--json", "--frames", frames).stdout)["points"]

    def test_of_a_capture_it_shows_the_first_whole_frame(self):
        self.drive("drive.pcap")
        self.assertEqual(self.draw(), self.draw("--frames", "1:1"))
        self.assertEqual(self.said(), ("frame 1, the first whole one; 3 others are not drawn, see --frames",
                                       {"frames": 1, "files": 1, "points": self.points_of("1:1"), "first": 1, "last": 1,
                                        "is_whole": True, "others": 3}, []))
        header, records = split(self.capture.read_bytes())
        self.capture = self.folder.write("joined.pcap", header + b"".join(records[len(records) // 20:]))
        self.assertEqual(self.draw(), self.draw("--frames", "2:2"))
        self.assertEqual(self.said()[0], "frame 2, the first whole one; 3 others are not drawn, see --frames")

    def test_a_frame_in_which_the_laser_came_on_is_shown_only_for_want_of_another(self):
        def dark(frame, number, eye, packets):
            return packets[:3] if (frame, number) < (2, 2) else packets
        self.capture = self.folder.write("dark.pcap", drive(dark, frames=4))
        self.assertEqual(self.draw(), self.draw("--frames", "3:3"))
        self.assertEqual(self.draw(), self.draw("--frames", "whole:1"))
        self.assertEqual(self.said()[0], "frame 3, the first whole one; 2 others are not drawn, see --frames")
        self.capture = self.folder.write("dark.pcap", drive(dark, frames=2))
        self.assertEqual((self.said()[0], self.said()[1]["is_whole"]), ("frame 2", True))

    def test_without_a_whole_frame_it_shows_the_first_and_warns(self):
        self.drive("lossy.pcap", "--loss", "0.05")
        self.assertEqual(self.draw(), self.draw("--frames", "1:1"))
        shows, pictured, warnings = self.said()
        self.assertEqual(shows, "frame 1, the first with points, as none is whole; 3 others are not drawn, see --frames")
        self.assertEqual((pictured["first"], pictured["is_whole"]), (1, False))
        self.assertEqual(warnings, [f"lumdump: warning: {self.folder / 'said.png'}: it shows {shows}"])
        shows = "frame 2, which is not whole"
        self.assertEqual(self.said("--frames", "2:2")[::2], (shows, [f"lumdump: warning: {self.folder / 'said.png'}: it shows {shows}"]))
        self.assertEqual(self.said("--frames", "2:3")[2], [])

    def test_what_came_late_is_told_of_frames_that_were_asked_for(self):
        """Each line of the capture is whole but one of frame 1, of which a packet comes when frame 8 does."""
        def change(frame, number, eye, packets):
            is_silent = eye == 1 and (1, 10) < (frame, number) < (8, 0)
            return packets[:2] + packets[3:] if (frame, number, eye) == (1, 10, 1) else [] if is_silent else packets
        self.capture = self.folder.write("late.pcap", drive(change, frames=9))
        for frames, is_late in (("1:1", True), ("1:2", True), ("2:2", False), (":", False)):
            with self.subTest(frames):
                chosen = ["--frames", frames] if frames != ":" else []
                r = run("lumdump", self.capture, *chosen, "--json", "-o", self.folder / "look.png")
                late = [one["late"] for one in json.loads(r.stdout)["left_out"]]
                self.assertEqual((len(late), r.stderr.count("came after their frame had been written")), (is_late, is_late))

    def test_pictures_of_a_rotation_are_counted(self):
        self.drive("long.pcap", "--frames", "25")
        said = run("lumdump", self.capture, "--rotate", "1s", "-o", self.folder / "r.png", "--json")
        names = [name for name in self.folder.names() if name.startswith("r-")]
        [pictured] = json.loads(said.stdout)["pictures"]
        self.assertEqual((pictured["frames"], pictured["files"], len(names), said.stderr), (25, 3, 3, ""))
        shows = f"picture    {self.folder / 'r.png'} shows "
        for how, says in ((("1s",), "25 frames in 3 pictures, 1 to 25"), (("1h",), "25 frames over each other, 1 to 25"),
                          (("1s", "--frames", "5:5"), "frame 5"), (("1s", "--frames", "5:16"), "12 frames in 2 pictures, 5 to 16")):
            with self.subTest(how):
                r = run("lumdump", self.capture, "--rotate", *how, "-o", self.folder / "r.png")
                self.assertEqual([line[len(shows):] for line in r.stderr.splitlines() if line.startswith(shows)], [says])

    def test_several_frames_are_drawn_if_they_are_asked_for(self):
        self.drive("drive.pcap")
        self.assertNotEqual(self.draw("--frames", "2:4"), self.draw("--frames", "2:2"))
        self.assertEqual(self.said("--frames", "2:4"), ("3 frames over each other, 2 to 4", {
            "frames": 3, "files": 1, "points": self.points_of("2:4"), "first": 2, "last": 4, "others": 0}, []))
        self.assertEqual(self.said("--range", "900:999")[:2], ("no frame with points", {"frames": 0, "files": 0, "points": 0,
                                                                                               "others": 0}))

    def scale(self, rows):
        """The colours of the scale, from its lower end."""
        return [c for c in (png_rows.colours(row, 0, 1600)[BAR.start + 9] for row in reversed(rows[ABOVE.start:ABOVE.stop])) if c != PAPER]

    def test_colours_are_ranges(self):
        """Of a wall of trees and cars, what is near is dark and blue; the end of the street is far: bright and yellow."""
        rows = png_rows.rows(self.draw(), BOTH.stop)
        near = png_rows.colours(rows[BOTH.stop - 12], EYES["blue"].start, EYES["blue"].stop)
        self.assertTrue(all(c == PANEL or c[2] > c[0] for c in near))
        far = png_rows.colours(rows[BOTH.start + 12], 700, EYES["green"].stop)
        self.assertGreater(sum(red > blue for red, _, blue in far), len(far) / 3)

    def test_each_colouring_has_its_picture_and_the_same_scale(self):
        made = {colour: png_rows.rows(self.draw("--colour", colour), BOTH.stop) for colour in ("range", "height", "pulse_width")}
        self.assertEqual(made["range"], png_rows.rows(self.draw(), BOTH.stop))
        images = {colour: rows[BOTH.start:] for colour, rows in made.items()}
        self.assertEqual(len({tuple(map(bytes, rows)) for rows in images.values()}), 3)
        self.assertEqual(len({tuple(self.scale(rows)) for rows in made.values()}), 1)
        scale = self.scale(made["range"])
        self.assertGreater(len(scale), 600)
        light = [0.2126 * r + 0.7152 * g + 0.0722 * b for r, g, b in scale]
        self.assertTrue(all(b >= a - 1 for a, b in zip(light, light[1:])), "it can be read without its hues")

    def test_the_scale_is_that_of_the_page_of_lumview(self):
        page = (HERE / "../../tools/lumview/page/palette.js").read_text()
        colours = bytes.fromhex("".join(re.findall('"([0-9a-f]+)"', re.search("viridis:([^,]*),", page)[1])))
        samples = [colours[i:i + 3] for i in range(0, len(colours), 3)]
        first, last = map(float, re.search(r"SHARE = .*viridis: \[([\d.]+), ([\d.]+)\]", page).groups())
        scale = self.scale(png_rows.rows(self.draw(), ABOVE.stop))
        for i, colour in enumerate(scale):
            at = (first + (last - first) * i / (len(scale) - 1)) * (len(samples) - 1)
            low = min(int(at), len(samples) - 2)
            for k in range(3):
                self.assertAlmostEqual(colour[k], samples[low][k] + (samples[low + 1][k] - samples[low][k]) * (at - low), delta=1)

    def test_heights_are_those_of_the_world(self):
        """The ground has one colour, near and far: the lowest rows of the image, and the middle of the street."""
        rows = png_rows.rows(self.draw("--colour", "height"), BOTH.stop)
        ground = [png_rows.colours(rows[y], 0, 1600)[700] for y in range(BOTH.stop - 100, BOTH.stop - 8)]
        for one in ground:
            self.assertTrue(all(abs(a - b) < 40 for a, b in zip(one, ground[0])), (one, ground[0]))

    def test_what_does_not_go_with_a_picture_is_refused(self):
        for arguments, says in ((("--size", "639x700", "-o", "a.png"), "is not WIDTHxHEIGHT in pixels, each from 640 to 8000"),
                                (("--size", "1000", "-o", "a.png"), "is not WIDTHxHEIGHT"),
                                (("--size", "1000x", "-o", "a.png"), "is not WIDTHxHEIGHT"),
                                (("--size", "1000x900", "-o", "a.ply"), "--size goes with png output only"),
                                (("--colour", "height", "-o", "a.ply"), "--colour goes with png output only"),
                                (("--colour", "green", "-o", "a.png"), "is not one of range height pulse_width")):
            with self.subTest(arguments):
                r = run("lumdump", self.capture, *arguments)
                self.assertEqual(r.returncode, 2)
                self.assertIn(says, r.stderr)

    def test_a_disk_that_is_full_is_told(self):
        r = run("lumdump", self.capture, "-q", "--format", "png", "-o", "/dev/full")
        self.assertEqual(r.returncode, 1)
        self.assertIn("/dev/full: cannot write: No space left on device", r.stderr)
        self.assertNotIn("cairo", r.stderr)


if __name__ == "__main__":
    shards.main()
