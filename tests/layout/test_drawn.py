#!/usr/bin/env python3
"""test_drawn.py [CC [COUNT]]: what lumtable --layout writes for drawn profiles reads as layout_any.c does, bit for bit, here and
on a Cortex-M0+, and compiles without a warning. LUM_BIN is where lumtable is."""
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
HERE = ROOT / "tests" / "layout"
PORT = ROOT / "examples" / "firmware" / "port"
LUMTABLE = pathlib.Path(os.environ.get("LUM_BIN", ROOT / "build" / "release" / "bin")) / "lumtable"
CC = sys.argv.pop(1) if len(sys.argv) > 1 else "cc"
COUNT = int(sys.argv.pop(1)) if len(sys.argv) > 1 else 20
CORE = [ROOT / "src" / "core" / f"{name}.c" for name in ("clock", "group", "layout_any", "product", "wire")]
FLAGS = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wshadow", "-Wtype-limits", "-Wstrict-prototypes",
         "-Wmissing-prototypes", "-Wundef", "-Wcast-qual", "-Werror", f"-I{ROOT}/include", f"-I{ROOT}/src", "-iquote", f"{ROOT}/src/core",
         f"-I{PORT.parent}"]
M0PLUS = ["-mcpu=cortex-m0plus", "-mthumb", "-Os", "-ffreestanding", "-fno-tree-loop-distribute-patterns", "-isystem",
          f"{PORT}/freestanding"]
PATIENCE_S = 1200

# Of layout.h, without lum_ before them.
FUNCTIONS = ("clock_follow", "clock_init", "group_decode", "group_word", "layout_copy_angles", "layout_is_read")

# As lum_group_field has them, and the fewest bits with which packets can be good.
FIELDS = {"tag": 2, "eye": 1, "line": 1, "num_samples": 1, "first_sample_index": 1, "timestamp": 1}
UNITS_NS = (1000, 1000, 1000, 1, 10, 100, 125, 250, 500, 999, 2000, 10_000, 1_000_000, 1_000_000_000)


class Field:
    def __init__(self, at, width, order, low=0, bits=0):
        self.at, self.width, self.order, self.low, self.bits = at, width, order, low, bits

    def size(self):
        return self.bits or 8 * self.width

    def yaml(self):
        bits = f", bits: [{self.low}, {self.low + self.bits - 1}]" if self.bits else ""
        return f"at: {self.at}, bytes: {self.width}, order: {self.order}{bits}"

    def c(self):
        return f"{{{self.at}, {self.width}, LUM_ORDER_{self.order.upper()}, {self.low}, {self.bits}}}"


class Profile:
    """A valid one."""

    def __init__(self, seed):
        self.random = random.Random(seed)
        self.samples = 65
        while self.samples > 64:
            self._place()
        top = 2 ** min(32, self.fields["eye"].size()) - 1
        self.eyes = self._eyes(top)
        self.angle_order = self.random.choice(("azimuth_elevation", "elevation_azimuth"))
        self.sample_order = self.random.choice(("little", "big"))
        self.unit_ns = 1000
        if "timestamp" in self.fields:
            self.unit_ns = self.random.choice((*UNITS_NS, self.random.randint(1, 10**9), 1000 * self.random.randint(1, 10**6)))

    def _eyes(self, top):
        """Two that follow each other, or any two."""
        low = min(self.random.choice((0, 1, top - 1, self.random.randrange(top))), top - 1)
        pair = [low, self.random.choice((low + 1, top, self.random.randint(low + 1, top)))]
        self.random.shuffle(pair)
        return pair

    def _cut(self, names, width):
        """Ranges of bits for fields that share so many bytes; None: there is no room."""
        cuts = sorted(self.random.sample(range(8 * width + 1), 2 * len(names))) if len(names) <= 4 * width else []
        ranges = dict(zip(names, zip(cuts[::2], cuts[1::2])))
        fit = len(ranges) == len(names) and all(high - low >= FIELDS[name] for name, (low, high) in ranges.items())
        return ranges if fit else None

    def _word(self, at, names):
        """Fields in the same bytes, which are added."""
        order = self.random.choice(("little", "big"))
        width = self.random.choice((1, 2, 4, 8))
        if len(names) == 1 and self.random.random() < 0.6:
            self.fields[names[0]] = Field(at, width, order, 0, self.random.choice((0, 0, 8 * width)))
            return width
        ranges = None
        while ranges is None:
            width = self.random.choice((1, 2, 4, 8))
            ranges = self._cut(names, width)
        for name, (low, high) in ranges.items():
            self.fields[name] = Field(at, width, order, low, high - low)
        return width

    def _type(self):
        """The tag in place of the packet type: its lowest bits."""
        width = self.random.choice((1, 2, 4, 8))
        bits = self.random.choice((0, self.random.randint(2, 8 * width)))
        self.fields["tag"] = Field(8, width, "little", 0, bits)
        return width

    def _place(self):
        left_out = {name for name, chance in (("num_samples", 0.15), ("timestamp", 0.1)) if self.random.random() < chance}
        names = [name for name in FIELDS if name not in left_out]
        self.random.shuffle(names)
        words = []
        for name in names:
            if words and self.random.random() < 0.4:
                self.random.choice(words).append(name)
            else:
                words.append([name])
        self.fields = {}
        at = 12
        for word in words:
            if word == ["tag"] and at == 12 and self.random.random() < 0.5:
                at = max(at, 8 + self._type())
            else:
                at += self.random.choice((0, 0, 1, 3))
                at += self._word(at, word)
        self.samples = at + self.random.choice((0, 0, 1, 5))

    def yaml(self):
        group = [f"  {name}: {{{self.fields[name].yaml()}{f', unit_ns: {self.unit_ns}' if name == 'timestamp' else ''}}}"
                 if name in self.fields else f"  {name}: none" for name in FIELDS]
        return "\n".join(("version: 1", "group:", *group, f"  samples: {self.samples}",
                          f"eye_values: {{blue: {self.eyes[0]}, green: {self.eyes[1]}}}", f"angle_order: {self.angle_order}",
                          f"sample_order: {self.sample_order}", ""))

    def c(self):
        fields = ", ".join(self.fields[name].c() if name in self.fields else "{0, 0, 0, 0, 0}" for name in FIELDS)
        return (f"{{{{8, {{{fields}}}, {self.samples}, 0, LUM_{self.angle_order.upper()}, LUM_ORDER_{self.sample_order.upper()}, "
                f"{{{self.eyes[0]}u, {self.eyes[1]}u}}, {{1, 2, 3, 4}}, 0, 2000, {self.unit_ns}u}}}}")


