"""Mutation testing of the core: changes one thing at a time in a source file and
looks whether a unit test notices.

Most mutants of a file are compiled into one object and chosen by an environment
variable as it is loaded before the library's; those in constant expressions are
compiled one by one. Tests are linked with the core as a shared library, once, and
once more with AddressSanitizer, which what survived the first is shown to. What is
undefined ends a test in both."""
import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import threading

import mutants as find

ROOT = pathlib.Path(__file__).resolve().parents[2]
LEAST = 95.0
CFLAGS = ["-std=c99", "-w", "-O1", "-g0", "-fPIC"]
TRAPS = ["-fsanitize=undefined,bounds-strict", "-fsanitize-undefined-trap-on-error"]
GUARDS = ["-fsanitize=address"]
# What is loaded first comes before the sanitizer, and defines what the library does.
ASAN_OPTIONS = "verify_asan_link_order=0:detect_odr_violation=0:detect_leaks=0"

# Ends a test program at its first failure, or when it has had its time. Without a
# name for the file of marks there are none.
RUNTIME = """
#define _GNU_SOURCE
#include <stdio.h>
#include <stdlib.h>
#include <sys/time.h>
#include <unistd.h>
int lum_mutant;
unsigned char lum_reached[LUM_MUTANTS + 1];
__attribute__((constructor)) static void begin(void)
{
    const char *number = getenv("LUM_MUTANT");
    const char *ms = getenv("LUM_MUTANT_MS");
    const long limit = ms != NULL ? atol(ms) : 0;
    const struct itimerval t = {{0, 0}, {limit / 1000, limit % 1000 * 1000}};
    lum_mutant = number != NULL ? atoi(number) : 0;
    setitimer(ITIMER_PROF, &t, NULL);
    unsetenv("LD_PRELOAD");
}
__attribute__((destructor)) static void end(void)
{
    const char *name = getenv("LUM_MUTANT_MARKS");
    FILE *f = name != NULL ? fopen(name, "wb") : NULL;
    if (f != NULL) {
        fwrite(lum_reached, 1, sizeof lum_reached, f);
        fclose(f);
    }
}
void _fail(const char *file, int line)
{
    (void)file;
    (void)line;
    _exit(1);
}
"""


class Trouble(Exception):
    """What makes a run say nothing of the tests."""


class Refused(Exception):
    """A mutant that is not C."""


def run(command, **options):
    r = subprocess.run(list(map(str, command)), capture_output=True, text=True, **options)
    if r.returncode != 0:
        raise Trouble(f"{shlex.join(map(str, command))}:\n{r.stderr[:4000]}")
    return r.stdout


class Programs:
    """The tests, built in one way."""

    def __init__(self, house, out, flags):
        self.house, self.out, self.flags = house, out, flags
        self.seconds = {}  # of CPU time, by name

    def compile(self, target, *what):
        run(["gcc", *CFLAGS, *self.flags, *self.house.include, "-o", target, *what])

    def build(self, pool):
        house = self.house
        self.out.mkdir(parents=True, exist_ok=True)
        library = self.out / "library.so"
        self.compile(library, "-shared", *house.sources)
        objects = [(self.out / (s.stem + ".o"), s) for s in house.support]
        list(pool.map(lambda o: self.compile(o[0], "-c", o[1]), objects))
        links = ["-lcmocka", "-lm", f"-Wl,-rpath,{self.out}"]
        list(pool.map(lambda t: self.compile(
            self.out / t[0], f'-DLUM_SOURCE_DIR="{house.root}"', t[1],
            *(o for o, _ in objects), library, *links), house.tests.items()))
        for name in house.tests:
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            if self.start(name, {}) != 0:
                raise Trouble(f"{name} fails as it is, without any mutant")
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            self.seconds[name] = sum(after[:2]) - sum(before[:2])

    def start(self, name, environment):
        return subprocess.call(
            [str(self.out / name)], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL, cwd=self.out,
            env={**os.environ, "ASAN_OPTIONS": ASAN_OPTIONS, **environment})

    def killer(self, names, preload, number):
        """Which test notices first, or None."""
        for name in names:
            limit_ms = int(300 + 8000 * self.seconds[name])
            code = self.start(name, {"LD_PRELOAD": str(preload), "LUM_MUTANT": str(number),
                                     "LUM_MUTANT_MS": str(limit_ms)})
            if code != 0:
                return name if code != -signal.SIGPROF else f"{name}, out of time"
        return None


class House:
    """What is mutated and what tests it; made by hand for the tool's own tests."""

    def __init__(self, root, out, sources, tests, support=(), include=()):
        self.root, self.out = root, out
        self.sources = sources  # of the library
        self.tests = tests      # name: source
        self.support = support  # linked with every test
        self.include = [f"-I{i}" for i in include]
        self.plain = Programs(self, out / "plain", [])
        self.guarded = Programs(self, out / "guarded", GUARDS)

    def build(self, pool):
        self.plain.build(pool)
        self.guarded.build(pool)


