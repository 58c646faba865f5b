"""Sizes, stacks and instructions of the core on small targets.

size.py BUILD_DIR TABLE [--update]: builds src/core in BUILD_DIR for every
target, measures, and compares with the tables between the markers of TABLE, or
writes them anew. Status 1 when a figure has grown by more than 2 % or is over
its bar, and when the core calls for floating point or division.
size.py BUILD_DIR --worst TARGET: searches the worst push on one target, such as
"M4F -O2", and shows what was found.
"""

import collections
import glob
import os
import re
import shutil
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
PORT = os.path.join(ROOT, "examples", "firmware", "port")
HERE = os.path.join(ROOT, "tests", "size")
GATE = os.path.join(ROOT, "tests", "tools", "nm_gate.sh")
# Files that are linked in place of others.
REPLACED = {"layout_fixed": "layout_any", "frames_none": "frames"}
# From a datagram to lines and points.
DECODE_PATH = ["lum_packet_decode", "lum_assembler_init", "lum_assembler_push", "lum_assembler_line",
               "lum_fixed_projector_init", "lum_points_fixed_compute"]
# The same with a projector that a computer made.
TABLE_PATH = [f for f in DECODE_PATH if f != "lum_fixed_projector_init"]
# What a gateway calls that only listens.
LISTENER = [*DECODE_PATH, "lum_layout_init", "lum_heartbeat_encode"]
# The same without lines; what lum_layout_init and lum_fixed_projector_init make comes from a computer.
RECEIVER = ["lum_packet_decode", "lum_receiver_init", "lum_receiver_push", "lum_receiver_line", "lum_points_fixed_compute"]
TABLES = os.path.join(ROOT, "tests", "unit", "tables", "typical.c")
DECODE_ROW = "**the decode path**, with its libgcc"
FIXED_ROW = "the decode path, fixed layout, projector of lumtable"
NO_FRAMES_ROW = "the same, without frame numbers"
RECEIVER_ROW = "**a receiver without lines**, with its libgcc"
FIXED_RECEIVER_ROW = "a receiver without lines, fixed layout"
# Rows, what is called, and the files in place of others.
PROGRAMS = [
    (DECODE_ROW, DECODE_PATH, ()),
    ("a listener, with its libgcc", LISTENER, ()),
    (FIXED_ROW, TABLE_PATH, ("layout_fixed",)),
    (NO_FRAMES_ROW, TABLE_PATH, ("layout_fixed", "frames_none")),
    (RECEIVER_ROW, RECEIVER, ()),
    ("the same, with tables of lumtable", [*RECEIVER, "typical_layout", "typical_projector"], ()),
    (FIXED_RECEIVER_ROW, RECEIVER, ("layout_fixed",)),
]
ALLOWED_GROWTH = 0.02
BEGIN = "<!-- script/size --update writes from here -->"
END = "<!-- to here -->"

