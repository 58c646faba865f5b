"""Calibrations and profiles in YAML, read as the command-line tools read them, with their messages."""
from __future__ import annotations

from typing import Any

from ._c import ffi, lib, text
from ._errors import OptionError


def read_keys(content: bytes, name: str, keys: Any, kind: str) -> None:
    """Set the keys that a text has."""
    import yaml

    why = ffi.new("lum_key_refusal *")

    def walk(node: Any, path: str) -> None:
        for key, value in node.value:
            line = key.start_mark.line + 1
            full = f"{path}{key.value}"
            if isinstance(value, yaml.MappingNode):
                walk(value, full + ".")
            elif lib.lum_keys_set(keys, full.encode(), value.value.encode(), line, why) != lib.LUM_OK:
                raise OptionError(f"{name}:{line}: {text(why.key)}: {text(why.text)}")

    node = yaml.compose(content.decode())
    if not isinstance(node, yaml.MappingNode):
        raise OptionError(f"{name}:1: not a mapping of keys")
    walk(node, "")
