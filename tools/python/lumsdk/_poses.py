"""Poses: where a sensor was, and frames moved by them."""
from __future__ import annotations

import os
import warnings
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np

from ._c import check, ffi, lib, sized, text
from ._errors import CaptureError, CaptureWarning, Error, OptionError, UnknownKeyError, warn
from ._build import assemble, select
from ._frame import Frame
from ._grid import JOINED
from ._info import Info

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray
    from typing_extensions import Literal

    from ._types import Array, Clock, Doubles, Outside

    Time = Union[int, float]

_CLOCKS = {"sensor": lib.LUM_POSES_SENSOR, "utc": lib.LUM_POSES_UTC}
_TO = {"start": lib.LUM_MOVE_TO_START, "middle": lib.LUM_MOVE_TO_MIDDLE, "world": lib.LUM_MOVE_TO_WORLD}
MOMENTS = tuple(_TO)
"""Where points can be moved to."""

_OUTSIDE = ("nan", "nearest", "raise")
_CAUSES = (("before", "before the first pose"), ("after", "after the last one"), ("in_gap", "in gaps of the poses"),
           ("no_start", "in a frame without a pose at its start or middle"), ("no_time", "without a time"))
_UNIT_ERROR = 0.02
_NUMBER = (int, float, np.integer, np.floating)
_ROUNDING = 1e-15
"""The most that normalising a quaternion again changes its numbers."""

_MOVED = {"start": "the start of the frame", "middle": "the middle of the frame", "world": "the world"}
_GAP_S, _JUMP_M = lib.LUM_POSES_GAP_NS * 1e-9, 100.0


