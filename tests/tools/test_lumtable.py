#!/usr/bin/env python3
"""lumtable: layout and projector as constants in C, and code for a layout. That each target has the constants as its own init makes
them is tests/unit/test_tables.c; that the code reads as layout_any.c does is tests/layout."""
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

from support import PATIENCE_S, run

ROOT = pathlib.Path(__file__).resolve().parents[2]
TABLES = ROOT / "tests" / "unit" / "tables"
CC = shutil.which("cc") or shutil.which("gcc")


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)


class Source(Folder):
    def test_files_of_the_unit_test_are_what_it_writes(self):
        typical = run("lumtable", "--name", "typical")
        self.assertEqual(typical.returncode, 0, typical.stderr)
        self.assertEqual(typical.stdout, (TABLES / "typical.c").read_text())
        odd = run("lumtable", "--name", "odd", "--profile", TABLES / "odd.profile.yaml",
                  "--calibration", TABLES / "odd.calibration.yaml")
        self.assertEqual(odd.returncode, 0, odd.stderr)
        self.assertEqual(odd.stdout, (TABLES / "odd.c").read_text())

    def test_sample_files_are_the_built_in_values(self):
        r = run("lumtable", "--profile", ROOT / "calib" / "profile-default.yaml",
                "--calibration", ROOT / "calib" / "typical.yaml")
        self.assertEqual(r.returncode, 0, r.stderr)
        without = run("lumtable").stdout.replace("profile: built in", "profile: profile-default.yaml")
        self.assertEqual(r.stdout, without.replace("calibration: built in", "calibration: typical.yaml"))

    def test_a_file_or_standard_output(self):
        path = self.folder / "sensor.c"
        r = run("lumtable", "-o", path)
        self.assertEqual((r.returncode, r.stdout, r.stderr), (0, "", ""))
        self.assertEqual(path.read_text(), run("lumtable", "--output", "-").stdout)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["sensor.c"])

    def test_one_file_from_standard_input(self):
        yaml = (TABLES / "odd.profile.yaml").read_bytes()
        r = run("lumtable", "--profile", "-", stdin=yaml)
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertIn(".data_packet_type = 200u", r.stdout)

    def test_a_name_of_a_file_does_not_end_the_comment(self):
        path = self.folder / "a*\\ \n#error.yaml"
        path.write_text("version: 1\n")
        head = run("lumtable", "--calibration", path).stdout.split("*/")[0]
        self.assertIn("calibration: a?? ??error.yaml\n", head)

    def test_the_fixed_layout_of_the_core_is_what_it_writes(self):
        r = run("lumtable", "--layout")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertEqual(r.stdout, (ROOT / "src" / "core" / "layout_fixed.c").read_text())

    def test_code_is_of_the_profile_that_it_names(self):
        r = run("lumtable", "--layout", "--profile", TABLES / "odd.profile.yaml", "--set", "group.samples=64")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertIn(" *   profile: odd.profile.yaml\n *   set: group.samples=64\n */\n", r.stdout)
        self.assertIn("#define SAMPLES_AT 64u\n", r.stdout)
        self.assertNotIn("calibration", r.stdout)

    def compile(self, source, *flags):
        path = self.folder / "tables.c"
        path.write_text(source)
        return subprocess.run([CC, "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", *flags,
                               "-I", str(ROOT / "include"), "-c", str(path), "-o", str(self.folder / "tables.o")],
                              capture_output=True, text=True, timeout=PATIENCE_S, check=False)

    @unittest.skipIf(CC is None, "no compiler")
    def test_it_compiles_without_a_warning(self):
        r = self.compile(run("lumtable", "--name", "left").stdout)
        self.assertEqual(r.returncode, 0, r.stderr)

    @unittest.skipIf(CC is None, "no compiler")
    def test_headers_of_another_version_refuse_it(self):
        tables, code = run("lumtable").stdout, run("lumtable", "--layout").stdout
        for source, header, macro in ((tables, "profile.h", "LUM_LAYOUT_VERSION"), (tables, "points_fixed.h", "LUM_FIXED_PROJECTOR_VERSION"),
                                      (code, "profile.h", "LUM_LAYOUT_VERSION")):
            other = self.folder / header / "lum"
            other.mkdir(parents=True, exist_ok=True)
            text = (ROOT / "include" / "lum" / header).read_text()
            raised, count = re.subn(rf"(#define {macro}) (\d+)", r"\1 99", text)
            self.assertEqual(count, 1)
            for version in (raised, re.sub(rf"#define {macro} .*", "", text)):
                (other / header).write_text(version)
                r = self.compile(source, "-I", str(other.parent), "-iquote", str(ROOT / "src" / "core"))
                self.assertNotEqual(r.returncode, 0)
                self.assertIn("made for another version of lumsdk", r.stderr)


class Arguments(Folder):
    def refused(self, *arguments, status=2):
        r = run("lumtable", *arguments)
        self.assertEqual(r.returncode, status, r.stderr)
        self.assertEqual(r.stdout, "")
        self.assertTrue(r.stderr.startswith("lumtable: "), r.stderr)
        return r.stderr

    def test_names_that_are_none_in_c(self):
        for name in ("", "9a", "_a", "a-b", "a b", "ä", "a" * 41):
            self.assertIn("is not a name in C", self.refused("--name", name))
        self.assertEqual(run("lumtable", "--name", "a" * 40).returncode, 0)
        self.assertEqual(run("lumtable", "--name", "int").returncode, 0)

    def test_arguments_that_it_has_not(self):
        self.assertIn("did you mean --profile", self.refused("--prof", "a.yaml"))
        self.assertIn("sensor.yaml", self.refused("sensor.yaml"))
        self.assertIn("--calibration and --profile both name it", self.refused("--profile", "-", "--calibration", "-"))
        self.assertEqual(run("lumtable", "--nothing").returncode, 2)

    def test_what_does_not_go_with_code(self):
        for words in (["--calibration", TABLES / "odd.calibration.yaml"], ["--name", "left"], ["--set", "tof_lsb_ps=13"]):
            with self.subTest(words):
                self.assertIn("--layout: ", self.refused("--layout", *words))
                self.assertIn(str(words[-1 if words[0] == "--set" else 0]), self.refused(*words, "--layout"))
        self.assertIn("did you mean --layout", self.refused("--lay"))
        self.assertEqual(run("lumtable", "--layout=yes").returncode, 2)

    def test_files_that_are_wrong(self):
        path = self.folder / "bad.yaml"
        path.write_text("version: 1\ngroup: {tag: 3}\n")
        self.assertIn("bad.yaml:2", self.refused("--profile", path))
        self.assertIn("bad.yaml", self.refused("--calibration", path))
        self.assertIn("missing.yaml", self.refused("--calibration", self.folder / "missing.yaml"))

    def test_an_output_that_cannot_be_written(self):
        self.assertIn("no/where.c", self.refused("-o", self.folder / "no" / "where.c", status=1))
        if pathlib.Path("/dev/full").exists():
            self.assertIn("/dev/full", self.refused("-o", "/dev/full", status=1))

    def test_help_and_version(self):
        text = run("lumtable", "--help").stdout
        for option in ("--layout", "--profile", "--calibration", "--name", "-o, --output"):
            self.assertIn(option, text)
        self.assertTrue(all(len(line) <= 80 for line in text.splitlines()))
        self.assertRegex(run("lumtable", "--version").stdout, r"^lumtable \d+\.\d+\.\d+\n$")


if __name__ == "__main__":
    unittest.main()
