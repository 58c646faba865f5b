#!/usr/bin/env python3
"""test_dump.py DUMP: that the comparison of script/abi sees what it is for. DUMP is of the library as it is; changed copies
stand for later ones. The last line counts."""
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree as xml

import layout

HERE = pathlib.Path(__file__).parent
DUMP = pathlib.Path(sys.argv.pop())
SUPPRESSED = HERE / "liblumsdk.suppr"


def remove(tree, tag, name):
    found = 0
    for parent in tree.iter():
        for child in [c for c in parent if c.tag == tag and c.get("name") == name]:
            parent.remove(child)
            found += 1
    assert found > 0, name


def struct(tree, name):
    return next(c for c in tree.iter("class-decl") if c.get("name") == name and c.get("size-in-bits"))


def grow(one, place, bits=64):
    """A member of 8 bytes more, at a place of the list."""
    members = one.findall("data-member")
    size = int(one.get("size-in-bits"))
    at = int(members[place].get("layout-offset-in-bits")) if place < len(members) else size
    for member in members[place:]:
        member.set("layout-offset-in-bits", str(int(member.get("layout-offset-in-bits")) + bits))
    one.set("size-in-bits", str(size + bits))
    new = xml.fromstring(xml.tostring(members[0]))  # struct_size's type, or another of 8 bytes
    new.set("layout-offset-in-bits", str(at))
    new.find("var-decl").set("name", "added")
    one.insert(list(one).index(members[place]) if place < len(members) else len(list(one)), new)


class Comparison(unittest.TestCase):
    def compare(self, change=None):
        tree = xml.parse(DUMP)
        if change is not None:
            change(tree.getroot())
        with tempfile.TemporaryDirectory() as folder:
            later = pathlib.Path(folder) / "later.abi"
            tree.write(later)
            r = subprocess.run(["abidiff", "--suppressions", SUPPRESSED, DUMP, later], capture_output=True, text=True)
        return r.returncode, r.stdout

    def broken(self, change, said):
        status, output = self.compare(change)
        self.assertNotEqual(status & 4, 0, output)
        self.assertIn(said, output)

    def test_the_same_is_the_same(self):
        self.assertEqual(self.compare(), (0, ""))

    def test_a_function_that_goes_is_seen(self):
        def change(tree):
            remove(tree, "elf-symbol", "lum_reader_next_frame")
            remove(tree, "function-decl", "lum_reader_next_frame")
        self.broken(change, "lum_reader_next_frame")

    def test_the_variable_that_goes_is_seen(self):
        def change(tree):
            remove(tree, "elf-symbol", "lum_command_specs")
            remove(tree, "var-decl", "lum_command_specs")
        self.broken(change, "lum_command_specs")

    def test_a_struct_that_grows_is_seen(self):
        for name in ("lum_layout", "lum_record", "lum_datagram", "lum_projector"):
            with self.subTest(name):
                def change(tree, name=name):
                    one = struct(tree, name)
                    grow(one, len(one.findall("data-member")))
                self.broken(change, name)

    def test_a_member_that_moves_is_seen(self):
        for name in ("lum_frame_info", "lum_writer_options"):
            with self.subTest(name):
                self.broken(lambda tree, name=name: grow(struct(tree, name), 1), name)

    def test_a_struct_that_tells_its_size_may_grow_at_its_end(self):
        for name in self.sized():
            with self.subTest(name):
                def change(tree, name=name):
                    one = struct(tree, name)
                    grow(one, len(one.findall("data-member")))
                status, output = self.compare(change)
                self.assertEqual(status, 0, output)

    def test_every_struct_that_tells_its_size_is_in_the_dump(self):
        self.assertEqual(sorted(n for n, (_, members) in layout.structs(DUMP).items() if layout.tells_its_size(members)), sorted(self.sized()))

    def sized(self):
        """Structs with a struct_size, as the headers declare them."""
        found = re.findall(r"^\S*: (lum_\w+)\.struct_size: size_t at 0$", (HERE / "headers.txt").read_text(), re.M)
        self.assertTrue(found)
        return found

    def test_what_may_grow_is_what_tells_its_size(self):
        listed = re.search(r"name_regexp = \^lum_\(([a-z_|]*)\)\$", SUPPRESSED.read_text()).group(1).split("|")
        self.assertEqual(sorted(f"lum_{name}" for name in listed), sorted(self.sized()))


class Layout(unittest.TestCase):
    """What libabigail lets pass."""

    def names(self, name, place, bits=64):
        tree = xml.parse(DUMP)
        one = struct(tree.getroot(), name)
        grow(one, len(one.findall("data-member")) if place is None else place, bits)
        with tempfile.TemporaryDirectory() as folder:
            later = pathlib.Path(folder) / "later.abi"
            tree.write(later)
            return [fault[0] for fault in layout.faults(DUMP, later)]

    def test_the_same_is_the_same(self):
        self.assertEqual(list(layout.faults(DUMP, DUMP)), [])

    def test_every_struct_that_grows_is_seen_unless_it_tells_its_size(self):
        for name, (_, members) in layout.structs(DUMP).items():
            if members:
                with self.subTest(name):
                    self.assertEqual(self.names(name, None), [] if layout.tells_its_size(members) else [name])

    def test_growth_into_padding_is_seen(self):
        self.assertEqual(self.names("lum_capture_source", None, bits=0), ["lum_capture_source"])

    def test_a_member_that_moves_is_seen(self):
        for name in ("lum_writer_options", "lum_sensor_event"):
            self.assertEqual(self.names(name, 1), [name])


if __name__ == "__main__":
    result = unittest.main(exit=False).result
    bad = len(result.failures) + len(result.errors)
    print(f"{max(0, result.testsRun - bad)} passed, {bad} failed")
    sys.exit(bad > 0)