class Poses:
    """Where a sensor was over time, from a file or from arrays.

        poses = lumsdk.Poses("poses.txt")                      # TUM: t x y z qx qy qz qw; or CSV with a header
        poses = lumsdk.Poses("00.txt", times="times.txt")      # KITTI
        poses = lumsdk.Poses(times, matrices)                  # (n,) and (n, 4, 4), (n, 3, 4), or (n, 7) as TUM has them

    Times are whole numbers of nanoseconds, or floats of seconds; by the sensor's clock or since 1970 UTC. Between two
    poses the sensor moves along their screw. The exception says what is wrong in a file.
    """

    __slots__ = ("__weakref__", "_c", "_clock", "_count", "_limits", "_span", "files", "is_plain", "name")

    def __init__(self, source: Union[str, os.PathLike[str], Sequence[Time], Array], poses: Optional[ArrayLike] = None, *,
                 times: Union[str, os.PathLike[str], None] = None, clock: Optional[Clock] = None,
                 gap: float = _GAP_S, jump: float = _JUMP_M) -> None:
        """Read or take poses.

        Args:
            source: a file's name, or the times of arrays.
            poses: of arrays, one for each time.
            times: the file of times of KITTI.
            clock: "sensor" or "utc"; without it, times above 10^8 s are UTC.
            gap: seconds; times between two poses that are farther apart have no pose.
            jump: metres; the longest step from a pose to the next one, outside gaps and within 0.1 s.

        Raises:
            CaptureError: the file cannot be read, or its poses are invalid.
            OptionError: arrays or options are invalid.
        """
        if clock not in (None, *_CLOCKS):
            raise OptionError(f'clock is {clock!r}; use "sensor" or "utc"')
        if not isinstance(gap, _NUMBER) or not 1e-9 <= gap <= 1e9:
            raise OptionError(f"gap is {gap!r}; use seconds above 0, up to 1e9")
        if not isinstance(jump, _NUMBER) or not jump > 0:
            raise OptionError(f"jump is {jump!r}; use metres above 0, or math.inf")
        options = sized("lum_poses_options", clock=_CLOCKS.get(clock or "", lib.LUM_POSES_BY_SIZE), gap_ns=round(gap * 1e9),
                        jump_m=float(jump))
        made, error = ffi.new("lum_poses **"), ffi.new("lum_error *")
        if isinstance(source, (str, os.PathLike)):
            self.name, self.files = os.fsdecode(source), [os.fsdecode(file) for file in (source, times) if file is not None]
            if any("\0" in file for file in self.files):
                raise OptionError(f"a file's name is {self.files!r}; use one without the character 0")
            if poses is not None:
                raise OptionError("poses go with an array of times, and not with a file, which has its own")
            of_times = ffi.new("char[]", os.fsencode(times)) if times is not None else ffi.NULL
            check(lib.lum_poses_read(os.fsencode(source), of_times, options, made, error), error, CaptureError)
        else:
            self.name, self.files = "poses", []
            if times is not None or poses is None:
                raise OptionError("arrays are given as Poses(times, poses)")
            at, list_ = _arrays(source, poses)
            check(lib.lum_poses_new(ffi.cast("int64_t *", ffi.from_buffer(at)), ffi.cast("lum_pose *", ffi.from_buffer(list_)),
                                    len(at), options, made, error), error, OptionError)
        self._c = ffi.gc(made[0], lib.lum_poses_free)
        info = sized("lum_poses_info")
        lib.lum_poses_get_info(self._c, info)
        self._clock, self._count, self._limits = info.clock, info.count, (float(gap), float(jump))
        self._span = info.first_ns, info.last_ns
        self.is_plain = (gap, jump) == (_GAP_S, _JUMP_M) and (self.clock == "utc") == (info.first_ns > lib.LUM_POSES_UTC_NS)
        """Whether a file of them says all of it: there, gap and jump are the usual ones, and the clock is by the times' size."""

    def __len__(self) -> int:
        """How many there are."""
        return int(self._count)

    @property
    def clock(self) -> Clock:
        """By which clock times are: "sensor" or "utc"."""
        return "utc" if self._clock == lib.LUM_POSES_UTC else "sensor"

    @property
    def span(self) -> tuple[int, int]:
        """The times of the first and the last, in nanoseconds."""
        return self._span

    def _all(self) -> tuple[NDArray[np.int64], Doubles]:
        times, poses = np.empty(len(self), "i8"), np.empty((len(self), 7))
        time, pose = ffi.cast("int64_t *", ffi.from_buffer(times)), ffi.cast("lum_pose *", ffi.from_buffer(poses))
        for i in range(len(self)):
            lib.lum_poses_get(self._c, i, time + i, pose + i)
        return times, poses

    @property
    def times(self) -> NDArray[np.int64]:
        """Their times in nanoseconds: (n,) int64, a copy."""
        return self._all()[0]

    @property
    def tum(self) -> Doubles:
        """x y z qx qy qz qw of each: (n, 7) float64, a copy."""
        return self._all()[1]

    def at(self, time: Time, outside: Literal["raise", "nearest"] = "raise") -> Doubles:
        """The pose of a time: (4, 4), which takes points of the sensor, as columns, into the world.

        Args:
            time: an int in nanoseconds, or a float in seconds.
            outside: what to do with a time that has no pose: refuse it, or take the nearest one.
        """
        if outside not in ("raise", "nearest"):
            raise OptionError(f'outside is {outside!r}; use "raise" or "nearest"')
        time_ns = _nanoseconds(time)
        pose, rows = ffi.new("lum_pose *"), np.zeros((4, 4))
        place = lib.lum_poses_at(self._c, time_ns, ffi.NULL, pose)
        if place != lib.LUM_POSES_INSIDE and outside == "raise":
            where = "in a gap of the poses" if place == lib.LUM_POSES_IN_GAP else "outside of them"
            raise OptionError(f"{self.name}: {time_ns * 1e-9:.6f} s is {where}: they are from {self.span[0] * 1e-9:.6f} to "
                              f"{self.span[1] * 1e-9:.6f} s; outside=\"nearest\" takes the nearest")
        lib.lum_pose_matrix(pose, ffi.cast("double *", ffi.from_buffer(rows)))
        rows[3, 3] = 1.0
        return rows

    def to_text(self) -> str:
        """As save() writes them."""
        lines = ["# timestamp tx ty tz qx qy qz qw"]
        for time, pose in zip(*(column.tolist() for column in self._all())):
            sign, size = "-" if time < 0 else "", abs(time)
            lines.append(f"{sign}{size // 10**9}.{size % 10**9:09d} {' '.join(map(repr, pose))}")
        return "\n".join(lines) + "\n"

    def save(self, path: Union[str, os.PathLike[str]]) -> None:
        """Write them as TUM: seconds, x y z, qx qy qz qw. The file does not store clock, gap and jump."""
        with open(path, "w", encoding="ascii") as file:
            file.write(self.to_text())

    def origin(self) -> Optional[tuple[float, float, float]]:
        """What to subtract from world coordinates so that float32 can hold them, in whole kilometres; None: nothing is beyond 5 km."""
        out = ffi.new("double [3]")
        return tuple(out) if lib.lum_poses_origin(self._c, out) else None

    def __eq__(self, other: object) -> bool:
        """Whether times, poses, clock, gap and jump are the same; quaternions down to the last digit of a float64 but one."""
        if not isinstance(other, Poses):
            return NotImplemented
        if (self._count, self._span, self._clock, self._limits) != (other._count, other._span, other._clock, other._limits):
            return False
        (times, poses), (others, theirs) = self._all(), other._all()
        return (np.array_equal(times, others) and np.array_equal(poses[:, :3], theirs[:, :3])
                and bool((np.abs(poses[:, 3:] - theirs[:, 3:]) < _ROUNDING).all()))

    def __hash__(self) -> int:
        return hash((self._count, self._span, self._clock, self._limits))

    def __reduce__(self) -> tuple[Any, ...]:
        return _restore, (*self._all(), self.clock, self._limits, self.name, self.files)

    def __repr__(self) -> str:
        return f"<Poses {self.name}: {len(self)}, {self.span[0] * 1e-9:.3f} to {self.span[1] * 1e-9:.3f} s, {self.clock}>"


