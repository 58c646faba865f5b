"""The keys of calibrations and profiles: the name and the allowed values of each."""
from __future__ import annotations

from typing import Any

from ._c import ffi, lib, text


_QUOTED_MAX = 55


def quoted(value: str) -> str:
    """A text as messages quote it: in printable ASCII, and shortened."""
    out = ""
    for byte in value.encode(errors="surrogatepass"):
        if len(out) > _QUOTED_MAX:
            return out + "..."
        out += chr(byte) if 0x20 <= byte < 0x7f else f"\\x{byte:02x}"
    return out


class Key:
    """The name and the allowed values of a key."""

    is_number = True

    def __init__(self, c: Any) -> None:
        self.name = text(c.name)
        self.allowed = text(c.allowed)
        self.words = [text(word) for word in c.words if word]
        self.is_word = c.kind == lib.LUM_KEY_WORD
        self.is_pair = c.kind == lib.LUM_KEY_WORD_OR_PAIR
        self.is_whole = c.kind in (lib.LUM_KEY_WHOLE, lib.LUM_KEY_WORD_OR_WHOLE)


class Text(Key):
    """A key of a rig."""

    def __init__(self, name: str, allowed: str, is_number: bool) -> None:
        self.name, self.allowed, self.is_number = name, allowed, is_number
        self.words: list[str] = []
        self.is_word = self.is_pair = self.is_whole = False


def describe(keys: Any) -> dict[str, Key]:
    """All keys of a kind, by name."""
    found: dict[str, Key] = {}
    c = ffi.new("lum_key *")
    while lib.lum_keys_describe(keys, len(found), c) == lib.LUM_OK:
        key = Key(c)
        found[key.name] = key
    return found
