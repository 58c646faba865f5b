"""Mutation testing: changes one thing at a time in a source file and looks whether a
unit test notices.

A room is a directory of sources and the tests of it. Most mutants of a file are
compiled into one object and chosen by an environment variable as it is loaded before
the room's library; those in constant expressions are compiled one by one. Tests are
linked with the room's sources as a shared library, once, and once more with
AddressSanitizer, which what survived the first is shown to. What is undefined ends a
test in both."""
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
import struct
import subprocess
import sys
import tempfile
import threading

import mutants as find

ROOT = pathlib.Path(__file__).resolve().parents[2]
LEAST = 97.0
# Points by plain C alone: no machine has all kinds of vectors.
CFLAGS = ["-std=c99", "-w", "-O1", "-g0", "-fPIC", "-DLUM_PLAIN_POINTS"]
TRAPS = ["-fsanitize=undefined,bounds-strict", "-fsanitize-undefined-trap-on-error"]
GUARDS = ["-fsanitize=address"]
# What one of them cannot tell from the original is the original.
COMPILERS = [("gcc", "-O2"), ("clang", "-O2"), ("gcc", "-Os")]
# What is loaded first comes before the sanitizer, and defines what the library does.
ASAN_OPTIONS = "verify_asan_link_order=0:detect_odr_violation=0:detect_leaks=0"

