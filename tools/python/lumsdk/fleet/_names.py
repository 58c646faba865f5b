"""Names of files as text: on disk a name is bytes, in tables and on a terminal it is text."""
from __future__ import annotations

import re

# Python has a byte that is no text as a surrogate.
_NO_TEXT = re.compile("[\ud800-\udfff]")
_LOOKS_WRITTEN = re.compile(r"\\(?=x5c|x[89a-f][0-9a-f]|ud[89a-f][0-9a-f]{2})")
_WRITTEN = re.compile(r"\\(?:x(5c|[89a-f][0-9a-f])|u(d[89a-f][0-9a-f]{2}))")


def printable(text: str) -> str:
    """Words for a user: what is no text becomes \\xff."""
    return _NO_TEXT.sub(_write, text)


def to_text(name: str) -> str:
    """A file's name as text that is another one for each name."""
    return printable(_LOOKS_WRITTEN.sub(r"\\x5c", name))


def to_name(text: str) -> str:
    """The file's name of which to_text() made a text."""
    return _WRITTEN.sub(_read, text)


def _write(found: re.Match[str]) -> str:
    code = ord(found.group())
    return f"\\x{code - 0xDC00:02x}" if 0xDC80 <= code <= 0xDCFF else f"\\u{code:04x}"


def _read(found: re.Match[str]) -> str:
    byte, code = found.groups()
    if byte == "5c":
        return "\\"
    return chr(0xDC00 + int(byte, 16)) if byte else chr(int(code, 16))