def _restore(times: Array, poses: Array, clock: Clock, limits: tuple[float, float], name: str,
             files: list[str]) -> Poses:
    made = Poses(times, poses, clock=clock, gap=limits[0], jump=limits[1])
    made.name, made.files = name, files
    return made


def _nanoseconds(time: Any) -> int:
    if isinstance(time, (int, np.integer)) and not isinstance(time, bool) and abs(int(time)) < 2 ** 63:
        return int(time)
    if isinstance(time, (float, np.floating)) and abs(float(time)) < 4e9:
        return round(float(time) * 1e9)
    raise OptionError(f"a time is {time!r}; use an int of nanoseconds, below 2^63, or a float of seconds, below 4e9")


def _arrays(times: Any, poses: Any) -> tuple[Array, Array]:
    """Times in nanoseconds, and x y z qx qy qz qw."""
    try:
        at, given = np.asarray(times), np.asarray(poses, "f8")
    except (TypeError, ValueError) as error:
        raise OptionError(f"times and poses are arrays of numbers: {error}") from error
    if at.ndim != 1 or at.dtype.kind not in "iuf" or not len(at):
        raise OptionError(f"times have the shape {at.shape} of {at.dtype}; use (n,), n from 1, of ints in nanoseconds or "
                          "floats in seconds")
    if at.dtype.kind == "f":
        if not np.all(np.abs(at) < 4e9):
            raise OptionError("times as floats are seconds, and one is not finite or above 4e9; nanoseconds are given as ints")
        at = np.round(at.astype("f8") * 1e9)
    elif at.dtype.kind == "u" and at.max() >= 2 ** 63:
        raise OptionError(f"a time is {at.max()} ns; use times below 2^63")
    if given.shape not in ((len(at), 7), (len(at), 4, 4), (len(at), 3, 4)):
        raise OptionError(f"poses have the shape {given.shape}; for {len(at)} times use ({len(at)}, 4, 4), "
                          f"({len(at)}, 3, 4), or ({len(at)}, 7) with x y z qx qy qz qw")
    return np.ascontiguousarray(at, "i8"), np.ascontiguousarray(given if given.ndim == 2 else _of_matrices(given))


