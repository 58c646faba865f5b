#!/usr/bin/env python3
"""check.py EXPORT DIR...: what llvm-cov's export says of the sources under DIR and the headers beside them.

EXPORT is the JSON of `llvm-cov export`. Fails unless every region of code, every outcome of every branch and every
condition (MC/DC: it alone has turned its decision's outcome) is covered. What cannot happen is excluded by a comment
on its line, or alone on the lines before it, that says why:

    /* mcdc: WHY */

A comment that excludes nothing fails as well, and so does a file of code that no test links, and an && or || that
belongs to no measured decision: then the compiler has left that decision out.
"""
import argparse
import json
import pathlib
import re
import sys

EXCLUSION = re.compile(r"/\*\s*mcdc:\s*(.*?)\s*\*/", re.DOTALL)
HIDDEN = re.compile(
    r"""/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*'|^[ \t]*\#(?:\\\n|[^\n])*""",
    re.DOTALL | re.MULTILINE,
)
FUNCTION = re.compile(r"^\{", re.MULTILINE)
CONDITION = 6  # kind of a branch that is a condition of a decision


def blank(match):
    return re.sub(r"[^\n]", " ", match.group())


class Source:
    """A file of C: where it excludes, and where its operators stand."""

    def __init__(self, path):
        self.text = pathlib.Path(path).read_text(encoding="utf-8")
        self.lines = self.text.split("\n")
        self.code = HIDDEN.sub(blank, self.text)
        self.exclusions = {self.target(m): re.sub(r"\s*\n\s*\*?\s*", " ", m[1]) for m in EXCLUSION.finditer(self.text)}

    def place(self, at):
        return self.text.count("\n", 0, at) + 1, at - self.text.rfind("\n", 0, at)

    def target(self, comment):
        """The line that a comment is about: its own, or the next that has code."""
        line, column = self.place(comment.start())
        code = self.code.split("\n")
        if code[line - 1][: column - 1].strip():
            return line
        line = self.place(comment.end())[0]
        while line < len(code) and not code[line - 1].strip():
            line += 1
        return line

    def operators(self):
        return [self.place(m.start()) for m in re.finditer(r"&&|\|\|", self.code)]

    def quote(self, place):
        line, column, end_line, end = place
        text = self.lines[line - 1]
        return text[column - 1 : end - 1] if line == end_line else text[column - 1 :].strip() + " ..."


class File:
    """The records of one file. A function of a header is compiled many times: what one of them covers is covered."""

    def __init__(self, record):
        self.source = Source(record["filename"])
        self.summary = record["summary"]
        self.segments = record["segments"]
        self.branches = {}
        self.kinds = {}
        self.decisions = {}
        for branch in record["branches"]:
            place = tuple(branch[:4])
            sums = self.branches.setdefault(place, [0, 0])
            sums[0] += branch[4]
            sums[1] += branch[5]
            self.kinds[place] = branch[8]
        for decision in record["mcdc_records"]:
            found = self.decisions.setdefault(tuple(decision[:4]), [False] * len(decision[6]))
            for i, covered in enumerate(decision[6]):
                found[i] = found[i] or covered

    def conditions(self, decision):
        """The places of its conditions, in order."""
        inside = [p for p in self.branches if self.kinds[p] == CONDITION and is_within(p, decision)]
        return sorted(inside) if len(inside) == len(self.decisions[decision]) else []

    def missing(self):
        """(place, what lacks) of all that is not covered."""
        for line, column, count, has_count, is_entry, is_gap in self.segments:
            if has_count and is_entry and not is_gap and count == 0:
                yield (line, column, line + 1, 1), "is not executed"
        for place, counts in self.branches.items():
            for count, outcome in zip(counts, ("true", "false")):
                if count == 0:
                    yield place, f"is never {outcome}"
        for place, covered in self.decisions.items():
            conditions = self.conditions(place)
            for i, good in enumerate(covered):
                if not good:
                    yield (conditions[i] if conditions else place), f"does not decide (condition {i + 1})"

    def unmeasured(self):
        """&& and || outside every decision."""
        for line, column in self.source.operators():
            place = (line, column, line, column + 2)
            if not any(is_within(place, decision) for decision in self.decisions):
                yield place, "belongs to no measured decision: the compiler left it out"


def is_within(place, outer):
    return place[:2] >= outer[:2] and place[2:] <= outer[2:]


def check_file(name, file):
    """Prints what is wrong. (Things wrong, exclusions that are needed.)"""
    wrong = [f"{name}:{p[0]}:{p[1]}: `{file.source.quote(p)}` {what}" for p, what in sorted(file.unmeasured())]
    used = set()
    for place, what in sorted(file.missing()):
        if place[0] in file.source.exclusions:
            used.add(place[0])
        else:
            wrong.append(f"{name}:{place[0]}:{place[1]}: `{file.source.quote(place)}` {what}")
    for line, why in sorted(file.source.exclusions.items()):
        if line in used:
            print(f"excluded  {name}:{line}: {why}")
        else:
            wrong.append(f"{name}:{line}: its exclusion is not needed: {why}")
    print("".join(f"{text}\n" for text in wrong), end="")
    return len(wrong), len(used)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("export")
    parser.add_argument("dirs", nargs="+", metavar="DIR")
    arguments = parser.parse_args()
    here = pathlib.Path.cwd()
    with open(arguments.export, encoding="utf-8") as export:
        records = json.load(export)["data"][0]["files"]
    with_code = [r for r in records if r["summary"]["functions"]["count"] > 0]
    files = {str(pathlib.Path(r["filename"]).relative_to(here)): File(r) for r in with_code}
    sums = {"lines": 0, "branches": 0, "mcdc": 0}
    wrong = excluded = 0
    for name, file in sorted(files.items()):
        bad, used = check_file(name, file)
        wrong += bad
        excluded += used
        for key in sums:
            sums[key] += file.summary[key]["count"]
    for source in sorted(path for d in arguments.dirs for path in pathlib.Path(d).glob("*.c")):
        if str(source) not in files and FUNCTION.search(source.read_text(encoding="utf-8")):
            print(f"{source}: no test of these links it")
            wrong += 1
    print(
        f"{sums['lines']} lines, {sums['branches']} outcomes of branches, {sums['mcdc']} conditions of decisions: "
        f"{wrong} not covered, {excluded} lines excluded"
    )
    return 1 if wrong or not sums["mcdc"] else 0


if __name__ == "__main__":
    sys.exit(main())
