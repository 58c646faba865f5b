#!/usr/bin/env python3
"""tidy.py [--all] PRESET CHECKS ARGUMENT... -- FILE...: clang-tidy over those of the files that changed (changed.py), or with --all
over each of them, with CHECKS added to those of .clang-tidy, and ARGUMENTs of clang-tidy.

What was seen without a finding is not looked at again: a record in $LUM_CACHE, else in lumsdk of the user's cache folder,
says so of all that a result depends on: the text of the file and of each file of the tree that it includes, the compiler's
arguments, the checks and their configuration, clang-tidy itself. Paths count from the top folder, so another clone has the
same records. Headers of the system are not part of it."""
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

import changed

TOP = pathlib.Path(__file__).resolve().parents[1]
INCLUDE = re.compile(rb'^[ \t]*#[ \t]*include[ \t]*["<]([^">\n]+)[">]', re.M)
RECORDS_MAX = 20000


class Sources:
    """Files of the tree, and what they include of it; each is read once."""

    def __init__(self, top):
        self.top, self.texts, self.found = top, {}, {}

    def text(self, path):
        if path not in self.texts:
            self.texts[path] = path.read_bytes()
        return self.texts[path]

    def includes(self, path, folders):
        """A name may be found in several of the folders: only the first counts for the compiler, each counts here."""
        key = path, folders
        if key not in self.found:
            self.found[key] = {candidate for name in INCLUDE.findall(self.text(path))
                               for folder in (path.parent, *folders)
                               if (candidate := pathlib.Path(os.path.normpath(folder / os.fsdecode(name)))).is_file()}
        return self.found[key]

    def closure(self, path, folders):
        """The file and all of the tree that it includes, also by others, in order."""
        seen, waiting = {path}, [path]
        while waiting:
            for other in self.includes(waiting.pop(), folders) - seen:
                if self.top in other.parents:
                    seen.add(other)
                    waiting.append(other)
        return sorted(seen)


def commands(build):
    """Path -> arguments of the compiler, of all the times that it is compiled, without the names of its input and outputs."""
    table = {}
    for entry in json.loads((build / "compile_commands.json").read_text()):
        words = shlex.split(entry["command"])
        kept, skip = [], False
        for word in words:
            if skip or word in ("-o", "-c"):
                skip = word == "-o"
            elif word != entry["file"]:
                kept.append(word)
        table.setdefault(pathlib.Path(entry["file"]), []).extend(kept)
    return table


def folders_of(arguments):
    """Those of -I, -isystem and the like that are in the tree count."""
    out, take = [], False
    for word in arguments:
        if take:
            out.append(pathlib.Path(word))
        take = word in ("-I", "-isystem", "-iquote")
        if word.startswith("-I") and len(word) > 2:
            out.append(pathlib.Path(word[2:]))
    return tuple(out)


def configurations(top, path):
    """The .clang-tidy files above a file, to the top."""
    return [f for folder in path.parents if folder == top or top in folder.parents
            if (f := folder / ".clang-tidy").is_file()]


def key_of(top, sources, path, files, arguments, version, extra):
    digest = hashlib.sha256()

    def add(data):
        digest.update(b"%d:" % len(data) + data)

    for text in (version, *extra, *(a.replace(str(top), "TOP") for a in arguments)):
        add(text.encode())
    for file in [*configurations(top, path), *files]:
        add(str(file.relative_to(top)).encode())
        add(sources.text(file))
    return digest.hexdigest()


class Records:
    """What was seen clean: an empty file each."""

    def __init__(self):
        cache = os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache"
        self.folder = pathlib.Path(os.environ.get("LUM_CACHE") or pathlib.Path(cache) / "lumsdk") / "tidy"
        self.folder.mkdir(parents=True, exist_ok=True)

    def has(self, key):
        """And it is the newest then."""
        try:
            os.utime(self.folder / key)
            return True
        except FileNotFoundError:
            return False

    def add(self, key):
        (self.folder / key).touch()

    def forget_old(self):
        """The oldest half, where there are too many."""
        records = [e for e in os.scandir(self.folder) if e.is_file()]
        if len(records) > RECORDS_MAX:
            for e in sorted(records, key=lambda e: e.stat().st_mtime)[:len(records) // 2]:
                pathlib.Path(e.path).unlink(missing_ok=True)


def tidy(build, path, checks, extra):
    """One file a run: clang-tidy 14 confuses va_lists of several. (whether it is clean, what it said)"""
    r = subprocess.run(["clang-tidy", "-p", build, f"--checks={checks}", *extra, "--quiet", path],
                       capture_output=True, text=True, errors="replace", stdin=subprocess.DEVNULL, check=False)
    # Its count of hidden warnings goes to stderr, as does what it could not read.
    faults = "".join(f"{line}\n" for line in r.stderr.splitlines() if "error" in line.lower())
    return r.returncode == 0 and not faults and not r.stdout.strip(), r.stdout + faults


def version():
    program = shutil.which("clang-tidy")
    if program is None:
        sys.exit("tidy.py needs clang-tidy (Debian: clang-tidy)")
    return subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout


def look(top, build, paths, checks, extra, everything, jobs, out=sys.stdout):
    """0, or 1 where something is wrong."""
    table, sources, records = commands(build), Sources(top), Records()
    unknown = [p for p in paths if p not in table]
    for p in unknown:
        print(f"{p}: no build compiles it", file=out)
    paths = [p for p in paths if p in table]
    names, sentence = changed.changed(top, everything)
    files = {p: sources.closure(p, folders_of(table[p])) for p in paths}
    # What a file is looked at by is part of it.
    touched = [p for p in paths if names is None
               or any(str(f.relative_to(top)) in names for f in [*configurations(top, p), *files[p]])]
    is_of = version()
    keys = {p: key_of(top, sources, p, files[p], table[p], is_of, (checks, *extra)) for p in touched}
    waiting = [p for p in touched if not records.has(keys[p])]
    bad = len(unknown)
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for path, (is_clean, said) in zip(waiting, pool.map(lambda p: tidy(build, p, checks, extra), waiting)):
            if is_clean:
                records.add(keys[path])
            else:
                bad += 1
                print(said or f"{path}: clang-tidy failed", file=out)
    records.forget_old()
    print(f"clang-tidy: {sentence}: {len(touched)} of {len(paths)} files; {len(touched) - len(waiting)} of them are unchanged since"
          f" they were clean, {bad} with findings", file=out)
    return 1 if bad else 0


def main():
    at = sys.argv.index("--")
    words, files = sys.argv[1:at], sys.argv[at + 1:]
    everything = "--all" in words
    preset, checks, *extra = [w for w in words if w != "--all"]
    try:
        sys.exit(look(TOP, TOP / "build" / preset, [TOP / f for f in files], checks, extra, everything, os.cpu_count() or 2))
    except changed.Refused as refusal:
        sys.exit(f"tidy.py: {refusal}")


if __name__ == "__main__":
    main()
