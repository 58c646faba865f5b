#!/usr/bin/env python3
"""check.py DIST BIN PLATFORM...: the sdist and the wheels in DIST, against the programs of this machine in BIN. The last
line counts: N passed, N failed, N skipped."""
from __future__ import annotations

import email
import functools
import gzip
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import venv
import zipfile

TOP = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = ("lumctl", "lumdump", "lumsim")
LARGEST = 2_000_000
ROOM = 20_000  # to grow, so that the limit is no surprise
SIMULATE = ("--frames", "2", "--lines", "64", "--seed", "5", "--loss", "0.01")
QEMU = ("qemu-aarch64-static", "-L", "/usr/aarch64-linux-gnu")
MUSL = pathlib.Path("/lib/ld-musl-x86_64.so.1")
WINE = shutil.which("wine64") or "/usr/lib/wine/wine64"

# What a wheel may need of its system.
LINUX = {"libc.so.6", "libm.so.6", "libpthread.so.0", "libdl.so.2", "librt.so.1"}
NEEDS = {
    "manylinux_x86_64": LINUX,
    "manylinux_aarch64": LINUX | {"ld-linux-aarch64.so.1"},
    "musllinux_x86_64": {"libc.so"},
    "macos_arm64": {"/usr/lib/libSystem.B.dylib"},
    "macos_x86_64": {"/usr/lib/libSystem.B.dylib"},
    "windows_x86_64": {"kernel32.dll", "ws2_32.dll", "iphlpapi.dll", "advapi32.dll"},
}


class Skipped(Exception):
    """This machine cannot run it."""


def run(*command, **options):
    made = subprocess.run([*map(str, command)], capture_output=True, text=True, timeout=240, check=False, **options)
    if made.returncode != 0:
        raise AssertionError(f"{' '.join(map(str, command))} ended with {made.returncode}:\n{made.stdout}{made.stderr}")
    return made.stdout


def same(found, wanted, what):
    if found != wanted:
        raise AssertionError(f"{what}: {found!r}, expected {wanted!r}")


def public_functions():
    """What the public headers declare, of the rooms in liblumsdk."""
    text = (TOP / "cmake/shared.cmake").read_text()
    rooms = re.search(r"set\(lum_shared_rooms ([^)]*)\)", text)[1].split()
    lines = [line.split() for room in rooms for line in (TOP / f"tests/abi/{room}.symbols").read_text().splitlines()]
    return {line[0] for line in lines if line[-1] == "public"}


def package_sources():
    folder = TOP / "tools/python"
    files = (path for path in folder.glob("lumsdk/**/*") if path.suffix == ".py" or path.name == "py.typed")
    return {path.relative_to(folder).as_posix() for path in files}


class Wheel:
    """A wheel, unpacked, and what is in it."""

    def __init__(self, path, platform, folder):
        self.path, self.platform, self.folder = path, platform, folder
        with zipfile.ZipFile(path) as archive:
            self.names = {name for name in archive.namelist() if not name.endswith("/")}
            archive.extractall(folder)
        self.is_windows = platform.startswith("windows")
        self.suffix = ".exe" if self.is_windows else ""
        end = {"macos": ".dylib", "windows": ".dll"}.get(platform.split("_")[0], ".so")
        self.library = folder / f"lumsdk/liblumsdk{end}"
        self.data = path.name.split("-py3")[0] + ".data"
        self.about = path.name.split("-py3")[0] + ".dist-info"
        self.scripts = folder / self.data / "scripts"
        for name in PROGRAMS:
            self.program(name).chmod(0o755)

    def program(self, name):
        return self.scripts / f"{name}{self.suffix}"

    def binaries(self):
        return [self.library, *(self.program(name) for name in PROGRAMS)]

    def runner(self):
        """What runs a program of this platform here."""
        if self.platform == "manylinux_x86_64":
            return ()
        if self.platform == "manylinux_aarch64":
            if not shutil.which(QEMU[0]) or not pathlib.Path(QEMU[2]).exists():
                raise Skipped("there is no qemu-aarch64-static with a C library (Debian: qemu-user-static libc6-dev-arm64-cross)")
            return QEMU
        if self.platform == "musllinux_x86_64":
            if not MUSL.exists():
                raise Skipped("there is no musl (Debian: musl)")
            return ()
        if not pathlib.Path(WINE).exists():
            raise Skipped("there is no wine64 (Debian: wine64)")
        return (WINE,)

    def call(self, program, *arguments):
        environment = {**os.environ, "WINEDEBUG": "-all", "WINEPREFIX": str(TOP / "build/wine")}
        return run(*self.runner(), program, *arguments, cwd=self.folder, env=environment)


