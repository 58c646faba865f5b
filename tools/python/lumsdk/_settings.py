"""Calibrations and wire profiles, by key."""
from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Optional, TypeVar, Union

from ._c import ffi, lib, text
from ._errors import Error, OptionError

Value = Union[int, float, str]
_S = TypeVar("_S", bound="_Settings")


class _Settings(Mapping[str, Value]):
    """A mapping of all keys to their values. It does not change; replace() makes another."""

    _kind: ClassVar[str]
    _struct: ClassVar[str]
    _begin: ClassVar[Any]
    _take: ClassVar[Any]

    def __init__(self, values: Union[Mapping[str, Any], str, os.PathLike[str], None] = None) -> None:
        """The defaults, with values on top: a mapping (nested or with dots), a path of a YAML file, or its text."""
        self._keys = ffi.new("lum_keys *")
        type(self)._begin(self._keys, ffi.NULL)
        self._name = f"the {self._kind}"
        if values is None:
            pass
        elif isinstance(values, _Settings):
            if not isinstance(values, type(self)):
                raise TypeError(f"a {values._kind} is given where a {self._kind} belongs")
            self._keys[0] = values._keys[0]
        elif isinstance(values, Mapping):
            self._set_all(values)
        elif isinstance(values, (str, os.PathLike)):
            self._read(values)
        else:
            raise TypeError(f"a {self._kind} is a path, a text of YAML, a mapping or a lumsdk.{type(self).__name__}, "
                            f"not {type(values).__name__}")
        self._check()

    def _read(self, values: Union[str, os.PathLike[str]]) -> None:
        from ._yaml import read_keys

        if isinstance(values, str) and "\n" in values:
            name, content = "text", values.encode()
        else:
            name = os.fsdecode(values)
            try:
                with open(values, "rb") as file:
                    content = file.read(lib.LUM_CONFIG_BYTES_MAX + 1)
            except OSError as error:
                raise OptionError(f"{name}: {error.strerror}") from error
        self._name = name
        read_keys(content, name, self._keys, self._kind)

    def _refusal(self, why: Any) -> OptionError:
        key, said = text(why.key), text(why.text)
        return OptionError(f"{self._name}: {key}: {said}" if key else f"{self._name}: {said}")

    def _set(self, key: str, value: Any) -> None:
        why = ffi.new("lum_key_refusal *")
        if isinstance(value, bool) or not isinstance(value, (int, float, str)):
            raise TypeError(f"{self._name}: {key}: a value is a number or a word, not {type(value).__name__}")
        written = value if isinstance(value, str) else repr(value)
        if lib.lum_keys_set(self._keys, key.encode(), written.encode(), 1, why) != lib.LUM_OK:
            raise self._refusal(why)

    def _set_all(self, values: Mapping[str, Any], above: str = "") -> None:
        for key, value in values.items():
            if not isinstance(key, str):
                raise TypeError(f"{self._name}: a key is a text, not {type(key).__name__}")
            if isinstance(value, Mapping):
                self._set_all(value, f"{above}{key}.")
            else:
                self._set(above + key, value)

    def _check(self) -> None:
        self._to_c()

    def _to_c(self) -> Any:
        """The struct of the library."""
        out, why = ffi.new(f"{self._struct} *"), ffi.new("lum_key_refusal *")
        if type(self)._take(self._keys, out, why) != lib.LUM_OK:
            raise self._refusal(why)
        return out

    def replace(self: _S, values: Optional[Mapping[str, Any]] = None) -> _S:
        """One with other values on top of these."""
        made = type(self)(self)
        made._set_all(values or {})
        made._check()
        return made

    def _names(self) -> Iterator[str]:
        key, i = ffi.new("lum_key *"), 0
        while lib.lum_keys_describe(self._keys, i, key) == lib.LUM_OK:
            yield text(key.name)
            i += 1

    def __iter__(self) -> Iterator[str]:
        return (name for name in self._names() if self._get(name) is not None)

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def _get(self, key: str) -> Optional[str]:
        out = ffi.new("char[]", int(lib.LUM_KEY_VALUE_BYTES))
        return text(out) if lib.lum_keys_get(self._keys, key.encode(), out) == lib.LUM_OK else None

    def __getitem__(self, key: str) -> Value:
        """A value, such as that of "eyes.blue.mount.x_m": a number, or a word such as "none"."""
        got = self._get(key) if isinstance(key, str) else None
        if got is None:
            raise KeyError(f"a {self._kind} has no key {key!r}; it has {', '.join(self)}")
        for number in (int, float):
            try:
                return number(got)
            except ValueError:
                pass
        return got

    def to_yaml(self) -> str:
        """As the text of a YAML file, which reads back exactly."""
        size = lib.lum_keys_write(self._keys, ffi.NULL, 0)
        out = ffi.new("char[]", size + 1)
        lib.lum_keys_write(self._keys, out, size + 1)
        return text(out)

    def __eq__(self, other: object) -> bool:
        return type(other) is type(self) and self.to_yaml() == other.to_yaml()  # type: ignore[attr-defined]

    def __hash__(self) -> int:
        return hash((type(self).__name__, self.to_yaml()))

    def __repr__(self) -> str:
        usual = type(self)()
        other = {key: value for key, value in self.items() if usual.get(key) != value}
        return f"{type(self).__name__}({other if other else ''})"

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (dict(self),)


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


def setting_of(calibration: Calibration, profile: Profile, settings: Any) -> tuple[Calibration, Profile]:
    """Both, with the option set= on top: {key: value}, or ["key=value", ...]."""
    if isinstance(settings, str):
        settings = [settings]
    if not isinstance(settings, Mapping):
        try:
            settings = dict(entry.split("=", 1) for entry in settings)
        except (TypeError, ValueError, AttributeError):
            raise OptionError(f"set is {settings!r}; right is a mapping of keys to values, or texts KEY=VALUE, such as "
                              "group.line.at=14") from None
    for key, value in settings.items():
        of_calibration = key in set(calibration._names())
        try:
            if of_calibration:
                calibration = calibration.replace({key: value})
            else:
                profile = profile.replace({key: value})
        except Error as error:
            raise OptionError(f"set: {error}") from None
    return calibration, profile
