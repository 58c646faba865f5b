"""A frame: all points of one sweep of one sensor, as arrays."""
from __future__ import annotations

import dataclasses
import datetime
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, Optional, Union

import numpy as np

from . import _image
from ._c import address_of, ffi, lib, sized, text
from ._errors import OptionError, UnknownKeyError, warn
from ._raw import RAW_COLUMNS, Raw, attach
from ._raw import of as raw_of
from ._settings import Profile

if TYPE_CHECKING:
    import pandas  # type: ignore[import-untyped,unused-ignore]
    import pyarrow  # type: ignore[import-untyped,unused-ignore]
    from typing_extensions import Literal

    from ._poses import Outside, Poses
    from ._project import Projection
    from ._rig import RigSensor
    from ._write import Line

    Array = np.ndarray[Any, np.dtype[Any]]

_TYPES: dict[int, np.dtype[Any]] = {lib.LUM_TYPE_FLOAT: np.dtype("f4"), lib.LUM_TYPE_UINT32: np.dtype("u4"),
          lib.LUM_TYPE_UINT16: np.dtype("u2"), lib.LUM_TYPE_UINT8: np.dtype("u1")}

_NUMBERS: dict[str, int] = {text(lib.lum_column_name(c)): c for c in range(lib.LUM_COLUMN_COUNT)}

COLUMNS: Mapping[str, np.dtype[Any]] = MappingProxyType(
    {name: _TYPES[lib.lum_column_get_type(c)] for name, c in _NUMBERS.items()})
"""Every column that a frame can have, and the type of its numbers."""

EYES = ("blue", "green")

JOINED = -1
"""In place of a member of a rig: points of several."""

PIXELS = int(lib.LUM_LINE_PIXELS)

LINE_DTYPE = np.dtype([("number", "u4"), ("eye", "u1"), ("first_point", "u4"), ("point_count", "u4"),
                       ("angle_count", "u2"), ("lost_words", "u4"), ("clock_us", "i8"), ("arrival_ns", "i8")])
"""The fields of Frame.lines."""

_FLOAT = np.dtype("f4")

_EPOCH = datetime.datetime(1970, 1, 1, tzinfo=datetime.timezone.utc)


class _Memory:
    """Memory of a frame, which keeps the frame alive: the base of every array of it."""

    __slots__ = ("__array_interface__", "owner")

    def __init__(self, owner: Any, address: int, shape: tuple[int, ...], strides: Optional[tuple[int, ...]],
                 dtype: np.dtype[Any]) -> None:
        self.owner = owner
        self.__array_interface__ = {"version": 3, "data": (address, False), "shape": shape, "strides": strides,
                                    "typestr": dtype.str}


def _c_lines() -> np.dtype[Any]:
    """The layout of lum_frame_line, which is filled in C."""
    fields = [name for name, _ in ffi.typeof("lum_frame_line").fields]
    types = {"struct_size": np.dtype(f"u{ffi.sizeof('size_t')}")}
    types.update({name: np.dtype(LINE_DTYPE[name]) for name in LINE_DTYPE.names or ()})
    return np.dtype({"names": fields, "formats": [types[name] for name in fields],
                     "offsets": [ffi.offsetof("lum_frame_line", name) for name in fields],
                     "itemsize": ffi.sizeof("lum_frame_line")})


_C_LINES = _c_lines()


class Member(NamedTuple):
    """A sensor of a rig that is read."""

    place: int
    """In the rig, from 0."""
    sensor: RigSensor


