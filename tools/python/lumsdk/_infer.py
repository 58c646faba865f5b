"""The layout of a capture's data packets, found from the packets alone."""
from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, Optional

from ._c import check, failure, ffi, lib, sized, text
from ._errors import CaptureError, warn
from ._inputs import Functions, Input, open_input
from ._options import parse_port, parse_sensor
from ._settings import Profile

if TYPE_CHECKING:
    from ._types import Given

_VERDICTS = {lib.LUM_INFER_FOUND: "found", lib.LUM_INFER_UNSURE: "unsure", lib.LUM_INFER_TOO_LITTLE: "too little",
             lib.LUM_INFER_NOTHING_FITS: "nothing fits"}


@dataclasses.dataclass(frozen=True)
class Finding:
    """What was found out about one key of the profile."""

    key: str
    """Such as "group.tag"."""
    value: str
    """As it stands in the YAML."""
    told: bool
    """Whether the packets determine it; otherwise it keeps its default."""
    evidence: str
    """Why, in one line."""
    equal: str
    """What fits equally well; empty: nothing does."""
    look: str
    """What to check to decide it; empty: nothing."""


@dataclasses.dataclass(frozen=True)
class Inference:
    """What infer() found out."""

    verdict: str
    """ "found"; "unsure", where another reading is about as good; "too little"; "nothing fits"."""
    text: str
    """One line: what was found, what is missing, or which identity fails."""
    profile: Optional[Profile]
    """The layout that explains the packets; None: there is none."""
    second: Optional[Profile]
    """The next best reading that gives other points; None: there is none."""
    margin: float
    """The smallest of all keys: by how many percentage points its field explains more than the best field with other values."""
    margin_key: str
    """The key with that margin, such as "group.line"; empty without a profile."""
    packets: int
    """Packets that were looked at."""
    fit: int
    """Of them, those that the profile explains."""
    findings: tuple[Finding, ...]
    """What each key is, and why; empty without a profile."""
    yaml: str
    """The profile as a file, with the evidence as comments; empty without one."""
    counts: dict[str, int]
    """What else was read, until it had enough: other_type, control, foreign, cut_short, left_out, and elsewhere (another port,
    sensor or interface, or no datagram), as lumdump --infer --json has them. With packets, these are all records, joined ones
    taken apart."""


def _open(source: Input, kept: list[Any]) -> tuple[Any, Optional[Functions]]:
    """A capture of the library, as by ffi.gc()."""
    given, functions = source.begin(kept)
    out, error = ffi.new("lum_capture **"), ffi.new("lum_error *")
    if "path" in given:
        status = lib.lum_capture_open(given["path"], out, error)
    elif "paths" in given:
        status = lib.lum_capture_open_several(given["paths"], given["path_count"], out, error)
    else:
        status = lib.lum_capture_open_source(given["source"], out, error)
    if functions is not None and functions.problem is not None:
        raise functions.problem
    check(status, error, CaptureError)
    return ffi.gc(out[0], lib.lum_capture_close), functions


def _is_of(interface: str, capture: Any) -> bool:
    found = lib.lum_capture_interface(capture)
    return not interface or (found != ffi.NULL and text(found) == interface)


def _read(made: Any, capture: Any, interface: str, functions: Optional[Functions]) -> int:
    """As much of a capture as is needed, and how many records of other interfaces were left out. What cannot be read to its end is
    used as far as it can."""
    record, error = ffi.new("lum_record *"), ffi.new("lum_error *")
    wants, status, skipped = 1, 1, 0
    while wants > 0:
        status = lib.lum_capture_next(capture, record, error)
        if status <= 0:
            break
        if _is_of(interface, capture):
            wants = lib.lum_infer_push(made, record, error)
        else:
            skipped += 1
    if functions is not None and functions.problem is not None:
        raise functions.problem
    if wants < 0:
        raise failure(error)
    damage = ffi.new("lum_error *")
    if lib.lum_capture_damaged(capture, damage):
        warn(text(damage.text))
    if status < 0:
        warn(text(error.text))
    return skipped


def _profile(found: Any) -> Profile:
    made = Profile()
    lib.lum_keys_of_profile(made._keys, found)
    made._usual = False
    return made


def _finding(found: Any) -> Finding:
    return Finding(text(found.name), text(found.value), bool(found.is_told), text(found.evidence), text(found.equal),
                   text(found.look))


def _yaml(result: Any) -> str:
    out = ffi.new("char[]", lib.LUM_INFER_YAML_BYTES)
    lib.lum_infer_write_yaml(result, out, lib.LUM_INFER_YAML_BYTES)
    return text(out)


_COUNTS = ("other_type", "control", "foreign", "cut_short", "left_out", "elsewhere")


def _solve(made: Any, skipped: int) -> Inference:
    result, error = sized("lum_infer_result"), ffi.new("lum_error *")
    if lib.lum_infer_solve(made, result, error) < 0:
        raise failure(error)
    return Inference(
        verdict=_VERDICTS[result.verdict], text=text(result.text),
        profile=_profile(ffi.addressof(result, "profile")) if result.has_profile else None,
        second=_profile(ffi.addressof(result, "second")) if result.has_second else None,
        margin=float(result.margin),
        margin_key=text(result.findings[result.margin_key].name) if result.has_profile else "",
        packets=int(result.counts.packets), fit=int(result.fit),
        findings=tuple(_finding(result.findings[i]) for i in range(result.finding_count)), yaml=_yaml(result),
        counts={name: int(getattr(result.counts, name)) + (skipped if name == "elsewhere" else 0) for name in _COUNTS})


def infer(source: Given, *, sensor: Optional[str] = None, port: Optional[int] = None) -> Inference:
    """Find the layout of the data packets of captures that do not decode, as lumdump --infer does.

    Nothing but the packets is used; a profile in the capture is not. At most 20,000 of them are looked at.

        found = lumsdk.infer("drive.pcap")
        if found.profile is not None:
            source = lumsdk.open("drive.pcap", profile=found.profile)

    Args:
        source: What open() takes: paths, a pattern, the bytes of a capture, a binary file object, a URL.
        sensor: The address of one of several sensors, or its name, such as "10.42.0.37%eth1".
        port: The sensors' UDP port in them, if NAT has changed it from 5517.

    Raises:
        CaptureError: A capture cannot be opened.
        OptionError: The address or the port is invalid.
    """
    options, error = sized("lum_infer_options"), ffi.new("lum_error *")
    chosen = parse_sensor(sensor) if sensor is not None else None
    if chosen is not None:
        options.has_sensor, options.sensor = True, chosen.address
    if port is not None:
        options.port = parse_port(port)
    opened, kept = open_input(source), list[Any]()
    try:
        out = ffi.new("lum_infer **")
        check(lib.lum_infer_create(options, out, error), error)
        made = ffi.gc(out[0], lib.lum_infer_free)
        capture, functions = _open(opened, kept)
        try:
            skipped = _read(made, capture, chosen.interface if chosen is not None else "", functions)
        finally:
            ffi.release(capture)
        return _solve(made, skipped)
    finally:
        opened.close()