ARM = "arm-none-eabi-"
RISCV = "riscv64-unknown-elf-"
M4F = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]
Target = collections.namedtuple("Target", "name prefix flags level")
TARGETS = [
    Target("M0+ -Os", ARM, ["-mcpu=cortex-m0plus", "-mthumb"], "-Os"),
    Target("M3 -Os", ARM, ["-mcpu=cortex-m3", "-mthumb"], "-Os"),
    Target("M4F -Os", ARM, M4F, "-Os"),
    Target("M7 -Os", ARM, ["-mcpu=cortex-m7", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv5-d16"], "-Os"),
    Target("rv32imac -Os", RISCV, ["-march=rv32imac", "-mabi=ilp32"], "-Os"),
    Target("M4F -O2", ARM, M4F, "-O2"),
]
YARDSTICK = TARGETS[0]
MEASURED = [t for t in TARGETS if t.name.startswith("M4F") or t is YARDSTICK]

COMMON = ["-std=c99", "-ffreestanding", "-Wall", "-Wextra", "-Werror",
          "-I" + os.path.join(ROOT, "include"), "-isystem", os.path.join(PORT, "freestanding")]

SECTIONS = ["-ffunction-sections", "-fdata-sections"]
BUILD_TYPES = ["MinSizeRel", "Release", "RelWithDebInfo", "Debug"]
BUILT = [t for t in TARGETS if t.name in ("M0+ -Os", "M4F -Os")]

RAM_OPEN = [1, 2, 4]
RAM_WORDS = [1000, 2000, 4000]
RAM_REACH = 4
DATAGRAM = 1472
LINE_WORDS = [1000, 2000, 4000]
CLOCK_HZ = 100_000_000
HELPERS = "of it libgcc, and padding"  # a rest, which the sum above watches
SMALLEST = "1,000, and a datagram of 1,472 bytes"
NO_LINES = "no lines: a receiver, and a datagram of 1,472 bytes"
FIRST_ANGLES = 334  # in the packet that opens a line


class Failure(Exception):
    """Something that a person has to look at."""


def run(*command, cwd=None, timeout=100):
    done = subprocess.run(command, cwd=cwd, timeout=timeout, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Failure("%s failed:\n%s%s" % (" ".join(command), done.stdout, done.stderr))
    return done.stdout


def source_of(module):
    return os.path.join(ROOT, "src", "core", module + ".c")


MODULES = sorted(os.path.splitext(os.path.basename(p))[0] for p in glob.glob(source_of("*")))


def linked(instead=()):
    """The modules of a program, with some files in place of others."""
    left_out = {REPLACED[m] for m in instead} | (set(REPLACED) - set(instead))
    return [m for m in MODULES if m not in left_out]


# Flash


def flash_of(target, path):
    """Bytes of code, constants and initial values in an object or a program."""
    total = 0
    for line in run(target.prefix + "size", "-A", path).splitlines():
        words = line.split()
        if words and re.match(r"\.(text|rodata|srodata|data|sdata|ARM\.ex)", words[0]):
            total += int(words[1])
    return total


def link(target, directory, name, objects):
    """Everything of the objects, and what they call of the compiler's library."""
    out = os.path.join(directory, name + ".elf")
    run(target.prefix + "gcc", *target.flags, "-nostdlib", "-Wl,--no-gc-sections", "-Wl,-e,0",
        "-Wl,--unresolved-symbols=ignore-all", *objects, "-lgcc", "-o", out)
    return out


def compile_modules(target, directory, *flags):
    """The objects of all modules, by name."""
    os.makedirs(directory, exist_ok=True)
    run(target.prefix + "gcc", *target.flags, target.level, *COMMON, *flags, "-c", *map(source_of, MODULES),
        cwd=directory)
    return {m: os.path.join(directory, m + ".o") for m in MODULES}


def link_called(target, directory, name, functions, objects):
    """Functions and all that they call, as firmware is linked. Only what every firmware has may be missing."""
    out = os.path.join(directory, name + ".elf")
    run(target.prefix + "gcc", *target.flags, "-nostdlib", "-Wl,--gc-sections", "-Wl,-e," + functions[0],
        *["-Wl,--defsym=%s=0" % f for f in ("memcpy", "memset", "memcmp")], *["-Wl,-u," + f for f in functions],
        *objects, "-lgcc", "-o", out)
    return out


def compile_core(target, directory):
    objects = compile_modules(target, directory, "-fcallgraph-info=su,da")
    run(target.prefix + "gcc", *target.flags, target.level, *COMMON, "-fno-tree-loop-distribute-patterns",
        "-fcallgraph-info=su,da", "-c", os.path.join(PORT, "memory.c"), cwd=directory)
    return objects


def measure_flash(target, directory, objects):
    figures = {m: flash_of(target, o) for m, o in objects.items()}
    alone = sum(figures[m] for m in linked())
    figures["**the core**"] = flash_of(target, link(target, directory, "core", [objects[m] for m in linked()]))
    figures[HELPERS] = figures["**the core**"] - alone
    sections = compile_modules(target, os.path.join(directory, "sections"), *SECTIONS)
    tables = os.path.join(directory, "tables.o")
    run(target.prefix + "gcc", *target.flags, target.level, *COMMON, "-fdata-sections", "-c", TABLES, "-o", tables)
    for row, functions, instead in PROGRAMS:
        called = link_called(target, directory, "called", functions, [*[sections[m] for m in linked(instead)], tables])
        figures[row] = flash_of(target, called)
    return figures


def refuse_float_and_division(target, directory, objects):
    """On the yardstick, which has neither in hardware, both would be calls."""
    archive = os.path.join(directory, "core.a")
    run(target.prefix + "ar", "rc", archive, *objects.values())
    run(GATE, target.prefix + "nm", archive)


def measure_builds(target, directory):
    """The decode path as a firmware's project builds it, by build types of CMake; and with optimization of it all."""
    build = os.path.join(directory, "build")
    os.makedirs(directory)
    with open(os.path.join(directory, "CMakeLists.txt"), "w", encoding="utf-8") as f:
        f.write("cmake_minimum_required(VERSION 3.22)\nproject(firmware C)\n")
        f.write('add_subdirectory("%s" lumsdk EXCLUDE_FROM_ALL)\n' % ROOT)
    figures = {}
    for kind in BUILD_TYPES:
        run("cmake", "-S", directory, "-B", build, "-DCMAKE_SYSTEM_NAME=Generic", "-DCMAKE_BUILD_TYPE=" + kind,
            "-DCMAKE_TRY_COMPILE_TARGET_TYPE=STATIC_LIBRARY", "-DCMAKE_C_COMPILER=%sgcc" % target.prefix,
            "-DCMAKE_C_FLAGS=" + " ".join([*target.flags, *SECTIONS]))
        run("cmake", "--build", build, "--target", "lum_core", "--parallel", "2")
        archive = os.path.join(build, "lumsdk", "src", "core", "liblum_core.a")
        figures[kind] = flash_of(target, link_called(target, directory, kind, DECODE_PATH, [archive]))
    objects = compile_modules(target, os.path.join(directory, "lto"), "-flto", *SECTIONS)
    called = link_called(target, directory, "lto", DECODE_PATH, [objects[m] for m in linked()])
    figures["none, `-Os -flto`"] = flash_of(target, called)
    return figures


# Stack


def read_graph(directory, modules):
    """Frames in bytes, and calls, of every function that the compiler saw."""
    frames, calls = {}, collections.defaultdict(set)
    for module in modules:
        with open(os.path.join(directory, module + ".ci"), encoding="utf-8") as f:
            text = f.read()
        for title, label in re.findall(r'node: \{ title: "([^"]+)" label: "([^"]*)"', text):
            if re.search(r"bytes \((?!static)|[1-9]\d* dynamic objects", label):
                raise Failure("%s has a stack frame of no fixed size: %s" % (title, label))
            found = re.search(r"(\d+) bytes \(static\)", label)
            if found:
                frames[title] = int(found.group(1))
        for source, target in re.findall(r'edge: \{ sourcename: "([^"]+)" targetname: "([^"]+)"', text):
            calls[source].add(target)
    return frames, calls


def read_helpers(target, program, frames, calls):
    """Adds the functions of libgcc, from their instructions: an upper bound."""
    addresses = collections.defaultdict(list)
    for line in run(target.prefix + "nm", program).splitlines():
        words = line.split()
        if len(words) == 3 and words[1] in "tTwW":
            addresses[int(words[0], 16) & ~1].append(words[2])
    blocks = re.split(r"\n(?=[0-9a-f]+ <[^>]+>:\n)", run(target.prefix + "objdump", "-d", program))
    for block in blocks:
        head = re.match(r"([0-9a-f]+) <", block)
        if not head:
            continue
        bytes_used = 4 * sum(len(expand(r)) for r in re.findall(r"\bpush\S*\s+\{([^}]*)\}", block))
        bytes_used += sum(int(n) for n in re.findall(r"\bsub\s+sp, (?:sp, )?#(\d+)", block))
        bytes_used += sum(int(n) for n in re.findall(r"\baddi\s+sp,sp,-(\d+)", block))
        called = re.findall(r"\b(?:bl?(?:\.[nw])?|jal|j)\s+(?:ra,)?[0-9a-f]+ <([^>+]+)>", block)
        for name in addresses[int(head.group(1), 16)]:
            if name not in frames:
                frames[name] = bytes_used
                calls[name].update(c for c in called if c != name)


def expand(registers):
    """The registers of a push, with ranges such as r4-r7."""
    out = []
    for part in registers.replace(" ", "").split(","):
        ends = re.fullmatch(r"r(\d+)-r(\d+)", part)
        out += range(int(ends.group(1)), int(ends.group(2)) + 1) if ends else [part]
    return out


def deepest(name, frames, calls, known, path):
    """The most bytes of stack below and with a function, and the way there."""
    if name in path:
        raise Failure("recursion: %s" % " -> ".join(path + [name]))
    if name not in known:
        if name == "__indirect_call":
            raise Failure("%s calls by a pointer: no graph shows where to" % path[-1])
        if name not in frames:
            raise Failure("%s: the stack that it needs is not known" % name)
        ways = [deepest(c, frames, calls, known, path + [name]) for c in calls[name]]
        below = max(ways, default=(0, []))
        known[name] = (frames[name] + below[0], [name] + below[1])
    return known[name]


def measure_stack(target, directory, objects):
    """Of each module the public function that needs most, and the worst way."""
    figures, worst = {}, (0, [])
    for instead in ((), tuple(REPLACED)):
        modules = linked(instead)
        frames, calls = read_graph(directory, [*modules, "memory"])
        read_helpers(target, link(target, directory, "core", [objects[m] for m in modules]), frames, calls)
        known = {}
        for module in modules:
            symbols = run(target.prefix + "nm", "--defined-only", "-g", objects[module])
            depths = [deepest(f, frames, calls, known, []) for f in re.findall(r" T (lum_\w+)", symbols)]
            if depths:
                figures[module] = max(figures.get(module, 0), max(depths)[0])
                worst = max(worst, max(depths))
    return {**{m: figures[m] for m in MODULES if m in figures}, "**the core**": worst[0]}, worst[1]


# RAM


def measure_ram(target, directory):
    """Sizes as the compiler has them, of objects that it placed."""
    source = os.path.join(directory, "ram.c")
    with open(source, "w", encoding="utf-8") as f:
        f.write('#include "lum/assembler.h"\n#include "lum/points_fixed.h"\n#include "lum/receiver.h"\n')
        whole = "sizeof(lum_assembler) + %du * sizeof(lum_line_slot) + %du * sizeof(uint32_t)"
        whole += " + LUM_ASSEMBLER_REACH(%du) * sizeof(lum_reach)" % RAM_REACH
        for n in RAM_OPEN:
            for w in RAM_WORDS:
                f.write("char ram_%d_%d[" % (n, w) + whole % (2 * n, 2 * n * w) + "];\n")
        f.write("char ram_receiver[sizeof(lum_receiver) + LUM_RECEIVER_WORDS(%du) * sizeof(uint32_t)];\n" % DATAGRAM)
        for name in ("lum_assembler", "lum_line_slot", "lum_reach", "lum_receiver", "lum_fixed_projector", "lum_layout"):
            f.write("char size_of_%s[sizeof(%s)];\n" % (name, name))
    run(target.prefix + "gcc", *target.flags, *COMMON, "-c", source, "-o", os.path.join(directory, "ram.o"))
    symbols = run(target.prefix + "nm", "-S", os.path.join(directory, "ram.o"))
    return {name: int(size, 16) for size, name in re.findall(r"([0-9a-f]+) [BDC] (\w+)", symbols)}


# Instructions


def run_counted(target, directory, name, instead=()):
    """What a program says that counts on the emulated board."""
    os.makedirs(directory, exist_ok=True)
    program = os.path.join(directory, name + ".elf")
    port = [os.path.join(PORT, f + ".c") for f in ("startup_cortex_m", "board", "port_semihosting", "memory", "text")]
    run(target.prefix + "gcc", *target.flags, target.level, *COMMON, "-fno-tree-loop-distribute-patterns",
        "-I" + os.path.dirname(PORT), "-nostdlib", "-L" + PORT, "-T", "mps2.ld",
        *[os.path.join(HERE, f + ".c") for f in (name, "count")], *map(source_of, linked(instead)), *port, "-lgcc",
        "-o", program)
    return run("qemu-system-arm", "-machine", "mps2-an386", "-nographic", "-monitor", "none", "-serial", "none",
               "-icount", "shift=5", "-semihosting-config", "enable=on,target=native,arg=" + name, "-kernel", program,
               timeout=600)


def instructions(output):
    """Instructions for each unit that was counted, by name."""
    sums = {n: (int(t), int(r), int(u)) for n, t, r, u in re.findall(r"^(\w+) (\d+) (\d+) (\d+)$", output, re.M)}
    reading = sums["nothing"][0] / sums["nothing"][1]
    ticks, readings, loop = sums["loop"]
    tick = loop / (ticks - readings * reading)  # instructions
    return {n: (t - r * reading) * tick / u for n, (t, r, u) in sums.items() if n not in ("nothing", "loop")}


def measure_instructions(target, directory):
    fixed = instructions(run_counted(target, directory, "measure", ["layout_fixed"]))
    figures = {"fixed_" + name: value for name, value in fixed.items()}
    for name in ("measure", "worst"):
        figures.update(instructions(run_counted(target, directory, name)))
    return figures


def instructions_of_line(costs, words, projected):
    """Of a line of 1000 angles and so many words, one or more of each pixel."""
    kind = "singles" if words <= 1000 else "pulses"
    total = costs["line"] + (1000 - FIRST_ANGLES) * costs["angles"] + words * costs[kind]
    return total + (words * costs["points_" + kind] if projected else 0)


# Tables


class Table:
    """Figures under a heading. is_better_higher: growth is no fault."""

    def __init__(self, heading, corner, columns, decimals=0, is_better_higher=False):
        self.heading, self.corner, self.columns = heading, corner, columns
        self.decimals, self.is_better_higher = decimals, is_better_higher
        self.rows = collections.OrderedDict()

    def put(self, row, column, value):
        self.rows.setdefault(row, {})[column] = value

    def render(self):
        lines = ["### " + self.heading, "", "| %s | %s |" % (self.corner, " | ".join(self.columns)),
                 "|---|" + "---:|" * len(self.columns)]
        for row, cells in self.rows.items():
            texts = [f"{cells[c]:,.{self.decimals}f}" if c in cells else "" for c in self.columns]
            lines.append("| %s | %s |" % (row, " | ".join(texts)))
        return "\n".join(lines) + "\n"


def parse(text):
    """Figures of tables as render() writes them, by heading, row and column."""
    figures, heading, columns = {}, "", None
    for line in text.splitlines():
        if line.startswith("### "):
            heading, columns = line[4:], None
        cells = [c.strip() for c in line.strip("|").split("|")] if line.startswith("|") else None
        if cells and columns is None:
            columns = cells[1:]
        elif cells and not cells[0].startswith("---"):
            for column, cell in zip(columns, cells[1:]):
                if cell:
                    figures[heading, cells[0], column] = float(cell.replace(",", ""))
    return figures


WORST_ROWS = [("**worst push** " + row + profile, name + kind)
              for row, kind in (("that a search finds", ""), ("that is dropped", "_dropped"),
                                ("by a receiver", "_received"))
              for profile, name in (("", "worst"), (", wide profile", "wide"))]
COST_ROWS = [
    ("a range word in order, one of a pixel", "singles"),
    ("a range word in order, two of a pixel", "pulses"),
    ("a range word of a packet that comes before its time", "reordered"),
    ("an angle in order", "angles"),
    ("a packet of a single word", "packet"),
    ("a packet of a single word, fixed layout", "fixed_packet"),
    ("a line: opening it and handing it out", "line_alone"),
    ("a push that closes a line without angles", "closing"),
    ("by a receiver: a range word in order", "received"),
    ("by a receiver: an angle in order, and its line", "received_angles"),
    ("a word's return number, count and pulse width", "returns"),
    ("a projected point, one of a pixel", "points_singles"),
    ("a projected point, two of a pixel", "points_pulses"),
    ("a projected point, one of a pixel far aside", "points_aside"),
    *WORST_ROWS,
]


def measure(build):
    """All tables, and the way of the deepest stack on the yardstick."""
    names = [t.name for t in TARGETS]
    measured = [t.name for t in MEASURED]
    flash = Table("Flash, bytes", "module", names)
    builds = Table("Flash of the decode path, bytes", "build type of CMake", [t.name.split()[0] for t in BUILT])
    stack = Table("Stack, bytes", "deepest of the module's functions", names)
    ram = Table("RAM, bytes", "words of a line", ["%d open line%s an eye" % (n, "s" if n > 1 else "") for n in RAM_OPEN])
    costs = Table("Instructions, each", "of", measured, decimals=1)
    rates = Table("Lines a second at 100 MHz", "words of a line",
                  [n + w for w in (", assembled", ", projected too") for n in measured], is_better_higher=True)
    way, sizes = [], {}
    for target in TARGETS:
        directory = os.path.join(build, target.name.replace(" ", ""))
        objects = compile_core(target, directory)
        if target is YARDSTICK:
            refuse_float_and_division(target, directory, objects)
        for row, value in measure_flash(target, directory, objects).items():
            flash.put(row, target.name, value)
        figures, deepest_way = measure_stack(target, directory, objects)
        for row, value in figures.items():
            stack.put(row, target.name, value)
        way = way or deepest_way
        here = measure_ram(target, directory)
        if sizes and here != sizes:
            raise Failure("RAM on %s differs from that on %s" % (target.name, TARGETS[0].name))
        sizes = here
        if target in BUILT:
            for row, value in measure_builds(target, os.path.join(directory, "builds")).items():
                builds.put(row, target.name.split()[0], value)
        if target in MEASURED:
            put_costs(costs, rates, target, measure_instructions(target, directory))
    for words in RAM_WORDS:
        for n, column in zip(RAM_OPEN, ram.columns):
            ram.put(f"{words:,}", column, sizes["ram_%d_%d" % (n, words)])
    ram.put(SMALLEST, ram.columns[0], sizes["ram_1_1000"] + DATAGRAM)
    ram.put(NO_LINES, ram.columns[0], sizes["ram_receiver"] + DATAGRAM)
    return [flash, builds, stack, ram, costs, rates], way, sizes


def put_costs(costs, rates, target, figures):
    figures["line_alone"] = figures["line"] - FIRST_ANGLES * figures["angles"]
    for row, name in COST_ROWS:
        costs.put(row, target.name, round(figures[name], 1))
    for words in LINE_WORDS:
        for ending, projected in ((", assembled", False), (", projected too", True)):
            rates.put(f"{words:,}", target.name + ending, CLOCK_HZ // instructions_of_line(figures, words, projected))


# What a figure may not pass, whatever stands in the table.
BARS = [
    *[("Flash, bytes", row, YARDSTICK.name, bar)
      for row, bar in ((DECODE_ROW, 5400), (FIXED_ROW, 4200), (NO_FRAMES_ROW, 3600), (RECEIVER_ROW, 2880),
                       (FIXED_RECEIVER_ROW, 2520), ("**the core**", 9640))],
    *[("Stack, bytes", "**the core**", t.name, 160) for t in TARGETS],
    ("RAM, bytes", SMALLEST, "1 open line an eye", 20480),
    *[("Instructions, each", COST_ROWS[i][0], "M4F -O2", 10.5) for i in (0, 1)],
    *[("Instructions, each", COST_ROWS[i][0], YARDSTICK.name, 30) for i in (0, 1)],
    ("Instructions, each", "a projected point, one of a pixel", "M4F -O2", 125),
    ("Instructions, each", "a projected point, two of a pixel", "M4F -O2", 125),
    ("Instructions, each", "a projected point, one of a pixel", YARDSTICK.name, 1000),
    ("Instructions, each", "a packet of a single word", YARDSTICK.name, 1000),
    ("Instructions, each", "a packet of a single word, fixed layout", YARDSTICK.name, 700),
    *[("Instructions, each", "**worst push** " + row, target, bar)
      for row, large, small in (("that a search finds", 90000, 170000), ("that is dropped", 35000, 57000),
                                ("by a receiver", 16200, 31500), ("by a receiver, wide profile", 16200, 33000))
      for target, bar in (("M4F -O2", large), (YARDSTICK.name, small))],
]


def over_bars(figures):
    faults = []
    for *where, bar in BARS:
        value = figures[tuple(where)]
        if value > bar:
            name = ", ".join(where).replace("*", "")
            faults.append("%s: %s is over the bar of %s" % (name, number(value), number(bar)))
    return faults


def grown(tables, old, new):
    """Figures that are worse than the table by more than is allowed."""
    faults = []
    better_higher = {t.heading for t in tables if t.is_better_higher}
    for key, value in new.items():
        if key[1] == HELPERS:
            continue
        if key not in old:
            faults.append("%s, %s, %s: not in the table" % key)
        elif key[0] in better_higher and value < old[key] * (1 - ALLOWED_GROWTH):
            faults.append("%s, %s, %s: %s, fell from %s" % (*key, number(value), number(old[key])))
        elif key[0] not in better_higher and value > old[key] * (1 + ALLOWED_GROWTH):
            faults.append("%s, %s, %s: %s, grew from %s" % (*key, number(value), number(old[key])))
    return faults + ["%s, %s, %s: gone, but in the table" % key for key in old if key not in new]


def number(value):
    return f"{value:,.0f}" if value == int(value) else f"{value:,.1f}"


def toolchain():
    versions = [run(p + "gcc", "--version").splitlines()[0] for p in (ARM, RISCV)]
    return "; ".join(versions + [run("qemu-system-arm", "--version").splitlines()[0]])


def render(tables, way, sizes, tools):
    notes = ["Made with: %s." % tools, "",
             "The deepest stack on %s: %s." % (YARDSTICK.name, ", ".join("`%s`" % w.split("/")[-1] for w in way)), "",
             "Of the RAM: " + "; ".join("`%s` %s" % (n[len("size_of_"):], f"{v:,}")
                                        for n, v in sizes.items() if n.startswith("size_of_")) + ".", ""]
    return "\n".join(notes + [t.render() for t in tables])


def split_document(path):
    with open(path, encoding="utf-8") as f:
        text = f.read()
    head, found, rest = text.partition(BEGIN)
    body, closed, tail = rest.partition(END)
    if not found or not closed:
        raise Failure("%s lacks the markers of its tables:\n%s\n%s" % (path, BEGIN, END))
    return head, body, tail


def check(tables, body, new, tools):
    if tools not in body:
        print("note: the table was made with other tools than these: %s" % tools)
    faults = over_bars(new) + grown(tables, parse(body), new)
    for fault in faults:
        print("size: " + fault, file=sys.stderr)
    if faults:
        print("too large: %d of %d figures; script/size --update writes the tables anew" % (len(faults), len(new)))
        return 1
    print("%d figures: none has grown, none is over its bar" % len(new))
    return 0


def show_worst(build, name):
    target = next((t for t in MEASURED if t.name == name), None)
    if target is None:
        raise Failure("no target %s: one of %s" % (name, ", ".join(t.name for t in MEASURED)))
    output = run_counted(target, build, "worst")
    print(re.sub(r"^\w+ \d+ \d+ \d+\n", "", output, flags=re.M), end="")
    for kind, value in instructions(output).items():
        print(f"{kind:16} {value:10,.0f}")
    return 0


def main(arguments):
    build, path = arguments[:2]
    if path == "--worst":
        return show_worst(build, arguments[2])
    shutil.rmtree(build, ignore_errors=True)
    os.makedirs(build)
    head, body, tail = split_document(path)
    tables, way, sizes = measure(build)
    tools = toolchain()
    text = render(tables, way, sizes, tools)
    print(text)
    new = parse(text)
    if "--update" not in arguments[2:]:
        return check(tables, body, new, tools)
    with open(path, "w", encoding="utf-8") as f:
        f.write(head + BEGIN + "\n" + text + END + tail)
    faults = over_bars(new)
    for fault in faults:
        print("size: " + fault, file=sys.stderr)
    print("%s is written; over their bars: %d" % (path, len(faults)))
    return 1 if faults else 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except Failure as failure:
        print("size: %s" % failure, file=sys.stderr)
        sys.exit(1)
