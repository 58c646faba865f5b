#!/usr/bin/env python3
"""tell.py PLANNED JUNIT [NAME=STATUS:LOG]...: what failed, what did not run and why, and the closing line: N passed, N failed,
N skipped.

PLANNED is what ctest --show-only=json-v1 printed, JUNIT what --output-junit wrote. A test counts as one; a step, which has
that label, as many as its last line says, if that is like ours. NAME is a step that ran before ctest.
PLANNED is - where ctest did not run at all. The status is 1 if anything failed, or was planned and never began."""
import collections
import json
import pathlib
import re
import sys
import xml.etree.ElementTree

CLOSING = re.compile(r"(\d+) passed, (\d+) failed(?:, (\d+) skipped)?")
END_LINES = 40  # of what failed


class Result:
    """status: passed, failed or skipped."""

    def __init__(self, name, status, seconds, output, counts_own):
        self.name, self.status, self.seconds, self.output = name, status, seconds, output
        lines = output.rstrip("\n").split("\n")
        self.last = lines[-1]
        closing = CLOSING.fullmatch(self.last) if counts_own and status != "skipped" else None
        if closing:
            self.counts = [int(n or 0) for n in closing.groups()]
        else:
            self.counts = [int(status == word) for word in ("passed", "failed", "skipped")]
        if status == "failed":
            self.counts[1] = max(1, self.counts[1])

    def left_out(self):
        """What it says that it did not run: our own scripts, cmocka, unittest."""
        for line in self.output.splitlines():
            if line.startswith("not run: "):
                yield line.removeprefix("not run: ")
            elif match := re.fullmatch(r"\[  SKIPPED \] ([a-z_0-9]+)", line):
                yield match[1]
            elif match := re.fullmatch(r"(\S+)(?: \([^ ]*\))? \.\.\. skipped (.*)", line):
                yield f"{match[1]}: {match[2]}"


def planned_in(path):
    """Name -> whether it is a step; nothing where ctest could not even plan."""
    try:
        tests = json.loads(pathlib.Path(path).read_text())["tests"]
    except (OSError, ValueError, KeyError):
        return {}
    return {test["name"]: any(p["name"] == "LABELS" and "step" in p["value"] for p in test.get("properties", []))
            for test in tests}


def cases_of(junit):
    """None where ctest ended before it wrote them."""
    try:
        return xml.etree.ElementTree.parse(junit).getroot().iter("testcase")
    except (OSError, xml.etree.ElementTree.ParseError):
        return []


def of_ctest(steps, junit):
    ran = set()
    for case in cases_of(junit):
        name, status, output = case.get("name"), case.get("status"), case.findtext("system-out") or ""
        skipped = case.find("skipped")
        if status == "run":
            status = "passed"
        elif status == "notrun" and skipped is not None and skipped.get("message", "").startswith("SKIP_"):
            status = "skipped"
        else:
            status = "failed"
            output = output or "it did not run"
        ran.add(name)
        yield Result(name, status, float(case.get("time")), output, steps.get(name, False))
    for name in steps:
        if name not in ran:
            yield Result(name, "failed", 0.0, "ctest ended before it began", False)
    if not steps:
        yield Result("ctest", "failed", 0.0, "it found no tests", False)


def of_step(word):
    name, _, rest = word.partition("=")
    status, _, log = rest.partition(":")
    state = {"0": "passed", "77": "skipped"}.get(status, "failed")
    return Result(name, state, 0.0, pathlib.Path(log).read_text(errors="replace"), True)


def say(counts):
    passed, failed, skipped = counts
    return f"{passed} passed, {failed} failed" + (f", {skipped} skipped" if skipped else "")


def group_of(result, steps):
    """Tests of a build stand together, a step alone."""
    if result.name in steps:
        return result.name
    build = re.match(r"(arm64|asan|m32|s390x|tsan|memcheck)\.", result.name)
    return f"tests-{build[1]}" if build else "tests"


def tell(results, steps):
    groups = collections.OrderedDict()
    for r in results:
        groups.setdefault(group_of(r, steps), []).append(r)
    total = [0, 0, 0]
    for name, members in groups.items():
        counts = [sum(column) for column in zip(*(r.counts for r in members))]
        total = [a + b for a, b in zip(total, counts)]
        word = "FAIL " if counts[1] else "ok   " if counts[0] else "skip "
        print(f"{word} {name} ({say(counts).replace(', 0 failed', '')}, {sum(r.seconds for r in members):.0f} s)")
        for r in members:
            prefix = "" if r.name == name else f"{r.name}: "
            if r.status == "skipped":
                print(f"      not run: {prefix}{r.last}")
            elif r.status == "failed":
                print("".join(f"      {prefix}{line}\n" for line in r.output.splitlines()[-END_LINES:]), end="")
            for line in sorted(set(r.left_out())):
                print(f"      not run: {prefix}{line}")
    print(say(total))
    return 1 if total[1] else 0


def main():
    before = [of_step(word) for word in sys.argv[3:]]
    planned = {} if sys.argv[1] == "-" else planned_in(sys.argv[1])
    tested = [] if sys.argv[1] == "-" else list(of_ctest(planned, sys.argv[2]))
    return tell(before + tested, {r.name for r in before} | {n for n, is_step in planned.items() if is_step})


if __name__ == "__main__":
    sys.exit(main())
