"""lumdump --smooth against the angles that lumsim knows."""
import math
import unittest

import shards
from support import Folder, read_csv, run, simulate

NOISE = 0.005  # degrees, of lumsim's encoders


def place(row):
    return row["frame"], row["eye"], row["line"], row["pixel"]


def angles(rows):
    return {place(r): (float(r["azimuth"]), float(r["elevation"])) for r in rows}


def rms(rows, truth):
    """Of azimuth and elevation, degrees, over pixels."""
    ours, exact = angles(rows), angles(truth)
    return [math.sqrt(sum((angle[i] - exact[p][i]) ** 2 for p, angle in ours.items()) / len(ours)) for i in (0, 1)]


class Smooth(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)
        self.source = self.folder / "in.pcap"

    def simulate(self, *arguments):
        simulate(self.source, "--frames", "1", "--truth", self.folder / "truth.csv", *arguments)
        return read_csv(self.folder / "truth.csv")

    def convert(self, *arguments, name="out.csv"):
        out = self.folder / name
        r = run("lumdump", self.source, "-o", out, *arguments)
        self.assertEqual(r.returncode, 0, r.stderr)
        return out

    def test_the_angles_come_nearer_to_the_truth(self):
        truth = self.simulate("--seed", "5")
        plain = read_csv(self.convert())
        smooth = read_csv(self.convert("--smooth", "31"))
        for before, after in zip(rms(plain, truth), rms(smooth, truth)):
            self.assertTrue(0.9 * NOISE < before < 1.1 * NOISE, before)
            self.assertLess(after, 0.3 * before)
        # across the beam, so do the points
        across = [math.sqrt(sum((float(r[c]) - float(t[c]) * float(r["range"]) / float(t["range"])) ** 2
                                for r, t in zip(rows, truth) for c in "xyz") / len(rows))
                  for rows in (plain, smooth)]
        self.assertLess(across[1], 0.4 * across[0])
        # and nothing else has changed
        self.assertEqual(len(smooth), len(plain))
        for column in plain[0]:
            if column not in ("x", "y", "z", "azimuth", "elevation"):
                self.assertEqual([r[column] for r in smooth], [r[column] for r in plain], column)

    def test_they_do_so_beside_lost_packets(self):
        truth = self.simulate("--loss", "0.05", "--seed", "6")
        plain = read_csv(self.convert())
        smooth = read_csv(self.convert("--smooth", "31"))
        self.assertLess(len(plain), len(truth))
        self.assertEqual([place(r) for r in smooth], [place(r) for r in plain])
        for before, after in zip(rms(plain, truth), rms(smooth, truth)):
            self.assertLess(after, 0.35 * before)

    def test_off_gives_the_same_file(self):
        self.simulate()
        for ending in "csv", "las", "pcap":
            plain = self.convert(name=f"plain.{ending}").read_bytes()
            self.assertEqual(self.convert("--smooth", "0", name=f"off.{ending}").read_bytes(), plain)
            self.assertEqual(self.convert("--smooth", "31", "--smooth", "0", name=f"no.{ending}").read_bytes(), plain)
            smooth = self.convert("--smooth", "31", name=f"on.{ending}").read_bytes()
            # a recording holds the packets as they came
            self.assertEqual(smooth == plain, ending == "pcap")

    def test_the_order_is_two_unless_the_window_is_three(self):
        self.simulate()
        files = {text: self.convert("--smooth", text).read_bytes() for text in ("31", "31:2", "31:4", "3", "3:1", "0")}
        self.assertEqual(files["31"], files["31:2"])
        self.assertEqual(files["3"], files["3:1"])
        self.assertEqual(len({files[text] for text in ("31", "31:4", "3", "0")}), 4)

    def test_what_is_no_window_is_refused(self):
        for text in ("2", "30", "64", "65", "-1", "x", "", ":", "31:", ":2", "31:6", "31:-1", "5:5", "31:2:1", "31 ",
                     "4294967327", "000000000031x"):
            with self.subTest(text):
                r = run("lumdump", "in.pcap", "--smooth", text)
                self.assertEqual(r.returncode, 2, r.stderr)
                self.assertIn(f"--smooth: '{text}' is not 0 for off, an odd number of pixels up to 63", r.stderr)


if __name__ == "__main__":
    shards.main()