@functools.cache
def native_capture(folder, bin_folder):
    path = folder / "native.pcap"
    run(bin_folder / "lumsim", "-q", "-o", path, *SIMULATE)
    return path


# Facts of files.

def holds_the_package_its_library_and_programs_and_nothing_else(w):
    wanted = package_sources() | {"lumsdk/_declarations.py", f"lumsdk/{w.library.name}"}
    wanted |= {"lumsdk/lumview.html"} if (TOP / "build/release/lumview.html").exists() else set()
    wanted |= {f"{w.data}/scripts/{name}{w.suffix}" for name in PROGRAMS}
    wanted |= {f"{w.about}/{name}" for name in ("METADATA", "WHEEL", "RECORD", "licenses/LICENSE", "licenses/third-party.txt")}
    wanted |= {f"{w.about}/entry_points.txt"} if "[project.scripts]" in (TOP / "pyproject.toml").read_text() else set()
    same(sorted(w.names ^ wanted), [], "too many, or missing")


def has_yaml_and_what_unpacks_within(w):
    has = (TOP / "build/wheels" / w.platform / "build/summary.txt").read_text().splitlines()
    for part in ("config", "captures compressed by gzip", "captures compressed by zstd", "lumctl", "lumdump", "lumsim"):
        same(f"{part}: yes" in has, True, f"{part} is in the build")
    told = (w.folder / w.about / "licenses/third-party.txt").read_text()
    for name in ("libyaml", "zlib", "Zstandard"):
        same(f"\n{name}\n=" in told, True, f"{name} is among the licences")


def names_its_platform_and_the_version_of_the_headers(w):
    about = email.message_from_string((w.folder / w.about / "WHEEL").read_text())
    tags = {tag.split("-")[-1] for tag in about.get_all("Tag")}
    same(about["Root-Is-Purelib"], "false", "Root-Is-Purelib")
    same(set(w.path.stem.split("-")[-1].split(".")), tags, "tags of the file's name")
    header = (TOP / "include/lum/version.h").read_text()
    version = ".".join(re.search(rf"LUM_VERSION_{part}\s+(\d+)", header)[1] for part in ("MAJOR", "MINOR", "PATCH"))
    metadata = email.message_from_string((w.folder / w.about / "METADATA").read_text())
    same((metadata["Version"], w.path.name.split("-")[1]), (version, version), "version")


def is_smaller_than_2_mb_with_room_to_grow(w):
    if w.path.stat().st_size >= LARGEST - ROOM:
        raise AssertionError(f"it has {w.path.stat().st_size:,} bytes")


def exported(w):
    if w.is_windows:
        return set(re.findall(r"^\s*Name: (\w+)$", run("llvm-readobj", "--coff-exports", w.library), re.MULTILINE))
    if w.platform.startswith("macos"):
        text = run("llvm-objdump", "--macho", "--exports-trie", w.library)
        # zig's linker exports two names of its own with any library.
        return set(re.findall(r"^0x[0-9A-F]+\s+_(\w+)", text, re.MULTILINE)) - {"__dso_handle", "_mh_dylib_header"}
    names = [line.split()[0] for line in run("llvm-nm", "-D", "--defined-only", "--format=posix", w.library).splitlines()]
    return {name.partition("@")[0] for name in names} - {"LUMSDK_0.1"}


def exports_what_the_public_headers_declare_and_nothing_else(w):
    same(sorted(exported(w) ^ public_functions()), [], "too many, or missing")


def needed(w, path):
    if w.platform.startswith("macos"):
        lines = run("llvm-objdump", "--macho", "--dylibs-used", path).splitlines()[1:]
        return {line.split()[0] for line in lines} - {"@rpath/liblumsdk.dylib"}
    text = run("llvm-readobj", "--needed-libs", path)
    return set(re.search(r"NeededLibraries \[(.*?)\]", text, re.DOTALL)[1].split())


def needs_libraries_of_the_system_alone(w):
    for path in w.binaries():
        found = needed(w, path)
        if w.is_windows:
            found = {name.lower() for name in found if not name.startswith("api-ms-win-crt-")}
        same(sorted(found - NEEDS[w.platform]), [], f"{path.name} needs")


