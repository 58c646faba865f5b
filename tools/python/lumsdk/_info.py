"""What is known of a frame as a whole, apart from its arrays."""
from __future__ import annotations

from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple, Optional

from ._c import lib, sized, text
from ._grid import EYES

if TYPE_CHECKING:
    from ._rig import RigSensor

LOSSES = ("lost_words", "lines_missing_angles", "lines_missing", "lines_in_pauses", "lines_cut", "lines_late", "points_cut",
          "no_angle", "no_range")
"""The causes in Frame.losses."""


class Members(NamedTuple):
    """The sensors of a rig that is read."""

    sensors: tuple[RigSensor, ...]
    rig: tuple[str, ...]
    """All of the rig, as Rig.describe() says it."""


class Info(SimpleNamespace):  # a data class takes a millisecond of each import
    """What is known of a frame as a whole, apart from its arrays."""

    number: int
    sensor: int
    is_complete: bool
    is_first: bool
    is_last: bool
    begin_clock_us: int
    end_clock_us: int
    begin_arrival_ns: int
    end_arrival_ns: int
    begin_utc_ns: int
    utc_error_ns: int
    has_pause: bool
    interface: str
    lines: tuple[int, int]
    rows: tuple[int, int]
    losses: dict[str, int]
    member: int = 0
    """1 + the place of its sensor in the rig; 0: it was read without one; JOINED."""
    name: str = ""
    pose: Optional[tuple[tuple[float, ...], ...]] = None
    rig: tuple[str, ...] = ()
    """All of the rig, as Rig.describe() says it."""

    def __init__(self, **values: Any) -> None:
        """Those that are of rigs alone can be left out."""
        super().__init__(**{**{name: getattr(Info, name) for name in ("member", "name", "pose", "rig")}, **values})

    def replace(self, **values: Any) -> Info:
        """The same with other values."""
        return Info(**{**vars(self), **values})

    @classmethod
    def of(cls, frame: Any, members: Optional[Members]) -> Info:
        """That of a frame of the library."""
        i = sized("lum_frame_info")
        lib.lum_frame_get_info(frame, i)
        counts = {"lines_missing": sum(i.lines_missing), "no_angle": i.losses.no_angle, "no_range": i.losses.no_range}
        losses = {name: counts[name] if name in counts else getattr(i, name) for name in LOSSES}
        values = {name: getattr(i.times if name.endswith(("_us", "_ns")) else i, name) for name in list(cls.__annotations__)[:12]}
        values.update(interface=text(i.sensor_interface), lines=tuple(i.lines), losses=losses,
                      rows=tuple(lib.lum_frame_rows(frame, eye) for eye in range(len(EYES))))
        if members is not None and i.member:
            sensor = members.sensors[i.member - 1]
            values.update(member=i.member, name=sensor.name, pose=tuple(map(tuple, sensor.pose.tolist())), rig=members.rig)
        return cls(**values)
