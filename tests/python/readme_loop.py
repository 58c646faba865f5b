#!/usr/bin/env python3
"""readme_loop.py: the first block of Python in README.md, run as it stands by an installed lumsdk, on captures that its own
lumsim makes under the names that the block opens. Works in the current folder."""
import ast
import pathlib
import subprocess
import sys

import lumsdk
from lumsdk import _programs

README = pathlib.Path(__file__).resolve().parents[2] / "README.md"


def first_block(text):
    """The first block that reads a capture."""
    for part in text.split("```python\n")[1:]:
        block = part.partition("\n```")[0]
        if "lumsdk.open(" in block:
            return block
    sys.exit(f"{README.name} has no block of Python that opens a capture")


def opened(block):
    """The names of files that it opens."""
    for node in ast.walk(ast.parse(block)):
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "lumsdk.open":
            yield ast.literal_eval(node.args[0])


def main():
    block = first_block(README.read_text(encoding="utf-8"))
    for name in opened(block):
        for i in range(2 if "*" in name else 1):
            subprocess.run([_programs.find("lumsim"), "-q", "-o", name.replace("*", str(i)), "--frames", "2", "--lines", "64",
                            "--seed", str(i + 1), "--address", f"10.42.0.{37 + i}"], check=True)
        with lumsdk.open(name) as source:
            points = [len(frame) for frame in source]
        if not points or not all(points):
            sys.exit(f"{name} gives frames of {points} points")
        print(f"{name}: {len(points)} frames, {sum(points)} points, by {lumsdk.__file__}")
    names = {}
    exec(compile(block, README.name, "exec"), names)
    print(f"ran:\n{block}")


if __name__ == "__main__":
    main()
