#!/usr/bin/env python3
"""budget.py LEVEL SECONDS: whether the tree and the tests are within budget.txt: files in git, and the processor time that
this run of script/test took, without installs. LEVEL is fast, all or whole.

Times are those of the machine that budget.txt names. On another one they are multiplied by how much longer a piece of work
takes that is always the same."""
import pathlib
import subprocess
import sys
import time

TOP = pathlib.Path(__file__).resolve().parents[2]
FILE = pathlib.Path(__file__).parent / "budget.txt"
YARDSTICK_S = 0.055  # of the machine that budget.txt names


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
    """The best of five, because what comes between makes it longer."""
    def once():
        begin = time.process_time()
        table = {}
        for i in range(400_000):
            table[i * 2654435761 & 0xFFFF] = i
        return time.process_time() - begin
    return min(once() for _ in range(5))


def files_in_git():
    """None where this is no checkout."""
    r = subprocess.run(["git", "ls-files", "-z"], cwd=TOP, capture_output=True, check=False)
    return r.stdout.count(b"\0") if r.returncode == 0 else None


def hold(path, level, files, seconds, slowness, out):
    budget, passed, failed = read(path), 0, 0

    def check(text, is_within):
        nonlocal passed, failed
        passed, failed = passed + is_within, failed + (not is_within)
        print(f"{'ok   ' if is_within else 'FAIL '} {text}", file=out)
        if not is_within:
            print(f"      make room, or raise tests/runner/{path.name} in a commit that says what it brings", file=out)

    for name in "files", level:
        if name not in budget:
            raise ValueError(f"{path.name} has no line for {name}")
    if files is not None:
        check(f"{files} of {budget['files']:.0f} files in git", files <= budget["files"])
    allowed = budget[level] * slowness
    check(f"{seconds / 60:.1f} of {allowed:.1f} processor minutes"
          + (f", as this machine takes {slowness:.1f} times as long" if round(slowness, 1) != 1.0 else ""), seconds / 60 <= allowed)
    print(f"{passed} passed, {failed} failed", file=out)
    return 1 if failed else 0


def main():
    return hold(FILE, sys.argv[1], files_in_git(), float(sys.argv[2]), max(1.0, yardstick_s() / YARDSTICK_S), sys.stdout)


if __name__ == "__main__":
    sys.exit(main())
