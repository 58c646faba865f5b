#!/usr/bin/env python3
"""declare.py COMPILER INCLUDE OUTPUT: the declarations of the public headers as a module that cffi reads without a parser.

The compiler's preprocessor reads the headers, so that what stands there is the only place where a declaration is written. Bodies of
inline functions are left out, and with them the functions: a library has no symbol of theirs."""
import pathlib
import re
import subprocess
import sys

import cffi


def headers(include):
    """The public headers, as they are named in #include."""
    return sorted(path.relative_to(include).as_posix() for path in include.glob("lum/**/*.h"))


def preprocess(compiler, include, names, *options):
    """The headers with their macros expanded, and with marks that tell the file of each line."""
    text = "".join(f"#include <{name}>\n" for name in names)
    command = [*compiler, "-E", *options, "-x", "c", "-std=c99", "-I", str(include), "-D__attribute__(x)=", "-"]
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout


def numbers(compiler, include, names):
    """The macros that are whole numbers."""
    macros = preprocess(compiler, include, names, "-dM")
    found = re.findall(r"^#define (LUM_\w+) (?:\(?U?INT\d+_C\()?(0x[0-9A-Fa-f]+|\d+)[uUlL]*\)*$", macros, re.MULTILINE)
    return "".join(f"#define {name} {value}\n" for name, value in sorted(found))


def lines_of(text, include):
    """The lines that stand in the public headers themselves."""
    inside = False
    for line in text.splitlines():
        mark = re.match(r'# \d+ "(.*)"', line)
        if mark:
            inside = pathlib.Path(mark[1]).resolve().is_relative_to(include)
        elif inside and line.strip():
            yield line


def without_bodies(text):
    """Inline functions go."""
    kept, at = [], 0
    for match in re.finditer(r"^(?:static )?inline\b[^;{]*\{", text, re.MULTILINE):
        if match.start() < at:
            continue
        kept.append(text[at:match.start()])
        depth, at = 1, match.end()
        while depth:
            depth += {"{": 1, "}": -1}.get(text[at], 0)
            at += 1
    return "".join(kept) + text[at:]


def declarations(compiler, include):
    """What cffi reads."""
    include = pathlib.Path(include).resolve()
    names = headers(include)
    text = "\n".join(lines_of(preprocess(compiler, include, names), include))
    return numbers(compiler, include, names) + re.sub(r"\b_Bool\b", "bool", without_bodies(text))


def main(compiler, include, output):
    """Write the module."""
    ffi = cffi.FFI()
    ffi.set_source("lumsdk._declarations", None)
    ffi.cdef(declarations(compiler.split(";"), include))
    ffi.emit_python_code(output)


if __name__ == "__main__":
    main(*sys.argv[1:])
