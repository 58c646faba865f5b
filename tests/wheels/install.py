#!/usr/bin/env python3
"""install.py FOLDER: pip installs lumsdk from this checkout, and from its sdist where there is a C compiler alone. Works in
FOLDER. The last line counts: N passed, N failed, N skipped."""
import gzip
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import unittest
import venv

TOP = pathlib.Path(__file__).resolve().parents[2]
FOLDER = pathlib.Path(sys.argv.pop()).resolve()
COMPILER = ("gcc", "cc", "as", "ld", "ar", "ranlib", "nm", "strip", "sh")
OWN = {**os.environ, "PIP_DISABLE_PIP_VERSION_CHECK": "1", "PIP_NO_INPUT": "1"}
for name in ("PYTHONPATH", "LUM_BIN"):
    OWN.pop(name, None)


def run(*command, environment=OWN, status=0, **options):
    made = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=900, check=False, cwd=FOLDER,
                          env=environment, **options)
    if made.returncode != status:
        raise AssertionError(f"{' '.join(map(str, command))} ended with {made.returncode}:\n{made.stdout}{made.stderr}")
    return made.stdout + made.stderr


def fresh(name):
    """A venv that has pip alone."""
    shutil.rmtree(FOLDER / name, ignore_errors=True)
    venv.create(FOLDER / name, with_pip=True)
    return FOLDER / name / "bin"


def version():
    header = (TOP / "include/lum/version.h").read_text()
    return ".".join(re.search(rf"LUM_VERSION_{part}\s+(\d+)", header)[1] for part in ("MAJOR", "MINOR", "PATCH"))


class Clone(unittest.TestCase):
    """pip install ."""

    @classmethod
    def setUpClass(cls):
        cls.bin = fresh("clone")
        run(cls.bin / "pip", "install", TOP)

    def python(self, text):
        return run(self.bin / "python", "-I", "-c", text).strip()

    def test_the_loop_of_the_readme_runs(self):
        self.assertIn(str(FOLDER), run(self.bin / "python", "-I", TOP / "tests/python/readme_loop.py"))

    def test_the_version_is_that_of_the_headers_everywhere(self):
        told = self.python("import importlib.metadata, lumsdk; print(lumsdk.__version__, importlib.metadata.version('lumsdk'))")
        self.assertEqual(told, f"{version()} {version()}")
        for program in ("lumctl", "lumdump", "lumsim"):
            self.assertEqual(run(self.bin / program, "--version").strip(), f"{program} {version()}")

    def test_only_the_package_and_its_programs_are_installed(self):
        names = json.loads(self.python("import importlib.metadata, json; print(json.dumps([str(p) for p in "
                                       "importlib.metadata.files('lumsdk')]))"))
        kinds = {re.sub(r"^(\.\./)+", "", name).split("/")[0] for name in names}
        self.assertEqual(kinds, {"lumsdk", f"lumsdk-{version()}.dist-info", "bin"})
        self.assertEqual({name.rsplit("/", 1)[1] for name in names if "/bin/" in name} - {"lumcal", "lumfleet", "lumodom"}, {"lumctl", "lumdump", "lumsim"})
        self.assertEqual([name for name in names if re.search(r"\.(h|a|pc|cmake|1)$", name)], [])

    def test_the_page_is_there_where_a_build_of_the_clone_made_it(self):
        is_made = any((TOP / folder / "lumview.html").exists() for folder in ("build", "build/release"))
        found = "import lumsdk, pathlib; print(pathlib.Path(lumsdk.__file__).with_name('lumview.html').exists())"
        self.assertEqual(self.python(found), str(is_made))

    def test_programs_are_found_beside_this_python(self):
        self.assertEqual(self.python("from lumsdk import _programs; print(_programs.find('lumdump'))"), str(self.bin / "lumdump"))


class Sdist(unittest.TestCase):
    """From the sdist, with a C compiler and no library, cmake and ninja by pip."""

    @classmethod
    def setUpClass(cls):
        tools = FOLDER / "compiler"
        shutil.rmtree(tools, ignore_errors=True)
        tools.mkdir()
        for name in COMPILER:
            (tools / name).symlink_to(shutil.which(name))
        environment = {**OWN, "PATH": str(tools), "PKG_CONFIG_LIBDIR": str(FOLDER / "none")}
        launcher = environment.pop("CMAKE_C_COMPILER_LAUNCHER", None)
        if launcher:
            environment["CMAKE_C_COMPILER_LAUNCHER"] = shutil.which(launcher)
        shutil.rmtree(FOLDER / "dist", ignore_errors=True)
        run(TOP / "build/venv/bin/python", "-m", "build", "--sdist", "--no-isolation", "-o", FOLDER / "dist", TOP)
        cls.bin = fresh("bare")
        archive, = (FOLDER / "dist").glob("*.tar.gz")
        cls.log = run(cls.bin / "pip", "install", "-v", archive, environment=environment)
        run(cls.bin / "lumsim", "-q", "-o", "bare.pcap", "--frames", "2", "--lines", "64")
        (FOLDER / "bare.pcap.gz").write_bytes(gzip.compress((FOLDER / "bare.pcap").read_bytes(), 1))

    def test_the_build_says_what_it_leaves_out(self):
        for part in ("config: NO, missing: yaml-0.1", "picture: NO, missing: cairo-png", "captures compressed by gzip: NO, missing: zlib",
                     "captures compressed by zstd: NO, missing: libzstd", "captures compressed by lz4: NO, missing: liblz4"):
            self.assertIn(part, self.log)

    def test_captures_are_read_in_python(self):
        self.assertEqual(run(self.bin / "python", "-I", "-c", "import lumsdk\nprint(sum(len(f) > 0 for f in lumsdk.open('bare.pcap')))").strip(), "2")

    def test_what_is_left_out_is_said_at_use(self):
        wrong = run(self.bin / "python", "-I", "-c", "import lumsdk\nlist(lumsdk.open('bare.pcap.gz'))", status=1)
        self.assertIn("this build has no zlib: use gzip -dc", wrong)
        self.assertIn("no zlib", run(self.bin / "lumdump", "bare.pcap.gz", status=1))
        for arguments in (("lumdump", "bare.pcap", "--calibration"), ("lumctl", "--profile")):
            told = run(self.bin / arguments[0], *arguments[1:], TOP / "calib/typical.yaml", *(("status",) if arguments[0] == "lumctl" else ()),
                       status=2)
            self.assertIn("reads no YAML", told)
        self.assertIn("without cairo", run(self.bin / "lumdump", "bare.pcap", "-o", "bare.png", status=2))


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    result = unittest.main(exit=False, verbosity=2).result
    bad = len(result.failures) + len(result.errors)
    print(f"{max(0, result.testsRun - bad - len(result.skipped))} passed, {bad} failed, {len(result.skipped)} skipped")
    sys.exit(bad > 0)