def _of_matrices(given: Array) -> Array:
    """Each by the largest of its four numbers, so that nothing vanishes."""
    m = given[:, :3, :3]
    wrong = ~(np.abs(m @ m.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2)) <= _UNIT_ERROR) | ~(np.linalg.det(m) > 0)
    if wrong.any():
        raise OptionError(f"pose {int(wrong.argmax())} has no rotation in its first three columns; use "
                          "right-handed rows of length 1, square to each other")
    xx, yy, zz = m[:, 0, 0], m[:, 1, 1], m[:, 2, 2]
    four = np.empty((len(m), 4, 4))
    four[:, 0, 0], four[:, 1, 1], four[:, 2, 2] = 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz
    four[:, 3, 3] = 1 + xx + yy + zz
    for i, j, value in ((0, 1, m[:, 0, 1] + m[:, 1, 0]), (0, 2, m[:, 0, 2] + m[:, 2, 0]), (1, 2, m[:, 1, 2] + m[:, 2, 1]),
                        (0, 3, m[:, 2, 1] - m[:, 1, 2]), (1, 3, m[:, 0, 2] - m[:, 2, 0]), (2, 3, m[:, 1, 0] - m[:, 0, 1])):
        four[:, i, j] = four[:, j, i] = value
    best = np.diagonal(four, axis1=1, axis2=2).argmax(axis=1)
    rows = four[np.arange(len(m)), best]
    return np.hstack([given[:, :3, 3], rows / np.linalg.norm(rows, axis=1, keepdims=True)])


def _origin(given: Any) -> list[float]:
    """What is subtracted from the world; None: nothing."""
    try:
        made = np.zeros(3) if given is None else np.asarray(given, "f8")
    except (TypeError, ValueError):
        made = np.zeros(0)
    if made.shape != (3,) or not np.isfinite(made).all():
        raise OptionError(f"origin is {given!r}; use x, y and z in metres, three finite numbers")
    return list(made.tolist())


def _pointer(array: Array) -> Any:
    return ffi.cast("float *", ffi.from_buffer(array))


def _moments(info: Info, poses: Poses, to: str) -> tuple[int, int]:
    """The start of the frame and the moment that it is moved to, by the poses' clock."""
    if not info.begin_utc_ns:
        raise CaptureError("the frame has no clock: its profile has no timestamp, so its points have no poses; "
                           "use a profile with the field timestamp, or for Frame.from_arrays() utc_ns=")
    begin = info.begin_utc_ns if poses.clock == "utc" else info.begin_clock_us * 1000
    half = (info.end_clock_us - info.begin_clock_us) * 1000 // 2 if to == "middle" else 0
    return begin, begin + half


def _why(frame: Frame, poses: Poses, counts: Any, begin_ns: int) -> str:
    """The points that have no pose; "" if all have one."""
    without: dict[str, int] = {name: getattr(counts, name) for name, _ in _CAUSES}
    total = sum(without.values())
    if not total:
        return ""
    if total == counts.points:
        error = ffi.new("lum_error *")
        end_ns = begin_ns + round(frame.duration * 1e9)
        if lib.lum_poses_check_span(poses._c, os.fsencode(poses.name), begin_ns, end_ns, error) != 0:
            return f"frame {frame.number}: {text(error.text)}"
    return (f"frame {frame.number}: {total} of {counts.points} points have no pose: "
            + ", ".join(f"{without[name]} {cause}" for name, cause in _CAUSES if without[name]))


def of_several(poses: Poses) -> OptionError:
    """The refusal of poses by one sensor's clock for several sensors."""
    return OptionError(f"poses: {poses.name} has times of a sensor's clock, and each sensor has another: give poses with times of "
                       "UTC, or choose one sensor by sensor=")


def _check_frame(frame: Frame, poses: Poses) -> None:
    if frame._moved:
        raise OptionError(f"frame {frame.number}: its points were moved already, to "
                          f"{_MOVED[frame._moved]}: take the frame as it was read")
    if frame._info.member == JOINED and poses.clock != "utc":
        raise of_several(poses)
    lacking = tuple(name for name in Motion.needs if name not in frame)
    if lacking:
        raise UnknownKeyError(f"the frame has no column {', '.join(lacking)}, which moving points needs: open its source with "
                              f'columns="{",".join((*frame.columns, *lacking))}", or "all"')