def runs_on_the_oldest_system_of_its_tag(w):
    for path in w.binaries():
        if w.platform.startswith("manylinux"):
            versions = re.findall(r"GLIBC_([0-9.]+)", run("llvm-readobj", "--version-info", path))
            newest = max(tuple(map(int, version.split("."))) for version in versions)
            if newest > (2, 17):
                raise AssertionError(f"{path.name} needs GLIBC_{'.'.join(map(str, newest))}, and the tag promises 2.17")
        elif w.platform.startswith("macos"):
            text = run("llvm-objdump", "--macho", "--private-headers", path)
            same(re.search(r"(?:minos|LC_VERSION_MIN_MACOSX[^$]*?version) ([0-9.]+)", text)[1], "11.0", f"{path.name}, oldest macOS")
        elif w.is_windows:
            text = run("llvm-readobj", "--file-headers", path)
            major = int(re.search(r"MajorSubsystemVersion: (\d+)", text)[1])
            if major > 10:
                raise AssertionError(f"{path.name} needs Windows {major}")


def has_no_folder_of_its_builder_no_symbols_and_no_stack_that_runs(w):
    for path in w.binaries():
        for folder in {str(TOP), os.path.realpath(TOP / "build/venv"), str(pathlib.Path.home() / ".cache")}:
            if folder.encode() in path.read_bytes():
                raise AssertionError(f"{path.name} names {folder}")
        if "linux" in w.platform:
            headers = run("llvm-readobj", "--program-headers", "--dynamic-table", "--section-headers", path)
            for word in ("RPATH", "RUNPATH", "Name: .symtab", "Name: .debug_info"):
                if word in headers:
                    raise AssertionError(f"{path.name} has {word}")
            stack = re.search(r"Type: PT_GNU_STACK.*?Flags \[(.*?)\]", headers, re.DOTALL)
            if stack is None or "PF_X" in stack[1]:
                raise AssertionError(f"{path.name} has a stack that runs")
        elif w.platform == "macos_arm64" and "LC_CODE_SIGNATURE" not in run("llvm-objdump", "--macho", "--private-headers", path):
            raise AssertionError(f"{path.name} is not signed, and macOS would not run it")


def is_what_auditwheel_and_twine_take(w):
    run(sys.executable, "-m", "twine", "check", "--strict", w.path)
    if w.platform.startswith("manylinux"):
        text = " ".join(run(sys.executable, "-m", "auditwheel", "show", w.path).split())
        tag = w.path.stem.split("-")[-1].split(".")
        consistent = re.search(r'following platform tag: "(\w+)"', text)[1]
        if consistent not in tag:
            raise AssertionError(f"auditwheel says {consistent}, and the wheel {tag}")


# Facts of programs.

def simulates_and_converts_as_the_programs_of_this_machine_do(w, bin_folder):
    ours = native_capture(w.folder.parent, bin_folder)
    w.call(w.program("lumsim"), "-q", "-o", "made.pcap", *SIMULATE)
    same((w.folder / "made.pcap").read_bytes() == ours.read_bytes(), True, "the capture is that of this machine")
    shutil.copy(TOP / "calib/typical.yaml", w.folder / "typical.yaml")
    (w.folder / "made.pcap.gz").write_bytes(gzip.compress(ours.read_bytes(), 1))
    run("zstd", "-q", "-f", ours, "-o", w.folder / "made.pcap.zst")
    options = ("-q", "--calibration", "typical.yaml", "--edge", "both", "--columns", "x,y,z,range,pixel")
    run(bin_folder / "lumdump", ours, *options, "-o", w.folder / "wanted.ply", cwd=w.folder)
    for name in ("made.pcap", "made.pcap.gz", "made.pcap.zst"):
        w.call(w.program("lumdump"), name, *options, "-o", "cloud.ply")
        same(without_comments(w.folder / "cloud.ply"), without_comments(w.folder / "wanted.ply"), f"points of {name}")
        (w.folder / "cloud.ply").unlink()
    same(w.call(w.program("lumctl"), "--version").split()[0], "lumctl", "lumctl --version")


def without_comments(path):
    """A file of points, but for the lines that tell of its making."""
    head, end, rest = path.read_bytes().partition(b"end_header")
    return [line.rstrip() for line in head.splitlines() if not line.startswith(b"comment")], end, rest


def has_a_library_that_a_program_loads(w, bin_folder):
    ours = native_capture(w.folder.parent, bin_folder)
    program = w.folder / f"load{w.suffix}"
    root = TOP / "build/wheels" / w.platform
    w.runner()
    extra = {"musllinux_x86_64": ["-dynamic"], "windows_x86_64": []}.get(w.platform, ["-ldl"])
    run(root / "cc", "-std=gnu99", "-O1", "-I", TOP / "include", TOP / "tests/wheels/load.c", "-o", program, *extra)
    run(bin_folder / "lumdump", ours, "-q", "-o", w.folder / "count.csv")
    points = sum(1 for _ in (w.folder / "count.csv").open()) - 1
    same(w.call(program, w.library.relative_to(w.folder), ours).strip(), f"2 frames, {points} points", "what it read")