@dataclasses.dataclass
class _Info:
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

    @classmethod
    def of(cls, frame: Any, members: Sequence[Member]) -> _Info:
        """That of a frame of the library."""
        i = sized("lum_frame_info")
        lib.lum_frame_get_info(frame, i)
        losses = {"lost_words": i.lost_words, "lines_missing_angles": i.lines_missing_angles,
                  "lines_missing": sum(i.lines_missing), "lines_in_pauses": i.lines_in_pauses, "lines_cut": i.lines_cut,
                  "lines_late": i.lines_late,
                  "points_cut": i.points_cut, "no_angle": i.losses.no_angle, "no_range": i.losses.no_range}
        values = {name: getattr(i.times if name.endswith(("_us", "_ns")) else i, name) for name in list(cls.__annotations__)[:12]}
        values.update(interface=text(i.sensor_interface), lines=tuple(i.lines), losses=losses,
                      rows=tuple(lib.lum_frame_rows(frame, eye) for eye in range(len(EYES))))
        if members and i.member:
            place, sensor = members[i.member - 1]
            values.update(member=place + 1, name=sensor.name, pose=tuple(map(tuple, sensor.pose.tolist())))
        return cls(**values)


class Frame:
    """All points of one sweep of one sensor.

    ``frame["range"]`` is a column, one value a point; ``frame.columns`` names them. Points are in the order of their
    lines. Arrays are views of the frame's memory, nothing is copied; they stay valid after the frame and after its
    source. A frame can be pickled: what comes back has the same values in memory of its own.
    """

    __slots__ = ("__weakref__", "_arrays", "_c", "_count", "_info_made", "_lines_made", "_members", "_moved", "_raw")

    def __init__(self, pointer: Any, members: Sequence[Member] = ()) -> None:
        """Keep a frame of the library. Programs get frames from a source or a sensor."""
        self._members = members
        self._c = ffi.gc(lib.lum_frame_keep(pointer), lib.lum_frame_release)
        self._count: int = lib.lum_frame_count(self._c)
        self._arrays: dict[str, Array] = {}
        self._info_made: Optional[_Info] = None
        self._lines_made: Optional[Array] = None
        self._raw: Optional[Raw] = None
        self._moved = ""  # to where its points were moved; "": they are as the sensor saw them

    # What is known of it as a whole.

    @property
    def _info(self) -> _Info:
        if self._info_made is None:
            self._info_made = _Info.of(self._c, self._members)
        return self._info_made

    @property
    def number(self) -> int:
        """The frame's number."""
        return self._info.number

    @property
    def sensor(self) -> str:
        """The name of its sensor: that of the rig, such as "front", or without a rig its address, such as "10.42.0.37".

        If another sensor with that address came before, its interface is behind it: "10.42.0.37%eth1".
        """
        if self._info.name:
            return self._info.name
        interface = self._info.interface
        return address_of(self._info.sensor) + (f"%{interface}" if interface else "")

    @property
    def pose(self) -> Optional[Array]:
        """Where its sensor is on the vehicle, by the rig: (4, 4) float64, which takes points of the sensor, as columns, into
        the vehicle's frame. x, y and z are in the vehicle's frame already. None: it was read without a rig, or it has the
        points of several sensors."""
        return None if self._info.pose is None else np.array(self._info.pose)

    @property
    def complete(self) -> bool:
        """Whether nothing of it is known to be missing."""
        return self._info.is_complete

    @property
    def paused(self) -> bool:
        """Whether the sensor, or one of its eyes, paused inside it: it lacks lines, or has a part of another sweep."""
        return self._info.has_pause

    @property
    def first(self) -> bool:
        """Whether it is the first of its sensor. It was under way when the recording began, and may lack its start."""
        return self._info.is_first

    @property
    def last(self) -> bool:
        """Whether the recording ended with it. It may lack its end."""
        return self._info.is_last

    @property
    def utc_ns(self) -> int:
        """When its earliest line was measured, in nanoseconds since 1970 UTC.

        It is the sensor's clock converted to UTC by a fit to the arrival times of the packets. Where the profile has
        no timestamp, it is the arrival of that line, and utc_error_ns is None.
        """
        return self._info.begin_utc_ns or self._info.begin_arrival_ns

    @property
    def utc_error_ns(self) -> Optional[int]:
        """The estimated error of utc_ns in both directions.

        None: not known, since the profile has no clock, the host's clock was stepped nearby, or its stamps stand still.
        """
        error_ns = self._info.utc_error_ns
        return error_ns if self._info.begin_utc_ns and error_ns != lib.LUM_CLOCK_ERROR_UNKNOWN else None

    @property
    def time(self) -> datetime.datetime:
        """utc_ns as a datetime in UTC, down to the microsecond."""
        return _EPOCH + datetime.timedelta(microseconds=self.utc_ns // 1000)

    @property
    def duration(self) -> float:
        """Seconds from its earliest line to its latest, on the sensor's clock."""
        return (self._info.end_clock_us - self._info.begin_clock_us) * 1e-6

    @property
    def losses(self) -> dict[str, int]:
        """What is missing in it, by cause, with lumdump's names.

        no_range counts words without a range above zero, which are no damage. lines_late are lines of earlier
        frames that came after theirs had been handed out.
        """
        return dict(self._info.losses)

    @property
    def info(self) -> dict[str, Any]:
        """All that is known of it as a whole: numbers, clocks, lines of both eyes, and what losses has."""
        values = {**vars(self._info)}
        losses = values.pop("losses")
        for name in ("interface", "member", "name", "pose"):
            del values[name]
        values["utc_error_ns"] = self.utc_error_ns
        values["sensor"] = self.sensor
        for name in ("lines", "rows"):
            both = values.pop(name)
            values.update({f"{name}_{eye}": both[i] for i, eye in enumerate(EYES)})
        return {**values, "points": self._count, **losses}

    # Its arrays.

    def __len__(self) -> int:
        """How many points it has."""
        return self._count

    def __bool__(self) -> bool:
        """A frame is one, even without a point."""
        return True

    @property
    def columns(self) -> tuple[str, ...]:
        """The names of its columns, as open(columns=...) chose them."""
        if self._c is None:
            return tuple(name for name in (*_NUMBERS, *RAW_COLUMNS) if name in self._arrays)
        mask = lib.lum_frame_columns(self._c)
        return tuple(name for name, c in _NUMBERS.items() if mask >> c & 1)

    def _refuse(self, name: object) -> UnknownKeyError:
        if name in COLUMNS:
            return UnknownKeyError(f"the frame has no column {name!r}: name it in columns= when the source is opened, or "
                                   f'say columns="all"; it has {", ".join(self.columns) or "none"}')
        return UnknownKeyError(f"there is no column {name!r}; there are {', '.join(COLUMNS)}")

    def __getitem__(self, name: str) -> Array:
        """A column: (n,), of the type that COLUMNS tells. A view of the frame's memory."""
        try:
            return self._arrays[name]
        except (KeyError, TypeError):
            pass
        if not isinstance(name, str):
            raise TypeError(f"frame[...] takes a column's name, not {type(name).__name__}; points are taken from columns, as "
                            'frame["x"][mask], from frame.xyz[mask], or with all columns from frame.to_structured()[mask]')
        if self._c is None or name not in _NUMBERS:
            raise self._refuse(name)
        address = int(ffi.cast("uintptr_t", lib.lum_frame_column(self._c, _NUMBERS[name])))
        if not address:
            raise self._refuse(name)
        made = np.asarray(_Memory(self._c, address, (self._count,), None, COLUMNS[name]))
        self._arrays[name] = made
        return made

    def __contains__(self, name: object) -> bool:
        """Whether it has a column."""
        return name in self.columns

    def __iter__(self) -> Iterator[str]:
        """The names of its columns, as of a dictionary."""
        return iter(self.columns)

    def keys(self) -> tuple[str, ...]:
        """The names of its columns: with this, dict(frame) works."""
        return self.columns

    @property
    def xyz(self) -> Array:
        """x, y and z in metres: (n, 3) float32, a view of the frame's memory. x forward, y left, z up."""
        if "xyz" not in self._arrays:
            self._arrays["xyz"] = self._make_xyz()
        return self._arrays["xyz"]

    def _make_xyz(self) -> Array:
        if self._c is not None:
            spacing = ffi.new("size_t *")
            first = lib.lum_frame_xyz(self._c, spacing)
            if first:
                address = int(ffi.cast("uintptr_t", first))
                return np.asarray(_Memory(self._c, address, (self._count, 3), (4, 4 * max(spacing[0], 1)), _FLOAT))
        block = np.empty((3, self._count), "f4")
        for i, name in enumerate("xyz"):
            block[i] = self[name]
        return block.T

    @property
    def lines(self) -> Array:
        """Its lines, in the order in which they were complete: a structured array.

        number, eye (0 blue, 1 green), first_point and point_count (its points are those from first_point on),
        angle_count (pixels with angles, of 1000), lost_words, clock_us (the sensor's clock), arrival_ns (since 1970).
        """
        if self._lines_made is None:
            made = np.zeros(lib.lum_frame_line_count(self._c), _C_LINES)
            made["struct_size"] = _C_LINES.itemsize
            if len(made):
                first = ffi.cast("lum_frame_line *", ffi.from_buffer(made))
                get, frame = lib.lum_frame_get_line, self._c
                for i in range(len(made)):
                    get(frame, i, first + i)
            out = np.empty(len(made), LINE_DTYPE)
            for name in LINE_DTYPE.names or ():
                out[name] = made[name]
            self._lines_made = out
        return self._lines_made

    def _eye(self, eye: Union[str, int, None]) -> int:
        if eye is None:
            present = [i for i, count in enumerate(self._info.lines) if count]
            if len(present) > 1:
                raise ValueError('the frame has lines of both eyes: use eye="blue" or eye="green"')
            return present[0] if present else 0
        if isinstance(eye, str) and eye in EYES:
            return EYES.index(eye)
        raise ValueError(f'eye is {eye!r}; right is "blue" or "green"')

    def grid(self, column: str, eye: Union[str, None] = None, returns: int = 1, lines: Optional[int] = None) -> Array:
        """A column as a grid: (lines, 1000) float32, or (lines, 1000, returns) where returns is above 1.

        "xyz" gives all three coordinates: (lines, 1000, 3), or (lines, 1000, returns, 3).

        Cells without a point are NaN. Cell [line, pixel, k] is the k-th point of that pixel among those of the frame.
        Needs the column "pixel". eye may be left out where the frame has lines of one eye alone. lines is the
        number of rows; without it, there are as many as the line numbers of this eye show, by those that can be
        believed: a damaged packet can claim any. A warning says which lines with points have no row.
        """
        if self._info.member == JOINED:
            raise OptionError(f"the frame has points of several sensors, {self.sensor}, whose lines have the same numbers; a grid is "
                              "of the frame of one")
        which = self._eye(eye)
        if column == "xyz":
            return np.stack([self.grid(name, eye, returns, lines) for name in column], axis=-1)
        if column not in self.columns:
            raise self._refuse(column)
        if "pixel" not in self.columns:
            raise self._refuse("pixel")
        rows = self._believed_rows(which) if lines is None else _count(lines, "lines")
        if _count(returns, "returns") < 1:
            raise ValueError("returns is 0; right is a whole number from 1")
        out = np.empty((rows, PIXELS, returns), "f4")
        if self._c is None:
            self._fill(column, which, out)
        elif out.size:
            lib.lum_frame_grid_floats(self._c, _NUMBERS[column], which, rows, returns,
                                      ffi.cast("float *", ffi.from_buffer(out)))
        return out if returns > 1 else out[:, :, 0]

    def _believed_rows(self, eye: int) -> int:
        rows = self._info.rows[eye]
        beyond = self.lines[(self.lines["eye"] == eye) & (self.lines["number"] >= rows) & (self.lines["point_count"] > 0)]
        if len(beyond):
            numbers = ", ".join(str(number) for number in beyond["number"][:3])
            warn(f"frame {self.number}: lines of the {EYES[eye]} eye without a row in the grid: {len(beyond)}, with "
                 f"{beyond['point_count'].sum()} points: numbers as far from those of whole lines as {numbers} come from "
                 "damaged packets; lines= sets how many rows there are")
        return rows

    def _fill(self, column: str, eye: int, out: Array) -> None:
        """As lum_frame_grid_floats(), of arrays."""
        out.fill(np.nan)
        rows, _, returns = out.shape
        seen = set()
        for line in self.lines:
            number = int(line["number"])
            if line["eye"] != eye or number >= rows or number in seen:
                continue
            seen.add(number)
            part = slice(int(line["first_point"]), int(line["first_point"]) + int(line["point_count"]))
            pixels = self["pixel"][part].astype(np.intp)
            if not len(pixels):
                continue
            starts = np.r_[True, pixels[1:] != pixels[:-1]]
            indices = np.arange(len(pixels))
            rank = indices - np.maximum.accumulate(np.where(starts, indices, 0))
            kept = rank < returns
            out[number, pixels[kept], rank[kept]] = self[column][part][kept]

    # What it was made of.

    @property
    def angles(self) -> Array:
        """The raw angles of its lines, azimuth and elevation of each pixel: (lines, 1000, 2) int16. Of open(raw=True)."""
        return raw_of(self).angles

    @property
    def has_angles(self) -> Array:
        """Which pixels of its lines have angles: (lines, 1000) bool; the others are 0 in angles. Of open(raw=True)."""
        return raw_of(self).has_angles()

    @property
    def packets(self) -> Array:
        """The packets that its lines were made of, a structured array. Of open(raw=True).

        line (its place in frame.lines), tag (2 angles, 3 ranges), first_sample_index, num_samples, bad_words (of these, words that
        were skipped), clock_raw (ticks as sent), arrival_ns, order (in which packets were accepted). A line has all that were
        accepted; or none, where not all are known: after a seek, if it began before the place where reading went on.
        """
        return raw_of(self).packets

    @property
    def profile(self) -> Profile:
        """The profile that it was read with. Of open(raw=True)."""
        origin = raw_of(self).origin
        return Profile() if origin is None else origin.profile

    def with_raw(self, angles: Any, has_angles: Any = None, packets: Any = None, profile: Any = None) -> Frame:
        """The frame with other angles and packets, for write_capture().

        Args:
            angles: as the property has them, for the lines of this frame.
            has_angles: likewise; without it, all pixels have angles.
            packets: likewise; without them, lines are cut as the sensor does it.
            profile: of the clocks of these packets; without it, that which the frame has.
        """
        made = _restore(vars(self._info), self.to_dict(), self.lines, self._moved)
        made._raw = attach(self, angles, has_angles, packets, profile)
        return made

    def to_lines(self) -> list[Line]:
        """Its lines as values, in copies. Of open(raw=True)."""
        from ._write import to_lines

        return to_lines(self)

    # The sensor's motion.

    def deskew(self, poses: Poses, to: Literal["start", "middle"] = "start", outside: Outside = "nan") -> Frame:
        """The frame as if the sensor had stood still: each point is moved by the sensor's motion since, or until, a moment.

        Args:
            poses: where the sensor was.
            to: the moment: when the frame began, or halfway between its earliest and its latest line.
            outside: what becomes of points whose time has no pose: "nan", and a warning tells how many; "nearest" moves them
                by the nearest pose; "raise" refuses the frame.

        Returns:
            A frame with the same columns, where x, y and z are moved. Needs the columns x, y, z and time. A frame that was
            moved is not moved again.
        """
        from ._poses import move

        if to not in ("start", "middle"):
            raise ValueError(f'to is {to!r}; right is "start" or "middle"; frame.to_world() moves into the world')
        return move(self, poses, to, None, outside)

    def to_world(self, poses: Poses, origin: Optional[Sequence[float]] = None, outside: Outside = "nan") -> Frame:
        """The frame in the poses' fixed frame, each point by the pose of its own time.

        Args:
            poses: where the sensor was.
            origin: x, y, z in metres, which is subtracted: float32 loses more than half a millimetre farther than 5 km from 0.
                Without one a warning tells that, and poses.origin() is one.
            outside: as deskew() has it.

        Returns:
            A frame as deskew() returns it.
        """
        from ._poses import move

        return move(self, poses, "world", origin, outside)

    # Pictures.

    def image(self, column: str, eye: str = "both", returns: str = "nearest", *, view: Optional[Sequence[float]] = None,
              rows: Optional[int] = None, columns: Optional[int] = None) -> Array:
        """A column as a picture that lies as the world does: (rows, columns) float32, NaN where there is no point.

        Rows are elevations, from the highest down, and columns are azimuths, from left to right as one looks forward, both
        seen from the sensor's origin. Raw lines, as of grid(), bend and alternate in direction; here a straight edge is
        straight. "xyz" gives all three coordinates: (rows, columns, 3).

        Args:
            column: The name of a column, or "xyz".
            eye: "blue" (it looks right), "green" (left), or "both" as one picture of 120 degrees.
            returns: Which of the points that lie in a pixel fills it: "nearest", "farthest", "strongest" (the widest pulse;
                needs the column "pulse_width"), "first" or "last" in the frame.
            view: Degrees at the left, right, top and bottom edge. (60, -60, 3, -17) for both eyes, without it; green ends
                and blue begins at 0. A warning says how many points lie outside.
            rows: Without it, as many as the lines, rounded up to a multiple of 64.
            columns: 800 for an eye and 1600 for both, without it.
        """
        for name in column if column == "xyz" else [column]:
            if name not in self.columns:
                raise self._refuse(name)
        index = self.image_index(eye, returns, view=view, rows=rows, columns=columns)
        if column == "xyz":
            return np.stack([_image.take(self, name, index) for name in column], axis=-1)
        return _image.take(self, column, index)

    def image_index(self, eye: str = "both", returns: str = "nearest", *, view: Optional[Sequence[float]] = None,
                    rows: Optional[int] = None, columns: Optional[int] = None) -> Array:
        """Which point fills each pixel of image(): (rows, columns) int32, -1 for none.

        ``index[mask]`` are the points that fill the pixels of a mask, with -1 for empty ones. All points that lie in
        them, also those that lost their pixel to another one, are found by image_pixels().
        """
        return _image.index(self, eye, returns, view, rows, columns, pixels=False)

    def image_pixels(self, eye: str = "both", *, view: Optional[Sequence[float]] = None, rows: Optional[int] = None,
                     columns: Optional[int] = None) -> Array:
        """In which pixel of image() each point lies, whether it fills it or not: (n,) int32, row x columns + column.

        -1: it lies outside, or is of another eye. So ``(pixels >= 0) & mask.ravel()[pixels]`` are all points in a mask.
        """
        return _image.index(self, eye, "nearest", view, rows, columns, pixels=True)

    # In a camera's picture.

    def project(self, K: Any, T: Any, distortion: Optional[Sequence[float]] = None,
                size: Optional[tuple[int, int]] = None) -> Projection:
        """Where its points are in a camera's picture.

            seen = frame.project(K, T, distortion=(k1, k2, p1, p2, k3), size=(1920, 1080))
            draw(seen.pixels[seen.visible], seen.depth[seen.visible])

        A frame that was taken while the sensor moved is put right first: frame.deskew(poses).project(...).

        Args:
            K: the camera's matrix, [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], in pixels.
            T: what takes points of the sensor, or with a rig of the vehicle, as columns, into the camera's frame, which OpenCV
                has with x to the right, y downwards and z forward: (4, 4) or (3, 4).
            distortion: k1 k2 p1 p2 [k3 [k4 k5 k6]], as OpenCV has them.
            size: (width, height) of the picture; without it, all points in front of the camera are visible.

        Returns:
            pixels, depth and visible, in the order of the points. Where the distortion would bring points from far outside back
            into the picture, they are not visible.

        Raises:
            OptionError: a matrix, the distortion or the size is not right.
        """
        from ._project import project

        return project(self.xyz, K, T, distortion, size)

    # Into other forms.

    def __array__(self, *_: Any, **__: Any) -> Array:
        """A frame is several columns: each way to make one array or table of them has a name."""
        raise TypeError("a frame is not a single array: frame.xyz has the coordinates, (n, 3), frame.to_structured() all columns, "
                        'frame["x"] one of them, and frame.to_pandas() and frame.to_arrow() make a table')

    def to_dict(self) -> dict[str, Array]:
        """Its columns by their names, as views."""
        return {name: self[name] for name in self.columns}

    def to_structured(self) -> Array:
        """A copy as a structured array: (n,), with a field for each column."""
        names = self.columns
        out = np.empty(self._count, np.dtype([(name, self[name].dtype) for name in names]))
        for name in names:
            out[name] = self[name]
        return out

    def to_arrow(self, **options: Any) -> pyarrow.Table:
        """As a table of Arrow, without a copy where Arrow has the type. Needs pyarrow."""
        from ._table import to_arrow

        return to_arrow(self, **options)

    def to_pandas(self, **options: Any) -> pandas.DataFrame:
        """As a DataFrame. Needs pandas."""
        from ._table import to_pandas

        return to_pandas(self, **options)

    def _repr_html_(self) -> Optional[str]:
        """In a notebook: its range images, if matplotlib is there."""
        try:
            from ._notebook import to_html
        except ImportError:
            return None
        made: Optional[str] = to_html(self)
        return made

    # As a value.

    def __repr__(self) -> str:
        info = self._info
        state = "complete" if info.is_complete else "incomplete"
        lines = ", ".join(f"{count} {eye}" for eye, count in zip(EYES, info.lines))
        return f"<Frame {info.number} of {self.sensor}: {self._count} points, lines {lines}, {state}>"

    def __eq__(self, other: object) -> bool:
        """Whether all columns, lines and clocks are the same, bit by bit."""
        if not isinstance(other, Frame):
            return NotImplemented
        return (self.columns == other.columns and self._info == other._info
                and np.array_equal(self.lines, other.lines)
                and all(self[name].tobytes() == other[name].tobytes() for name in self.columns))

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self) -> tuple[Any, ...]:
        return _restore, (vars(self._info), self.to_dict(), self.lines, self._moved, self._raw)


def _count(value: Any, name: str) -> int:
    """A whole number from 0 on."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise TypeError(f"{name} is {value!r}; right is a whole number")
    if value < 0:
        raise ValueError(f"{name} is {value}; right is a whole number from 0")
    return int(value)


def _restore(info: Mapping[str, Any], arrays: Mapping[str, Array], lines: Array, moved: str = "",
             raw: Optional[Raw] = None) -> Frame:
    """A frame of values, in memory of its own."""
    made = Frame.__new__(Frame)
    made._c, made._members = None, ()
    made._info_made = _Info(**info)
    made._lines_made = lines
    made._moved = moved
    made._raw = raw
    made._arrays = dict(arrays)
    made._count = len(next(iter(arrays.values()))) if arrays else 0
    if all(name in arrays for name in "xyz"):
        block = np.empty((3, made._count), "f4")
        for i, name in enumerate("xyz"):
            block[i] = arrays[name]
            made._arrays[name] = block[i]
        made._arrays["xyz"] = block.T
    return made
