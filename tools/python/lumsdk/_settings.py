"""Calibrations and wire profiles, by key."""
from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Optional, TypeVar, Union

from ._c import ffi, lib, text
from ._errors import OptionError, UnknownKeyError, nearest
from ._keys import Key, describe

Value = Union[int, float, str]
_S = TypeVar("_S", bound="_Settings")

if TYPE_CHECKING:
    Given = Union[Mapping[str, Any], str, os.PathLike[str], None]

_SET = ("use a mapping of keys to values, such as {'group.line.at': 14}, or texts KEY=VALUE, such as "
        "['group.line.at=14']")
_KNOWN: dict[int, dict[str, Key]] = {}


def _known(keys: Any) -> dict[str, Key]:
    """All keys of a kind; they are the same always."""
    if keys.kind not in _KNOWN:
        _KNOWN[keys.kind] = describe(keys)
    return _KNOWN[keys.kind]


def refusal(why: Any) -> str:
    """What is wrong, behind its key."""
    key, said = text(why.key), text(why.text)
    return f"{key}: {said}" if key else said


def written(value: Any) -> Optional[str]:
    """A value as a YAML file has it; None: it cannot be one."""
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return None
    if hasattr(value, "__index__"):
        return str(value.__index__())
    return repr(float(value)) if hasattr(value, "__float__") else None


def _pair(values: Any) -> Optional[str]:
    """[LOW, HIGH] as a YAML file has it; None: it cannot be one."""
    parts = [written(value) for value in values]
    return None if None in parts else f"[{', '.join(map(str, parts))}]"


def _flat(values: Mapping[str, Any], name: str, above: str = "") -> Iterator[tuple[str, Any]]:
    """Nested mappings as keys with dots."""
    for key, value in values.items():
        if not isinstance(key, str):
            raise TypeError(f"{name}: a key is a text such as 'tof_lsb_ps', not {type(key).__name__}")
        if isinstance(value, Mapping):
            yield from _flat(value, name, f"{above}{key}.")
        else:
            yield above + key, value


class _Settings(Mapping[str, Value]):
    """A mapping of all keys to their values. It does not change; replace() makes another."""

    _kind: ClassVar[str]
    _struct: ClassVar[str]
    _begin: ClassVar[Any]
    _take: ClassVar[Any]

    def __init__(self, values: Given = None) -> None:
        """The defaults with values on top: a mapping, nested or with dots; the path of a YAML file; or its text."""
        self._keys = ffi.new("lum_keys *")
        type(self)._begin(self._keys, ffi.NULL)
        self._name = f"the {self._kind}"
        self._usual = values is None  # else messages do not call what is left the default
        if isinstance(values, _Settings):
            if not isinstance(values, type(self)):
                raise TypeError(f"a {values._kind} is given where a {self._kind} belongs")
            self._keys[0] = values._keys[0]
        elif isinstance(values, Mapping):
            self._set_all(_flat(values, self._name), f"{self._name}: ")
        elif isinstance(values, (str, os.PathLike)):
            from ._yaml import content_of

            self._parse(*content_of(values, lib.LUM_CONFIG_BYTES_MAX))
        elif values is not None:
            raise TypeError(f"a {self._kind} is a path, a text of YAML, a mapping or a lumsdk.{type(self).__name__}, "
                            f"not {type(values).__name__}")

    # Where values come from.

    @classmethod
    def _of_text(cls: type[_S], content: bytes, name: str) -> _S:
        """One of a text that has this name in messages."""
        made = cls()
        made._usual = False
        made._parse(content, name)
        return made

    def _parse(self, content: bytes, name: str) -> None:
        from ._yaml import read_keys

        self._name = read_keys(content, name, self._keys, self._kind == "profile")
        why = ffi.new("lum_key_refusal *")
        if type(self)._take(self._keys, ffi.new(f"{self._struct} *"), why) != lib.LUM_OK:
            line = f":{why.place}" if why.place else ""
            raise OptionError(f"{self._name}{line}: {refusal(why)}")

    def _set_all(self, values: Iterable[tuple[str, Any]], above: str) -> None:
        """Set values, check them one by one and together."""
        why, entries = ffi.new("lum_key_refusal *"), list(values)
        for place, (key, value) in enumerate(entries, 1):
            known = _known(self._keys).get(key)
            is_pair = known is not None and known.is_pair
            as_text = _pair(value) if is_pair and isinstance(value, (list, tuple)) else written(value)
            if as_text is None:
                right = "a word, or two whole numbers such as [0, 13]" if is_pair else "a number or a word"
                raise TypeError(f"{above}{key}: a value is {right}, not {type(value).__name__}")
            if lib.lum_keys_set(self._keys, key.encode(), as_text.encode(), place, why) != lib.LUM_OK:
                raise OptionError(f"{above}{refusal(why)}")
        if type(self)._take(self._keys, ffi.new(f"{self._struct} *"), why) != lib.LUM_OK:
            raise OptionError(f"{above}{refusal(why)}")

    def replace(self: _S, values: Mapping[str, Any]) -> _S:
        """One with other values on top of these, such as {"eyes.blue.mount.x_m": 0.1}."""
        return self._replace(_flat(values, self._name), f"{self._name}: ")

    def _replace(self: _S, values: Iterable[tuple[str, Any]], above: str) -> _S:
        made = type(self)()
        if not self._usual:
            type(self)._begin(made._keys, self._to_c())
        made._usual, made._name = False, self._name
        made._set_all(values, above)
        return made

    def _to_c(self) -> Any:
        """The struct of the library."""
        out, why = ffi.new(f"{self._struct} *"), ffi.new("lum_key_refusal *")
        if type(self)._take(self._keys, out, why) != lib.LUM_OK:
            raise OptionError(refusal(why))
        return out

    # As a mapping.

    def __iter__(self) -> Iterator[str]:
        """Its keys. "group.line.at" is "group.line", by which it is found too."""
        known = _known(self._keys)
        return (name for name in known if not (name.endswith(".at") and name[:-3] in known))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __getitem__(self, key: str) -> Value:
        """A value, such as that of "eyes.blue.mount.x_m": a number, or a text such as "none" or "[0, 14]"."""
        known = _known(self._keys)
        if not isinstance(key, str) or key not in known:
            near = nearest(str(key), known)
            raise UnknownKeyError(f"a {self._kind} has no key {key!r}" +
                                  (f"; did you mean {near[0]!r}?" if near else f"; it has {', '.join(self)}"))
        out = ffi.new("char[]", int(lib.LUM_KEY_VALUE_BYTES))
        lib.lum_keys_get(self._keys, key.encode(), out)
        got = text(out)
        if known[key].is_word or known[key].is_pair or got in known[key].words:
            return got
        return int(got) if known[key].is_whole else float(got)

    def to_yaml(self) -> str:
        """As the text of a YAML file, which reads back exactly."""
        size = lib.lum_keys_write(self._keys, ffi.NULL, 0)
        out = ffi.new("char[]", size + 1)
        lib.lum_keys_write(self._keys, out, size + 1)
        return text(out)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Settings) and type(other) is type(self) and self.to_yaml() == other.to_yaml()

    def __hash__(self) -> int:
        return hash((type(self).__name__, self.to_yaml()))

    def __repr__(self) -> str:
        usual = type(self)()
        other = {key: value for key, value in self.items() if usual[key] != value}
        return f"{type(self).__name__}({other or ''})"

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.to_yaml(),)


