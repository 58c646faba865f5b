#!/usr/bin/env python3
"""test_tools.py: the manifests, as the tools read them that they are for. Without a network. Status 77 where these tools are
not installed: script/setup --all puts them into build/manifests."""

import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unittest
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
PYTHON = TOP / "build/manifests/bin/python"
try:
    import esp_kconfiglib
    import kconfiglib
    from idf_component_tools.manager import ManifestManager
    from idf_component_tools.manifest import SolvedComponent
    from idf_component_tools.manifest.models import Manifest
    from idf_component_tools.sources.git import GitSource
    from platformio import fs
    from platformio.package.manifest.parser import ManifestParserFactory
    from platformio.package.manifest.schema import ManifestSchema
    from platformio.package.pack import PackagePacker
    from pykwalify.core import Core
    from ruamel.yaml import YAML
except ImportError as missing:
    if PYTHON.exists() and Path(sys.prefix) != PYTHON.parents[1]:
        os.execv(PYTHON, [str(PYTHON), "-B", *sys.argv])
    print(f"{missing}: the tools of PlatformIO, ESP-IDF and Zephyr are not in build/manifests, where script/setup --all puts them")
    sys.exit(77)

SOURCES = {str(path.relative_to(TOP)) for path in (TOP / "src/core").glob("*.c")} - {"src/core/frames_none.c", "src/core/layout_fixed.c"}
CORE = {str(path.relative_to(TOP)) for path in (TOP / "src/core").glob("*.[ch]")}
HEADERS = {str(path.relative_to(TOP)) for path in (TOP / "include/lum").glob("*.h")}
FLOATING = {"include/lum/image.h", "include/lum/points.h", "include/lum/pose.h", "include/lum/smooth.h"}


def copy_to(folder):
    """What packages are made from, and some that must stay out."""
    for name in "src", "include", "zephyr", "tests/manifests":
        shutil.copytree(TOP / name, Path(folder, name), ignore=shutil.ignore_patterns("__pycache__"))
    for path in TOP.iterdir():
        if path.is_file():
            shutil.copy(path, folder)


def names_of(archive):
    with tarfile.open(archive) as tar:
        return {os.path.normpath(member.name) for member in tar if member.isfile()}


class PlatformIO(unittest.TestCase):
    def setUp(self):
        # The list of licences is on the network.
        ManifestSchema.load_spdx_licenses = staticmethod(lambda: {"licenses": [{"licenseId": "MIT"}]})
        self.raw = ManifestParserFactory.new_from_dir(str(TOP)).as_dict()

    def test_the_manifest_is_valid(self):
        manifest = ManifestSchema().load_manifest(self.raw)
        self.assertEqual((manifest["name"], manifest["license"]), ("lumsdk", "MIT"))

    def test_it_builds_the_core(self):
        build = self.raw["build"]
        with tempfile.TemporaryDirectory() as folder:  # a tree with builds is large, and their links lead out of it
            copy_to(folder)
            found = fs.match_src_files(os.path.join(folder, build["srcDir"]), build["srcFilter"], ["c", "cpp", "S"])
        self.assertEqual(set(found), SOURCES)

    def test_headers_of_the_library_are_found_and_those_of_its_inside_are_not(self):
        for directory in self.raw["build"]["includeDir"], self.raw["build"]["srcDir"]:
            self.assertEqual(list((TOP / directory).glob("*.h")), [])
        self.assertTrue((TOP / self.raw["build"]["includeDir"] / "lum/packet.h").exists())

    def test_a_package_has_the_core_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            copy_to(folder)
            names = names_of(PackagePacker(folder).pack(os.path.join(folder, "lumsdk.tar.gz")))
        self.assertEqual(names, CORE | HEADERS - FLOATING | {"LICENSE", "README.md", "library.json"})


class EspIdf(unittest.TestCase):
    def test_the_manifest_is_valid(self):
        path = TOP / "idf_component.yml"
        self.assertEqual(ManifestManager(str(path), "lumsdk").validate().validation_errors, [])
        self.assertLessEqual(set(YAML(typ="safe").load(path)), set(Manifest.model_fields))  # unknown keys are no error there

    def test_a_dependency_by_git_has_the_core_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            copy_to(os.path.join(folder, "repository"))
            git = ["git", "-C", os.path.join(folder, "repository"), "-c", "user.name=test", "-c", "user.email=test"]
            for command in ["init", "-q"], ["add", "-A"], ["commit", "-q", "-m", "test"]:
                subprocess.run([*git, *command], check=True)
            source = GitSource(git=f"file://{folder}/repository", system_cache_path=os.path.join(folder, "cache"))
            found = source.versions("lumsdk").versions[0]
            component = SolvedComponent(name="lumsdk", source=source, version=str(found), component_hash=found.component_hash)
            there = Path(source.download(component, os.path.join(folder, "managed_components/lumsdk")))
            names = {str(path.relative_to(there)) for path in there.rglob("*") if path.is_file()}
        self.assertEqual(names, CORE | HEADERS | {"CMakeLists.txt", "Kconfig", "LICENSE", "README.md", "idf_component.yml",
                                                 "src/core/sources.cmake"})

    def test_what_cmake_asks_for_is_what_there_is_to_choose(self):
        """ANY is what is built without a choice."""
        asked = set(re.findall(r"CONFIG_(\w+)", (TOP / "src/core/sources.cmake").read_text()))
        kconfig = esp_kconfiglib.Kconfig(str(TOP / "Kconfig"))
        self.assertEqual(kconfig.warnings, [])
        self.assertEqual({symbol.name for symbol in kconfig.unique_defined_syms}, asked | {"LUMSDK_LAYOUT_ANY"})


class Zephyr(unittest.TestCase):
    # As far as it goes, as the build of Zephyr has it (scripts/zephyr_module.py).
    SCHEMA = {"type": "map", "mapping": {"name": {"type": "str"}, "build": {"type": "map", "mapping": {
        "cmake": {"type": "str"}, "kconfig": {"type": "str"}}}}}

    def test_the_module_is_valid_and_its_files_are_there(self):
        module = YAML(typ="safe").load(TOP / "zephyr/module.yml")
        Core(source_data=module, schema_data=self.SCHEMA).validate()
        self.assertTrue((TOP / module["build"]["cmake"] / "CMakeLists.txt").exists())
        self.assertTrue((TOP / module["build"]["kconfig"]).exists())

    def test_nothing_is_chosen_unless_an_application_chooses_it(self):
        kconfig = kconfiglib.Kconfig(str(TOP / "zephyr/Kconfig"))
        self.assertEqual(kconfig.warnings, [])
        self.assertEqual(kconfig.syms["LUMSDK"].str_value, "n")
        kconfig.syms["LUMSDK"].set_value("y")
        self.assertEqual({name for name, symbol in kconfig.syms.items() if symbol.str_value == "y"}, {"LUMSDK", "LUMSDK_LAYOUT_ANY"})


if __name__ == "__main__":
    unittest.main()
