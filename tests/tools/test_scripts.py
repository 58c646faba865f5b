#!/usr/bin/env python3
"""Examples without arguments, and scripts that measure without a build: each says what it needs, and no more."""
import pathlib
import subprocess
import sys
import unittest

from support import BIN, PATIENCE_S, Folder

TOP = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = BIN.parent / "examples"


def run(*command):
    return subprocess.run(list(map(str, command)), capture_output=True, text=True, timeout=PATIENCE_S, stdin=subprocess.DEVNULL)


class Examples(unittest.TestCase):
    def test_one_without_its_argument_stops_after_its_usage(self):
        for name in "capture_to_points", "live_lines", "own_laser":
            with self.subTest(name):
                r = run(EXAMPLES / name)
                self.assertEqual((r.returncode, r.stdout), (2, ""), r.stderr)
                self.assertRegex(r.stderr, rf"\Ausage: {name} [A-Z]+\n\Z")

    def test_a_capture_that_cannot_be_opened_has_no_points(self):
        r = run(EXAMPLES / "capture_to_points", Folder(self) / "nowhere.pcap")
        self.assertEqual((r.returncode, r.stdout), (1, ""))
        self.assertRegex(r.stderr, r"\Acapture_to_points: .*nowhere.pcap: cannot be opened: .*\n\Z")


class Measuring(unittest.TestCase):
    """Some build of this checkout may be fit; it is then what the mend names."""

    MEND = r"cmake -S .* && cmake --build|use --build "

    def refused(self, script, build, says, *words):
        r = run(sys.executable, TOP / "script" / script, *words, "--build", build)
        self.assertEqual((r.returncode, r.stdout), (2, ""), r.stderr)
        self.assertTrue(r.stderr.startswith(f"{script}: {build}"), r.stderr)
        self.assertIn(says, r.stderr)
        self.assertRegex(r.stderr, self.MEND)

    def test_without_a_build(self):
        folder = Folder(self)
        self.refused("bench", folder.path, "bin/lumsim is not there")
        self.refused("bench", folder.path, "bin/lumsim is not there", "--workers")
        for what in "load", "view":
            self.refused("soak", folder.path, "bin/lumsim is not there", what)

    def test_a_build_that_is_slow(self):
        folder = Folder(self)
        for name in ("bin/lumsim", "bin/lumdump", "bench/bench_points", "bench/bench_frame", "bench/bench_image",
                     "bench/bench_map", "bench/bench_move", "bench/yardstick"):
            (folder / name).parent.mkdir(exist_ok=True)
            folder.write(name, "")
        folder.write("CMakeCache.txt", "CMAKE_BUILD_TYPE:STRING=Debug\nLUM_SANITIZE:STRING=\n")
        self.refused("bench", folder.path, "of type Debug")
        folder.write("CMakeCache.txt", "CMAKE_BUILD_TYPE:STRING=Release\nLUM_SANITIZE:STRING=thread\n")
        self.refused("bench", folder.path, "has sanitizers")


if __name__ == "__main__":
    unittest.main()