class Module:
    """One file and its mutants."""

    def __init__(self, house, path):
        self.house, self.path = house, path
        self.dir = house.out / path.name
        finder = find.Finder(path, ["-std=c99", *house.include])
        self.source = finder.source
        self.mutants = finder.find()
        find.label(self.mutants)
        headers = [p for p in path.parent.glob("*.h")]
        if path.suffix == ".h":
            self.compiled = [s for s in house.sources if s.parent == path.parent
                             and self._includes(s, {h.name: h for h in headers}, set())]
        else:
            self.compiled = [path]
        if self.dir.exists():
            shutil.rmtree(self.dir)
        self.dir.mkdir(parents=True)
        for p in {*headers, *self.compiled} - {path}:
            shutil.copy(p, self.dir / p.name)
        self.runtime = self.dir / "lum_mutate_runtime.c"
        self.runtime.write_text(RUNTIME)

    def _includes(self, source, headers, seen):
        for name in re.findall(r'#include "([^"/]+)"', source.read_text()):
            if name == self.path.name:
                return True
            if name in headers and name not in seen:
                seen.add(name)
                if self._includes(headers[name], headers, seen):
                    return True
        return False

    def _compile(self, text, programs, target, *flags):
        (target.parent / self.path.name).write_text(text, encoding="latin-1", newline="")
        sources = [target.parent / p.name for p in self.compiled]
        programs.compile(target, f"-I{self.path.parent}", "-shared", *TRAPS, *flags, *sources,
                         f"-DLUM_MUTANTS={len(self.mutants)}", self.runtime)

    def build(self):
        house = self.house
        self.text = find.with_switches(self.source, self.mutants)
        marking = self.dir / "marking.so"
        self._compile(self.text, house.plain, marking, "-DLUM_REACH")
        self.reach = {}
        for name in house.tests:
            marks = self.dir / f"{name}.marks"
            code = house.plain.start(name, {"LD_PRELOAD": str(marking),
                                            "LUM_MUTANT_MARKS": str(marks)})
            if code != 0:
                raise Trouble(f"{name} fails with {self.path.name} in place, but no mutant chosen")
            self.reach[name] = marks.read_bytes()
        seconds = house.plain.seconds
        self.order = sorted(house.tests, key=lambda n: (
            n != f"test_{self.path.stem}", seconds[n] > 0.2, -sum(self.reach[n]), seconds[n]))
        # those that come to the file at all, for what has no mark
        self.touching = [n for n in self.order if any(self.reach[n])] or self.order
        self.built = {}
        self.lock = threading.Lock()

    def _with_all(self, programs):
        """The object with all mutants, for tests built in one way."""
        with self.lock:
            if programs not in self.built:
                target = self.dir / f"{programs.out.name}.so"
                self._compile(self.text, programs, target)
                killer = programs.killer(self.touching, target, 0)
                if killer:
                    raise Trouble(f"{killer} fails with {self.path.name} in place, "
                                  f"{programs.out.name}, but no mutant chosen")
                self.built[programs] = target
        return self.built[programs]

    def name_of(self, mutant):
        """As survivors.txt names it."""
        return f"{self.path.name}:{mutant.name}"

    def line_of(self, mutant):
        return self.source.count("\n", 0, mutant.start) + 1

    def judge(self, mutant):
        """Sets what became of it: killed, equivalent, survived, unreached, refused."""
        mutant.by = None
        names = self.touching
        if mutant.runtime:
            names = [n for n in self.order if self.reach[n][mutant.number]]
        try:
            mutant.by = self._killer(mutant, self.house.plain, names)
            if mutant.by:
                mutant.fate = "killed"
            elif self._is_same_code(mutant):
                mutant.fate = "equivalent"
            else:
                mutant.by = self._killer(mutant, self.house.guarded, names)
                mutant.fate = "killed" if mutant.by else "survived" if names else "unreached"
        except Refused:
            mutant.fate = "refused"
        return mutant

    def _killer(self, mutant, programs, names):
        if mutant.runtime:
            return programs.killer(names, self._with_all(programs), mutant.number)
        with tempfile.TemporaryDirectory(dir=self.dir) as d:
            for p in self.dir.glob("*.[ch]"):
                shutil.copy(p, d)
            target = pathlib.Path(d) / "one.so"
            try:
                self._compile(mutant.apply(self.source), programs, target)
            except Trouble as e:
                raise Refused from e
            return programs.killer(names, target, 0)

    def _code(self, text, compiler, flags):
        """What a compiler makes of the file; names of directories are not in it."""
        with tempfile.TemporaryDirectory(dir=self.dir) as d:
            for p in self.dir.glob("*.h"):
                shutil.copy(p, pathlib.Path(d) / p.name)
            for p in self.compiled:
                shutil.copy(p, pathlib.Path(d) / p.name)
            (pathlib.Path(d) / self.path.name).write_text(text, encoding="latin-1", newline="")
            digest = hashlib.sha256()
            for p in self.compiled:
                run([compiler, "-std=c99", "-w", flags, *self.house.include,
                     f"-I{self.path.parent}", "-c", p.name, "-o", "one.o"], cwd=d)
                digest.update((pathlib.Path(d) / "one.o").read_bytes())
            return digest.digest()

    def _is_same_code(self, mutant):
        for compiler in ("gcc", "clang"):
            if not shutil.which(compiler):
                continue
            key = "_plain_" + compiler
            if not hasattr(self, key):
                setattr(self, key, self._code(self.source, compiler, "-O2"))
            if self._code(mutant.apply(self.source), compiler, "-O2") == getattr(self, key):
                return True
        return False