class Calibration(_Settings):
    """What turns samples of a sensor into geometry: a mapping of keys such as "eyes.blue.mount.x_m"."""

    _kind = "calibration"
    _struct = "lum_calibration"
    _begin = lib.lum_keys_of_calibration
    _take = lib.lum_keys_calibration


class Profile(_Settings):
    """What is assumed of the layout of packets: a mapping of keys such as "group.line.at"."""

    _kind = "profile"
    _struct = "lum_profile"
    _begin = lib.lum_keys_of_profile
    _take = lib.lum_keys_profile


def entries(settings: Any) -> list[tuple[str, Any]]:
    """What set= names."""
    if isinstance(settings, Mapping):
        return list(_flat(settings, "set"))
    entries = [settings] if isinstance(settings, str) else settings
    try:
        pairs = [tuple(entry.split("=", 1)) for entry in entries]
    except (TypeError, AttributeError):
        raise TypeError(f"set is {settings!r}; {_SET}") from None
    if any(len(pair) != 2 or not pair[0] for pair in pairs):
        raise OptionError(f"set is {settings!r}; {_SET}")
    return [(key, value) for key, value in pairs]


def setting_of(calibration: Calibration, profile: Profile, settings: Any) -> tuple[Calibration, Profile]:
    """Both, with the option set= on top: {key: value}, or ["key=value", ...]."""
    of: dict[str, list[tuple[str, Any]]] = {"calibration": [], "profile": []}
    given = entries(settings)
    for key, _ in given:
        if key == "version":
            raise OptionError("set: version is a key of files only")
        kinds = [made for made in (calibration, profile) if key in _known(made._keys)]
        if not kinds:
            every = {**_known(calibration._keys), **_known(profile._keys)}
            near = nearest(key, every)
            raise OptionError(f"set: unknown key '{key}'; did you mean '{near[0]}'?" if near else
                              f"set: '{key}' is not a key of a calibration or a profile; they have "
                              f"{', '.join(every)}")
        of[kinds[0]._kind].extend(entry for entry in given if entry[0] == key)
    if of["calibration"]:
        calibration = calibration._replace(of["calibration"], "set: ")
    if of["profile"]:
        profile = profile._replace(of["profile"], "set: ")
    return calibration, profile
