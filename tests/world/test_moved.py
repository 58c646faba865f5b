#!/usr/bin/env python3
"""moved.txt: each story in it is told, and no test in it is left where it waited for real time."""
import ast
import functools
import pathlib
import re
import sys
import unittest

HERE = pathlib.Path(__file__).resolve().parent
TESTS = HERE.parent


def moved():
    """File, test, stories."""
    for line in (HERE / "moved.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            name, test, *stories = line.split()
            yield name, test, stories


@functools.cache
def tests_of(path):
    """Names of its tests: Class.test of Python, a function's of C. None are left of a file that is gone."""
    if not path.exists():
        return set()
    text = path.read_text()
    if path.suffix == ".c":
        return set(re.findall(r"cmocka_unit_test\(\s*(\w+)\)", text))
    classes = [node for node in ast.parse(text).body if isinstance(node, ast.ClassDef)]
    return {f"{c.name}.{f.name}" for c in classes for f in c.body if isinstance(f, ast.FunctionDef)}


class Moved(unittest.TestCase):
    def test_each_story_is_told(self):
        told = set()
        for path in (HERE / "stories").glob("*.c"):
            told.update(re.findall(r"^STORY\(\s*(\w+)", path.read_text(), re.M))
        for name, test, stories in moved():
            self.assertTrue(stories, f"{name} {test} is nowhere")
            self.assertLessEqual(set(stories), told, f"{name} {test}")

    def test_none_is_left(self):
        for name, test, _ in moved():
            folder = "tools" if name.endswith(".py") else "unit"
            self.assertNotIn(test, tests_of(TESTS / folder / name), name)

    def test_none_is_named_twice(self):
        names = [(name, test) for name, test, _ in moved()]
        self.assertEqual(len(names), len(set(names)))


if __name__ == "__main__":
    sys.dont_write_bytecode = True
    unittest.main()