# Ends a test program at its first failure, or when it has had its time. It stands
# before CMocka: runs the cases that are asked for, or all, and then writes for each
# how long it took and which mutants it came to.
RUNTIME = """
#define _GNU_SOURCE
#include <dlfcn.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
#include <cmocka.h>
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
typedef int run_cases(const char *, const struct CMUnitTest *, size_t, CMFixtureFunction,
                      CMFixtureFunction);
static void mark(FILE *f, double seconds)
{
    fwrite(&seconds, sizeof seconds, 1, f);
    fwrite(lum_reached, 1, sizeof lum_reached, f);
    memset(lum_reached, 0, sizeof lum_reached);
}
static int run_each(run_cases *cmocka, const char *name, const struct CMUnitTest *tests, size_t n,
                    FILE *f)
{
    int failed = 0;
    for (size_t i = 0; i < n; i++) {
        const clock_t before = clock();
        failed += cmocka(name, &tests[i], 1, NULL, NULL);
        mark(f, (double)(clock() - before) / CLOCKS_PER_SEC);
    }
    return failed;
}
int _cmocka_run_group_tests(const char *name, const struct CMUnitTest *const tests,
                            const size_t n, CMFixtureFunction setup, CMFixtureFunction teardown)
{
    run_cases *const cmocka = (run_cases *)dlsym(RTLD_NEXT, "_cmocka_run_group_tests");
    const char *marks = getenv("LUM_MUTANT_MARKS");
    const char *at = getenv("LUM_MUTANT_CASES");
    struct CMUnitTest *const asked = calloc(n + 1, sizeof *tests);
    size_t count = 0;
    if (setup != NULL || teardown != NULL) {
        abort();
    }
    if (marks != NULL) {
        FILE *const f = fopen(marks, "wb");
        const int failed = run_each(cmocka, name, tests, n, f);
        fclose(f);
        return failed;
    }
    if (at == NULL) {
        return cmocka(name, tests, n, NULL, NULL);
    }
    for (char *end; count < n && *at != 0; at = *end == ',' ? end + 1 : end) {
        asked[count++] = tests[strtoul(at, &end, 10) % n];
    }
    return cmocka(name, asked, count, NULL, NULL);
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
    """The tests, built in one way; each when it is first asked for."""

    def __init__(self, house, out, flags):
        self.house, self.out, self.flags = house, out, flags
        self.seconds = {}  # of CPU time, by name
        self.common = None
        self.lock = threading.Lock()

    def compile(self, target, *what):
        run(["gcc", *CFLAGS, *self.flags, *self.house.include, "-o", target, *what])

    def build(self, pool):
        """All of them."""
        self._build_common(pool)
        list(pool.map(self._link, self.house.tests))
        for name in self.house.tests:
            self._measure(name)

    def need(self, name):
        """One of them."""
        with self.lock:
            if name not in self.seconds:
                if self.common is None:
                    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
                        self._build_common(pool)
                self._link(name)
                self._measure(name)

    def _build_common(self, pool):
        house = self.house
        self.out.mkdir(parents=True, exist_ok=True)
        library = self.out / "library.so"
        objects = [(self.out / (s.stem + ".o"), s) for s in house.support]
        shared = pool.submit(self.compile, library, "-shared", *house.sources)
        list(pool.map(lambda o: self.compile(o[0], "-c", o[1]), objects))
        shared.result()
        self.common = [*(o for o, _ in objects), library]

    def _link(self, name):
        self.compile(self.out / name, f'-DLUM_SOURCE_DIR="{self.house.root}"',
                     self.house.tests[name], *self.common, "-lcmocka", "-lm",
                     f"-Wl,-rpath,{self.out}")

    def _measure(self, name):
        """Others may run meanwhile."""
        child = subprocess.Popen([str(self.out / name)], cwd=self.out, **self._options({}))
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            raise Trouble(f"{name} fails as it is, without any mutant")
        self.seconds[name] = used.ru_utime + used.ru_stime

    @staticmethod
    def _options(environment):
        nothing = subprocess.DEVNULL
        return {"stdin": nothing, "stdout": nothing, "stderr": nothing,
                "env": {**os.environ, "ASAN_OPTIONS": ASAN_OPTIONS, **environment}}

    def start(self, name, environment):
        return subprocess.call([str(self.out / name)], cwd=self.out, **self._options(environment))

    def killer(self, plan, preload, number):
        """Which test notices first, or None."""
        for name, cases, share in plan:
            self.need(name)
            limit_ms = int(300 + 8000 * share * self.seconds[name])
            code = self.start(name, {"LD_PRELOAD": str(preload), "LUM_MUTANT": str(number),
                                     "LUM_MUTANT_MS": str(limit_ms),
                                     "LUM_MUTANT_CASES": ",".join(map(str, cases))})
            if code != 0:
                return name if code != -signal.SIGPROF else f"{name}, out of time"
        return None


class Reach:
    """Which mutants the cases of a test program come to, and how long those take."""

    def __init__(self, marks, mutants):
        record = 8 + mutants + 1
        if not marks or len(marks) % record:
            raise Trouble("a test program wrote no marks")
        records = [marks[i:i + record] for i in range(0, len(marks), record)]
        self.seconds = [struct.unpack("d", r[:8])[0] for r in records]
        self.marks = [r[8:] for r in records]
        self.all = max(1e-6, sum(self.seconds))

    def cases(self, number):
        """Of a mutant, or with None of any, the shortest first; what share of the time
        they take."""
        there = [i for i, m in enumerate(self.marks)
                 if (any(m) if number is None else m[number])]
        there.sort(key=lambda i: self.seconds[i])
        return there, sum(self.seconds[i] for i in there) / self.all


class House:
    """A room: what is mutated and what tests it. Made by hand for the tool's own tests."""

    def __init__(self, root, out, sources, tests, support=(), include=(), name="all"):
        self.root, self.out, self.name = root, out, name
        self.sources = sources  # of the library
        self.tests = tests      # name: source
        self.support = support  # linked with every test
        self.include = [f"-I{i}" for i in include]
        self.plain = Programs(self, out / "plain", [])
        self.guarded = Programs(self, out / "guarded", GUARDS)

    def build(self, pool):
        self.plain.build(pool)


