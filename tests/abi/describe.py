"""describe.py HEADER...: what the public headers promise, one fact a line:
macros, types, values of enums, layouts of structs, functions. Run at the
repository's top.

Offsets and sizes are in bytes, on x86-64 and, of headers that need no host, on
Cortex-M too; where the two differ, both are told. Of what a comment calls
private no more is told than what it adds to the size."""

import subprocess
import sys

from clang.cindex import CursorKind, Index, TranslationUnit

# The compiler's own headers, such as stddef.h.
RESOURCES = subprocess.run(["clang-14", "-print-resource-dir"], check=True, text=True,
                           stdout=subprocess.PIPE).stdout.strip()
HOST = ["--target=x86_64-linux-gnu"]
SMALL = ["--target=thumbv6m-none-eabi", "-ffreestanding"]


def parse(header, target):
    unit = Index.create().parse(
        header, args=["-x", "c", "-std=c99", "-Iinclude", "-resource-dir", RESOURCES, *target],
        options=TranslationUnit.PARSE_DETAILED_PROCESSING_RECORD)
    faults = [str(d) for d in unit.diagnostics if d.severity >= d.Error]
    if faults:
        sys.exit("\n".join(faults))
    # An enum or struct stands in a typedef's place too; the order is the file's.
    own = [c for c in unit.cursor.get_children()
           if c.location.file and c.location.file.name == header]
    return sorted(own, key=lambda c: c.location.offset)


def both(host, small):
    return f"{host}" if small in (None, host) else f"{host} (Cortex-M: {small})"


def macro(cursor, _):
    tokens = [t.spelling for t in cursor.get_tokens()]
    if tokens[1:]:  # all but include guards
        yield "macro " + " ".join(tokens)


def enumeration(cursor, _):
    yield f"enum {cursor.spelling}"
    for value in cursor.get_children():
        yield f"{cursor.spelling}.{value.spelling} = {value.enum_value}"


def record(cursor, small):
    if not cursor.is_definition():
        yield f"struct {cursor.spelling}, opaque"
        return
    size = both(cursor.type.get_size(), small and small.type.get_size())
    yield f"struct {cursor.spelling} of {size}"
    others = small.type.get_fields() if small else cursor.type.get_fields()
    for field, other in zip(cursor.type.get_fields(), others):
        if "private" not in (field.raw_comment or ""):
            at = both(field.get_field_offsetof() // 8, other.get_field_offsetof() // 8)
            yield f"{cursor.spelling}.{field.spelling}: {field.type.spelling} at {at}"


def function(cursor, _):
    arguments = ", ".join(a.type.spelling for a in cursor.get_arguments()) or "void"
    if cursor.type.is_function_variadic():
        arguments += ", ..."
    kind = "inline" if cursor.is_definition() else "function"
    yield f"{kind} {cursor.result_type.spelling} {cursor.spelling}({arguments})"


def variable(cursor, _):
    yield f"variable {cursor.type.spelling} {cursor.spelling}"


def alias(cursor, _):
    name, meaning = cursor.spelling, cursor.underlying_typedef_type.spelling
    if meaning not in (f"struct {name}", f"enum {name}"):
        yield f"typedef {meaning} {name}"


TELL = {
    CursorKind.MACRO_DEFINITION: macro,
    CursorKind.ENUM_DECL: enumeration,
    CursorKind.STRUCT_DECL: record,
    CursorKind.FUNCTION_DECL: function,
    CursorKind.VAR_DECL: variable,
    CursorKind.TYPEDEF_DECL: alias,
}


def describe(header):
    known = TELL | {CursorKind.INCLUSION_DIRECTIVE: lambda *_: (),
                    CursorKind.MACRO_INSTANTIATION: lambda *_: ()}
    small = {}
    if header.count("/") == 2:  # include/lum/NAME.h
        small = {(c.kind, c.spelling): c for c in parse(header, SMALL)}
    for cursor in parse(header, HOST):
        if cursor.kind not in known:
            sys.exit(f"{cursor.location}: {cursor.kind} is new to {__file__}")
        for line in known[cursor.kind](cursor, small.get((cursor.kind, cursor.spelling))):
            yield f"{header.removeprefix('include/')}: {line}"


for path in sys.argv[1:]:
    print(*describe(path), sep="\n")