class Survivors:
    """The list of those that may survive: lines FILE:MUTANT, several if they share
    one reason, then the reason, indented."""

    def __init__(self, path):
        self.reasons = {}
        names, reason = [], []
        lines = path.read_text().splitlines() if path and path.exists() else []
        for number, line in enumerate([*lines, "end:"], 1):
            if line.startswith("#") or not line.strip():
                continue
            if line.startswith(" "):
                if not names:
                    raise Trouble(f"{path}:{number}: a reason without a mutant")
                reason.append(line.strip())
                continue
            if reason:
                self._keep(path, number, names, reason)
                names, reason = [], []
            names.append(line.strip())
        if names != ["end:"]:
            raise Trouble(f"{path}: {names[0]} has no reason")

    def _keep(self, path, number, names, reason):
        for name in names:
            if name in self.reasons:
                raise Trouble(f"{path}:{number}: {name} is there twice")
            self.reasons[name] = " ".join(reason)


def chosen(mutants, percent, seed):
    if percent >= 100:
        return mutants
    def place(m):
        digest = hashlib.sha256(f"{seed}:{m.name}".encode()).digest()
        return int.from_bytes(digest[:8], "big") / 2.0 ** 64
    return [m for m in mutants if place(m) * 100 < percent]


def cpu():
    return sum(sum(resource.getrusage(w)[:2])
               for w in (resource.RUSAGE_CHILDREN, resource.RUSAGE_SELF))


class Tally:
    """What came of the mutants, by file and in all."""
    COLUMNS = ("mutants", "killed", "listed", "new", "same")

    def __init__(self, listed):
        self.listed = listed
        self.total = dict.fromkeys(self.COLUMNS, 0)
        self.news, self.stale, self.kept = [], [], {}
        self.left_out = 0

    def add(self, module, judged, seconds):
        count = dict.fromkeys(self.COLUMNS, 0)
        for m in judged:
            name = module.name_of(m)
            self.left_out += m.fate == "refused"
            count["same"] += m.fate == "equivalent"
            count["mutants"] += m.fate not in ("refused", "equivalent")
            count["killed"] += m.fate == "killed"
            if m.fate in ("survived", "unreached"):
                self.kept[name] = m.fate
                count["listed" if name in self.listed.reasons else "new"] += 1
                if name not in self.listed.reasons:
                    self.news.append(f"{name}\n    line {module.line_of(m)}: {m.fate}")
            elif name in self.listed.reasons:
                self.stale.append(f"{name}: {m.fate}" + (f" by {m.by}" if m.by else ""))
        row(module.path.name, count, seconds)
        for key in self.total:
            self.total[key] += count[key]

    def miss_mutants(self, module):
        """What is listed of a file and is no mutant of it."""
        present = {module.name_of(m) for m in module.mutants}
        self.stale += [f"{n}: no such mutant" for n in self.listed.reasons
                       if n.startswith(module.path.name + ":") and n not in present]

    def miss_files(self, paths):
        there = {p.name for p in paths}
        self.stale += [f"{n}: no such file" for n in self.listed.reasons
                       if n.split(":")[0] not in there]


def pick(module, listed, options):
    """The mutants to try, and those that are taken from the list instead."""
    picked = chosen(module.mutants, options.sample, options.seed)
    if options.again is not None:
        picked = [m for m in picked if module.name_of(m) in options.again]
    if options.sample >= 100 and not options.unlisted:
        return picked, []
    known = [m for m in picked if module.name_of(m) in listed.reasons]
    for m in known:
        m.fate, m.by = "survived", None
    return [m for m in picked if m not in known], known


