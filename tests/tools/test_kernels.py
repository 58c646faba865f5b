#!/usr/bin/env python3
"""Clouds are the same, to the byte, whichever vectors of the processor make them."""
import os
import unittest

from support import Folder, run, simulate

KINDS = "plain", "sse2", "avx2", "avx512", "neon"  # one that the processor lacks is not taken

CAPTURES = {
    "many returns": ["--returns-max", "8", "--lines", "64", "--frames", "2"],
    "faults": ["--loss", "0.05", "--reorder", "0.05", "--duplicate", "0.02", "--corrupt", "0.01", "--lines", "64", "--frames", "2"],
    "dense": ["--lines", "640", "--frames", "1"],
}
CLOUDS = [("csv", ["--edge", "both"]), ("ply", []), ("ply", ["--columns", "x,y,z"]), ("pcd", ["--smooth", "9"]),
          ("xyz", ["--eye", "green", "--range", "5:40"])]


class Kinds(unittest.TestCase):
    def cloud(self, capture, kind, ending, options):
        out = self.folder.path / f"{kind}.{ending}"
        r = run("lumdump", capture, "-o", out, "--quiet", *options, env={**os.environ, "LUM_CPU": kind})
        self.assertEqual(r.returncode, 0, r.stderr)
        return out.read_bytes()

    def test_all_give_the_same_clouds(self):
        self.folder = Folder(self)
        for seed, (name, options) in enumerate(CAPTURES.items()):
            capture = simulate(self.folder.path / "capture.pcap", *options, "--seed", seed)
            for ending, choice in CLOUDS:
                expected = self.cloud(capture, "plain", ending, choice)
                self.assertGreater(len(expected), 10_000)
                for kind in KINDS[1:]:
                    with self.subTest(capture=name, kind=kind, ending=ending, choice=choice):
                        self.assertEqual(self.cloud(capture, kind, ending, choice), expected)


if __name__ == "__main__":
    unittest.main()
