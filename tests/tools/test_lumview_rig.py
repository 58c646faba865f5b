"""lumview with --rig: the sensors of a vehicle in one cloud."""
import itertools
import unittest

from support import BIN, run, simulate
from test_lumsim_rig import FRONT, LEFT, REAR, RIG, files_of, moved, write_rig
from test_lumview import Case

OLD = 8  # pictures without a new frame of a sensor, until it is left out
EACH = 16  # one of so many lines is compared


class Rig(Case):
    tool = BIN / "lumview"
    options = "--lines", "64", "--scene", "room"

    def rows(self, folder, source, sensor, number, *options):
        """The points of a frame of one sensor's own run, moved by its pose."""
        name, address, interface, *pose = sensor
        table = folder / "own.csv"
        r = run("lumdump", source, "-q", "-o", table, "--sensor", f"{address}%{interface}", *files_of(folder, sensor),
                "--frames", f"{number:.0f}:{number:.0f}", *options)
        self.assertEqual(r.returncode, 0, r.stderr)
        head, *rows = (line.split(",") for line in table.read_text().splitlines())
        line, *at = (head.index(name) for name in "line pixel eye return_number x y z".split())
        chosen = ([float(row[i]) for i in (line, *at)] for row in rows if int(row[line]) % EACH == 0)
        return sorted((*values[:4], *moved(pose, values[4:])) for values in chosen)

    def assert_points(self, cloud, first, count, rows):
        columns = zip(cloud.line_numbers(), cloud.pixels(), cloud.bits(), cloud.return_numbers(), cloud.xyz())
        got = sorted((line, pixel, bits & 1, turn, *xyz) for line, pixel, bits, turn, xyz in
                     itertools.islice(columns, first, first + count) if line % EACH == 0)
        self.assertEqual([g[:4] for g in got], [r[:4] for r in rows])
        self.assertLess(max(abs(a - b) for g, r in zip(got, rows) for a, b in zip(g[4:], r[4:])), 0.0011)

    def assert_cloud(self, cloud, source, sensors, *options):
        first = 0
        for number, count, i in cloud.parts:
            self.assert_points(cloud, first, count, self.rows(self.folder, source, sensors[i], number, *options))
            first += count
        self.assertEqual(first, cloud.points)

    def test_each_has_the_points_of_its_own_run_also_after_jumps(self):
        rig = write_rig(self.folder, *RIG)
        self.source = simulate(self.folder / "rig.pcapng", "--rig", rig, "--frames", 3, *self.options)
        self.serve("--paused", "--rig", rig)
        b = self.browser()
        hello = b.text("hello")
        self.assertEqual({k: hello["rig"][k] for k in ("frame", "sensors")}, {"frame": "base_link", "sensors": ["front", "left", "rear"]})
        self.assertEqual([[row[3], row[7], row[11]] for row in hello["rig"]["poses"]], [[1.2, 0, 1.7], [0.1, 0.3, 1.5], [-0.5, -0.1, 1.6]])
        self.assertEqual([eye["name"] for eye in hello["eyes"]], ["blue", "green"] * 3)
        status = b.status(lambda s: s["first_frame"] is not None)
        self.assertEqual((status["first_frame"], status["last_frame"]), (1, 3))
        clouds = [(b.cloud_of(number), ()) for number in (3, 2)]
        b.say("view falling 15")
        clouds.append((b.cloud(lambda c: (c.frame, c.edges) == (2, 2)), ("--edge", "falling", "--smooth", 15)))
        self.assertEqual(b.status(lambda s: s["message"] == "")["state"], "paused")
        self.assertEqual(len({cloud.content for cloud, _ in clouds}), 3)
        for cloud, options in clouds:
            self.assertEqual([i for _, _, i in cloud.parts], [0, 1, 2])
            self.assert_cloud(cloud, self.source, RIG, *options)

    def test_one_that_stops_is_left_out_after_a_few_frames(self):
        rig = write_rig(self.folder, FRONT, LEFT)
        front, left = (simulate(self.folder / f"{sensor[0]}.pcapng", "--rig", write_rig(self.folder, sensor, name="one.yaml"),
                                "--frames", count, *self.options) for sensor, count in ((FRONT, 14), (LEFT, 3)))
        self.serve("--paused", "--rig", rig, sources=[front, left])
        b = self.browser()
        self.assertEqual(b.status(lambda s: s["first_frame"] is not None)["last_frame"], 14)
        # The left one's third frame would be complete only at the end.
        expected = {n: [(n, 0), (min(n, 2), 1)] if n <= 2 + OLD else [(n, 0)] for n in (1, 2, 3, 10, 11, 14)}
        for number in (*expected, 10):
            self.assertEqual([(frame, i) for frame, _, i in b.cloud_of(number).parts], expected[number], number)
        b.say("seek 13")
        b.say("speed 100")
        b.say("play")
        self.assertIn("a frame of left is left out, as the sensor paused in it or has stopped (1 in all)",
                      b.status(lambda s: s["state"] == "ended" and s["message"])["message"])

    def test_one_of_it_is_shown_alone_where_it_stands(self):
        rig = write_rig(self.folder, *RIG)
        self.source = simulate(self.folder / "rig.pcapng", "--rig", rig, "--frames", 2, *self.options)
        self.serve("--paused", "--rig", rig, "--sensor", "rear")
        b = self.browser()
        self.assertEqual(b.text("hello")["rig"]["sensors"], ["rear"])
        cloud = b.cloud_of(2)
        self.assertEqual(cloud.parts, [])
        self.assert_points(cloud, 0, cloud.points, self.rows(self.folder, self.source, REAR, 2))

    def told(self, *arguments):
        self.serve(*arguments, "--speed", "100")
        return self.browser().status(lambda s: s["state"] == "ended" and s["message"])["message"]

    def test_what_is_missing_or_does_not_fit_is_said(self):
        rig = write_rig(self.folder, *RIG)
        self.source = simulate(self.folder / "rig.pcapng", "--rig", write_rig(self.folder, FRONT, REAR, name="two.yaml"),
                               "--frames", 1, *self.options)
        self.assertIn("the rig's sensor 10.42.0.37%eth1 sent no data", self.told("--rig", rig))
        self.assertIn("10.42.0.39", self.told("--rig", write_rig(self.folder, FRONT, name="front-only.yaml")))
        self.assertIn("there is no frame in it of the rig's sensors", self.told("--rig", write_rig(self.folder, LEFT, name="l.yaml")))
        bad = self.folder.write("bad.yaml", "version: 1\nsensors:\n  - {name: front, address: 10.42.0.37%eth0}\n"
                                            "  - {name: side, address: 10.42.0.39, profile: other.yaml}\n")
        self.folder.write("other.yaml", "version: 1\ndata_packet_type: 9\n")
        said = self.told("--rig", bad)
        self.assertRegex(said, r"a sensor of the rig: .*: lumdump .*rig\.pcapng --sensor ADDRESS --infer -o profile\.yaml finds the layout, "
                               "for profile: profile.yaml in the rig")
        own = self.folder / "own.pcapng"
        r = run("lumdump", self.source, "-q", "--sensor", "10.42.0.37%eth0", "--calibration", self.folder / "left.yaml", "-o", own)
        self.assertEqual(r.returncode, 0, r.stderr)
        self.source = own
        alone = write_rig(self.folder, ("front", "10.42.0.37", "eth0", 0, 0, 0, 0), name="front.yaml")
        self.assertIn(f"own.pcapng: it has a calibration of its own, which is not used: {alone} says which file each sensor has",
                      self.told("--rig", alone))

    def test_a_capture_of_several_without_it_names_it(self):
        self.source = simulate(self.folder / "rig.pcapng", "--rig", write_rig(self.folder, *RIG), "--frames", 1, *self.options)
        self.assertIn("10.42.0.37 is shown; there is also 10.42.0.37%eth1, 10.42.0.39: choose by lumview --sensor, or show all by a rig",
                      self.told())

    def test_what_cannot_be_is_refused(self):
        rig = write_rig(self.folder, *RIG)
        shared = self.folder.write("shared.yaml", "version: 1\nsensors:\n  - {name: a, address: 10.42.0.37}\n"
                                                  "  - {name: b, address: 10.42.0.37, interface: eth1}\n")
        source = simulate(self.folder / "s.pcap", "--frames", 1, "--lines", 64)
        in_file = "does not go with --rig: each sensor has its calibration and its profile in the rig's file"
        for arguments, message in (
                (["--rig", rig, "--calibration", "left.yaml", source], f"--calibration {in_file}"),
                (["--rig", rig, "--profile", "left.yaml", source], f"--profile {in_file}"),
                (["--rig", rig, "--set", "tof_lsb_ps=12", source], f"--set {in_file}"),
                (["--rig", rig, "udp://127.0.0.1"], "--rig goes with captures: show a live sensor by a lumview of its own, with "
                 "--calibration and --profile"),
                (["--rig", rig, "--sensor", "10.42.0.37", source], f"--sensor: '10.42.0.37' is not a sensor of {rig}, which has front, "
                 "left, rear"),
                (["--rig", "-", "-"], "standard input can be read only once"),
                (["--rig", "none.yaml", source], "none.yaml"),
                (["--rig", "", source], "--rig"),
                (["--sensor", "front", source], "--sensor: ")):
            r = run("lumview", "--no-open", *arguments)
            self.assertEqual((r.returncode, r.stdout, r.stderr.count("\n")), (2, "", 1), r.stderr)
            self.assertIn(message, r.stderr)
        self.assertEqual(run("lumview", "--no-open", "--rig", shared, "--sensor", "a", self.folder / "gone.pcap").returncode, 1)


if __name__ == "__main__":
    unittest.main()
