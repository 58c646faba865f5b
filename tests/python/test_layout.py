"""What cffi believes of the library's types is what a C compiler makes of the headers."""
import os
import pathlib
import shutil
import subprocess

import lumsdk._c as c
import pytest

INCLUDE = pathlib.Path(__file__).parents[2] / "include"
COMPILER = os.environ.get("CC") or shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")

pytestmark = pytest.mark.skipif(not COMPILER or not INCLUDE.is_dir(), reason="needs a C compiler and the headers")


def structs():
    """Every struct that has members, by its name."""
    typedefs, tagged, _ = c.ffi.list_types()
    for name in [*typedefs, *(f"struct {tag}" for tag in tagged)]:
        kind = c.ffi.typeof(name)
        if kind.kind == "struct" and has_members(name):
            yield name, kind


def has_members(name):
    """Whether it is defined in a public header."""
    try:
        return c.ffi.sizeof(name) > 0
    except c.ffi.error:
        return False


def enums():
    typedefs, _, _ = c.ffi.list_types()
    for name in [*typedefs, "enum lum_eye", "enum lum_framer_wants", "enum lum_eyes", "enum lum_group_field"]:
        kind = c.ffi.typeof(name)
        if kind.kind == "enum":
            yield name, kind


def constants():
    return [name for name in dir(c.lib) if name.startswith("LUM_") and isinstance(getattr(c.lib, name), int)]


@pytest.fixture(scope="module")
def compiled(tmp_path_factory):
    """What the compiler says, by the expressions that were asked for."""
    asked = {}
    for name, kind in structs():
        asked[f"sizeof({name})"] = c.ffi.sizeof(name)
        for field, about in kind.fields:
            asked[f"offsetof({name}, {field})"] = about.offset
            asked[f"sizeof((({name} *)0)->{field})"] = c.ffi.sizeof(about.type)
    for name, kind in enums():
        asked[f"sizeof({name})"] = c.ffi.sizeof(name)
        asked.update({element: value for value, element in kind.elements.items()})
    asked.update({name: getattr(c.lib, name) for name in constants()})
    tmp = tmp_path_factory.mktemp("layout")
    headers = sorted(path.relative_to(INCLUDE).as_posix() for path in INCLUDE.glob("lum/**/*.h"))
    lines = [*(f"#include <{header}>" for header in headers), "#include <stddef.h>", "#include <stdio.h>",
             "int main(void) {", *(f'    (void)printf("%lld\\n", (long long)({name}));' for name in asked), "}"]
    (tmp / "layout.c").write_text("\n".join(lines))
    subprocess.run([COMPILER, "-std=c99", "-w", "-I", str(INCLUDE), "-o", tmp / "layout", tmp / "layout.c"], check=True)
    answers = map(int, subprocess.run([tmp / "layout"], capture_output=True, check=True).stdout.split())
    return [(name, believed, answer) for (name, believed), answer in zip(asked.items(), answers)]


def test_sizes_offsets_and_values_are_those_of_the_compiler(compiled):
    wrong = [f"{name}: cffi has {believed}, the compiler {answer}" for name, believed, answer in compiled
             if believed != answer]
    assert not wrong, "\n".join(wrong)


def test_they_are_many(compiled):
    names = {name for name, _, _ in compiled}
    assert {"sizeof(lum_frame_info)", "offsetof(lum_reader_options, go_on)", "LUM_COLUMN_STRONGEST",
            "LUM_VERSION_MINOR"} <= names
    assert len(names) > 700
