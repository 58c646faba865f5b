#!/usr/bin/env python3
"""The bench guide is one page, leads from the first capture to a calibration, and its commands without a sensor do what it says."""
import os
import pathlib
import re
import subprocess
import unittest

from support import BIN, Folder, run

DOCS = pathlib.Path(__file__).resolve().parents[2] / "docs"
PAGE = (DOCS / "start.md").read_text()
LINES_OF_A_PAGE = 90


def commands(heading):
    """Those of a section, a line each, with what its comment says."""
    section = PAGE.partition(f"\n## {heading}\n")[2].partition("\n## ")[0]
    for line in re.findall(r"(?m)^    (\S.*)$", section):
        command, _, comment = line.partition(" #")
        yield command.strip(), comment.strip()


class Page(unittest.TestCase):
    def test_it_is_one_page(self):
        self.assertLessEqual(len(PAGE.splitlines()), LINES_OF_A_PAGE)

    def test_it_goes_from_the_first_capture_to_a_calibration(self):
        steps = re.findall(r"(?m)^\*\*(\d+)\. ", PAGE)
        self.assertEqual(steps, [str(n) for n in range(1, len(steps) + 1)])
        said = [command for command, _ in commands("A new sensor in seven steps")]
        order = ["lumctl doctor", "lumdump udp://10.42.0.37 --laser", "lumdump first.pcap", "lumdump first.pcap --infer -o profile.yaml",
                 "lumcal check first.pcap", "lumcal eyes a.pcap b.pcap c.pcap -o calibration.yaml"]
        places = [next(i for i, command in enumerate(said) if command.startswith(begin)) for begin in order]
        self.assertEqual(places, sorted(places))

    def test_every_option_is_one_of_its_tool(self):
        helps = {tool: run(tool, "--help").stdout for tool in ("lumctl", "lumdump", "lumsim")}
        for heading in "A new sensor in seven steps", "Without a sensor":
            for command, _ in commands(heading):
                words = command.split()
                for option in filter(lambda word: word.startswith("--"), words if words[0] in helps else ()):
                    self.assertRegex(helps[words[0]], rf"(?m)(^|[ ,]){option}\b", command)


class WithoutASensor(unittest.TestCase):
    def test_the_commands_do_what_their_comments_say(self):
        folder = Folder(self)
        environment = {**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"}
        before, ran = "", []
        for command, comment in commands("Without a sensor"):
            if "=" in command.split()[0]:
                before = f"{command}\n"
            elif not command.startswith("lumcal"):  # tests/python has its own
                r = subprocess.run(["bash", "-c", before + command], cwd=folder.path, env=environment, capture_output=True, text=True,
                                   timeout=300)
                self.assertEqual(r.returncode, 0, f"{command}\n{r.stderr}")
                self.assertIn("no point is left" if comment.startswith("a warning") else "", r.stderr)
                self.assertEqual("warning" in r.stderr, comment.startswith("a warning"), r.stderr)
                ran.append(command)
        self.assertGreater(len(ran), 5)
        self.assertIn(": found: ", subprocess.run([BIN / "lumdump", folder / "first.pcap", "--infer", "-o", folder / "again.yaml"],
                                                  capture_output=True, text=True).stderr)
        self.assertTrue((folder / "look.png").stat().st_size > 10_000)


if __name__ == "__main__":
    unittest.main()