class Module:
    """One file and its mutants."""

    def __init__(self, house, path):
        self.house, self.path = house, path
        self.dir = house.out / path.name
        finder = find.Finder(path, ["-std=c99", "-DLUM_PLAIN_POINTS", *house.include])
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
            self.reach[name] = Reach(marks.read_bytes(), len(self.mutants))
        # For what has no mark: all cases of the programs that come to the file, as a case
        # may look at a table by itself.
        touching = [n for n, *_ in self._plan(None)] or self.reach
        self.touching = [(n, range(len(self.reach[n].seconds)), 1.0) for n in touching]
        self.built, self.plain_code = {}, {}
        self.lock = threading.Lock()

    def _plan(self, number):
        """The cases that come to a mutant, by program: the module's own first, then the
        quick ones."""
        plan = [(name, *reach.cases(number)) for name, reach in self.reach.items()]
        plan = [p for p in plan if p[1]]
        plan.sort(key=lambda p: (p[0] != f"test_{self.path.stem}",
                                 p[2] * self.house.plain.seconds[p[0]]))
        return plan

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
        plan = self._plan(mutant.number) if mutant.runtime else self.touching
        try:
            mutant.by = self._killer(mutant, self.house.plain, plan)
            if mutant.by:
                mutant.fate = "killed"
            elif self._is_same_code(mutant):
                mutant.fate = "equivalent"
            else:
                mutant.by = self._killer(mutant, self.house.guarded, plan)
                mutant.fate = "killed" if mutant.by else "survived" if plan else "unreached"
        except Refused:
            mutant.fate = "refused"
        return mutant

    def _killer(self, mutant, programs, plan):
        if mutant.runtime:
            return programs.killer(plan, self._with_all(programs), mutant.number)
        with tempfile.TemporaryDirectory(dir=self.dir) as d:
            for p in self.dir.glob("*.[ch]"):
                shutil.copy(p, d)
            target = pathlib.Path(d) / "one.so"
            try:
                self._compile(mutant.apply(self.source), programs, target)
            except Trouble as e:
                raise Refused from e
            return programs.killer(plan, target, 0)

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
                run([compiler, "-std=c99", "-w", "-DLUM_PLAIN_POINTS", flags, *self.house.include,
                     f"-I{self.path.parent}", "-c", p.name, "-o", "one.o"], cwd=d)
                digest.update((pathlib.Path(d) / "one.o").read_bytes())
            return digest.digest()

    def _is_same_code(self, mutant):
        for compiler, flags in COMPILERS:
            if not shutil.which(compiler):
                continue
            with self.lock:
                if (compiler, flags) not in self.plain_code:
                    self.plain_code[compiler, flags] = self._code(self.source, compiler, flags)
            if self._code(mutant.apply(self.source), compiler, flags) == \
                    self.plain_code[compiler, flags]:
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
        self.room = dict.fromkeys(self.COLUMNS, 0)
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
            self.room[key] += count[key]

    def end_room(self, name, seconds):
        row(name, self.room, seconds)
        self.room = dict.fromkeys(self.COLUMNS, 0)

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


def work_in(house, paths, tally, options):
    """One room."""
    started = cpu()
    is_whole = options.again is None and options.sample >= 100
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        house.build(pool)
        for path in paths:
            at = cpu()
            module = Module(house, path)
            if module.mutants:
                tally.add(module, judge(module, pool, tally.listed, options), cpu() - at)
            if is_whole:
                tally.miss_mutants(module)
    tally.end_room(house.name, cpu() - started)


def work(rooms, listed, options):
    """Rooms with their files; a table on stdout. True if the bar is reached and no
    survivor is new."""
    started = cpu()
    tally = Tally(listed)
    is_whole = options.again is None and options.sample >= 100 and not options.file
    print(f"{'file':<18}{'mutants':>8}{'killed':>8}{'listed':>8}{'new':>6}{'%':>8}"
          f"{'same code':>11}{'CPU s':>8}", flush=True)
    for house, paths in rooms:
        work_in(house, paths, tally, options)
    if not options.file:
        tally.miss_files([p for _, paths in rooms for p in paths])
    row("all", tally.total, cpu() - started)
    options.last.parent.mkdir(parents=True, exist_ok=True)
    options.last.write_text(json.dumps(tally.kept, indent=1))
    return verdict(tally, LEAST if is_whole else 0.0)


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


def tests_of(library):
    """Names of the tests that CMake builds of a library."""
    cmake = (ROOT / "tests/unit/CMakeLists.txt").read_text()
    lists = re.findall(r"foreach\(test IN ITEMS([\w\s]+)\)\s*lum_unit_test\(\$\{test\} (\w+)(?: ROOM \w+)?\)",
                       cmake)
    return [n for names, of in lists for n in names.split() if of == library]


# What the tests of src/live are linked with: a session on a network that they move by hand.
SESSION = ["tests/fake/exact.c", "tests/fake/fake_net.c", "src/base/error.c", "src/base/sized.c", "src/host/laser_name.c",
           *(f"src/net/{n}.c" for n in ("endpoint", "exchange", "sensor", "session"))]