def serves_a_fresh_python_as_the_readme_says(w, _):
    folder = w.folder / "python"
    venv.create(folder, with_pip=True)
    run(folder / "bin/pip", "install", "-q", "--disable-pip-version-check", w.path)
    environment = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "LUM_BIN")}
    run(folder / "bin/python", "-I", TOP / "tests/python/readme_loop.py", cwd=w.folder, env=environment)


FACTS = (holds_the_package_its_library_and_programs_and_nothing_else, has_yaml_and_what_unpacks_within,
         names_its_platform_and_the_version_of_the_headers,
         is_smaller_than_2_mb_with_room_to_grow, exports_what_the_public_headers_declare_and_nothing_else, needs_libraries_of_the_system_alone,
         runs_on_the_oldest_system_of_its_tag, has_no_folder_of_its_builder_no_symbols_and_no_stack_that_runs,
         is_what_auditwheel_and_twine_take)
LIVE = (simulates_and_converts_as_the_programs_of_this_machine_do, has_a_library_that_a_program_loads)


def live_facts(platform):
    """Nothing here runs what is for macOS, and Python is that of this machine."""
    if platform.startswith("macos"):
        print(f"{platform}: linked and looked at, and not run")
        return ()
    return (*LIVE, serves_a_fresh_python_as_the_readme_says) if platform == "manylinux_x86_64" else LIVE


def check_sdist(dist):
    """It has what a build needs, and is small."""
    path, = dist.glob("lumsdk-*.tar.gz")
    with tarfile.open(path) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    for wanted in ("LICENSE", "README.md", "pyproject.toml", "PKG-INFO", "CMakeLists.txt", "include/lum/version.h",
                   "tests/abi/core.symbols", "tools/python/declare.py", *(f"tools/python/{name}" for name in package_sources())):
        same(wanted in names, True, f"{wanted} is there")
    foreign = [name for name in names if re.search(r"\.(pcap|pcapng|o|a|so|pyc|png)$|^(build|docs|dist|tests/(?!abi))|__pycache__", name)]
    same(foreign, [], "what does not belong there")
    run(sys.executable, "-m", "twine", "check", "--strict", path)
    if path.stat().st_size >= LARGEST:
        raise AssertionError(f"it has {path.stat().st_size:,} bytes")


class Count:
    def __init__(self):
        self.passed, self.failed, self.skipped = 0, 0, 0

    def take(self, where, fact, *arguments):
        name = f"{where}: {fact.__name__.replace('_', ' ')}"
        try:
            fact(*arguments)
        except Skipped as why:
            self.skipped += 1
            print(f"not run: {name}: {why}")
        except (AssertionError, OSError, ValueError, TypeError, KeyError, subprocess.SubprocessError) as error:
            self.failed += 1
            print(f"FAIL  {name}\n{error}")
        else:
            self.passed += 1
            print(f"ok    {name}")
        sys.stdout.flush()


def print_table(wheels):
    print(f"{'wheel':58}{'bytes':>10}{'library':>9}{''.join(f'{name:>9}' for name in PROGRAMS)}")
    for w in wheels:
        sizes = [w.path.stat().st_size, *(path.stat().st_size for path in w.binaries())]
        tags = w.path.name.partition("none-")[2][:-4]
        print(f"{tags:58}{sizes[0]:>10,}" + "".join(f"{size // 1000:>6} KB" for size in sizes[1:]))


TAGS = {"manylinux_x86_64": "manylinux*_x86_64", "manylinux_aarch64": "manylinux*_aarch64", "musllinux_x86_64": "musllinux*_x86_64",
        "macos_arm64": "macosx*_arm64", "macos_x86_64": "macosx*_x86_64", "windows_x86_64": "win_amd64"}


def main(dist, bin_folder, *platforms):
    count, wheels = Count(), []
    dist, bin_folder = pathlib.Path(dist).resolve(), pathlib.Path(bin_folder).resolve()
    with tempfile.TemporaryDirectory() as folder:
        count.take("sdist", check_sdist, dist)
        for platform in platforms:
            path, = dist.glob(f"lumsdk-*-{TAGS[platform]}.whl")
            w = Wheel(path, platform, pathlib.Path(folder) / platform)
            wheels.append(w)
            for fact in FACTS:
                count.take(platform, fact, w)
            for fact in live_facts(platform):
                count.take(platform, fact, w, bin_folder)
        print_table(wheels)
    print(f"{count.passed} passed, {count.failed} failed, {count.skipped} skipped")
    return count.failed > 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