def judge(module, pool, listed, options):
    trying, known = pick(module, listed, options)
    if trying:
        module.build()
    judged = known + list(pool.map(module.judge, trying))
    if options.verbose:
        for m in judged:
            print(f"{module.path.name}:{module.line_of(m)}: {m.name}: {m.fate} {m.by or ''}")
    return judged


def work(house, paths, listed, options):
    """All of it; a table on stdout. True if the bar is reached and none is new."""
    started = cpu()
    tally = Tally(listed)
    is_whole = options.again is None and options.sample >= 100
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        house.build(pool)
        print(f"{'file':<18}{'mutants':>8}{'killed':>8}{'listed':>8}{'new':>6}{'%':>8}"
              f"{'same code':>11}{'CPU s':>8}", flush=True)
        for path in paths:
            at = cpu()
            module = Module(house, path)
            if module.mutants:
                tally.add(module, judge(module, pool, listed, options), cpu() - at)
            if is_whole:
                tally.miss_mutants(module)
    if not options.file:
        tally.miss_files(paths)
    row("all", tally.total, cpu() - started)
    (house.out / "survivors.json").write_text(json.dumps(tally.kept, indent=1))
    return verdict(tally, LEAST if is_whole and not options.file else 0.0)


def row(name, c, seconds):
    percent = 100.0 * c["killed"] / c["mutants"] if c["mutants"] else 100.0
    print(f"{name:<18}{c['mutants']:>8}{c['killed']:>8}{c['listed']:>8}{c['new']:>6}"
          f"{percent:>8.1f}{c['same']:>11}{seconds:>8.1f}", flush=True)


def verdict(tally, least):
    total = tally.total
    if tally.news:
        print("\nsurvivors that tests/mutate/survivors.txt does not list:")
        print("\n".join(tally.news))
    if tally.stale:
        print("\nto be removed from tests/mutate/survivors.txt:")
        print("\n".join(tally.stale))
    if not total["mutants"]:
        print("FAIL: no mutants")
        return False
    percent = 100.0 * total["killed"] / total["mutants"]
    good = percent >= least and not tally.news and not tally.stale
    bar = f" (at least {least:.0f})" if least else ""
    print(f"\n{'ok' if good else 'FAIL'}: {total['killed']} of {total['mutants']} mutants killed, "
          f"{percent:.1f} %{bar}, {len(tally.news)} survivors not listed; "
          f"{total['same']} more compile to the same code, {tally.left_out} do not compile")
    return good


def core_tests():
    """The tests that CMake builds of the core: those of lum_core alone, and those of
    its modules that need more."""
    cmake = (ROOT / "tests/unit/CMakeLists.txt").read_text()
    lists = re.findall(r"foreach\(test IN ITEMS([\w\s]+)\)\s*lum_unit_test\(\$\{test\} (\w+)\)",
                       cmake)
    names = [n for names, library in lists for n in names.split()
             if library == "lum_core"
             or (library == "lum_points" and (ROOT / f"src/core/{n}.c").exists())]
    return {f"test_{n}": ROOT / f"tests/unit/test_{n}.c" for n in names}


def core_house(out):
    return House(ROOT, out, sorted((ROOT / "src/core").glob("*.c")), core_tests(),
                 [ROOT / "tests/unit/support.c", *sorted((ROOT / "src/points").glob("*.c"))],
                 [ROOT / "include", ROOT / "src"])


def parse(arguments):
    p = argparse.ArgumentParser(prog="mutate", description="Mutation testing of src/core.")
    p.add_argument("file", nargs="*", type=pathlib.Path, help="of src/core; all without")
    p.add_argument("--sample", type=float, default=100.0, metavar="PERCENT",
                   help="only so many of the mutants")
    p.add_argument("--seed", default="1", help="which of them")
    p.add_argument("--unlisted", action="store_true",
                   help="take those that are listed for survivors, without a try")
    p.add_argument("--again", action="store_true", help="only what survived the last run")
    p.add_argument("--out", type=pathlib.Path, default=ROOT / "build/mutate")
    p.add_argument("--jobs", type=int, default=os.cpu_count() or 2)
    p.add_argument("--verbose", action="store_true", help="say of every mutant what killed it")
    return p.parse_args(arguments)


def main(arguments):
    options = parse(arguments)
    options.out = options.out.resolve()
    last = options.out / "survivors.json"
    options.again = json.loads(last.read_text()) if options.again else None
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    paths = [p.resolve() for p in options.file] or sorted((ROOT / "src/core").glob("*.[ch]"))
    try:
        listed = Survivors(ROOT / "tests/mutate/survivors.txt")
        return 0 if work(core_house(options.out), paths, listed, options) else 1
    except (Trouble, find.Unparsable) as e:
        print(f"mutate: {e}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