def sources_of(directory):
    """Those that are linked: of src/core some take the place of others."""
    if directory == "src/core":
        listed = (ROOT / directory / "sources.cmake").read_text()
        return [ROOT / directory / n for n in re.search(r"set\(lum_core_sources([^)]*)\)", listed)[1].split()]
    return [p for p in sorted((ROOT / directory).glob("*.c")) if p.name != "main.c"]


def room(out, name, directory, tests, support=("tests/unit/support.c",), include=()):
    """Its sources are mutated; those of core and points are there for all."""
    sources = sources_of(directory)
    others = [p for d in ("src/core", "src/points") if d != directory for p in sources_of(d)]
    house = House(ROOT, out / name, sources,
                  {f"test_{n}": ROOT / f"tests/unit/test_{n}.c" for n in tests},
                  [*(ROOT / s for s in support), *(ROOT / "tests/unit").glob(f"{name}_rig.c"), *others],
                  [ROOT / "include", ROOT / "src", ROOT / directory, *(ROOT / i for i in include)], name)
    return house, sorted([*sources, *(ROOT / directory).glob("*.h")])


def room_instead(out, file, of, more=()):
    """The core with a file in place of one; only that file is mutated."""
    cmake = (ROOT / "tests/unit/CMakeLists.txt").read_text()
    define, names = re.search(rf"lum_core_instead\(\w+ (\w+) {file} ([\w ]+)\)", cmake).groups()
    house, _ = room(out, pathlib.Path(file).stem, "src/core", [*names.split(), *more])
    house.sources = [p.with_name(file) if p.name == of else p for p in house.sources]
    house.include.append(f"-D{define}")
    return house, [ROOT / "src/core" / file]


def all_rooms(out):
    """The core's tests are those of lum_core alone, and those of its modules that need
    more."""
    core = tests_of("lum_core") + [n for n in tests_of("lum_points")
                                   if (ROOT / f"src/core/{n}.c").exists()]
    return [room(out, "core", "src/core", core),
            room_instead(out, "layout_fixed.c", "layout_any.c"),
            room_instead(out, "frames_none.c", "frames.c", ["frames_none"]),
            room(out, "host", "src/host", tests_of("lum_host")),
            room(out, "points", "src/points", tests_of("lum_points")),
            room(out, "live", "src/live", ["contact", "laser_session", "session"], SESSION, ["tests/fake"]),
            room(out, "gateway", "examples/firmware", tests_of("lum_gateway"))]


def select(rooms, asked):
    """The files asked for, directories among them, in their rooms; all without."""
    asked = [p.resolve() for p in asked]
    there = {f for _, files in rooms for f in files}
    for p in asked:
        if not any(f == p or p in f.parents for f in there):
            raise Trouble(f"{p} is in no room: {', '.join(h.name for h, _ in rooms)}")
    def is_picked(f):
        return not asked or f in asked or bool(set(asked) & set(f.parents))
    picked = [(house, [f for f in files if is_picked(f)]) for house, files in rooms]
    return [(house, files) for house, files in picked if files]


def parse(arguments):
    p = argparse.ArgumentParser(prog="mutate", description="Mutation testing.")
    p.add_argument("file", nargs="*", type=pathlib.Path, help="or a directory of them; all without")
    p.add_argument("--sample", type=float, default=100.0, metavar="PERCENT",
                   help="only so many of the mutants")
    p.add_argument("--seed", default="1", help="which of them")
    p.add_argument("--unlisted", action="store_true",
                   help="take those that are listed for survivors, without a try")
    p.add_argument("--again", action="store_true", help="only what survived the last run")
    p.add_argument("--out", type=pathlib.Path, default=ROOT / "build/mutate")
    p.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)))
    p.add_argument("--verbose", action="store_true", help="say of every mutant what killed it")
    options = p.parse_args(arguments)
    options.out = options.out.resolve()
    options.last = options.out / "survivors.json"
    if options.again and not options.last.exists():
        p.error("--again: nothing was run before")
    options.again = json.loads(options.last.read_text()) if options.again else None
    return options


def main(arguments):
    options = parse(arguments)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        listed = Survivors(ROOT / "tests/mutate/survivors.txt")
        rooms = select(all_rooms(options.out), options.file)
        return 0 if work(rooms, listed, options) else 1
    except (Trouble, find.Unparsable) as e:
        print(f"mutate: {e}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