def run(*command, **options):
    """Its output."""
    r = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=PATIENCE_S,
                       check=False, **options)
    if r.returncode != 0:
        raise AssertionError(f"{command[0]}: {r.returncode}\n{r.stdout[-4000:]}")
    return r.stdout


class Drawn(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(cls.enterClassContext(tempfile.TemporaryDirectory()))
        profiles = [Profile(seed) for seed in range(COUNT)]
        for n, profile in enumerate(profiles):
            run(LUMTABLE, "--layout", "--profile", "-", "-o", cls.folder / f"layout_{n}.c", input=profile.yaml())
            names = [f"#define lum_{name} layout_{n}_{name}" for name in FUNCTIONS]
            (cls.folder / f"named_{n}.c").write_text("\n".join((*names, f'#include "layout_{n}.c"', "")))
        lines = ["static const lum_layout layouts[] = {", *(f"    {profile.c()}," for profile in profiles), "};",
                 *(f"DECLARE(layout_{n}_);" for n in range(len(profiles))), "const struct code codes[] = {",
                 *(f"    CODE(layout_{n}_, &layouts[{n}])," for n in range(len(profiles))), "};",
                 "const size_t code_count = sizeof codes / sizeof codes[0];"]
        (cls.folder / "codes.c").write_text(f'#include "{HERE}/compare.h"\n' + "\n".join(lines) + "\n")

    def build(self, compiler, *flags):
        """The layouts under names of their own and the list of them, as objects."""
        objects = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        run(compiler, *FLAGS, *flags, "-c", *sorted(self.folder.glob("named_*.c")), self.folder / "codes.c", cwd=objects)
        return sorted(objects.glob("*.o"))

    def check(self, output, datagrams):
        self.assertEqual(output.splitlines()[-1], f"{COUNT} of {COUNT} layouts agree on {datagrams} datagrams each")

    def test_here(self):
        program = self.folder / "compare"
        run(CC, *FLAGS, "-O1", *self.build(CC, "-O1"), HERE / "compare.c", *CORE, PORT / "port_host.c", PORT / "text.c", "-o", program)
        self.check(run(program, 2000), 2000)

    @unittest.skipUnless(shutil.which("arm-none-eabi-gcc") and shutil.which("qemu-system-arm"), "no compiler for Cortex-M, or no qemu-system-arm")
    def test_on_a_cortex_m0plus(self):
        program = self.folder / "compare.elf"
        port = [PORT / f"{name}.c" for name in ("startup_cortex_m", "board", "port_semihosting", "memory", "text")]
        run("arm-none-eabi-gcc", *FLAGS, *M0PLUS, "-nostdlib", f"-L{PORT}", "-T", "mps2.ld", *self.build("arm-none-eabi-gcc", *M0PLUS),
            HERE / "compare.c", *CORE, *port, "-lgcc", "-o", program)
        self.check(run("qemu-system-arm", "-M", "mps2-an385", "-display", "none", "-monitor", "none", "-serial", "none",
                       "-semihosting-config", "enable=on,target=native,arg=compare,arg=200", "-kernel", program), 200)

    @unittest.skipUnless(shutil.which("clang"), "no clang")
    def test_clang_has_no_warning(self):
        run("clang", *FLAGS, "-Wunreachable-code", "-Wimplicit-int-conversion", "-fsyntax-only",
            *sorted(self.folder.glob("named_*.c"))[:100])

    def test_the_cmake_of_the_firmware_reference(self):
        """Its file in place of layout_any.c."""
        program = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        (program / "lumsdk").symlink_to(ROOT)
        shutil.copy(self.folder / "layout_0.c", program / "layout_mine.c")
        page = (ROOT / "docs" / "firmware-reference.md").read_text().split("```cmake\n")[1].split("```")[0]
        (program / "CMakeLists.txt").write_text(f"cmake_minimum_required(VERSION 3.22)\nproject(mine C)\n{page}")
        run("cmake", "-S", program, "-B", program / "build", f"-DCMAKE_C_COMPILER={CC}")
        run("cmake", "--build", program / "build", "--target", "lum_core")
        names = {path.name for path in program.rglob("layout*.o")}
        self.assertEqual(names, {"layout_mine.c.o"})

    def test_lines_fit_a_page(self):
        for path in self.folder.glob("layout_*.c"):
            self.assertLessEqual(max(map(len, path.read_text().splitlines())), 80, path.name)


if __name__ == "__main__":
    unittest.main()
