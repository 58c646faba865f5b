#!/usr/bin/env python3
"""test_builds.py [CC]: what PlatformIO, ESP-IDF and Zephyr are told to build is the core, each file of it, and compiles.

None of the three is here: CMakeLists.txt beside this has stand-ins for the commands of the last two."""

import json
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
INSTEAD = {"src/core/frames_none.c": "src/core/frames.c", "src/core/layout_fixed.c": "src/core/layout_any.c"}
CORE = {str(path.relative_to(TOP)) for path in (TOP / "src/core").glob("*.c")} - INSTEAD.keys()
COMPILERS = [sys.argv.pop(1) if len(sys.argv) > 1 and sys.argv[1][0] != "-" else "cc"]
COMPILERS += filter(shutil.which, ["arm-none-eabi-gcc"])
FLAGS = "-std=c99 -ffreestanding -Os -Wall -Wextra -Wpedantic -Wconversion -Werror"


def run(*command):
    """Its output."""
    r = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if r.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))}: {r.returncode}\n{r.stdout}")
    return r.stdout


class Listed(unittest.TestCase):
    @unittest.skipUnless(shutil.which("arm-none-eabi-gcc"), "no arm-none-eabi-gcc: nothing is built for a controller")
    def test_a_compiler_for_controllers_is_used(self):
        self.assertIn("arm-none-eabi-gcc", COMPILERS)

    def test_each_file_of_the_core_is_in_the_list(self):
        text = (TOP / "src/core/sources.cmake").read_text()
        names = re.findall(r"\S+\.c\b", re.search(r"^set\(lum_core_sources(.*?)\)", text, re.M | re.S)[1])
        self.assertEqual(len(names), len(set(names)))
        self.assertEqual({f"src/core/{name}" for name in names}, CORE)

    def test_the_version_of_platformio_s_manifest_is_that_of_the_headers(self):
        numbers = re.findall(r"LUM_VERSION_(?:MAJOR|MINOR|PATCH) +(\d+)", (TOP / "include/lum/version.h").read_text())
        self.assertEqual(json.loads((TOP / "library.json").read_text())["version"], ".".join(numbers))


class Built(unittest.TestCase):
    """By CMake, with the stand-ins."""

    def build(self, system, compiler, *options):
        """(sources, directories of headers) of what is built."""
        with tempfile.TemporaryDirectory() as build:
            run("cmake", "-S", Path(__file__).parent, "-B", build, f"-DAS={system}", f"-DCMAKE_C_COMPILER={compiler}",
                f"-DCMAKE_C_FLAGS={FLAGS}", "-DCMAKE_C_COMPILER_FORCED=1", "-DCMAKE_SYSTEM_NAME=Generic", *options)
            run("cmake", "--build", build)
            listed = Path(build, "compile_commands.json")  # not written where nothing is compiled
            commands = json.loads(listed.read_text()) if listed.exists() else []
            archives = list(Path(build).rglob("*.a"))
            self.assertEqual(len(archives), 1 if commands else 0)
            for archive in archives:
                run(TOP / "tests/tools/nm_gate.sh", compiler.replace("gcc", "nm") if "-" in compiler else "nm", archive)
        headers = {name for command in commands for name in re.findall(r"(?:-I|-isystem) *(\S+)", command["command"])}
        return ({str(Path(command["file"]).resolve().relative_to(TOP)) for command in commands},
                {str(Path(name).resolve().relative_to(TOP)) for name in headers})

    def check(self, *arguments):
        for compiler in COMPILERS:
            with self.subTest(compiler):
                self.assertEqual(self.build(arguments[0], compiler, *arguments[1:]), (CORE, {"include"}))

    def test_a_component_of_esp_idf(self):
        self.check("esp-idf")

    def test_a_module_of_zephyr(self):
        self.check("zephyr", "-DCONFIG_LUMSDK=y")

    def test_files_that_kconfig_chooses(self):
        for options, others in ((["LAYOUT_FIXED"], {"src/core/layout_fixed.c"}), (["FRAMES_NONE"], {"src/core/frames_none.c"}),
                                (["LAYOUT_FIXED", "FRAMES_NONE"], INSTEAD.keys())):
            with self.subTest(options):
                sources, _ = self.build("esp-idf", COMPILERS[-1], *(f"-DCONFIG_LUMSDK_{option}=y" for option in options))
                self.assertEqual(sources, CORE - {INSTEAD[other] for other in others} | others)
        for system in ("esp-idf", "zephyr"):
            sources, _ = self.build(system, COMPILERS[-1], "-DCONFIG_LUMSDK=y", "-DCONFIG_LUMSDK_LAYOUT_OWN=y",
                                    "-DCONFIG_LUMSDK_LAYOUT_FILE=../../src/core/layout_fixed.c")
            self.assertEqual(sources, CORE - {"src/core/layout_any.c"} | {"src/core/layout_fixed.c"})

    def test_nothing_where_the_module_is_not_chosen(self):
        self.assertEqual(self.build("zephyr", COMPILERS[0]), (set(), set()))

    def test_esp_idf_reads_the_component_as_a_script_first(self):
        """Which returns from the command, so that nothing behind it may need a project."""
        with tempfile.TemporaryDirectory() as folder:
            script = Path(folder, "requirements.cmake")
            script.write_text("macro(idf_component_register)\nmessage(registered)\nreturn()\nendmacro()\n"
                              f"function(read)\ninclude({TOP}/CMakeLists.txt)\nendfunction()\nread()\n")
            self.assertEqual(run("cmake", "-D", "ESP_PLATFORM=1", "-P", script), "registered\n")


if __name__ == "__main__":
    unittest.main()
