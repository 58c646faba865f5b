#!/usr/bin/env python3
"""budget.py LEVEL SECONDS YARDSTICK: whether the tree and the tests are within budget.txt: the SIZES of the tree, and the
processor time that this run of script/test took, without installs. LEVEL is fast, all or whole.
budget.py watch YARDSTICK: does the same piece of work again and again, and writes how long each took, until the shell that
started it ends or kills it.

Times are those of the machine that budget.txt names while it has nothing else to do. They are multiplied by how much longer
that piece of work took while the tests ran: other work on a machine makes all of it longer."""
import os
import pathlib
import statistics
import subprocess
import sys
import time

TOP = pathlib.Path(__file__).resolve().parents[2]
FILE = pathlib.Path(__file__).parent / "budget.txt"
YARDSTICK_S = 0.055  # of the machine that budget.txt names
EACH_S = 10
SIZES = {"files": "files in git", "words": "words in README.md and docs", "design": "words in design.md", "lines": "lines in src and tools"}


def read(path):
    """Name -> number."""
    budget = {}
    for number, line in enumerate(path.read_text().splitlines(), 1):
        if line.startswith("#") or not line:
            continue
        try:
            name, value = line.split()
            budget[name] = float(value)
        except ValueError:
            raise ValueError(f"{path.name}:{number}: NAME NUMBER, not {line!r}") from None
    return budget


def yardstick_s():
    begin = time.process_time()
    table = {}
    for i in range(400_000):
        table[i * 2654435761 & 0xFFFF] = i
    return time.process_time() - begin


def watch(path):
    parent = os.getppid()
    with open(path, "w", encoding="ascii") as file:
        while os.getppid() == parent:
            print(yardstick_s(), file=file, flush=True)
            time.sleep(EACH_S)


def slowness(path):
    """1 where the machine is as fast as the one that budget.txt names, or faster."""
    return max(1.0, statistics.median(float(line) for line in path.read_text(encoding="ascii").split()) / YARDSTICK_S)


def sizes_of(top):
    """By the names of SIZES; nothing where this is no checkout."""
    r = subprocess.run(["git", "ls-files", "-z"], cwd=top, capture_output=True, text=True, check=False)
    if r.returncode != 0:
        return {}
    names = r.stdout.split("\0")[:-1]
    words = {n: len((top / n).read_bytes().split()) for n in names if n == "README.md" or n.startswith("docs/") and n.endswith(".md")}
    return {"files": len(names), "words": sum(words.values()), "design": words.get("docs/internals/design.md", 0),
            "lines": sum((top / n).read_bytes().count(b"\n") for n in names if n.startswith(("src/", "tools/")))}


def hold(path, level, sizes, seconds, slow, out):
    budget, passed, failed = read(path), 0, 0

    def check(text, is_within):
        nonlocal passed, failed
        passed, failed = passed + is_within, failed + (not is_within)
        print(f"{'ok   ' if is_within else 'FAIL '} {text}", file=out)
        if not is_within:
            print(f"      make room, or raise tests/runner/{path.name} in a commit that says what it brings", file=out)

    for name in (*SIZES, level):
        if name not in budget:
            raise ValueError(f"{path.name} has no line for {name}")
    for name, size in sizes.items():
        check(f"{size} of {budget[name]:.0f} {SIZES[name]}", size <= budget[name])
    allowed = budget[level] * slow
    check(f"{seconds / 60:.1f} of {allowed:.1f} processor minutes"
          + (f", as this machine took {slow:.1f} times as long" if round(slow, 1) != 1.0 else ""), seconds / 60 <= allowed)
    print(f"{passed} passed, {failed} failed", file=out)
    return 1 if failed else 0


def main():
    if sys.argv[1] == "watch":
        watch(sys.argv[2])
        return 0
    return hold(FILE, sys.argv[1], sizes_of(TOP), float(sys.argv[2]), slowness(pathlib.Path(sys.argv[3])), sys.stdout)


if __name__ == "__main__":
    sys.exit(main())
