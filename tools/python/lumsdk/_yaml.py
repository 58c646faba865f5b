"""Calibrations and profiles in YAML, read as the command-line tools read them: what they refuse, with their sentences."""
from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any, NoReturn, Union

import yaml  # type: ignore[import-untyped,unused-ignore]

from ._c import ffi, lib, text
from ._errors import OptionError
from ._keys import Key, describe, quoted

_PAIR_MAX = 63  # bytes of two numbers; more are cut, and none of it
_MARK = b"\xef\xbb\xbf"  # of UTF-8, at the begin of some files


def content_of(given: Union[str, os.PathLike[str]], most: int) -> tuple[bytes, str]:
    """The bytes of a text, or of a file that is named, up to one more than may be, and its name."""
    if isinstance(given, str) and "\n" in given:
        return given.encode(errors="surrogateescape"), "text"
    name = os.fsdecode(given)
    try:
        with open(given, "rb") as file:
            return file.read(most + 1), name
    except IsADirectoryError:
        raise OptionError(f"{name}: is a directory; a YAML file is needed") from None
    except OSError as error:
        raise OptionError(f"{name}: cannot be read: {error.strerror}") from error


class Reader:
    """One text that is being read."""

    bytes_max = lib.LUM_CONFIG_BYTES_MAX

    def __init__(self, content: bytes, name: str, known: Mapping[str, Key]) -> None:
        self.content, self.known = content, known
        self.name = "".join(c if " " <= c != "\x7f" else "?" for c in name)
        self.line = 0
        self.prefix = ""  # of paths in messages: "sensors.3"
        self.path = ""
        self.has_version = False
        self.event: Any = None

    # Messages.

    def fail(self, what: str) -> NoReturn:
        where = f"{self.name}:{self.line}" if self.line else self.name
        path = ".".join(part for part in (self.prefix, self.path) if part)
        raise OptionError(f"{where}: {path}: {what}" if path else f"{where}: {what}")

    def names(self, path: str) -> list[str]:
        """The keys of a mapping."""
        above = path + "." if path else ""
        below = [name[len(above):].split(".")[0] for name in self.known if name.startswith(above)]
        return list(dict.fromkeys(below))

    def allowed(self) -> str:
        """What may stand where the path is."""
        parts = [self.known[self.path].allowed] if self.path in self.known else []
        names = self.names(self.path)
        if names:
            parts.append("a mapping of " + ", ".join(names))
        return ", or ".join(parts)

    def refuse_value(self, what: str) -> NoReturn:
        self.fail(f"{what}; allowed: {self.allowed()}")

    def refuse_key(self, name: str) -> NoReturn:
        if name.isascii() and name.replace("_", "").isalnum():
            self.set(f"{self.path}.{name}" if self.path else name, "0")
        self.fail(f"unknown key '{quoted(name)}'; allowed here: {', '.join(self.names(self.path))}")

    def refuse_syntax(self, error: yaml.MarkedYAMLError) -> NoReturn:
        self.prefix = self.path = ""
        mark = error.problem_mark
        self.line = mark.line + 1 if mark else 1
        lines = self.content.splitlines()
        here = lines[self.line - 1] if self.line <= len(lines) else b""
        if here.lstrip(b" ").startswith(b"\t"):
            self.fail("a tab indents this line; use spaces")
        said = f"not valid YAML: {error.problem}"
        if error.context:
            line = f" (line {error.context_mark.line + 1})" if error.context_mark else ""
            said += f" {error.context}{line}"
        self.fail(said)

    def refuse_bytes(self, at: int, why: str) -> NoReturn:
        self.line = self.content.count(b"\n", 0, at) + 1
        self.fail(f"not plain UTF-8 text: {why}")

    # Events.

    def decode(self) -> str:
        """The text, which has no control characters."""
        try:
            decoded = self.content.decode()
        except UnicodeDecodeError as error:
            self.refuse_bytes(error.start, error.reason)
        bad = yaml.reader.Reader.NON_PRINTABLE.search(decoded)
        if bad:
            self.refuse_bytes(len(decoded[:bad.start()].encode()), "control characters are not allowed")
        return decoded

    def next(self) -> Any:
        try:
            self.event = next(self.events)
        except yaml.MarkedYAMLError as error:
            self.refuse_syntax(error)
        return self.event

    def is_plain(self) -> bool:
        return not self.event.style

    def is_empty(self) -> bool:
        return isinstance(self.event, yaml.ScalarEvent) and self.is_plain() and not self.event.value

    def refuse_links(self) -> None:
        if isinstance(self.event, yaml.AliasEvent):
            self.fail("aliases (*) are not accepted; write the value out")
        if getattr(self.event, "anchor", None) is not None:
            self.fail("anchors (&) are not accepted; leave it out")
        if getattr(self.event, "tag", None) is not None:
            self.fail("tags (!) are not accepted; leave it out")

    # Keys and values.

    def set(self, key: str, value: str) -> None:
        """Set a value, or refuse it."""
        raise NotImplementedError

    def read_scalar(self) -> None:
        key, value = self.known[self.path], self.event.value
        if value not in key.words:
            if not self.is_plain() and key.is_pair:
                self.refuse_value(f"'{quoted(value)}' is text; write [LOW, HIGH], without quotes")
            if not self.is_plain() and not key.is_word:
                self.refuse_value(f"'{quoted(value)}' is text; write a number, without quotes")
            if not value.isascii() or not value.isprintable():
                self.refuse_value(f"'{quoted(value)}' is not " + ("known" if key.is_word else "a whole number in digits"
                                                                  if key.is_whole else "a decimal number"))
        self.set(self.path, value)
        self.has_version |= self.path == "version"

    def read_pair(self) -> None:
        """The plain values of a sequence, such as [0, 14]."""
        found = []
        while not isinstance(self.next(), yaml.SequenceEndEvent):
            self.refuse_links()
            if not isinstance(self.event, yaml.ScalarEvent) or not self.is_plain():
                self.refuse_value("only numbers belong in [ ]")
            found.append(self.event.value)
        self.set(self.path, f"[{', '.join(found)}]"[:_PAIR_MAX])

    def read_value(self) -> None:
        self.refuse_links()
        if isinstance(self.event, yaml.MappingStartEvent) and self.names(self.path):
            self.read_mapping()
        elif isinstance(self.event, yaml.ScalarEvent) and self.path in self.known and not self.is_empty():
            self.read_scalar()
        elif self.is_empty():
            self.refuse_value("no value")
        elif isinstance(self.event, yaml.SequenceStartEvent) and self.path in self.known and self.known[self.path].is_pair:
            self.read_pair()
        elif isinstance(self.event, yaml.SequenceStartEvent):
            self.read_list()
        elif isinstance(self.event, yaml.MappingStartEvent):
            self.refuse_value("a mapping does not belong here")
        else:
            self.refuse_value("a single value does not belong here")

    def read_list(self) -> None:
        self.refuse_value("a sequence does not belong here")

    def read_key(self, seen: dict[str, int]) -> None:
        self.line = self.event.start_mark.line + 1
        self.refuse_links()
        if not isinstance(self.event, yaml.ScalarEvent):
            self.fail("a key must be a single word")
        name = self.event.value
        if name not in self.names(self.path):
            self.refuse_key(name)
        self.path = f"{self.path}.{name}" if self.path else name
        if name in seen:
            self.fail(f"repeated; it is already on line {seen[name]}")
        seen[name] = self.line

    def read_mapping(self) -> None:
        seen: dict[str, int] = {}
        above = self.path
        while not isinstance(self.next(), yaml.MappingEndEvent):
            self.read_key(seen)
            self.next()
            self.read_value()
            self.path = above

    # The document.

    def refuse_root(self) -> NoReturn:
        if isinstance(self.event, yaml.StreamEndEvent) or self.is_empty():
            self.line = 1
            self.fail("nothing but blanks or comments; begin with 'version: 1'")
        self.fail(f"not a mapping of keys; allowed here: {', '.join(self.names(''))}")

    def read(self) -> None:
        """Set the keys that the text has."""
        if len(self.content) > self.bytes_max:
            self.fail(f"longer than the {self.bytes_max} bytes that are accepted")
        if self.content.startswith(_MARK):
            self.content = self.content[len(_MARK):]
        self.events = iter(yaml.parse(self.decode(), Loader=yaml.SafeLoader))
        self.next()
        if isinstance(self.next(), yaml.StreamEndEvent):
            self.refuse_root()
        self.next()
        self.line = self.event.start_mark.line + 1
        self.refuse_links()
        if not isinstance(self.event, yaml.MappingStartEvent):
            self.refuse_root()
        self.read_mapping()
        self.next()
        if not isinstance(self.next(), yaml.StreamEndEvent):
            self.line = self.event.start_mark.line + 1
            self.fail("a second document begins; a file holds one")


class _KeysReader(Reader):
    """A calibration or a profile."""

    def __init__(self, content: bytes, name: str, keys: Any) -> None:
        super().__init__(content, name, describe(keys))
        self._keys = keys

    def set(self, key: str, value: str) -> None:
        why = ffi.new("lum_key_refusal *")
        if lib.lum_keys_set(self._keys, key.encode(), value.encode(), self.line, why) != lib.LUM_OK:
            self.fail(text(why.text))


def read_keys(content: bytes, name: str, keys: Any, needs_version: bool) -> str:
    """Set the keys that a text has. Returns the name as messages have it."""
    reader = _KeysReader(content, name, keys)
    reader.read()
    if needs_version and not reader.has_version:
        reader.line, reader.path = 1, "version"
        reader.fail("missing; a profile needs 'version: 1'")
    return reader.name