def move(frame: Frame, poses: Poses, to: str, origin: Union[Sequence[float], Array, None] = None,
         outside: Outside = "nan") -> Frame:
    """A frame with its points moved; its other columns are those of the frame."""
    if not isinstance(poses, Poses):
        raise TypeError(f"poses are {type(poses).__name__}; use lumsdk.Poses, such as lumsdk.Poses(\"poses.txt\")")
    _check_frame(frame, poses)
    if to not in MOMENTS:
        raise OptionError(f"to is {to!r}; use one of {', '.join(_TO)}")
    if outside not in _OUTSIDE:
        raise OptionError(f"outside is {outside!r}; use one of {', '.join(_OUTSIDE)}")
    x, y, z, time = (np.ascontiguousarray(frame[name], "f4") for name in ("x", "y", "z", "time"))
    if to == "world" and origin is None and poses.origin() is not None:
        warn(f"{poses.name}: the poses are farther than 5 km from 0, where float32 loses more than half a millimetre: give "
             f"origin={poses.origin()}, or another one")
    options = sized("lum_move_options", poses=poses._c, to=_TO[to], clamps=outside == "nearest",
                    origin=_origin(origin))
    block, counts, error = np.empty((3, len(frame)), "f4"), ffi.new("lum_move_counts *"), ffi.new("lum_error *")
    if len(frame):
        begin, start = _moments(frame._info, poses, to)
        points = sized("lum_move_points", x=_pointer(x), y=_pointer(y), z=_pointer(z), time=_pointer(time), count=len(frame),
                       begin_ns=begin, start_ns=start)
        check(lib.lum_points_move(points, options, *(_pointer(row) for row in block), counts, error), error, Error)
        told = _why(frame, poses, counts, begin)
        if told and outside == "raise":
            raise CaptureError(told)
        if told:
            warn(told + ("; the nearest pose moved them" if outside == "nearest" else "; they are NaN"))
    return assemble(frame._info, frame.to_dict(), frame.lines, to, block.T, frame._raw)


def _without_missing(frame: Frame) -> Frame:
    """Without points that are NaN."""
    kept = ~np.isnan(frame["x"])
    return frame if kept.all() else select(frame, kept)


class Motion:
    """Moves the frames of a file, and counts the points without a pose, as lumdump does."""

    needs = ("x", "y", "z", "time")

    def __init__(self, poses: Union[Poses, str, os.PathLike[str]], times: Union[str, os.PathLike[str], None], to: str,
                 bare: str = "") -> None:
        """Begin; bare is the format of an output that cannot say what an origin is, or ""."""
        self.poses = poses if isinstance(poses, Poses) else Poses(poses, times=times)
        self._to = to
        self._sensor = ""
        self.points = self.without = 0
        far = self.poses.origin() if to == "world" else None
        self.origin = np.array(far or (0.0, 0.0, 0.0))
        """What is subtracted from the world's coordinates."""
        self.notes = ["origin=" + ",".join(f"{value:.0f}" for value in self.origin)] if far else []
        if far and bare:
            raise OptionError(f"{self.poses.name}: the poses are farther than 5 km from 0, so x, y and z are relative to the "
                              f"{self.notes[0]}, and nothing in a file of {bare} would say so: give "
                              + ("comments=True" if bare in ("csv", "xyz") else "poses that are near 0")
                              + ", or write las, ply, pcd, parquet or npz")
        if far:
            warn(f"the poses are farther than 5 km from 0: x, y and z are relative to the {self.notes[0]}, which the file names "
                 "too, where it says where its points come from")

    def move(self, frame: Frame) -> Frame:
        """The points of a frame that have a pose."""
        self._sensor = self._sensor or frame.sensor
        if frame.sensor != self._sensor and self.poses.clock != "utc":
            raise of_several(self.poses)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", CaptureWarning)
            moved = _without_missing(move(frame, self.poses, self._to, self.origin if self._to == "world" else None))
        self.points += len(frame)
        self.without += len(frame) - len(moved)
        return moved

    def finish(self) -> None:
        """Raises CaptureError if no point has a pose; warns if some have none."""
        if not self.without:
            return
        told = f"{self.poses.name}: {self.without} of {self.points} points have no pose"
        if self.without == self.points:
            begin, end = (time * 1e-9 for time in self.poses.span)
            raise CaptureError(f"{told}: the poses are from {begin:.3f} to {end:.3f} s, {self.poses.clock}; are they "
                               "from another drive?")
        warn(f"{told} and are left out")
